"""Products of powers of several variables, degree by degree: the bookkeeping of power series."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations_with_replacement
from typing import Any, TypeAlias

import numpy as np

from squeal_core.arrays import FloatArray

Term: TypeAlias = tuple[int, ...]  # the variables of a product, in ascending order: z0 z0 z2


@dataclass(frozen=True)
class Monomials:
    """All products of `variables` variables up to a degree, 1 first.

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
        """Where a term stands among those of its degree."""
        return tuple({term: i for i, term in enumerate(terms)} for terms in self.terms)

    @cached_property
    def count(self) -> int:
        return sum(len(terms) for terms in self.terms)

    @lru_cache  # noqa: B019 - few, and kept for good
    def factors(self, degree: int) -> tuple[tuple[int, int, int], ...]:
        """Return (term, variable, term of one degree less) for each variable a term contains."""
        return tuple(self._factors(degree))

    @lru_cache  # noqa: B019
    def products(self, first: int, second: int) -> tuple[tuple[int, int, int], ...]:
        """Return (term, term of degree `first`, of `second`): the term is their product."""
        return tuple(self._products(first, second))

    def _factors(self, degree: int) -> Iterator[tuple[int, int, int]]:
        for place, term in enumerate(self.terms[degree]):
            for variable in dict.fromkeys(term):
                rest = list(term)
                rest.remove(variable)
                yield place, variable, self.places[degree - 1][tuple(rest)]

    def _products(self, first: int, second: int) -> Iterator[tuple[int, int, int]]:
        for i, left in enumerate(self.terms[first]):
            for j, right in enumerate(self.terms[second]):
                yield self.places[first + second][tuple(sorted(left + right))], i, j

    @cached_property
    def _chain(self) -> tuple[tuple[Any, Any], ...]:
        """For each degree from 1: the term it grows from, and the variable that is added."""
        return tuple(
            (np.array([self.places[d - 1][term[:-1]] for term in self.terms[d]], dtype=np.intp),
             np.array([term[-1] for term in self.terms[d]], dtype=np.intp))
            for d in range(1, self.degree + 1))

    def __call__(self, values: FloatArray) -> list[FloatArray]:
        """Return the terms of each degree at points: (variables, P) -> (terms of d, P) each."""
        found = [np.ones((1, values.shape[1]))]
        for parent, variable in self._chain:
            found.append(found[-1][parent] * values[variable])
        return found
