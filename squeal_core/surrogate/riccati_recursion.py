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

"""The power series of a spectrum's blocks, computed degree by degree."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from squeal_core.common.arrays import ComplexArray, IndexArray
from squeal_core.surrogate.monomials import Monomials

_COARSE = 2  # degree from which on single precision is enough: its terms are small corrections


class _LowerOrderTerms(NamedTuple):
    """Entries of each degree but the last, and the couplings and subspace that give those."""

    entries: list[ComplexArray]
    couplings: Any
    subspace: Any


@dataclass(frozen=True, eq=False)
class RiccatiRecursion:
    """The recursion over degrees; columns are the kept eigenvalues, block by block."""

    eigenvalues: ComplexArray
    couplings: ComplexArray
    blocks: Sequence[IndexArray]
    monomials: Monomials

    def _lower_terms(self) -> _LowerOrderTerms:
        """Return the blocks' entries (terms of d, entries) of each degree d below the last."""
        kept = np.concatenate(self.blocks)
        own = np.zeros((self.eigenvalues.size, kept.size), bool)
        column = 0
        for block in self.blocks:
            own[block, column:column + block.size] = True
            column += block.size
        gap = self.eigenvalues[:, None] - self.eigenvalues[kept]
        gap[own] = np.inf  # no component of X in its own block
        scale = -1.0 / gap
        start = np.zeros((1, self.eigenvalues.size, kept.size), complex)
        start[0, kept, np.arange(kept.size)] = 1.0
        couplings, subspace, result = self.couplings, [start], [self._entries(
            start * self.eigenvalues[kept])]
        if self.monomials.variables == 0:  # nothing depends on the operating point
            none = np.zeros((0, result[0].shape[1]), complex)
            return _LowerOrderTerms(result + self.monomials.degree * [none], couplings, start)
        for degree in range(1, self.monomials.degree):
            if degree == _COARSE:
                couplings, scale = couplings.astype(np.complex64), scale.astype(np.complex64)
            product = (self.couplings[:, :, kept] if degree == 1 else self._product(
                couplings, subspace[-1].astype(couplings.dtype), degree))
            result.append(self._entries(product))
            for i in range(1, degree):
                self._subtract(product, subspace[i], result[degree - i], i, degree - i)
            product *= scale  # in place: fresh memory costs as much as the product
            subspace.append(product)
        return _LowerOrderTerms(result, couplings, subspace[-1])

    def _product(self, couplings: Any, subspace: Any, degree: int) -> Any:
        """Return E (U + X) of a degree, from the subspace of one degree less."""
        count, size, columns = subspace.shape
        side = np.ascontiguousarray(subspace.transpose(1, 0, 2)).reshape(size, -1)
        product = np.zeros((len(self.monomials.terms[degree]), size, columns), subspace.dtype)
        moved = np.empty_like(side)
        for variable, coupling in enumerate(couplings):
            places = np.matmul(coupling, side, out=moved).reshape(size, count, columns)
            for term, factor, rest in self.monomials.products(1, degree - 1):
                if factor == variable:
                    product[term] += places[:, rest]
        return product

    def terms(self) -> list[ComplexArray]:
        """Return the blocks' entries (terms of d, entries) of each degree d."""
        lower = self._lower_terms()
        if self.monomials.variables == 0:
            return lower.entries
        return [*lower.entries, self._last_entries(lower.couplings, lower.subspace)]

    def _last_entries(self, couplings: Any, subspace: Any) -> Any:
        """Return the entries of the last degree: rows of the block alone are needed."""
        degree, parts, column = self.monomials.degree, [], 0
        single = sum(block.size == 1 for block in self.blocks)
        rows = np.concatenate(self.blocks[:single]) if single else np.zeros(0, np.intp)
        groups = [(rows, slice(0, single), 'rm,tmr->tr')]
        for block in self.blocks[single:]:
            first = max(column, single)
            column = first + block.size
            groups.append((block, slice(first, column), 'rm,tmc->trc'))
        for block, columns, formula in groups:
            side = subspace[:, :, columns]
            moved = [np.einsum(formula, e[block], side, optimize=formula[-1] == 'c')
                     for e in couplings]
            part = np.zeros((len(self.monomials.terms[degree]), *moved[0].shape[1:]), side.dtype)
            for term, variable, rest in self.monomials.products(1, degree - 1):
                part[term] += moved[variable][rest]
            parts.append(part.reshape(len(part), -1))
        return np.concatenate(parts, axis=1)

    def _entries(self, product: Any) -> Any:
        """Return the own-block entries (terms, entries) of (terms, M, kept)."""
        parts, column = [], 0
        for block in self.blocks:
            part = product[:, block, column:column + block.size]
            parts.append(part.reshape(len(product), -1))
            column += block.size
        return np.concatenate(parts, axis=1)

    def _subtract(self, product: Any, subspace: Any, entries: ComplexArray,
                  first: int, second: int) -> None:
        """Take X B of two degrees from the product."""
        sizes = np.array([block.size for block in self.blocks])
        single = int(np.searchsorted(sizes, 2))
        for term, i, j in self.monomials.products(first, second):
            product[term, :, :single] -= subspace[i, :, :single] * entries[j, :single]
        place, column = single, single
        for size in sizes[single:]:
            for term, i, j in self.monomials.products(first, second):
                block = entries[j, place:place + size**2].reshape(size, size)
                product[term, :, column:column + size] -= (
                    subspace[i, :, column:column + size] @ block)
            place, column = place + size**2, column + size
