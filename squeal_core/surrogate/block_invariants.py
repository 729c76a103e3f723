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
Eigenvalues of small blocks by the invariants of each block, which are smooth functions.

Eigenvalues that meet are no smooth functions of the operating point, but the coefficients of the
characteristic polynomial of all that meet are. A block of n eigenvalues is n numbers: its mean m
and the coefficients c_2 ... c_n of prod (z - z_k) = z^n + c_2 z^(n-2) + ... + c_n, z = lambda - m.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray

_TINY = 1e-200  # so small that nothing finite over it overflows


@dataclass(frozen=True, eq=False)
class BlockInvariants:
    """
    Where the invariants of blocks stand: single eigenvalues, means and squares of pairs, others.

    There are as many of them as eigenvalues.

    Parameters
    ----------
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.

    """

    sizes: IndexArray

    @cached_property
    def count(self) -> int:
        """Return the number of eigenvalues."""
        return int(self.sizes.sum())

    @cached_property
    def larger(self) -> tuple[slice, ...]:
        """Place of each larger block among the eigenvalues and invariants."""
        ends = np.cumsum(self.sizes).tolist()
        return tuple(slice(end - size, end) for end, size in zip(
            ends, self.sizes.tolist(), strict=True) if size > 2)

    def of(self, eigenvalues: ComplexArray) -> ComplexArray:
        """Return the invariants (..., n) of eigenvalues (..., n), block by block."""
        found = np.array(eigenvalues, order='C')
        first, middle, end = self._ends
        one, other = eigenvalues[..., first:end:2], eigenvalues[..., first + 1:end:2]
        found[..., first:middle] = 0.5 * (one + other)
        found[..., middle:end] = (0.5 * (one - other)) ** 2
        for place in self.larger:
            found[..., place] = _polynomial(eigenvalues[..., place])
        return found

    @cached_property
    def _ends(self) -> tuple[int, int, int]:
        """Places of the means of pairs, of their squares, of the larger blocks."""
        singles, pairs = (int(np.count_nonzero(self.sizes == size)) for size in (1, 2))
        return singles, singles + pairs, singles + 2 * pairs

    def eigenvalues(self, invariants: ComplexArray,
                    bounds: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """
        Return the eigenvalues, (..., n) [1/s], and bounds of their errors, (..., n) [1/s].

        Parameters
        ----------
        invariants : (..., n) array
            Of all blocks.
        bounds : (n,) array
            Of the errors of the invariants.

        """
        first, middle, end = self._ends
        roots = invariants.copy()
        errors = np.empty(roots.shape)
        errors[...] = bounds
        if end > first:
            mean, s = invariants[..., first:middle], np.sqrt(invariants[..., middle:end])
            off, square = bounds[first:middle], bounds[middle:end]
            roots[..., first:end:2], roots[..., first + 1:end:2] = mean + s, mean - s
            off = off + np.minimum(np.sqrt(square), square / (np.abs(s) + _TINY))
            errors[..., first:end:2] = errors[..., first + 1:end:2] = off
        for place in self.larger:
            roots[..., place], errors[..., place] = _solved(invariants[..., place], bounds[place])
        return roots, errors


def _polynomial(eigenvalues: ComplexArray) -> ComplexArray:
    """Return mean and coefficients (..., n) of a larger block."""
    mean = eigenvalues.mean(axis=-1, keepdims=True)
    coefficients = np.zeros((*eigenvalues.shape[:-1], eigenvalues.shape[-1] + 1), complex)
    coefficients[..., 0] = 1.0
    for root in np.moveaxis(eigenvalues - mean, -1, 0):
        coefficients[..., 1:] -= root[..., None] * coefficients[..., :-1]
    return np.concatenate([mean, coefficients[..., 2:]], axis=-1)


def _solved(invariants: ComplexArray, bounds: FloatArray) -> tuple[Any, Any]:
    """Return the eigenvalues (..., n) of a larger block and the bounds of their errors."""
    size = invariants.shape[-1]
    companion = np.zeros((*invariants.shape[:-1], size, size), complex)
    companion[..., range(1, size), range(size - 1)] = 1.0
    companion[..., 0, 1:] = -invariants[..., 1:]
    z = np.linalg.eigvals(companion)
    apart = np.abs(z[..., :, None] - z[..., None, :])
    apart[..., range(size), range(size)] = 1.0
    powers = np.abs(z)[..., None] ** np.arange(size - 2, -1, -1)
    off = powers @ bounds[1:] / (apart.prod(axis=-1) + _TINY)
    return invariants[..., :1] + z, bounds[0] + off
