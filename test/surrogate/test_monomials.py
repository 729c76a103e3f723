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

"""Products of powers against polynomials multiplied out by brute force."""

from collections import Counter
from itertools import product
from math import comb, prod

import numpy as np
import pytest
from squeal_core.surrogate.monomials import Monomials, Term

SIZES = [(variables, degree) for variables in range(7) for degree in range(5)]


def exponents(term: Term, variables: int) -> tuple[int, ...]:
    return tuple(term.count(i) for i in range(variables))


@pytest.mark.parametrize(('variables', 'degree'), SIZES)
def test_every_product_is_there_once(variables: int, degree: int) -> None:
    monomials = Monomials(variables, degree)
    for d, terms in enumerate(monomials.terms):
        every = {e for e in product(range(d + 1), repeat=variables) if sum(e) == d}
        assert len(terms) == len(every)
        assert {exponents(term, variables) for term in terms} == every
        assert [monomials.places[d][term] for term in terms] == list(range(len(terms)))
    assert monomials.count == comb(variables + degree, degree)
    assert monomials.terms[0] == ((),)
    if degree and variables:  # what expansions rely on: the terms of degree 1 are the variables
        assert monomials.terms[1] == tuple((i,) for i in range(variables))


@pytest.mark.parametrize(('variables', 'degree'), SIZES)
def test_values_are_products_of_powers(variables: int, degree: int) -> None:
    monomials = Monomials(variables, degree)
    values = np.random.default_rng(7).normal(size=(3, variables))
    values[2] = 0.0
    expected = [[prod(float(row[i]) for i in term) for terms in monomials.terms for term in terms]
                for row in values]
    np.testing.assert_allclose(monomials.at(values), expected, rtol=1e-13)  # of four factors


@pytest.mark.parametrize(('first', 'second'), [(0, 3), (1, 0), (1, 1), (1, 2), (2, 2), (3, 1)])
def test_products_multiply_polynomials(first: int, second: int) -> None:
    """The coefficients of a product are sums over `products`, as those of brute force."""
    monomials, generator = Monomials(3, first + second), np.random.default_rng(first)
    left, right = (generator.integers(-9, 9, len(monomials.terms[d])) for d in (first, second))
    expected: Counter[Term] = Counter()
    for (a, x), (b, y) in product(zip(monomials.terms[first], left, strict=True),
                                  zip(monomials.terms[second], right, strict=True)):
        expected[tuple(sorted(a + b))] += int(x * y)
    found: Counter[Term] = Counter()
    for term, i, j in monomials.products(first, second):
        found[monomials.terms[first + second][term]] += int(left[i] * right[j])
    assert found == expected
