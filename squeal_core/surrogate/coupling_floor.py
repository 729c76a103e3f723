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
Least remainder of a series by couplings over gaps, whatever its computed terms are.

A block changes with the operating point along closed walks of couplings: from an eigenvalue r of
it over others a, b, ... back into the block. Of a walk of n couplings comes a term of degree n,

    E_ra E_ab ... E_zr / ((lambda_r - lambda_a) (lambda_r - lambda_b) ...)

Where couplings form a ring, as of a friction couple of entries (i, i + 1) alone, every walk
shorter than the ring vanishes. All terms of a series are zero then, though it is not exact, and
nothing that is computed from these terms shows it. So walks beyond the degree of the series are
summed here, by root sum square: of one walk that is its size, of many with phases of their own
about what they come to. They count where the walks within the degree do not show them: of a matrix
without such a structure they do, and the remainder is the one of the terms.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly

LONGEST = 12  # couplings of a walk
_SAFETY = 4.0  # on the walks of one step: they may be in phase
_EQUAL = 4.9e-8  # of the largest eigenvalue: what counts as growth is no gap
_CANCELS = 0.1  # square of a sum over its root sum square, from which on symmetry is behind it
_SHOWN = 5.0  # times a geometric series of shorter walks, up to which the terms show it
_LARGEST = 1e30  # 1/s, that single precision holds


@dataclass(frozen=True, eq=False)
class CouplingFloor:
    """
    Size of the closed walks that the terms of a series do not show.

    Parameters
    ----------
    weights : (v,) array
        Of the scaled steps, where all change together.
    sizes : (v + 1, lengths, blocks) array
        Of the walks of degree + 1, degree + 2, ... couplings to `LONGEST` [1/s]: by each scaled
        step alone, at 1, and by all together, at a weighted step of 1 each.
    degree : int
        Of the series.

    """

    weights: FloatArray
    sizes: FloatArray
    degree: int

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes]."""
        return int(self.sizes.nbytes + self.weights.nbytes)

    def bound(self, steps: FloatArray) -> FloatArray:
        """Return the least remainder (..., blocks) [1/s] at scaled steps (..., v)."""
        size = np.abs(steps)
        together = (size * self.weights).max(axis=-1, initial=0.0, keepdims=True)
        size = np.concatenate([size, together], axis=-1)[..., None]
        powers = size ** np.arange(self.degree + 1, LONGEST + 1)
        return np.asarray(powers.reshape(*powers.shape[:-2], -1) @ self._flat)

    @cached_property
    def _flat(self) -> FloatArray:
        # all together at the largest of them is more than there is as it stands
        safety = np.append(np.full(len(self.sizes) - 1, _SAFETY), 1.0)
        return np.asarray((safety[:, None, None] * self.sizes).reshape(
            -1, self.sizes.shape[-1]))


def coupling_floor(roots: ComplexArray, couplings: ComplexArray, blocks: Sequence[IndexArray],
                   degree: int) -> CouplingFloor:
    """
    Return the closed walks beyond the degree of a series.

    Parameters
    ----------
    roots : (M,) array
        Eigenvalues [1/s].
    couplings : (v, M, M) array
        E_i.
    blocks : sequence of index arrays
        Roots of each block; those in none are mirror images.
    degree : int
        Of the expansion.

    """
    kept = np.concatenate(blocks)
    sizes = np.array([block.size for block in blocks])
    label = np.repeat(np.arange(sizes.size), sizes)
    own, starts = label[:, None] == label, np.cumsum(sizes) - sizes
    inverse = _inverse_gaps(roots[kept], own, _EQUAL * np.abs(roots).max(initial=0.0))
    together = _together(roots, couplings, kept, own)
    strengths = np.abs(couplings[:, kept[:, None], kept]) ** 2
    np.einsum('vaa->va', strengths)[:] = 0.0
    weights = np.sqrt(strengths.sum(axis=(1, 2)))
    weights[weights == 0.0] = 1.0
    strengths = np.concatenate(
        [strengths, [np.einsum('vab,v->ab', strengths, (weights.max(initial=0.0) / weights)**2)]])
    found = [_unseen(_walks(strength, inverse, together, own, starts), degree,
                     *(np.maximum.reduceat(each, starts) for each in _ratios(strength, inverse)))
             for strength in strengths]
    # an estimate needs no more than single precision
    return CouplingFloor(
        readonly(np.float32(weights / weights.max(initial=0.0))),
        readonly(np.float32(np.minimum(found, _LARGEST))), degree)


def _walks(strength: FloatArray, inverse: FloatArray, together: FloatArray, own: Any,
           starts: IndexArray) -> FloatArray:
    """Return the square of the closed walks (lengths, blocks) of 2, 3, ... couplings."""
    found, walks = [], strength
    for _ in range(2, LONGEST + 1):
        walks = strength @ (inverse * walks)
        found.append(np.add.reduceat((walks * own).sum(axis=0), starts))
        walks = together * walks
    return np.array(found)


def _ratios(strength: FloatArray, inverse: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return powers of the ratio of walks to shorter ones (kept,), see `_unseen`."""
    back = strength * strength.T  # there and back again
    pairs = np.maximum((back * inverse**2).max(axis=0), (inverse * (back @ inverse)).sum(axis=0))
    return pairs, (strength @ inverse).max(axis=0)


