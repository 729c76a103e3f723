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
from squeal_core.common.arrays import ComplexArray, IndexArray


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

    def eigenvalues(self, entries: ComplexArray) -> ComplexArray:
        """Return the eigenvalues (..., n) of blocks: of pairs mean +- sqrt(half^2 + b c)."""
        roots = np.empty((*entries.shape[:-1], self.count), complex)
        first, end = self.singles, self.singles + 2 * self.pairs
        roots[..., :first] = entries[..., :first]
        mean, half, upper, lower = np.moveaxis(self._quarters(entries), -2, 0)
        s = np.sqrt(half * half + upper * lower)
        roots[..., first:end:2], roots[..., first + 1:end:2] = mean - s, mean + s
        for _, size, there, place in self.larger:
            roots[..., place] = np.linalg.eigvals(
                entries[..., there].reshape(*entries.shape[:-1], size, size))
        return roots
