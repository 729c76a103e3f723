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

"""
Builds a table: the envelope is halved until each cell is known well enough.

Cells cover the envelope without overlap, so what is not answered is the cells given up as they
could not be halved any further, as at exceptional points, and single points whose verdict hangs on
the error.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
import time
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray, IndexArray, readonly
from squeal_core.common.errors import OperatingPointError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.build_checkpoint import BuildCheckpoint, Leaf, PerAxis
from squeal_core.surrogate.cell_fit import fit_cell
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.full_solutions import FullSolutions
from squeal_core.surrogate.table_cell import TableCell, TableTolerances
from squeal_core.surrogate.table_domain import places_of, TableDomain

Progress = Callable[[int, int], None]

_BOX = np.array([0.8, 0.9, 0.1])  # largest edges of a cell: ln speed, ln pressure, friction
_HALVINGS = 3  # of one axis
_DEPTH = 7  # of all axes together


def build_table(model: BrakeModel, domain: TableDomain | None = None, *,
                tolerances: TableTolerances | None = None,
                points: Sequence[OperatingPoint] | None = None, workers: int = 0,
                progress: Progress = lambda *_: None,
                checkpoint: BuildCheckpoint | None = None) -> ExpansionTable:
    """
    Build the table of a model over an envelope.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    domain : TableDomain, optional
        The envelope; None: `TableDomain.usual(model)`.
    tolerances : TableTolerances, optional
        Errors to keep to; None: `TableTolerances.of(model)`.
    points : sequence of OperatingPoint, optional
        Points of drives; only cells that contain one are built. None: all cells.
    workers : int
        Processes; 0: this one.
    progress : callable
        Called with the rows of boxes that are done and their number.
    checkpoint : BuildCheckpoint, optional
        Has the rows of an earlier build, and keeps each new one.

    Raises
    ------
    OperatingPointError
        Where none of the points lies in the envelope.

    """
    domain = domain or TableDomain.usual(model)
    tolerances = tolerances or TableTolerances.of(model)
    boxes = np.maximum(1, np.ceil(domain.width / _BOX - 1e-9)).astype(int)
    builder = _Builder(model, domain, tolerances, boxes, Tolerances.of(model))
    jobs = dict(enumerate(builder.jobs(None if points is None else places_of(points))))
    if not jobs:
        raise OperatingPointError(f'no point of {len(points or ())} lies in the envelope '
                                  f'{domain}; give a wider one')
    begun = time.monotonic()
    leaves = checkpoint.read(jobs) if checkpoint else {}
    about = {'build_seconds': 0.0, 'workers': workers, 'kept_rows': len(leaves)}
    if leaves:
        progress(len(leaves), len(jobs))
    for i, result in run_jobs(_leaves, {i: jobs[i] for i in jobs if i not in leaves}, workers):
        leaves[i] = result
        if checkpoint:
            checkpoint.keep(i, result)
        progress(len(leaves), len(jobs))
    about['build_seconds'] = round(time.monotonic() - begun, 1)
    return builder.table([leaf for i in sorted(leaves) for leaf in leaves[i]], about)


def _leaves(builder: '_Builder', boxes: Sequence[tuple[PerAxis, FloatArray | None]]) -> list[Leaf]:
    """Return the cells of boxes side by side, which share full solutions."""
    solutions = FullSolutions(builder.model, builder.domain)
    return [leaf for place, x in boxes for leaf in builder.leaves(solutions, (0, 0, 0), place, x)]


@dataclass(frozen=True, eq=False)
class _Builder:
    """Halves boxes and fits cells."""

    model: BrakeModel
    domain: TableDomain
    tolerances: TableTolerances
    boxes: IndexArray
    limits: Tolerances

    def jobs(self, x: FloatArray | None) -> Iterator[tuple['_Builder', Any]]:
        """Yield the arguments of `_leaves` by rows of boxes, or of those with some of places x."""
        first, second, third = self.boxes.tolist()
        for row in product(range(first), range(second)):
            places = [(*row, last) for last in range(third)]
            boxes = [(place, None if x is None else x[self.inside(place, (0, 0, 0), x)])
                     for place in places]
            boxes = [(place, some) for place, some in boxes if some is None or len(some)]
            if boxes:
                yield self, boxes

    def geometry(self, levels: PerAxis, place: PerAxis) -> tuple[FloatArray, FloatArray]:
        """Return the centre of a cell and half its edges."""
        half = 0.5 * self.domain.width / (self.boxes * 2.0 ** np.array(levels))
        return self.domain.low + half * (2.0 * np.array(place) + 1.0), half

    def inside(self, place: PerAxis, levels: PerAxis, x: FloatArray) -> Any:
        """Return whether each place x (P, 3) lies in a cell."""
        centre, half = self.geometry(levels, place)
        return (np.abs(x - centre) <= half * (1.0 + 1e-9)).all(axis=1)

    def leaves(self, solutions: FullSolutions, levels: PerAxis, place: PerAxis,
               x: FloatArray | None, axes: tuple[int, ...] = ()) -> Iterator[Leaf]:
        """Yield the cells that a box is halved into; along given axes without trying it first."""
        centre, half = self.geometry(levels, place)
        if not self.domain.contains(centre, half):
            yield Leaf(levels, place, None)
            return
        kept = None
        if not axes:
            result = fit_cell(solutions, centre, half, self.tolerances, self.limits)
            kept, axes = (result, ()) if isinstance(result, TableCell) else (
                result.cell, result.axes)
        axis = _axis(axes, levels)
        if axis is None:
            yield Leaf(levels, place, kept)
            return
        deeper = _with(levels, axis, levels[axis] + 1)
        for side in (0, 1):
            child = _with(place, axis, 2 * place[axis] + side)
            some = None if x is None else x[self.inside(child, deeper, x)]
            if some is None or len(some):
                yield from self.leaves(solutions, deeper, child, some, axes[1:])

    def table(self, leaves: Sequence[Leaf], about: dict[str, float]) -> ExpansionTable:
        """Return the table of the cells."""
        finest = np.max([leaf.levels for leaf in leaves], axis=0)
        grid = np.full(self.boxes * 2**finest, -1, np.int32)
        kept = [leaf for leaf in leaves if leaf.cell is not None]
        for i, leaf in enumerate(kept):
            size = 2 ** (finest - leaf.levels)
            start = size * leaf.place
            grid[tuple(slice(a, a + b) for a, b in zip(start, size, strict=True))] = i
        geometry = [self.geometry(leaf.levels, leaf.place) for leaf in kept]
        centres, halves = np.array(geometry).reshape(-1, 2, 3).transpose(1, 0, 2)
        return ExpansionTable(
            domain=self.domain, tolerances=self.tolerances, modes=self.model.size,
            grid=readonly(grid, np.int32), centres=readonly(centres), halves=readonly(halves),
            cells=tuple(leaf.cell for leaf in kept if leaf.cell is not None),
            about={**about, 'given_up': len(leaves) - len(kept)})


def _axis(axes: tuple[int, ...], levels: PerAxis) -> int | None:
    """Return the axis to halve; None where a cell is not halved any further."""
    if not axes or sum(levels) >= _DEPTH:
        return None
    if levels[axes[0]] < _HALVINGS:
        return axes[0]
    return int(np.argmin(levels)) if min(levels) < _HALVINGS else None


def _with(values: PerAxis, axis: int, value: int) -> PerAxis:
    first, second, third = (value if i == axis else old for i, old in enumerate(values))
    return first, second, third
