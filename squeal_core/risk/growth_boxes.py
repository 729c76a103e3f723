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
from itertools import pairwise, product
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.risk.growth_grid import GrowthGrid
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

_LARGEST = np.array([1.2, 2.7, 0.25, 0.12])  # width of a box, of ln speed, ln pressure, mu, ln k_c
_SMALLEST = np.array([0.3, 0.4, 0.05, 0.04])  # below which its expansion serves whatever its error
_TOLERANCE = 0.2  # 1/s, where the sign of a growth rate is open
_FRACTION = 0.5  # of a growth rate, by which it may be off
_SHARE = 0.5  # of the change by the last degree: what is left out, measured at a third of it
_FAR = 300.0  # 1/s below zero, from which on a mode is not looked at
_LISTED = 30.0  # 1/s below zero, from which on a mode is evaluated
_NEAR_BAND = (0.7, 1.4)  # times the ends of the band: frequencies that may come into it
_FEW = 4  # points of a box that are solved in full where an expansion fails
_CHUNK = 2048  # points evaluated at once
_CHECKED = (3, 3, 5, 5)  # points along the axes of a box at which its expansion is checked
_EDGE = 0.2  # of a distance to the band: it then changes about as much as growth over ln k_c
_NONE = -1e3  # 1/s, where no mode is near growth


@dataclass(frozen=True)
class BandGrowth:
    """
    Growth in a frequency band: how far a mode is above the threshold within the band.

    Parameters
    ----------
    band : (2,) floats
        Ends of the band [rad/s].
    threshold : float
        Growth rate that counts as unstable [1/s].

    """

    band: tuple[float, float]
    threshold: float

    def excess(self, values: ComplexArray) -> FloatArray:
        """
        Return the growth rate above the threshold, or a scaled distance to the band if less.

        It is above zero just where a mode grows within the band, and continuous at its ends.
        """
        low, high = self.band
        return np.minimum(values.real - self.threshold,
                          _EDGE * np.minimum(values.imag - low, high - values.imag))


@dataclass(frozen=True)
class GridBox:
    """Part of a grid: index of its first point along each axis, and of the one after its last."""

    low: tuple[int, ...]
    high: tuple[int, ...]

    @property
    def size(self) -> IndexArray:
        """Return the number of points along each axis."""
        return np.subtract(self.high, self.low)

    @property
    def slices(self) -> tuple[slice, ...]:
        return tuple(map(slice, self.low, self.high))

    @property
    def places(self) -> IndexArray:
        """Index (P, 4) of all points."""
        return np.stack(np.meshgrid(*map(np.arange, self.low, self.high), indexing='ij'),
                        axis=-1).reshape(-1, 4)

    @property
    def checked(self) -> IndexArray:
        """Index (P, 4) of a lattice of points, both ends of each axis among them."""
        axes = [np.linspace(low, high - 1, count).round().astype(np.intp)
                for low, high, count in zip(self.low, self.high, _CHECKED, strict=True)]
        return np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, 4)

    def halves(self, axis: int) -> tuple['GridBox', 'GridBox']:
        middle = (self.low[axis] + self.high[axis]) // 2
        return (GridBox(self.low, (*self.high[:axis], middle, *self.high[axis + 1:])),
                GridBox((*self.low[:axis], middle, *self.low[axis + 1:]), self.high))


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
    excess = np.empty(box.size, np.float32)
    expansions = 0
    waiting = [box]
    while waiting:
        part = waiting.pop()
        expansions += 1
        values, axis = _by_expansion(grid, criterion, part)
        if values is None and part.size.prod() <= _FEW:
            values = _by_full_solutions(grid, criterion, part)
        if values is None:
            waiting.extend(part.halves(axis))
        else:
            inner = tuple(slice(low - first, high - first) for low, high, first in zip(
                part.low, part.high, box.low, strict=True))
            excess[inner] = values.reshape(part.size)
    return BoxGrowth(box, excess, expansions)


def _by_expansion(grid: GrowthGrid, criterion: BandGrowth,
                  box: GridBox) -> tuple[FloatArray | None, int]:
    """Return the excess growth at a box's points, or None and the axis along which to halve it."""
    smallest = np.maximum(np.round(_SMALLEST / grid.steps), 1.0)
    longest = int(np.argmax(box.size / smallest))
    try:
        expansion = expand_spectrum(
            grid.model, grid.between(np.array(box.low), np.subtract(box.high, 1)),
            stiffness_step=0.5 * float(_SMALLEST[3]))
    except np.linalg.LinAlgError:
        return None, longest
    check = _ExpansionCheck.of(grid, criterion, box, expansion)
    divisible = box.size > smallest
    if not check.suffices and divisible.any():
        return None, check.worst_axis(divisible)
    return np.concatenate(list(_evaluated(grid, criterion, box, expansion, check.blocks))), 0


