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

"""Eigenvalues at a group of operating points by one expansion, and their errors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.surrogate.grid_columns import columns_of
from squeal_core.surrogate.spectral_deviation import Accuracy, Deviation
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

_COUNTS = ('mode', 'squeal_modes', 'flutter_modes', 'divergent_modes')
_NO_CHANGE = 0.01  # tolerances: less of a change than that is compared with nothing


@dataclass(frozen=True, eq=False)
class LastTerms:
    """
    The terms of the highest degree of a series: they predict the errors of smaller groups.

    Parameters
    ----------
    expansion : SpectralExpansion
        The series.
    entries : (entries,) bool array
        Those of the blocks that matter.
    factor : float
        Tolerances by their size.

    """

    expansion: SpectralExpansion
    entries: Any
    factor: float

    @classmethod
    def of(cls, expansion: SpectralExpansion, matters: Any,
           factor: float = 1.0) -> 'LastTerms':
        """Return those of the blocks of eigenvalues (n,) that matter."""
        blocks = np.logical_or.reduceat(matters, expansion.starts) if matters.size else matters
        return cls(expansion, np.repeat(blocks, expansion.sizes**2), factor)

    def worth(self, coefficients: FloatArray, tolerances: float) -> 'LastTerms':
        """Return the same where a group of points is known to be so many tolerances off."""
        largest = float(self._at(self._steps(coefficients)).max())
        factor = self.factor * tolerances / largest if largest else self.factor
        return LastTerms(self.expansion, self.entries, factor)

    def predicted(self, coefficients: FloatArray) -> FloatArray:
        """Return the predicted errors (P,) at the points of a group, in tolerances."""
        return self._at(self._steps(coefficients))

    def far_half(self, coefficients: FloatArray) -> Any:
        """Return whether points lie above the middle of the coefficient that matters most."""
        steps = self._steps(coefficients)
        if not steps.any():
            return np.zeros(len(steps), bool)
        halved = [float(self._at(np.where(axis, 0.5, 1.0) * steps).max())
                  if np.any(steps[:, axis]) else np.inf
                  for axis in np.eye(steps.shape[1], dtype=bool)]
        return steps[:, int(np.argmin(halved))] > 0.0

    def _steps(self, coefficients: FloatArray) -> FloatArray:
        """Return z (P, v) from the middle of a group."""
        steps = self.expansion.steps(coefficients)
        return np.asarray(steps - 0.5 * (steps.min(axis=0) + steps.max(axis=0)))

    def _at(self, steps: FloatArray) -> FloatArray:
        monomials = self.expansion.monomials
        first = monomials.count - len(monomials.terms[-1])
        last = np.ascontiguousarray(self.expansion.series[first:, self.entries])
        terms = monomials.at(steps)[:, first:] @ last.view(float)
        return np.asarray(self.factor * np.abs(terms.view(complex)).max(axis=1, initial=0.0))


@dataclass(frozen=True, eq=False)
class GroupExpansion:
    """
    Eigenvalues at P points by one expansion, and their change by its last degree.

    Parameters
    ----------
    expansion : SpectralExpansion
        The series.
    eigenvalues, lower : (P, n) complex arrays
        Eigenvalues, and those without the last degree [1/s].
    changes : (P, n) complex array
        The differences.
    off : (P, n) array
        The same in tolerances, of modes that matter.

    """

    expansion: SpectralExpansion
    eigenvalues: ComplexArray
    lower: ComplexArray
    changes: ComplexArray
    off: FloatArray

    @classmethod
    def at(cls, expansion: SpectralExpansion, coefficients: FloatArray,
           accuracy: Accuracy) -> 'GroupExpansion':
        """Evaluate an expansion at coefficients (P, 9)."""
        eigenvalues, lower = (series.eigenvalues(coefficients)
                              for series in (expansion, expansion.truncated()))
        changes = expansion.differences(eigenvalues, lower)
        return cls(expansion, eigenvalues, lower, changes,
                   accuracy.in_tolerances(eigenvalues, changes))

    def last_terms(self) -> LastTerms:
        """Return those of the blocks that matter at any of the points."""
        return LastTerms.of(self.expansion, (self.off > 0.0).any(axis=0))

    def most_changed(self) -> list[int]:
        """Return the points where one block or another changes most, the largest change first."""
        if not self.off.size:
            return [0]
        by_block = np.maximum.reduceat(self.off, self.expansion.starts, axis=1)
        blocks = np.argsort(-by_block.max(axis=0), kind='stable')
        return list(dict.fromkeys(by_block.argmax(axis=0)[blocks].tolist()))

    def undecided(self, checks: Mapping[int, Deviation], accuracy: Accuracy, modes: int) -> Any:
        """
        Return whether a verdict or a mode's number at each point is within the error.

        Parameters
        ----------
        checks : mapping
            How far points are off, by place.
        accuracy : Accuracy
            What counts as growing, and where.
        modes : int
            N of the model.

        Notes
        -----
        A growth rate may be off by what the last degree changes, or by as much more as checks
        have found in the same block. What is counted may not change with the last degree.

        """
        least = _NO_CHANGE * accuracy.tolerances.growth
        ratio = np.ones(self.eigenvalues.shape[1])
        for i, deviation in checks.items():
            ratio = np.maximum(ratio, deviation.distances / (np.abs(self.changes[i]) + least))
        if ratio.size:
            ratio = np.repeat(np.maximum.reduceat(ratio, self.expansion.starts),
                              self.expansion.sizes)
        close = (np.abs(self.eigenvalues.real - accuracy.limits.growth)
                 <= ratio * np.abs(self.changes)).any(axis=1)
        one, other = (columns_of(eigenvalues, modes, accuracy.limits, accuracy.band)
                      for eigenvalues in (self.eigenvalues, self.lower))
        for name in _COUNTS:
            close |= ~np.isclose(one[name], other[name], rtol=0.0, atol=0.0, equal_nan=True)
        return close
