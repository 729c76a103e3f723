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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, repr_with_shapes
from squeal_core.common.frozen_records import frozen_record
from squeal_core.stability.eigensolution import ComplexModes, Kind, Mode, Tolerances
from squeal_core.surrogate.cell_arrays import CellStack, OMITTED_DEGREE, stack_cells
from squeal_core.surrogate.table_cell import (
    DEGREE,
    fit_terms,
    not_known,
    TableCell,
    TableTolerances,
    verdict_within_error,
)
from squeal_core.surrogate.table_domain import TableDomain

_FACTORS = fit_terms(DEGREE).factors
_OMITTED = fit_terms(OMITTED_DEGREE).count
_ROUNDING = 1e-12  # of a box, by which one is taken for its neighbour
_GROWING: tuple[Kind, Kind] = ('divergence', 'flutter')  # by whether it oscillates


@dataclass(frozen=True, eq=False)
class TableModes:
    """
    Kept modes at P points.

    Parameters
    ----------
    eigenvalues : (P, K) complex array
        Kept eigenvalues with Im >= 0 in order of mode number, NaN beyond `counts` [1/s].
    errors : (P, K) array
        Bounds of their errors [1/s].
    numbers : (P, K) index array
        Mode numbers; 0 beyond `counts`.
    counts, divergent : (P,) index arrays
        Number of kept modes, and of those, the first ones, that do not oscillate.
    omitted_below : (P,) array
        Growth rate that all other oscillating modes stay below [1/s].
    cells : (P,) index array
        Cell of each point; -1: the table has no answer.
    tolerances : Tolerances

    """

    eigenvalues: ComplexArray
    errors: FloatArray
    numbers: IndexArray
    counts: IndexArray
    divergent: IndexArray
    omitted_below: FloatArray
    cells: IndexArray
    tolerances: Tolerances

    __repr__ = repr_with_shapes

    @classmethod
    def in_order(cls, eigenvalues: ComplexArray, errors: FloatArray, omitted: FloatArray, *,
                 modes: int, omitted_below: FloatArray, cells: IndexArray,
                 tolerances: Tolerances) -> 'TableModes':
        """
        Return modes in order of mode number.

        Parameters
        ----------
        eigenvalues, errors : (P, K) arrays
            Of cells, NaN beyond their number; those that neither oscillate nor grow,
            and conjugates, are left out.
        omitted : (P, L) array
            Angular frequencies of the omitted modes, NaN beyond their number [rad/s].
        modes : int
            N, modes of the model: they are numbered from the highest frequency down, as the
            non-oscillating ones come first.
        omitted_below, cells, tolerances
            As of the class.

        """
        oscillate = eigenvalues.imag > tolerances.oscillation
        diverge = (eigenvalues.real > tolerances.growth) & (
            np.abs(eigenvalues.imag) <= tolerances.oscillation)
        key = np.where(oscillate, eigenvalues.imag, np.where(diverge, -eigenvalues.real, np.inf))
        divergent = diverge.sum(axis=1)
        counts = divergent + oscillate.sum(axis=1)
        place = np.arange(counts.max(initial=0))
        order = key.argsort(axis=1, kind='stable')[:, :place.size]
        # places in the flat arrays
        order += eigenvalues.shape[1] * np.arange(len(eigenvalues))[:, None]
        listed = place < counts[:, None]
        eigenvalues = np.where(listed, eigenvalues.take(order), complex(np.nan, np.nan))
        above = (omitted[:, None, :] > eigenvalues.imag[:, :, None]).sum(axis=2)
        numbers = modes - above - (counts[:, None] - 1 - place)
        numbers = np.where(place < divergent[:, None], place + 1, numbers)
        return cls(eigenvalues, np.where(listed, errors.take(order), np.nan),
                   np.where(listed, numbers, 0), counts, divergent, omitted_below, cells,
                   tolerances)

    @property
    def answered(self) -> Any:
        """Points that the table answers (P,)."""
        return self.cells >= 0

    def __len__(self) -> int:
        return int(self.cells.size)

    def listed(self) -> list[ComplexModes]:
        """Return the complex modes at all points, none where the table does not answer."""
        growth = self.eigenvalues.real
        points, places = (growth > self.tolerances.growth).nonzero()
        order = np.lexsort((-growth[points, places], points))  # the worst first
        worst = points[order], places[order]
        unstable = self.eigenvalues[worst]
        kinds = map(_GROWING.__getitem__, (
            np.abs(unstable.imag) > self.tolerances.oscillation).tolist())
        growing = tuple(map(Mode, self.numbers[worst].tolist(), unstable.tolist(), kinds))
        result, start = [], 0
        for eigenvalues, errors, numbers, first, count, below, end in zip(
                self.eigenvalues, self.errors, self.numbers, self.divergent.tolist(),
                self.counts.tolist(), self.omitted_below.tolist(),
                np.bincount(points, minlength=self.cells.size).cumsum().tolist(), strict=True):
            eigenvalues = eigenvalues[:count]
            result.append(frozen_record(
                ComplexModes, nonoscillatory=eigenvalues[:first], oscillatory=eigenvalues[first:],
                mode_eigenvalues=eigenvalues, errors=errors[:count], tolerances=self.tolerances,
                source='table', mode_numbers=numbers[:count], omitted_below=below,
                unstable=growing[start:end]))
            start = end
        return result


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

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes]."""
        arrays = (self.grid, self.centres, self.halves, *self._stack[1:], *(
            array for cell in self.cells for array in (cell.series, cell.omitted)))
        return sum(array.nbytes for array in arrays)

    def without(self, cell: int) -> 'ExpansionTable':
        """Return the table without a cell."""
        result = replace(self, grid=np.where(self.grid == cell, -1, self.grid))
        vars(result)['_stack'] = self._stack  # its cells are the same ones
        return result

    def locate(self, x: FloatArray) -> IndexArray:
        """Return the cell of each place x (P, 3); -1: none."""
        grid, scale, offset, last = self._boxes
        box = np.minimum(np.fmax(x * scale + offset, 0.0), last)  # NaN is outside
        i, j, k = box.astype(np.intp).T
        return np.asarray(grid[i, j, k])

    def evaluate(self, x: FloatArray, tolerances: Tolerances,
                 band_hz: tuple[float, float] | None = None) -> TableModes:
        """
        Return the modes at P points.

        Parameters
        ----------
        x : (P, 3) array
            Places in the domain's coordinates; the friction opposes the sliding.
        tolerances : Tolerances
            What counts as oscillation and growth. A point at which the sign of a growth rate
            hangs on its error is not answered.
        band_hz : (2,) floats, optional
            Nor is one at which an omitted mode may be the least stable of this band.

        """
        stack, (cells, eigenvalues, errors, omitted) = self._stack, self._values(x)
        below = stack.omitted_below[cells]
        unknown = not_known(eigenvalues, errors, stack.mirrored[cells], below[:, None],
                            self.tolerances, tolerances)
        unknown |= verdict_within_error(eigenvalues, errors, tolerances)
        missing = unknown.any(axis=1)
        if band_hz is not None:
            low, high = 2.0 * np.pi * band_hz[0], 2.0 * np.pi * band_hz[1]
            inside = (eigenvalues.imag >= max(low, tolerances.oscillation)) & (
                eigenvalues.imag <= high)
            missing |= ~(inside & (eigenvalues.real > below[:, None])).any(axis=1)
        return TableModes.in_order(
            eigenvalues, errors, omitted, modes=self.modes, omitted_below=below,
            cells=np.where(missing, -1, cells), tolerances=tolerances)

    def eigenvalues(self, x: FloatArray, tolerances: Tolerances) -> tuple[ComplexArray, Any]:
        """
        Return the kept eigenvalues, (P, K) in no order [1/s], and which points are answered.

        As `evaluate`, but it answers close to a stability boundary, too.
        """
        stack, (cells, eigenvalues, errors, _) = self._stack, self._values(x, numbered=False)
        unknown = not_known(eigenvalues, errors, stack.mirrored[cells],
                            stack.omitted_below[cells, None], self.tolerances, tolerances)
        return eigenvalues, (cells >= 0) & ~unknown.any(axis=1)

    def _values(self, x: FloatArray, *, numbered: bool = True
                ) -> tuple[IndexArray, ComplexArray, FloatArray, FloatArray]:
        """
        Return cells (P,), eigenvalues (P, K), their errors, frequencies of omitted modes (P, L).

        NaN at points without a cell, and beyond the number of a cell. The polynomials are
        evaluated point by point, so that its bits do not depend on the other points.
        """
        stack, cells = self._stack, self.locate(x)
        factors = np.ones((len(x), 4))
        factors[:, 1:] = (x - stack.centres[cells]) / stack.halves[cells]
        terms = factors[:, _FACTORS].prod(axis=1)[:, None]
        values = np.empty((len(x), stack.series.shape[2]))
        omitted = np.empty((len(x), stack.omitted.shape[2] if numbered else 0))
        points_of: dict[int, list[int]] = {}
        for point, cell in enumerate(cells.tolist()):
            points_of.setdefault(cell, []).append(point)
        for cell, points in points_of.items():
            here = terms[points]
            values[points] = (here @ stack.series[cell])[:, 0]
            if numbered:
                omitted[points] = (here[..., :_OMITTED] @ stack.omitted[cell])[:, 0]
        eigenvalues, errors = stack.layout.eigenvalues(values.view(complex), stack.bounds[cells])
        return cells, eigenvalues, errors, omitted

    @cached_property
    def _boxes(self) -> tuple[IndexArray, FloatArray, FloatArray, FloatArray]:
        """
        Return the grid with a border of no cells, and which x has which of its boxes.

        That is x * scale + offset, from 0 to a last one; the ends of the envelope are in it.
        """
        boxes = np.array(self.grid.shape)
        scale = (1.0 - 2.0 * _ROUNDING) * boxes / self.domain.width
        return (np.pad(self.grid, 1, constant_values=-1), scale,
                1.0 + _ROUNDING - self.domain.low * scale, boxes + 1.0)

    @cached_property
    def _stack(self) -> CellStack:
        return stack_cells(self.cells, self.centres, self.halves)
