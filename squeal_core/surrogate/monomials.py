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

"""Products of powers of several variables, degree by degree: the bookkeeping of power series."""

from dataclasses import dataclass
from functools import cache, cached_property
from itertools import combinations_with_replacement
from typing import TypeAlias

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray

Term: TypeAlias = tuple[int, ...]  # the variables of a product, in ascending order: z0 z0 z2


@dataclass(frozen=True)
class Monomials:
    """
    All products of `variables` variables up to a degree, 1 first.

    Parameters
    ----------
    variables : int
    degree : int

    """

    variables: int
    degree: int

    @cached_property
    def terms(self) -> tuple[tuple[Term, ...], ...]:
        """Terms of each degree, from 0."""
        return tuple(tuple(combinations_with_replacement(range(self.variables), d))
                     for d in range(self.degree + 1))

    @cached_property
    def places(self) -> tuple[dict[Term, int], ...]:
        """Return the place of each term among those of its degree."""
        return tuple({term: i for i, term in enumerate(terms)} for terms in self.terms)

    @cached_property
    def count(self) -> int:
        return sum(len(terms) for terms in self.terms)

    @cache  # noqa: B019 - few, and kept for good
    def products(self, first: int, second: int) -> tuple[tuple[int, int, int], ...]:
        """Return (term, term of degree `first`, of `second`): the term is their product."""
        return tuple((self.places[first + second][tuple(sorted(left + right))], i, j)
                     for i, left in enumerate(self.terms[first])
                     for j, right in enumerate(self.terms[second]))

    @cached_property
    def factors(self) -> IndexArray:
        """Places (degree, count) of the factors of each term among 1, z0, z1, ..."""
        every = [term for terms in self.terms for term in terms]
        return np.array([[term[i] + 1 if i < len(term) else 0 for term in every]
                         for i in range(self.degree)], np.intp).reshape(self.degree, self.count)

    def at(self, values: FloatArray) -> FloatArray:
        """Return all terms, degree by degree: (..., variables) -> (..., count)."""
        factors = np.ones((*values.shape[:-1], self.variables + 1))
        factors[..., 1:] = values
        return np.asarray(factors[..., self.factors].prod(axis=-2))
