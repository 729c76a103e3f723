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
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.table_cell import (
    DEGREE,
    fit_terms,
    not_known,
    TableCell,
    TableTolerances,
    verdict_within_error,
)
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_modes import TableModes


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
        return int(self.grid.nbytes + self.centres.nbytes + self.halves.nbytes + sum(
            2 * cell.series.nbytes + 6 * cell.omitted.nbytes for cell in self.cells))

    def without(self, cell: int) -> 'ExpansionTable':
        """Return the table without a cell."""
        return replace(self, grid=np.where(self.grid == cell, -1, self.grid))

    def locate(self, x: FloatArray) -> IndexArray:
        """Return the cell of each place x (P, 3); -1: none."""
        low, boxes_per_unit, last = self._axes
        share = (x - low) * boxes_per_unit
        inside: Any = ((share >= 0.0) & (share <= last + 1.0)).all(axis=1)  # NaN is outside
        box = np.where(inside[:, None], np.minimum(share, last), 0.0).astype(np.intp)
        return np.asarray(np.where(inside, self.grid[box[:, 0], box[:, 1], box[:, 2]], -1))

    def evaluate(self, x: FloatArray, tolerances: Tolerances) -> TableModes:
        """
        Return the modes at P points.

        Parameters
        ----------
        x : (P, 3) array
            Places in the domain's coordinates; the friction opposes the sliding.
        tolerances : Tolerances
            What counts as oscillation and growth. A point at which the sign of a growth rate
            hangs on its error is not answered.

        """
        cells, roots, errors, omitted = self._values(x)
        below = self._omitted_below[cells]
        unknown = not_known(roots, errors, self._mirrored[cells], below[:, None],
                            self.tolerances, tolerances)
        unknown |= verdict_within_error(roots, errors, tolerances)
        return TableModes.in_order(
            roots, errors, omitted, modes=self.modes, omitted_below=below,
            cells=np.where(unknown.any(axis=1), -1, cells), tolerances=tolerances)

    def eigenvalues(self, x: FloatArray, tolerances: Tolerances) -> ComplexArray:
        """
        Return the kept eigenvalues, (P, K) in no order [1/s]; rows of NaN without an answer.

        As `evaluate`, but it answers close to a stability boundary, too.
        """
        cells, roots, errors, _ = self._values(x)
        unknown = not_known(roots, errors, self._mirrored[cells],
                            self._omitted_below[cells, None], self.tolerances, tolerances)
        roots[unknown.any(axis=1)] = complex(np.nan, np.nan)
        return roots

    def _values(self, x: FloatArray
                ) -> tuple[IndexArray, ComplexArray, FloatArray, FloatArray]:
        """
        Return cells (P,), eigenvalues (P, K), their errors, frequencies of omitted modes (P, L).

        NaN at points without a cell, and beyond the number of a cell.
        """
        cells, (kept, most_omitted) = self.locate(x), self._widths
        roots, errors = np.empty((len(x), kept), complex), np.empty((len(x), kept))
        omitted = np.empty((len(x), most_omitted))
        roots[...] = complex(np.nan, np.nan)
        errors[...] = omitted[...] = np.nan
        points_of: dict[int, list[int]] = {}
        for point, cell in enumerate(cells.tolist()):
            points_of.setdefault(cell, []).append(point)
        points_of.pop(-1, None)
        for cell, points in points_of.items():
            u = (x[points] - self.centres[cell]) / self.halves[cell]
            found = self.cells[cell].at(fit_terms(DEGREE).at(u))
            for array, values in zip((roots, errors, omitted), found, strict=True):
                array[points, :values.shape[1]] = values
        return cells, roots, errors, omitted

    @cached_property
    def _axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Lower corner of the envelope, finest boxes per unit, number of the last, each (3,)."""
        boxes = np.array(self.grid.shape)
        return self.domain.low, boxes / self.domain.width, boxes - 1.0

    @cached_property
    def _widths(self) -> tuple[int, int]:
        """Largest number of kept eigenvalues and of omitted modes of a cell."""
        return (max((cell.layout.count for cell in self.cells), default=1),
                max((cell.omitted.shape[1] for cell in self.cells), default=0))

    @cached_property
    def _omitted_below(self) -> FloatArray:
        """Bound of each cell on the growth rates of its omitted modes, NaN last: of no cell."""
        return np.array([*(cell.omitted_below for cell in self.cells), np.nan])

    @cached_property
    def _mirrored(self) -> Any:
        """Eigenvalues of each cell (cells + 1, K) whose conjugates are not among them."""
        found = np.zeros((len(self.cells) + 1, self._widths[0]), bool)
        for row, cell in zip(found, self.cells, strict=False):
            row[:cell.mirrored.size] = cell.mirrored
        return found
