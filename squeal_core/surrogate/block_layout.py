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
Layout of the entries of an expansion's blocks, and their eigenvalues.

Laid out for evaluation: the entries of modes alone in their block, then of all pairs
[[m + h, b], [c, m - h]] the means m, the halves h, all b and all c, then the larger blocks, row by
row. The last axis is that of entries, blocks or roots; those before it are of terms or of points.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg.lapack import zgeev
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray

_TINY = 1e-200  # so small that nothing finite over it overflows
_TWO_TWICE = np.array([2.0, 2.0, 1.0, 1.0])  # norms: mean and half are in two entries each
_ALL_BUT_MEAN = np.array([0.0, 2.0, 2.0, 2.0])


@dataclass(frozen=True, eq=False)
class BlockSizes:
    """
    Sizes of blocks of eigenvalues: singles first, then pairs, then larger ones.

    Parameters
    ----------
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.

    """

    sizes: IndexArray

    @cached_property
    def singles(self) -> int:
        """Return the number of blocks of one eigenvalue."""
        return int(np.searchsorted(self.sizes, 2))

    @cached_property
    def pairs(self) -> int:
        """Return the number of blocks of two."""
        return int(np.searchsorted(self.sizes, 3)) - self.singles

    @cached_property
    def count(self) -> int:
        """Return the number of eigenvalues."""
        return int(self.sizes.sum())


class BlockLayout(BlockSizes):
    """Where the entries of blocks are."""

    @cached_property
    def larger(self) -> tuple[tuple[int, int, slice, slice], ...]:
        """Of each larger block its place among the blocks, its size, its entries, its roots."""
        return tuple(self._larger())

    def _larger(self) -> Iterator[tuple[int, int, slice, slice]]:
        entry, root = self.singles + 4 * self.pairs, self.singles + 2 * self.pairs
        for block, size in enumerate(self.sizes.tolist()):
            if size > 2:
                yield block, size, slice(entry, entry + size**2), slice(root, root + size)
                entry, root = entry + size**2, root + size

    @cached_property
    def entries(self) -> int:
        return int((self.sizes**2).sum())

    def _quarters(self, entries: Any) -> Any:
        """Return the means, halves, upper and lower entries of the pairs (..., 4, pairs)."""
        first, count = self.singles, self.pairs
        return entries[..., first:first + 4 * count].reshape(*entries.shape[:-1], 4, count)

    def laid_out(self, rows: Any) -> Any:
        """Return entries (..., entries) so laid out, of blocks row by row, one after the other."""
        found = np.array(rows)
        first, end = self.singles, self.singles + 4 * self.pairs
        a, b, c, d = np.moveaxis(
            np.asarray(rows)[..., first:end].reshape(*found.shape[:-1], self.pairs, 4), -1, 0)
        half = found.real.dtype.type(0.5)  # single precision stays it
        found[..., first:end] = np.concatenate([half * (a + d), half * (a - d), b, c], axis=-1)
        return found

    def block(self, entries: Any, place: int) -> Any:
        """Return the entries (..., size^2) of one block, row by row."""
        if place < self.singles:
            return entries[..., place:place + 1]
        if place < self.singles + self.pairs:
            mean, half, upper, lower = np.moveaxis(
                self._quarters(entries)[..., place - self.singles], -1, 0)
            return np.stack([mean + half, upper, lower, mean - half], axis=-1)
        return entries[..., self.larger[place - self.singles - self.pairs][2]]

    def norms(self, entries: ComplexArray) -> FloatArray:
        """Return the Frobenius norm of each block (..., blocks)."""
        squares = np.abs(entries) ** 2
        pairs = _TWO_TWICE @ self._quarters(squares)
        larger = [squares[..., there].sum(axis=-1, keepdims=True)
                  for _, _, there, _ in self.larger]
        return np.asarray(np.sqrt(np.concatenate(
            [squares[..., :self.singles], pairs, *larger], axis=-1)))

    def solved(self, entries: ComplexArray,
               remainder: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """
        Return the roots (..., n) of blocks, one after the other, and what they are off by.

        Parameters
        ----------
        entries : (..., entries) array
            Laid out so.
        remainder : (..., blocks) array
            Norm of what each block leaves out.

        """
        roots, quarters, s = self._small_blocks(entries)
        errors = np.empty(roots.shape)
        errors[..., :self.singles] = remainder[..., :self.singles]
        if self.pairs:
            self._note_errors_of_pairs(errors, remainder, quarters, s)
        for block, size, there, place in self.larger:
            found, condition = _eigenvalues(entries[..., there], size)
            roots[..., place] = found
            errors[..., place] = size * condition * remainder[..., block, None]
        return roots, errors

    def eigenvalues_of(self, entries: ComplexArray) -> ComplexArray:
        """Return the roots alone (..., n), as `solved` has them, for half of its time."""
        roots, _, _ = self._small_blocks(entries)
        for _, size, there, place in self.larger:
            roots[..., place] = np.linalg.eigvals(
                entries[..., there].reshape(*entries.shape[:-1], size, size))
        return roots

    def _small_blocks(self, entries: ComplexArray
                      ) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
        """
        Return the roots (..., n), those of larger blocks not yet among them, quarters and s.

        Those of pairs are mean +- s, s^2 = half^2 + upper lower.
        """
        roots = np.empty((*entries.shape[:-1], self.count), complex)
        first, end = self.singles, self.singles + 2 * self.pairs
        roots[..., :first] = entries[..., :first]
        quarters = self._quarters(entries)
        mean, half = quarters[..., 0, :], quarters[..., 1, :]
        s = np.sqrt(half * half + quarters[..., 2, :] * quarters[..., 3, :])
        roots[..., first:end:2], roots[..., first + 1:end:2] = mean - s, mean + s
        return roots, quarters, s

    def _note_errors_of_pairs(self, errors: FloatArray, remainder: FloatArray,
                              quarters: ComplexArray, s: ComplexArray) -> None:
        first, end = self.singles, self.singles + 2 * self.pairs
        left = remainder[..., first:first + self.pairs]
        change = left * (_ALL_BUT_MEAN @ np.abs(quarters) + left)  # of s^2
        off = left + np.minimum(np.sqrt(change), change / (np.abs(s) + _TINY))
        errors[..., first:end:2] = errors[..., first + 1:end:2] = off


def _eigenvalues(entries: ComplexArray, size: int) -> tuple[ComplexArray, FloatArray]:
    """Return the eigenvalues (..., m) of matrices (..., m^2), and the condition of each."""
    if entries.ndim > 1:
        found = [_eigenvalues(row, size) for row in entries.reshape(-1, size**2)]
        shape = (*entries.shape[:-1], size)
        return (np.array([one for one, _ in found], complex).reshape(shape),
                np.array([one for _, one in found]).reshape(shape))
    # LAPACK itself: a quarter of the time of eig and inv
    roots, left, right, failed = zgeev(entries.reshape(size, size))
    if failed:
        return roots, np.full(size, np.inf)
    return roots, 1.0 / (np.abs((left.conj() * right).sum(axis=0)) + _TINY)
