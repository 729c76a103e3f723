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

"""The modes that a table has of points."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, repr_with_shapes
from squeal_core.stability.eigensolution import ComplexModes, Mode, Tolerances


@dataclass(frozen=True, eq=False)
class TableModes:
    """
    Kept modes at P points.

    Parameters
    ----------
    roots : (P, K) complex array
        Kept eigenvalues with Im >= 0 in order of mode number, NaN beyond `counts` [1/s].
    errors : (P, K) array
        Bounds of their errors [1/s].
    numbers : (P, K) index array
        Mode numbers; 0 beyond `counts`.
    counts : (P,) index array
        Number of kept modes.
    omitted_below : (P,) array
        Growth rate that all other oscillating modes stay below [1/s].
    cells : (P,) index array
        Cell of each point; -1: the table has no answer.
    tolerances : Tolerances

    """

    roots: ComplexArray
    errors: FloatArray
    numbers: IndexArray
    counts: IndexArray
    omitted_below: FloatArray
    cells: IndexArray
    tolerances: Tolerances

    __repr__ = repr_with_shapes

    @property
    def answered(self) -> Any:
        """Points that the table answers (P,)."""
        return self.cells >= 0

    def __len__(self) -> int:
        return int(self.cells.size)

    def modes(self, place: int) -> ComplexModes:
        """Return the complex modes at one of the points, which the table answers."""
        count, first, omitted_below = self._ends[place]
        roots = self.roots[place, :count]
        return ComplexModes(
            roots[:first], roots[first:], roots, self.errors[place, :count], self.tolerances,
            'table', mode_numbers=self.numbers[place, :count], omitted_below=omitted_below,
            growing=self._growing[place])

    @cached_property
    def _ends(self) -> list[tuple[int, int, float]]:
        """
        Return of each point the number of modes and of those that do not oscillate.

        Their numbers are the first; and the growth rate that others stay below.
        """
        quiet = (self.roots.imag <= self.tolerances.oscillation).sum(axis=1)
        return list(zip(self.counts.tolist(), quiet.tolist(), self.omitted_below.tolist(),
                        strict=True))

    @cached_property
    def _growing(self) -> list[tuple[Mode, ...]]:
        """Return the growing modes of each point, worst first, as `ComplexModes.unstable`."""
        growth = np.where(self.roots.real > self.tolerances.growth, self.roots.real, -np.inf)
        order = np.argsort(-growth, axis=1, kind='stable')
        roots, numbers = (np.take_along_axis(values, order, axis=1)
                          for values in (self.roots, self.numbers))
        kinds = np.where(np.abs(roots.imag) > self.tolerances.oscillation, 'flutter',
                         'divergence')
        return [tuple(map(Mode, *(column[:count] for column in columns)))
                for count, *columns in zip(
                    np.isfinite(growth).sum(axis=1).tolist(), numbers.tolist(), roots.tolist(),
                    kinds.tolist(), strict=True)]

    def growth_rates(self, low_hz: float, high_hz: float) -> FloatArray:
        """
        Return the largest growth rate of an oscillating mode in a band (P,) [1/s].

        NaN without an answer, and where no kept mode in the band is above the omitted ones.
        """
        hertz = self.roots.imag / (2.0 * np.pi)
        inside = ((hertz >= low_hz) & (hertz <= high_hz)
                  & (self.roots.imag > self.tolerances.oscillation))
        growth = np.where(inside, self.roots.real, -np.inf).max(axis=1, initial=-np.inf)
        return np.where(growth > self.omitted_below, growth, np.nan)
