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

"""Deviation of eigenvalues of expansions from full solutions, or from lower degrees."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.table_cell import TableTolerances

_FREQUENCY = 2e-5  # largest error of a frequency, relative
_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Deviation:
    """
    Deviation of eigenvalues from reference eigenvalues.

    Parameters
    ----------
    off : float
        Largest distance of a mode that matters, in tolerances.
    growth : float
        Largest error of growth of those [1/s].
    distances : (n,) array
        Of each eigenvalue [1/s]; 0 where it does not matter.

    """

    off: float
    growth: float
    distances: FloatArray


@dataclass(frozen=True, eq=False)
class Accuracy:
    """
    Eigenvalues that matter, and their required accuracy.

    Parameters
    ----------
    tolerances : TableTolerances
        Errors to keep to.
    limits : Tolerances
        What counts as oscillation and growth.
    band : (2,) floats
        In which the least stable mode is wanted [Hz].

    """

    tolerances: TableTolerances
    limits: Tolerances
    band: tuple[float, float]

    def matters(self, eigenvalues: ComplexArray) -> Any:
        """Return whether each of (P, n) is close to growing, or the least stable in the band."""
        oscillating = eigenvalues.imag > self.limits.oscillation
        growing = np.where(
            oscillating, eigenvalues.real > self.tolerances.matters,
            (eigenvalues.real > self.tolerances.growth) & (
                np.abs(eigenvalues.imag) <= self.limits.oscillation))
        low, high = (_TURN * end for end in self.band)
        growth = np.where(oscillating & (eigenvalues.imag >= low) & (eigenvalues.imag <= high),
                          eigenvalues.real, -np.inf)
        least = growth.max(axis=1, keepdims=True, initial=-np.inf)
        return growing | (np.isfinite(growth) & (growth >= least - self.tolerances.growth))

    def in_tolerances(self, eigenvalues: ComplexArray, errors: ComplexArray) -> FloatArray:
        """Return errors of eigenvalues in tolerances; 0 where an eigenvalue does not matter."""
        allowed = self.tolerances.allowed(eigenvalues)
        turning = np.maximum(allowed, _FREQUENCY * np.abs(eigenvalues.imag))
        off = np.maximum(np.abs(errors.real) / allowed, np.abs(errors.imag) / turning)
        return np.asarray(np.where(self.matters(eigenvalues), off, 0.0))

    def deviation(self, result: ComplexArray, truth: ComplexArray) -> Deviation:
        """Compare two spectra (n,), (m,): each mode that matters in one with the other."""
        off, growth, distances = 0.0, 0.0, np.zeros(result.size)
        for one, other in ((result, truth), (truth, result)):
            [matter] = self.matters(one[None])
            if not matter.any() or not other.size:
                off = np.inf if matter.any() else off
                continue
            errors = one - other[np.abs(one[:, None] - other).argmin(axis=1)]
            off = max(off, float(self.in_tolerances(one[None], errors[None]).max()))
            if one is result:
                growth = float(np.abs(errors.real[matter]).max())
                distances = np.where(matter, np.abs(errors), 0.0)
        return Deviation(off, growth, distances)
