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
Pairs of roots that come near each other: what the series of their blocks leave out.

Two modes alone, a difference g of roots apart and coupled by E_rc and E_cr, have the roots

    mean +- (g / 2) sqrt((1 + x)^2 + y),    x = dg / g,  y = 4 E_rc E_cr / g^2,

x of first, y of second order in the step. Beyond degree d of its series |g y| / 4 times
rho^(d - 1) / (1 - rho), rho = |x| + sqrt|y|, is left out. A weakly coupled pair that is about to
cross has a small term of each degree and many of them: it hides behind the terms of other modes,
and the ratio of successive terms of the whole block does not show it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly

_MOST = 64  # pairs kept of an expansion, beside the first of each root
_EQUAL = 1e-15  # of the largest difference: below it two eigenvalues are one
_NEAREST = 0.01  # 1 - rho at least: a pair without coupling may cross


@dataclass(frozen=True, eq=False)
class PairRemainder:
    """
    The pairs of roots of different blocks that matter first around an expansion point.

    Parameters
    ----------
    rates : (v, 3, pairs) complex array
        By scaled step: x, 2 E_rc / g and 2 E_cr / g of each pair.
    weights : (pairs,) array
        |g| / 4 [1/s].
    order, owners : index arrays
        A list of pairs, sorted by block, and the block of each.
    blocks : int
        How many there are.
    degree : int
        Of the series.

    """

    rates: ComplexArray
    weights: FloatArray
    order: IndexArray
    owners: IndexArray
    blocks: int
    degree: int

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes], with what is made of it at first use."""
        return int(2 * self.rates.nbytes + self.weights.nbytes + 2 * self.order.nbytes
                   + self.owners.nbytes)

    def bound(self, steps: FloatArray) -> FloatArray:
        """Return what is left out (..., blocks) [1/s] at scaled steps (..., v)."""
        rates, weights, order, starts = self._evaluation
        moved = (steps @ rates).view(complex)
        moved = moved.reshape(*moved.shape[:-1], 3, -1)
        size = np.abs(moved[..., 1, :] * moved[..., 2, :])
        ratio = np.abs(moved[..., 0, :])
        ratio += np.sqrt(size)
        size *= weights
        size *= ratio ** (self.degree - 1)
        size /= np.maximum(1.0 - ratio, _NEAREST)
        return np.asarray(np.add.reduceat(size.take(order, axis=-1), starts, axis=-1))

    @cached_property
    def _evaluation(self) -> tuple[FloatArray, FloatArray, IndexArray, IndexArray]:
        """Rates (v, 6 pairs) and weights with a pair of nothing, which blocks without one have."""
        rates = np.pad(self.rates, ((0, 0), (0, 0), (0, 1)))
        without = np.setdiff1d(np.arange(self.blocks), self.owners)
        owners = np.concatenate([self.owners, without])
        order = np.concatenate([self.order, np.full(without.size, self.weights.size)])
        order = order[np.argsort(owners, kind='stable')]
        starts = np.searchsorted(np.sort(owners), np.arange(self.blocks))
        flat: FloatArray = rates.reshape(len(rates), 3 * rates.shape[2]).view(float)
        return flat, np.append(self.weights, 0.0), order, starts


def pair_remainder(roots: ComplexArray, couplings: ComplexArray, blocks: Sequence[IndexArray],
                   steps: Sequence[FloatArray], degree: int) -> PairRemainder:
    """
    Return the pairs with the largest terms left out, all `steps` (v,) taken together.

    Parameters
    ----------
    roots : (M,) array
        Eigenvalues [1/s].
    couplings : (v, M, M) array
        E_i.
    blocks : sequence of index arrays
        Roots of each block; those in none are mirror images.
    steps : sequence of (v,) arrays
        Scaled, one for each parameter.
    degree : int
        Of the expansion.

    """
    label = np.full(roots.size, -1)
    for i, block in enumerate(blocks):
        label[block] = i
    gap = roots - roots[:, None]
    left_out = _left_out(gap, couplings, steps, degree)
    left_out[label[:, None] == label] = 0.0
    first, second = _largest(left_out, label >= 0)
    gap = gap[first, second]
    diagonal = np.einsum('vaa->va', couplings)
    rates = np.stack([diagonal[:, second] - diagonal[:, first],
                      2.0 * couplings[:, first, second],
                      2.0 * couplings[:, second, first]], axis=1) / gap
    both = np.concatenate([label[first], label[second]])
    order = np.argsort(both, kind='stable')
    order = order[both[order] >= 0]
    # an estimate needs no more than single precision, and so a table's file is half as large
    return PairRemainder(readonly(rates.astype(np.complex64), complex),
                         readonly(np.float32(0.25 * np.abs(gap))),
                         readonly(order % max(gap.size, 1), np.intp),
                         readonly(both[order], np.intp), len(blocks), degree)


def _left_out(gap: ComplexArray, couplings: ComplexArray, steps: Sequence[FloatArray],
              degree: int) -> Any:
    """Return the leading term left out of each pair (M, M), in units that do not matter."""
    change, strength = np.zeros(gap.shape), np.zeros(gap.shape)
    for step in steps:
        moved = np.tensordot(step, couplings, axes=1)
        own = np.diag(moved)
        change += np.abs(own - own[:, None])
        strength += np.abs(moved)
    size = np.abs(gap)
    size = np.maximum(size, _EQUAL * (size.max(initial=0.0) or 1.0))
    square = 4.0 * strength * strength.T / size**2
    return size * square * np.minimum(change / size + np.sqrt(square), 1.0) ** (degree - 1)


def _largest(left_out: FloatArray, kept: Any) -> tuple[IndexArray, IndexArray]:
    """Return pairs, the first of each the lower: the largest, and the largest of each root."""
    size = len(left_out)
    own = np.flatnonzero(kept)
    chosen = {(min(pair), max(pair)) for pair in zip(
        own.tolist(), left_out[own].argmax(axis=1).tolist(), strict=True)}
    upper = np.triu(left_out).ravel()
    most = min(_MOST, upper.size)
    order = np.argpartition(-upper, most - 1)[:most] if most else np.zeros(0, np.intp)
    chosen.update(zip((order // size).tolist(), (order % size).tolist(), strict=True))
    pairs = np.array(sorted(pair for pair in chosen if left_out[pair] > 0.0), np.intp)
    first, second = pairs.reshape(-1, 2).T
    return first, second
