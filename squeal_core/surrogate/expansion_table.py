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

"""Table of the eigenvalues that matter, cell by cell of an envelope: look-up and evaluation."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, repr_with_shapes
from squeal_core.stability.eigensolution import ComplexModes, Tolerances
from squeal_core.surrogate.table_cell import (
    DEGREE,
    fit_terms,
    TableCell,
    TableTolerances,
    verdict_within_error,
)
from squeal_core.surrogate.table_domain import coordinates, TableDomain
from squeal_core.surrogate.table_modes import TableModes

_FEW = 64  # points


@dataclass(frozen=True, eq=False)
class ExpansionTable:
    """
    Polynomials of the eigenvalues that matter, one set for each cell of an envelope.

    Parameters
    ----------
    domain : TableDomain
        The envelope.
    tolerances : TableTolerances
        Errors that the table keeps to.
    modes : int
        N, modes of the model.
    grid : (n1, n2, n3) index array
        Cell at each box of the finest subdivision; -1: none.
    centres, halves : (cells, 3) arrays
        Centre of each cell and half its edges, in the domain's coordinates.
    cells : sequence of TableCell
    about : mapping
        How it was built, and its coverage: texts and numbers.

    """

    domain: TableDomain
    tolerances: TableTolerances
    modes: int
    grid: Any
    centres: FloatArray
    halves: FloatArray
    cells: Sequence[TableCell]
    about: Mapping[str, Any] = field(default_factory=dict)

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        boxes = np.array(self.grid.shape)
        object.__setattr__(self, '_low', self.domain.low)
        object.__setattr__(self, '_per_box', boxes / self.domain.width)
        object.__setattr__(self, '_last', boxes - 1)

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes]."""
        return int(self.grid.nbytes + self.centres.nbytes + self.halves.nbytes + sum(
            2 * cell.series.nbytes + 6 * cell.omitted.nbytes for cell in self.cells))

    @cached_property
    def _most(self) -> int:
        """Largest number of eigenvalues kept in a cell."""
        return max((cell.layout.count for cell in self.cells), default=1)

    def without(self, cell: int) -> 'ExpansionTable':
        """Return the table without a cell."""
        return replace(self, grid=np.where(self.grid == cell, -1, self.grid))

    def locate(self, x: FloatArray) -> IndexArray:
        """Return the cell of each place x (P, 3); -1: none."""
        share = (x - self._low) * self._per_box  # type: ignore[attr-defined]
        last = self._last  # type: ignore[attr-defined]
        inside = ((share >= 0.0) & (share <= last + 1.0)).all(axis=1)  # NaN is outside
        box = np.where(inside[:, None], np.minimum(share, last), 0.0).astype(np.intp)
        return np.where(inside, self.grid[box[:, 0], box[:, 1], box[:, 2]], -1)

    def _cell_at(self, x: tuple[float, float, float]) -> int:
        """Return what `locate` does, of one place, for a tenth of its time."""
        box = []
        for value, (low, per_box, last) in zip(x, self._axes, strict=True):
            share = (value - low) * per_box
            if not 0.0 <= share <= last + 1.0:
                return -1
            box.append(min(int(share), last))
        return int(self.grid[box[0], box[1], box[2]])

    @cached_property
    def _axes(self) -> list[tuple[float, float, int]]:
        return list(zip(self._low.tolist(), self._per_box.tolist(),  # type: ignore[attr-defined]
                        self._last.tolist(), strict=True))  # type: ignore[attr-defined]

    def evaluate(self, rotor_speeds: ArrayLike, contact_pressures: ArrayLike,
                 frictions: ArrayLike, tolerances: Tolerances) -> TableModes:
        """
        Return the modes at P points; numbers and arrays are broadcast together.

        Parameters
        ----------
        rotor_speeds, contact_pressures, frictions : (P,) arrays
            Magnitudes: Omega [rad/s], p0 [Pa], mu [-]; the friction opposes the sliding.
        tolerances : Tolerances
            What counts as oscillation and growth. A point at which the sign of a growth rate
            hangs on its error is not answered.

        """
        return self._collected(coordinates(rotor_speeds, contact_pressures, frictions), tolerances)

    def eigenvalues(self, rotor_speeds: ArrayLike, contact_pressures: ArrayLike,
                    frictions: ArrayLike, tolerances: Tolerances) -> ComplexArray:
        """
        Return the kept eigenvalues, (P, K) in no order [1/s]; rows of NaN without an answer.

        As `evaluate`, but it answers close to a stability boundary, too.
        """
        x = coordinates(rotor_speeds, contact_pressures, frictions)
        found = np.full((len(x), self._most), complex(np.nan, np.nan))
        for place, points in _groups(self.locate(x)):
            cell, u = self.cells[place], (x[points] - self.centres[place]) / self.halves[place]
            roots, errors, _ = cell.at(fit_terms(DEGREE).at(u))
            valid = ~cell.fails(roots, errors, self.tolerances, tolerances).any(axis=1)
            found[points[valid], :roots.shape[1]] = roots[valid]
        return found

    def modes_at(self, rotor_speed: float, contact_pressure: float, friction: float,
                 tolerances: Tolerances) -> tuple[ComplexModes, int] | None:
        """Return the modes at one point and its cell, as `evaluate`; None without an answer."""
        if not (rotor_speed > 0.0 and contact_pressure > 0.0):
            return None
        x = math.log(rotor_speed), math.log(contact_pressure), friction
        place = self._cell_at(x)
        if place < 0:
            return None
        found = _Evaluated(self, place, np.array([x]), tolerances)
        if not found.valid[0]:
            return None
        return found.modes(), place

    def _collected(self, x: FloatArray, tolerances: Tolerances) -> TableModes:
        cells = self.locate(x)
        shape = len(x), self._most
        roots = np.full(shape, complex(np.nan, np.nan))
        errors, numbers = np.full(shape, np.nan), np.zeros(shape, np.intp)
        counts, below = np.zeros(len(x), np.intp), np.full(len(x), np.nan)
        for place, points in _groups(cells):
            found = _Evaluated(self, place, x[points], tolerances)
            width = found.roots.shape[1]
            roots[points, :width], errors[points, :width] = found.roots, found.errors
            numbers[points, :width], counts[points] = found.numbers, found.counts
            below[points] = self.cells[place].omitted_below
            cells[points[~found.valid]] = -1
        return TableModes(roots, errors, numbers, counts, below, cells, tolerances)


