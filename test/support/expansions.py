# Copyright 2026 squeal_ros developers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""Roots of an expansion at a point, and how far they are from the truth."""

from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from squeal_core import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

# terms from the second degree on are of single precision, and so large at most
SINGLE = 1e-4


def series_at(expansion: SpectralExpansion, at: OperatingPoint) -> ComplexArray:
    """Return the roots at one point."""
    return expansion.eigenvalues(np.array(at.coefficients()))


def whole(expansion: SpectralExpansion, values: Any) -> Any:
    """Values of the expansion's roots, then of their mirror images (conjugates)."""
    return np.concatenate([values, np.conj(values[expansion.mirrored])])


def off(expansion: SpectralExpansion, roots: ComplexArray,
        truth: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Distance of each root from its own of the truth, one to one; and the truth in that order."""
    every = whole(expansion, roots)
    zeros = np.zeros(truth.size - every.size)  # of coordinates that nothing holds
    ours, theirs = linear_sum_assignment(np.abs(np.append(every, zeros)[:, None] - truth))
    assert np.array_equal(ours, np.arange(truth.size))
    away = np.abs(np.append(every, zeros) - truth[theirs])
    assert away[every.size:].max(initial=0.0) < 1e-6
    return away[:roots.size], truth[theirs][:roots.size]
