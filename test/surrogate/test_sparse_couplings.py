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
Tables of friction couples whose series say nothing of what they leave out: rings, sparse ones.

Of a ring of n couplings every term of a degree below n vanishes around mu = 0, though the
eigenvalues move. What a table answers has to be within its errors all the same, as they come from
full solutions.
"""

from collections.abc import Callable

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_cell import TableTolerances
from squeal_core.surrogate.table_domain import TableDomain
from support.engine_models import point

HERTZ = np.array([2e3, 2.6e3, 3.3e3, 4.1e3, 5e3])


def ring(size: int, generator: np.random.Generator) -> FloatArray:
    """Return a couple of each mode with the next alone, round to the first."""
    weights = generator.choice([-1.0, 1.0], size) * generator.uniform(0.5, 1.5, size)
    return np.roll(np.diag(weights), 1, axis=1)


def permuted(size: int, generator: np.random.Generator) -> FloatArray:
    """Rings of any lengths, no entry on the diagonal."""
    while True:
        order = generator.permutation(size)
        if not (order == np.arange(size)).any():
            return np.asarray(np.eye(size)[order] * generator.choice([-1.0, 1.0], size))


def nilpotent(size: int, generator: np.random.Generator) -> FloatArray:
    """Chains that lead nowhere: no eigenvalue moves."""
    return np.asarray(np.triu(generator.normal(size=(size, size)), 1))


def sparse(size: int, generator: np.random.Generator) -> FloatArray:
    """Return a few entries anywhere but on the diagonal."""
    couple = generator.normal(size=(size, size)) * (generator.random((size, size)) < 1.5 / size)
    np.fill_diagonal(couple, 0.0)
    return couple


def noisy(size: int, generator: np.random.Generator) -> FloatArray:
    """Return a ring in a full matrix of little: all terms are there, and say too little."""
    return ring(size, generator) + 10.0 ** generator.uniform(-6.0, -1.0) * generator.normal(
        size=(size, size))


def shifted(size: int, generator: np.random.Generator) -> FloatArray:
    """Return a ring of modes whose gaps change."""
    return ring(size, generator) + np.diag(generator.normal(size=size))


def coupled(hertz: FloatArray, couple: FloatArray, **arrays: FloatArray) -> BrakeModel:
    return BrakeModel(angular_frequencies=2.0 * np.pi * hertz, friction_couple=couple,
                      contact_area=0.005, nominal_contact_stiffness=1e10, **arrays)


def farthest_off(model: BrakeModel, highest_friction: float) -> tuple[float, float]:
    """
    Return the largest error of a table, over its own estimate, and how far eigenvalues move.

    The table is built from almost no friction on; it answers most points.
    """
    domain = TableDomain(rotor_speed=(19.0, 21.0), contact_pressure=(6e5, 8e5),
                         friction=(1e-6, highest_friction))
    table = build_table(model, domain, tolerances=TableTolerances())
    limits = Tolerances.of(model)
    x = domain.low + domain.width * np.random.default_rng(1).random((100, 3))
    points, found = domain.points(model, x), table.evaluate(x, limits)
    assert found.answered.mean() > 0.8
    worst = moved = 0.0
    at_rest = complex_modes(model, point(friction=0.0)).mode_eigenvalues
    listed = found.listed()
    for place in np.flatnonzero(found.answered).tolist():
        ours, truth = listed[place], complex_modes(model, points[place]).mode_eigenvalues
        away = np.abs(ours.mode_eigenvalues - truth[ours.numbers - 1])
        worst = max(worst, float((away / (ours.errors + 1e-6)).max()))
        moved = max(moved, float(np.abs(truth - at_rest).max()))
    return worst, moved


def test_a_ring_of_five_that_no_term_sees() -> None:
    """All terms to degree 3 vanish around mu = 0; the truth is 60 1/s away at mu = 0.2."""
    model = coupled(HERTZ, 0.05 * np.roll(np.eye(5), 1, axis=1))
    expansion = expand_spectrum(model, point(friction=0.0, friction_slope=0.0,
                                             contact_stiffness=1e10))
    assert np.abs(expansion.series[1:]).max() < 1e-6
    worst, moved = farthest_off(model, 0.2)
    assert worst <= 1.0
    assert moved > 50.0


@pytest.mark.parametrize(('kind', 'size'), [
    (ring, 8), (permuted, 6), (nilpotent, 5), (sparse, 8), (noisy, 5), (shifted, 3)])
def test_answers_are_within_their_errors(
        kind: Callable[[int, np.random.Generator], FloatArray], size: int) -> None:
    """Modes of 1.5 kHz and up, 200 to 1200 Hz apart, in any order."""
    generator = np.random.default_rng(size)
    hertz = generator.permutation(1500.0 + np.cumsum(generator.uniform(200.0, 1200.0, size)))
    couple = kind(size, generator) * 10.0 ** generator.uniform(-1.7, -0.9)
    assert farthest_off(coupled(hertz, couple), 0.2)[0] <= 1.0


def test_a_ring_of_two_coefficients() -> None:
    """Stiffness couples the one pair, friction the others: no coefficient alone has the ring."""
    couple, follower = np.roll(np.eye(5), 1, axis=1), np.zeros((5, 5))
    couple[2], follower[2, 3] = 0.0, 1e3
    worst, moved = farthest_off(coupled(HERTZ, 0.05 * couple, follower=follower), 0.2)
    assert worst <= 1.0
    assert moved > 0.1