def _groups(cells: IndexArray) -> Iterator[tuple[int, IndexArray]]:
    """Yield each cell with its points."""
    if cells.size <= _FEW:  # a dictionary is faster than sorting
        found: dict[int, list[int]] = {}
        for point, cell in enumerate(cells.tolist()):
            found.setdefault(cell, []).append(point)
        yield from ((cell, np.array(points)) for cell, points in found.items() if cell >= 0)
        return
    order = np.argsort(cells, kind='stable')
    ends = np.flatnonzero(np.diff(cells[order])) + 1
    for points in np.split(order, ends):
        if points.size and cells[points[0]] >= 0:
            yield int(cells[points[0]]), points


class _Evaluated:
    """The modes of one cell at places x (P, 3), in order of mode number."""

    def __init__(self, table: ExpansionTable, place: int, x: FloatArray,
                 tolerances: Tolerances) -> None:
        cell = table.cells[place]
        u = (x - table.centres[place]) / table.halves[place]
        roots, errors, omitted = cell.at(fit_terms(DEGREE).at(u))
        self.tolerances, self.below = tolerances, cell.omitted_below
        bad = cell.fails(roots, errors, table.tolerances, tolerances)
        bad |= verdict_within_error(roots, errors, tolerances)
        self.valid = ~bad.any(axis=1)
        oscillating = roots.imag > tolerances.oscillation
        self.quiet = not oscillating.all()
        key = roots.imag
        if self.quiet:
            divergent = (roots.real > tolerances.growth) & (
                np.abs(roots.imag) <= tolerances.oscillation)
            key = np.where(oscillating, key, np.where(divergent, -roots.real, np.inf))
        order = key.argsort(axis=1)
        flat = order if len(x) == 1 else order + order.shape[1] * np.arange(len(x))[:, None]
        self.roots, self.errors = roots.take(flat), errors.take(flat)
        self.counts = np.full(len(x), order.shape[1])
        self._number(oscillating, omitted, table.modes)
        if self.quiet:
            self._clear(np.isposinf(key.take(flat)))

    def _number(self, oscillating: Any, omitted: FloatArray, modes: int) -> None:
        """Count from the highest frequency down, as the non-oscillating modes come first."""
        size = self.roots.shape[1]
        above = (omitted[:, None, :] > self.roots.imag[:, :, None]).sum(axis=2)
        if not self.quiet:
            self.numbers = np.arange(modes - size + 1, modes + 1) - above
            return
        count, first = oscillating.sum(axis=1, keepdims=True), np.arange(size)
        growing = ((self.roots.imag <= self.tolerances.oscillation)
                   & (self.roots.real > self.tolerances.growth)).sum(axis=1, keepdims=True)
        numbers = modes - above - (count - 1 - (first - growing))
        self.numbers = np.where(first < growing, first + 1, numbers)

    def _clear(self, unlisted: Any) -> None:
        """Leave out what neither oscillates nor grows, and conjugates."""
        self.roots[unlisted] = complex(np.nan, np.nan)
        self.errors[unlisted] = np.nan
        self.numbers[unlisted] = 0
        self.counts = self.counts - unlisted.sum(axis=1)

    def modes(self) -> ComplexModes:
        """Return the modes at the only point."""
        roots, errors, numbers = self.roots[0], self.errors[0], self.numbers[0]
        first = 0  # of those that oscillate
        if self.quiet:
            count = int(self.counts[0])
            roots, errors, numbers = roots[:count], errors[:count], numbers[:count]
            first = int((roots.imag <= self.tolerances.oscillation).sum())
        return ComplexModes(
            roots[:first], roots[first:], roots, errors, self.tolerances, 'table',
            mode_numbers=numbers, omitted_below=self.below)
