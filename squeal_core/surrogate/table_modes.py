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
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, repr_with_shapes
from squeal_core.stability.eigensolution import ComplexModes, Tolerances


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

    @classmethod
    def in_order(cls, roots: ComplexArray, errors: FloatArray, omitted: FloatArray, *, modes: int,
                 omitted_below: FloatArray, cells: IndexArray,
                 tolerances: Tolerances) -> 'TableModes':
        """
        Return modes in order of mode number.

        Parameters
        ----------
        roots, errors : (P, K) arrays
            Eigenvalues of cells, NaN beyond their number; those that neither oscillate nor grow,
            and conjugates, are left out.
        omitted : (P, L) array
            Angular frequencies of the omitted modes, NaN beyond their number [rad/s].
        modes : int
            N, modes of the model: they are numbered from the highest frequency down, as the
            non-oscillating ones come first.
        omitted_below, cells, tolerances
            As of the class.

        """
        oscillate = roots.imag > tolerances.oscillation
        diverge = (roots.real > tolerances.growth) & (
            np.abs(roots.imag) <= tolerances.oscillation)
        key = np.where(oscillate, roots.imag, np.where(diverge, -roots.real, np.inf))
        divergent = diverge.sum(axis=1)
        counts = divergent + oscillate.sum(axis=1)
        place = np.arange(counts.max(initial=0))
        order = key.argsort(axis=1, kind='stable')[:, :place.size]
        order += roots.shape[1] * np.arange(len(roots))[:, None]  # places in the flat arrays
        listed = place < counts[:, None]
        roots = np.where(listed, roots.take(order), complex(np.nan, np.nan))
        above = (omitted[:, None, :] > roots.imag[:, :, None]).sum(axis=2)
        numbers = modes - above - (counts[:, None] - 1 - place)
        numbers = np.where(place < divergent[:, None], place + 1, numbers)
        return cls(roots, np.where(listed, errors.take(order), np.nan),
                   np.where(listed, numbers, 0), counts, omitted_below, cells, tolerances)

    @property
    def answered(self) -> Any:
        """Points that the table answers (P,)."""
        return self.cells >= 0

    def answered_in(self, low_hz: float, high_hz: float) -> Any:
        """Points (P,) at which, too, no omitted mode may be the least stable of a band."""
        hertz = self.roots.imag / (2.0 * np.pi)
        low_hz = max(low_hz, self.tolerances.oscillation / (2.0 * np.pi))
        growth = np.where((hertz >= low_hz) & (hertz <= high_hz), self.roots.real, -np.inf).max(
            axis=1, initial=-np.inf)
        return (self.cells >= 0) & (growth > self.omitted_below)

    def __len__(self) -> int:
        return int(self.cells.size)

    def modes(self, place: int) -> ComplexModes:
        """Return the complex modes at one of the points, which the table answers."""
        count = self.counts[place]
        roots = self.roots[place, :count]
        first = np.count_nonzero(roots.imag <= self.tolerances.oscillation)
        return ComplexModes(
            roots[:first], roots[first:], roots, self.errors[place, :count], self.tolerances,
            'table', mode_numbers=self.numbers[place, :count],
            omitted_below=float(self.omitted_below[place]))
