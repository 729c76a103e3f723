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
Estimates of series whose terms vanish: friction couples that form rings, and others as sparse.

Where the estimate accepts an answer the truth has to be within it, but for a small factor on
errors far below the tolerance.
"""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from support.engine_models import point

TOLERANCE = 0.1  # 1/s
NEGLIGIBLE = 0.05  # of what is tolerated: an estimate of less may be beaten


def ring(size: int, generator: np.random.Generator) -> FloatArray:
    """Return a couple of each mode with the next alone, round to the first."""
    couple = np.zeros((size, size))
    place = np.arange(size)
    couple[place, (place + 1) % size] = generator.choice([-1.0, 1.0], size) * generator.uniform(
        0.5, 1.5, size)
    return couple


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


def coupled(couple: FloatArray, generator: np.random.Generator) -> BrakeModel:
    """Modes of 1.5 kHz and up, 200 to 1200 Hz apart, in any order."""
    frequencies = 1500.0 + np.cumsum(generator.uniform(200.0, 1200.0, len(couple)))
    return BrakeModel(angular_frequencies=2.0 * np.pi * generator.permutation(frequencies),
                      friction_couple=couple)


def rubbing(friction: float) -> OperatingPoint:
    return point(friction=friction, friction_slope=0.0, contact_stiffness=1e10)


def errors(model: BrakeModel, anchor: SpectralExpansion,
           at: OperatingPoint) -> tuple[FloatArray, ...]:
    """Return true and estimated errors of the roots, and what is tolerated."""
    roots, estimates = (each[:, 0]
                        for each in anchor.eigenvalues(np.array(at.coefficients())[:, None]))
    every, truth = np.concatenate([roots, roots[anchor.mirrored].conj()]), eigenvalues(model, at)
    ours, theirs = linear_sum_assignment(np.abs(every[:, None] - truth))
    away = np.abs(every[ours] - truth[theirs])[:roots.size]
    return away, estimates, np.maximum(TOLERANCE, -0.02 * roots.real)


def test_a_ring_of_five_that_no_term_sees() -> None:
    """All terms to degree 3 vanish around mu = 0; the truth is 60 1/s away at mu = 0.2."""
    couple = 0.05 * np.roll(np.eye(5), 1, axis=1)
    model = BrakeModel(angular_frequencies=2.0 * np.pi * np.array([2e3, 2.6e3, 3.3e3, 4.1e3, 5e3]),
                       friction_couple=couple)
    anchor = expand_spectrum(model, rubbing(0.0))
    _, *higher = np.split(np.abs(anchor.series), [1])
    assert higher[0].max() < 1e-6
    away, estimates, _ = errors(model, anchor, rubbing(0.2))
    assert away.max() > 50.0
    assert np.all(away <= estimates)


@pytest.mark.parametrize('size', range(3, 9))
@pytest.mark.parametrize('kind', [ring, permuted, nilpotent, sparse, noisy, shifted])
def test_accepted_answers_are_within_their_estimates(kind: Any, size: int) -> None:
    generator = np.random.default_rng(size)
    accepted = 0
    for _ in range(8):
        model = coupled(kind(size, generator) * 10.0 ** generator.uniform(-3.0, -1.2), generator)
        start = float(generator.choice([0.0, 0.05, 0.2, 0.4]))
        anchor = expand_spectrum(model, rubbing(start))
        for step in 10.0 ** generator.uniform(-3.0, -0.1, 12):
            away, estimates, tolerated = errors(model, anchor, rubbing(
                start + float(step * generator.choice([-1.0, 1.0]))))
            if np.any(estimates > tolerated):
                continue
            accepted += 1
            assert np.all(away <= np.maximum(estimates, NEGLIGIBLE * tolerated))
    assert accepted > 20  # not by refusing all


def test_rings_longer_than_a_walk_is_looked_for_are_far_below() -> None:
    """What a ring of n couplings brings falls as the n-th power: nothing is left of 13."""
    generator = np.random.default_rng(0)
    model = coupled(0.02 * ring(13, generator), generator)
    anchor = expand_spectrum(model, rubbing(0.0))
    away, _, tolerated = errors(model, anchor, rubbing(0.3))
    assert np.all(away < 1e-3 * tolerated)


def test_a_ring_of_two_coefficients() -> None:
    """Stiffness couples the one pair, friction the others: no coefficient alone has the ring."""
    frequencies = 2.0 * np.pi * np.array([2e3, 2.6e3, 3.3e3, 4.1e3, 5e3])
    friction, follower = np.zeros((5, 5)), np.zeros((5, 5))
    for row in range(5):
        (follower if row == 2 else friction)[row, (row + 1) % 5] = 1.0
    model = BrakeModel(angular_frequencies=frequencies, friction_couple=0.05 * friction,
                       follower=1e3 * follower)
    anchor = expand_spectrum(model, rubbing(0.0))
    for step in (0.02, 0.05, 0.1, 0.2):
        away, estimates, tolerated = errors(model, anchor, rubbing(step))
        assert np.all(away <= np.maximum(estimates, NEGLIGIBLE * tolerated))
    assert away.max() > TOLERANCE


def test_a_full_matrix_has_no_floor(kang: BrakeModel) -> None:
    """Its terms show what they leave out: few blocks have a floor above the estimate."""
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    anchor = expand_spectrum(kang, start)
    steps = np.full((1, anchor.rows.size), 0.3)
    floor = anchor.floor.bound(steps)[0]
    assert np.count_nonzero(floor > 0.01 * TOLERANCE) <= 1
