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

"""How the error of an expansion grows with the step, and whether its estimate is honest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from support.engine_models import between, near, point, random_model, random_point
from support.expansions import off, series_at, SINGLE, whole


@pytest.mark.parametrize('degree', [3, 4, 5])
@pytest.mark.parametrize('which', ['kang', 'blocks'])
def test_errors_fall_with_the_step(kang: BrakeModel, degree: int, which: str) -> None:
    """
    Error ~ step^(degree + 1): single modes, pairs and larger blocks.

    Of a block the mean of its roots is what a power series holds; the roots themselves may merge.
    """
    model, start, floor = {
        'kang': (kang, kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42),
                 10.0 * SINGLE),
        'blocks': (random_model(14, seed=1), point(), 0.1 * SINGLE)}[which]
    expansion = expand_spectrum(model, start, degree=degree)
    end = replace(start, rotor_speed=22.0, friction=0.40, contact_stiffness=0.357e11,
                  contact_pressure=1.08 * start.contact_pressure)
    steps = 1.25 ** np.arange(8, -8, -1)
    away = np.transpose([off_means(expansion, model, between(start, end, step)) for step in steps])
    rates: dict[int, list[float]] = {1: [], 2: [], 3: []}
    for size, line in zip(expansion.sizes, away, strict=True):
        # where the series converges, and its error is more than single precision
        used = np.flatnonzero((line > floor) & (line < 0.1))[-5:]
        if used.size >= 4:
            rates[min(size, 3)].append(np.polyfit(np.log(steps[used]), np.log(line[used]), 1)[0])
    for size in (1,) if which == 'kang' else (1, 2, 3):
        of_size = rates[size]
        # where the first term that is left out happens to be small the line bends
        assert sum(rate < degree + 0.4 for rate in of_size) <= 0.05 * len(of_size)
        assert degree + 0.6 < np.median(of_size) < degree + 2.0


def off_means(expansion: SpectralExpansion, model: BrakeModel, at: OperatingPoint) -> FloatArray:
    """Return how far the mean of each block's roots is from that of the truth."""
    roots, _ = series_at(expansion, at)
    truth = eigenvalues(model, at)
    every = whole(expansion, roots)
    _, theirs = linear_sum_assignment(np.abs(every[:, None] - truth))
    ends = np.cumsum(expansion.sizes) - expansion.sizes
    return np.abs(np.add.reduceat(roots - truth[theirs[:roots.size]], ends)) / expansion.sizes


@pytest.mark.parametrize('degree', [3, 4, 6])
def test_rate_of_a_single_mode_in_closed_form(degree: int) -> None:
    """Expand w -> sqrt(w^2 + k a - (d/2)^2): its series in k is known, and the error's rate."""
    model = BrakeModel(angular_frequencies=[1e3], contact_stiffness=[[1.0]])
    expansion = expand_spectrum(model, point(contact_stiffness=2e6), degree=degree)

    def error(step: float) -> float:
        k = 2e6 + step * 2e6
        exact = -2.0 + 1j * np.sqrt(1e6 + k - 4.0)
        (root,), _ = series_at(expansion, point(contact_stiffness=k))
        return float(abs(root - exact))

    large, small = error(0.4), error(0.2)
    assert small > 1e-6  # no rounding
    # the ratio of successive errors is 2^(degree + 1), less a part in the step
    assert np.log2(large / small) == pytest.approx(degree + 1.0, abs=0.35)


@pytest.mark.parametrize('seed', [1, 2])
def test_errors_are_honest(kang: BrakeModel, seed: int) -> None:
    """
    Over the whole range, expanded up to 30 % away in every parameter.

    The estimate is none of all that could be: of roots that oscillate one in 200 is off by more,
    all but a few of them where no answer would come of it. Where one would, the estimate of no
    root is beaten by half. Closely spaced roots that decay at 2e4 1/s without oscillating are the
    known exception: their error estimate counts for nothing, and nothing hangs on them.
    """
    generator = np.random.default_rng(seed)
    larger = beaten = answered = 0
    for _ in range(12):
        start = random_point(generator, kang.contact_area)
        expansion = expand_spectrum(kang, start)
        for step in 10.0 ** generator.uniform(-2.5, -0.5, 6):
            at = near(start, float(step), generator)
            roots, errors = series_at(expansion, at)
            away, truth = off(expansion, roots, eigenvalues(kang, at))
            counted = (truth.imag > 1.0) & (away > SINGLE)
            larger += int(counted.sum())
            beaten += int(np.count_nonzero(away[counted] > errors[counted]))
            if np.all(errors <= np.maximum(0.1, -0.02 * roots.real)):
                answered += 1
                assert np.all(away[counted] <= 1.5 * errors[counted])
                # what a tolerance of 0.1 1/s is for
                growing = truth.real > -5.0
                assert away[growing & (truth.imag > 1.0)].max(initial=0.0) < 0.1
    assert answered > 24
    assert larger > 500
    assert beaten <= 0.005 * larger + 1


def test_far_away_the_error_is_not_finite(kang: BrakeModel) -> None:
    expansion = expand_spectrum(kang, point())
    for far in (point(rotor_speed=200.0), point(contact_stiffness=0.1e11), point(friction=0.9),
                point(rotor_speed=1e6, contact_pressure=1e9)):
        assert series_at(expansion, far)[1].max() == np.inf


def test_at_its_centre_it_is_the_full_solution(kang: BrakeModel) -> None:
    expansion = expand_spectrum(kang, point())
    roots, errors = series_at(expansion, point())
    away, _ = off(expansion, roots, eigenvalues(kang, point()))
    assert away.max() < 1e-4  # rounding of both, of matrices with entries of 1e10
    assert errors.max() < 1e-3


def test_reach_is_where_errors_are_a_tenth(kang: BrakeModel) -> None:
    """A step of the reach in a single coefficient costs about 0.1 1/s, within its order."""
    expansion = expand_spectrum(kang, point())
    for row, reach in zip(expansion.rows, expansion.trust_radius, strict=True):
        if expansion.centre[expansion.rows.tolist().index(row)] == 0.0 or reach > 1e10:
            continue
        moved = np.array(point().coefficients())[:, None]
        moved[row] += 0.3 * reach
        assert 0.0 < expansion.eigenvalues(moved)[1].min() < 0.1
