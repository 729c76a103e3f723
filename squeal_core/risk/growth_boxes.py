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
Growth rates on a grid of operating points, from local expansions of the spectrum.

The grid is cut into boxes. One expansion at the centre of a box serves all of its points if the
sign of growth is certain in it or if the eigenvalues that leave it open are accurate enough;
otherwise the box is halved. Where a mode grows throughout, or all modes decay, boxes stay large.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.risk.expansion_check import BandGrowth, ExpansionCheck, NONE
from squeal_core.risk.growth_grid import GridBox, GrowthGrid
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

_LARGEST = np.array([1.2, 2.7, 0.25, 0.12])  # width of a box, of ln speed, ln pressure, mu, ln k_c
_SMALLEST = np.array([0.3, 0.4, 0.05, 0.04])  # below which its expansion serves whatever its error
_LEFT = 0.5  # of a box, up to which one box around what is left of it is enough
_FEW = 8  # points of a box that are solved in full, for less than an expansion
_CHUNK = 2048  # points evaluated at once


@dataclass(frozen=True, eq=False)
class BoxGrowth:
    """Excess growth (n1, n2, n3, n4) [1/s] at the points of a box, and how it was computed."""

    box: GridBox
    excess: Any
    expansions: int


def first_boxes(grid: GrowthGrid) -> list[GridBox]:
    """Return boxes that cover a grid."""
    cuts = [_cuts(count, step, width) for count, step, width in zip(
        grid.shape, grid.steps.tolist(), _LARGEST.tolist(), strict=True)]
    return [GridBox(tuple(low for low, _ in ends), tuple(high for _, high in ends))
            for ends in product(*cuts)]


def _cuts(count: int, step: float, width: float) -> list[tuple[int, int]]:
    ends = np.linspace(0, count, max(math.ceil((count - 1) * step / width), 1) + 1).round()
    return [(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True)]


def box_growth(grid: GrowthGrid, criterion: BandGrowth, box: GridBox) -> BoxGrowth:
    """
    Return the largest excess growth at each point of a box.

    Parameters
    ----------
    grid : GrowthGrid
        Operating points.
    criterion : BandGrowth
        Which growth counts.
    box : GridBox
        Part of the grid.

    """
    excess = np.full(box.size, np.nan, np.float32)
    expansions = 0
    waiting = [box]
    while waiting:
        part = waiting.pop()
        if part.size.prod() <= _FEW:
            _write(excess, box, part, _by_full_solutions(grid, criterion, part))
            continue
        expansions += 1
        answered, left = _by_expansion(grid, criterion, part)
        for piece, values in answered:
            _write(excess, box, piece, values)
        waiting.extend(left)
    return BoxGrowth(box, excess, expansions)


def _write(excess: Any, box: GridBox, part: GridBox, values: FloatArray) -> None:
    """Write the values of a part of a box where there are none yet."""
    inner = tuple(slice(low - first, high - first)
                  for low, high, first in zip(part.low, part.high, box.low, strict=True))
    there = excess[inner]
    excess[inner] = np.where(np.isnan(there), values.reshape(part.size), there)


def _by_expansion(grid: GrowthGrid, criterion: BandGrowth, box: GridBox
                  ) -> tuple[list[tuple[GridBox, FloatArray]], list[GridBox]]:
    """Return the pieces of a box that one expansion answers, and boxes around the others."""
    smallest = np.maximum(np.round(_SMALLEST / grid.steps), 1.0)
    try:
        expansion = expand_spectrum(
            grid.model, grid.between(np.array(box.low), np.subtract(box.high, 1)),
            stiffness_step=0.5 * float(_SMALLEST[3]))
    except np.linalg.LinAlgError:
        return [], list(box.halves(int(np.argmax(box.size / smallest))))
    check = ExpansionCheck.of(grid, criterion, box, expansion)
    pieces = [(box, True)] if (box.size <= smallest).all() else list(check.pieces())
    answered = [
        (part, np.concatenate(list(_evaluated(grid, criterion, part, expansion, check.listed))))
        for part, serves in pieces if serves]
    return answered, _around([part for part, serves in pieces if not serves], box, smallest)


def _around(parts: Sequence[GridBox], box: GridBox, smallest: FloatArray) -> list[GridBox]:
    """Return boxes around parts of a box: one if it is small enough, else the two least ones."""
    whole = box.around(parts)
    if whole is None:
        return []
    if whole.size.prod() <= _LEFT * box.size.prod():
        return [whole]
    divided = [[half for side in whole.halves(axis) if (half := side.around(parts)) is not None]
               for axis in np.flatnonzero(whole.size > 1).tolist()]
    longest = (whole.size / smallest)[whole.size > 1]
    sizes = np.array([sum(int(half.size.prod()) for half in halves) for halves in divided])
    return divided[int(np.lexsort((-longest, sizes))[0])]


def _evaluated(grid: GrowthGrid, criterion: BandGrowth, box: GridBox, expansion: SpectralExpansion,
               blocks: IndexArray) -> Iterator[FloatArray]:
    """Yield the largest excess growth of some blocks at the points of a box, in chunks."""
    places = box.places
    if not blocks.size:
        yield np.full(len(places), NONE)
        return
    for start in range(0, len(places), _CHUNK):
        values = expansion.eigenvalues_of_blocks(
            blocks, grid.coefficients(places[start:start + _CHUNK]))
        yield criterion.excess(values).max(axis=1)


def _by_full_solutions(grid: GrowthGrid, criterion: BandGrowth, box: GridBox) -> FloatArray:
    return np.array([criterion.excess(eigenvalues(grid.model, grid.between(place, place))).max()
                     for place in box.places])
