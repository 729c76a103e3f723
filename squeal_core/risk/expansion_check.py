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

"""Where an expansion of the spectrum gives the sign of growth in a box of a grid."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.risk.growth_grid import GridBox, GrowthGrid
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

_TOLERANCE = 0.2  # 1/s, where the sign of a growth rate is open
_FRACTION = 0.5  # of a growth rate, by which it may be off
_SHARE = 0.5  # of the change by the last degree: what is left out, measured at a third of it
_FAR = 300.0  # 1/s below zero, from which on a mode is not looked at
_LISTED = 30.0  # 1/s below zero, from which on a mode is evaluated
_NEAR_BAND = (0.7, 1.4)  # times the ends of the band: frequencies that may come into it
_CHECKED = (3, 3, 5, 5)  # points along the axes of a box at which its expansion is checked
_LAST = tuple(count - 1 for count in _CHECKED)
_EDGE = 0.2  # of a distance to the band: it then changes about as much as growth over ln k_c
NONE = -1e3  # 1/s, where no mode is near growth


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


@dataclass(frozen=True, eq=False)
class ExpansionCheck:
    """
    Check of an expansion at a lattice of points of a box.

    Parameters
    ----------
    lattice : four index arrays
        Grid indices of the lattice along each axis.
    off : (l1, l2, l3, l4, blocks) array
        Error of a block over what it may be, zero where its sign of growth is certain.
    grows, may_grow : (l1, l2, l3, l4, blocks) bool arrays
        Whether it surely grows and may grow.
    listed : index array
        Blocks that come near growth somewhere.

    """

    lattice: Sequence[IndexArray]
    off: FloatArray
    grows: Any
    may_grow: Any
    listed: IndexArray

    @classmethod
    def of(cls, grid: GrowthGrid, criterion: BandGrowth, box: GridBox,
           expansion: SpectralExpansion) -> 'ExpansionCheck':
        lattice = [np.linspace(low, high - 1, count).round().astype(np.intp)
                   for low, high, count in zip(box.low, box.high, _CHECKED, strict=True)]
        places = np.stack(np.meshgrid(*lattice, indexing='ij'), axis=-1).reshape(-1, 4)
        sums = expansion.partial_sums(grid.coefficients(places))
        values = sums[-1]
        excess = criterion.excess(values)
        low, high = _NEAR_BAND[0] * criterion.band[0], _NEAR_BAND[1] * criterion.band[1]
        excess[:, ((values.imag < low) | (values.imag > high)).all(axis=0)] = NONE
        owner = np.repeat(np.arange(expansion.sizes.size), expansion.sizes)
        errors = _truncation_errors(sums, owner, (excess > -_FAR).any(axis=0))
        starts = np.searchsorted(owner, np.arange(expansion.sizes.size))
        grows = np.logical_or.reduceat(_FRACTION * excess > errors, starts, axis=1)
        off = errors / np.maximum(_TOLERANCE, _FRACTION * np.abs(excess))
        off[(excess <= -errors) | grows[:, owner]] = 0.0
        listed = np.logical_or.reduceat((excess > -_LISTED).any(axis=0), starts)

        def on_lattice(values: Any) -> Any:
            return values.reshape(*_CHECKED, -1)

        return cls(
            lattice, on_lattice(np.maximum.reduceat(off, starts, axis=1)), on_lattice(grows),
            on_lattice(np.logical_or.reduceat(excess > -errors, starts, axis=1)),
            np.flatnonzero(listed))

    def pieces(self, low: Sequence[int] = (0, 0, 0, 0),
               high: Sequence[int] = _LAST) -> Iterator[tuple[GridBox, bool]]:
        """Yield pieces of the box and whether the expansion serves them."""
        there = tuple(slice(a, b + 1) for a, b in zip(low, high, strict=True))
        blocks = self.off.shape[-1]
        off = self.off[there].reshape(-1, blocks)
        grows, may_grow = (
            found[there].reshape(-1, blocks) for found in (self.grows, self.may_grow))
        accurate = (off <= 1.0).all(axis=0)
        decided = (grows & accurate).any(axis=1)
        serves = not bool(may_grow[~decided][:, ~accurate].any())
        axis = int(np.argmax(np.subtract(high, low)))
        if serves or high[axis] - low[axis] == 1:
            yield GridBox(
                tuple(int(x[a]) for x, a in zip(self.lattice, low, strict=True)),
                tuple(int(x[b]) + 1 for x, b in zip(self.lattice, high, strict=True))), serves
            return
        middle = (low[axis] + high[axis]) // 2
        yield from self.pieces(low, (*high[:axis], middle, *high[axis + 1:]))
        yield from self.pieces((*low[:axis], middle, *low[axis + 1:]), high)


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
