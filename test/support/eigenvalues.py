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

"""Eigenvalues by the plainest means, and how far they are from others."""

import numpy as np
from scipy.optimize import linear_sum_assignment
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray


def companion(stiffness: FloatArray, damping: FloatArray) -> FloatArray:
    """Return the first-order form, all 2N rows."""
    n = len(stiffness)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]])


def companion_at(model: BrakeModel, at: OperatingPoint) -> FloatArray:
    """Return the first-order form at a point, coordinates without stiffness included."""
    return companion(model.stiffness(at), model.damping(at))


def companion_roots(model: BrakeModel, at: OperatingPoint) -> ComplexArray:
    """Return all eigenvalues (2N,) of the first-order form at a point."""
    return np.asarray(np.linalg.eigvals(companion_at(model, at)))


def distance(first: ComplexArray, second: ComplexArray) -> float:
    """Return the largest distance of eigenvalues, paired one to one."""
    away = np.abs(first[:, None] - second)
    return float(away[linear_sum_assignment(away)].max())