def _unseen(squares: FloatArray, degree: int, pairs: FloatArray,
            mixing: FloatArray) -> FloatArray:
    """
    Return the walks (lengths, blocks) beyond the degree that those within it do not show.

    Parameters
    ----------
    squares : (lengths, blocks) array
        Of walks of 2, 3, ... couplings.
    degree : int
        Of the expansion.
    pairs : (blocks,) array
        Fourth power of the ratio of couplings to gaps, there and back.
    mixing : (blocks,) array
        Square of the greatest ratio of walks to those a coupling shorter.

    """
    seen, beyond = np.split(np.sqrt(squares), [degree - 1])
    ratio = pairs ** 0.25
    for before, after in zip(seen[:-1], seen[1:], strict=True):
        ratio = np.maximum(ratio, np.minimum(
            after / np.where(before > 0.0, before, np.inf), np.sqrt(mixing)))
    more = np.arange(len(beyond))[:, None]
    shown = np.max([size * ratio ** (more + len(seen) - i) for i, size in enumerate(seen)], axis=0)
    return np.where(beyond > _SHOWN * shown, beyond, 0.0)


def _inverse_gaps(roots: ComplexArray, own: Any, least: float) -> FloatArray:
    """Return the square of 1 / |lambda_c - lambda_a| (a, c), a with its mirror image; own: 0."""
    found = 1.0 / np.maximum(np.abs(roots[:, None] - roots), least)
    mirrored = (np.abs(roots.imag) > least)[:, None]
    found += mirrored / np.maximum(np.abs(roots[:, None].conj() - roots), least)
    return np.asarray(np.where(own, 0.0, found) ** 2)


def _together(roots: ComplexArray, couplings: ComplexArray, kept: IndexArray,
              own: Any) -> FloatArray:
    """
    Return the part (a, c) of the walks from c to a that is left where symmetry cancels them.

    Two equal modes of an axisymmetric disc are coupled by walks over each other pair of modes that
    cancel, to rounding. What is left is seen by the walks of two couplings in some direction.
    """
    signs = np.cos(np.arange(len(couplings)))  # a direction that is no other's
    coupling = np.tensordot(signs, couplings, axes=1)
    gap = roots[:, None] - roots[kept]
    gap[kept] = np.where(own, np.inf, gap[kept])
    mixed = coupling[:, kept] / np.where(gap == 0.0, np.inf, gap)
    rows = coupling[kept]
    sum_ = np.abs(rows @ mixed - mixed[kept] * np.diag(coupling)[kept]) ** 2
    square = np.abs(rows) ** 2 @ np.abs(mixed) ** 2
    part = sum_ / np.where(square > 0.0, square, 1.0)
    return np.asarray(np.where((square > 0.0) & (part < _CANCELS), part, 1.0))