@dataclass(frozen=True, eq=False)
class _ExpansionCheck:
    """
    Check of an expansion at a lattice of points of a box.

    Parameters
    ----------
    suffices : bool
        Whether the expansion serves the whole box.
    errors : (P,) array
        Largest error where the sign of growth is open, over what it may be.
    blocks : index array
        Blocks that are evaluated in the box.

    """

    suffices: bool
    errors: FloatArray
    blocks: IndexArray

    @classmethod
    def of(cls, grid: GrowthGrid, criterion: BandGrowth, box: GridBox,
           expansion: SpectralExpansion) -> '_ExpansionCheck':
        sums = expansion.partial_sums(grid.coefficients(box.checked))
        values = sums[-1]
        excess = criterion.excess(values)
        low, high = _NEAR_BAND[0] * criterion.band[0], _NEAR_BAND[1] * criterion.band[1]
        excess[:, ((values.imag < low) | (values.imag > high)).all(axis=0)] = _NONE
        owner = np.repeat(np.arange(expansion.sizes.size), expansion.sizes)
        errors = _truncation_errors(sums, owner, (excess > -_FAR).any(axis=0))
        grows = (excess > errors).all(axis=0)
        if grows.any():
            return cls(True, np.zeros(len(values)), np.unique(owner[grows]))
        open_ = (excess > -errors).any(axis=0)
        allowed = np.maximum(_TOLERANCE, _FRACTION * np.abs(excess))
        off = np.where(open_, errors / allowed, 0.0).max(axis=1)
        listed = (excess > -_LISTED).any(axis=0)
        return cls(bool(off.max() <= 1.0), off, np.unique(owner[listed]))

    def worst_axis(self, divisible: Any) -> int:
        """Return the axis with the largest error at its ends, of those that can be divided."""
        errors = self.errors.reshape(_CHECKED)
        centre = tuple(count // 2 for count in _CHECKED)
        along = [max(errors[(*centre[:axis], end, *centre[axis + 1:])] for end in (0, -1))
                 for axis in range(len(_CHECKED))]
        return int(np.argmax(np.where(divisible, along, -1.0)))


def _truncation_errors(sums: Sequence[ComplexArray], owner: IndexArray,
                       wanted: Any) -> FloatArray:
    """
    Return estimates of the errors (P, n) of some eigenvalues, zero of the others.

    The change by the last degree, and of the one before, whose successor may vanish: as two modes
    alone repel, lambda = mean +- sqrt(gap^2 / 4 + c^2), c^2 / gap is followed by 4 c^2 / gap^2
    times itself.
    """
    before, last = (np.abs(b - a)[:, wanted] for a, b in pairwise(sums[-3:]))
    places = np.flatnonzero(wanted)
    gaps = np.abs(sums[-1][:, places, None] - sums[-1][:, None])
    gaps[:, owner[places][:, None] == owner] = np.inf
    ratio = 4.0 * before / np.maximum(gaps.min(axis=-1, initial=np.inf), 1e-30)
    errors = np.zeros(sums[-1].shape)
    errors[:, wanted] = _SHARE * (last + before * np.minimum(ratio, 1.0))
    return errors


def _evaluated(grid: GrowthGrid, criterion: BandGrowth, box: GridBox, expansion: SpectralExpansion,
               blocks: IndexArray) -> Iterator[FloatArray]:
    """Yield the largest excess growth of some blocks at the points of a box, in chunks."""
    places = box.places
    if not blocks.size:
        yield np.full(len(places), _NONE)
        return
    for start in range(0, len(places), _CHUNK):
        values = expansion.eigenvalues_of_blocks(
            blocks, grid.coefficients(places[start:start + _CHUNK]))
        yield criterion.excess(values).max(axis=1)


def _by_full_solutions(grid: GrowthGrid, criterion: BandGrowth, box: GridBox) -> FloatArray:
    return np.array([criterion.excess(eigenvalues(grid.model, grid.between(place, place))).max()
                     for place in box.places])
