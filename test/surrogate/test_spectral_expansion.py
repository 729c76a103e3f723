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

"""Expansions of any model, at any points, with and without their errors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from support.eigenvalues import companion_roots, distance
from support.engine_models import between, near, point, random_model
from support.expansions import off, series_at, SINGLE, whole

OPERATORS = ('gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
             'negative_slope')


# ---------------------------------------------------------------- any model

@pytest.mark.parametrize('size', [1, 2, 3, 60, 150])
def test_models_of_any_size(size: int) -> None:
    model, generator = random_model(size, seed=size), np.random.default_rng(size)
    expansion = expand_spectrum(model, point())
    assert expansion.sizes.sum() + expansion.mirrored.sum() == 2 * size
    for step, most in ((0.001, SINGLE), (0.01, SINGLE), (0.03, 0.01)):
        at = near(point(), step, generator)
        away, truth = off(expansion, series_at(expansion, at), companion_roots(model, at))
        assert np.count_nonzero(truth.imag > 1.0) == size
        assert np.all(away[truth.imag > 1.0] < most)


@pytest.mark.parametrize('changes', [
    *(pytest.param({name: None}, id=f'no {name}') for name in OPERATORS),
    pytest.param(dict.fromkeys(OPERATORS[:4]), id='slope alone'),
    pytest.param(dict.fromkeys(OPERATORS), id='nothing'),
    pytest.param({'follower': 1e-6}, id='follower'),
    pytest.param({'support_stiffness': 1e6, 'support_damping': 3.0}, id='supports'),
    pytest.param({'contact_retardation_time': 8e-6}, id='contact damping'),
    pytest.param({'gyroscopic': 0.0}, id='zeros')])
def test_models_without_or_with(changes: dict[str, Any]) -> None:
    size, generator = 12, np.random.default_rng(3)
    shapes = generator.normal(size=(size, size))
    symmetric = shapes @ shapes.T / size
    arrays = {name: scale if scale is None or name.endswith('time') else scale * (
        shapes if name == 'follower' else symmetric) for name, scale in changes.items()}
    model = random_model(size, seed=4, **arrays)
    expansion = expand_spectrum(model, point())
    for step, most in ((0.003, SINGLE), (0.02, 0.01)):
        at = near(point(), step, generator)
        away, truth = off(expansion, series_at(expansion, at), companion_roots(model, at))
        counted = truth.imag > 1.0
        assert counted.sum() >= size - 2
        assert np.all(away[counted] < most)
    assert expansion.rows.size == (
        0 if changes.keys() >= set(OPERATORS) else expansion.centre.size)
    assert expansion.rows.max(initial=0) < 6  # contact damping adds no variable to the series


@pytest.mark.parametrize('changes', [
    {'friction': 0.0}, {'friction_slope': 0.0}, {'contact_pressure': 0.0},
    {'contact_stiffness': 0.0}, {'rotor_speed': -20.0, 'friction': -0.42}])
def test_points_where_a_coefficient_vanishes_or_is_negative(changes: dict[str, float]) -> None:
    model, start = random_model(12, seed=5), point(**changes)
    expansion = expand_spectrum(model, start)
    at = replace(start, rotor_speed=1.002 * start.rotor_speed,
                 friction_slope=start.friction_slope + 1e-4)
    away, _ = off(expansion, series_at(expansion, at), companion_roots(model, at))
    assert np.all(away < SINGLE)


def turned(model: BrakeModel, angle: float) -> BrakeModel:
    """Return the brake with the cos and sin shapes of every doublet turned into each other."""
    w, turn, i = model.angular_frequencies, np.eye(model.size), 0
    while i + 1 < model.size:
        if w[i] > 0.0 and abs(w[i + 1] - w[i]) < 1e-9 * w[i]:
            c, s = np.cos(angle * (i + 1)), np.sin(angle * (i + 1))
            turn[i:i + 2, i:i + 2] = [[c, -s], [s, c]]
            i += 1
        i += 1
    assert not np.array_equal(turn, np.eye(model.size))
    return replace(model, provenance={}, **{
        name: turn.T @ getattr(model, name) @ turn for name in OPERATORS})


def test_the_orientation_of_doublets_does_not_matter(kang: BrakeModel) -> None:
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    first, second = expand_spectrum(kang, start), expand_spectrum(turned(kang, 0.7), start)
    assert first.sizes.tolist() == second.sizes.tolist()
    at = replace(start, rotor_speed=21.0, friction=0.41)
    assert distance(*(series_at(expansion, at) for expansion in (first, second))) < SINGLE


def test_at_its_centre_it_is_the_full_solution(kang: BrakeModel) -> None:
    expansion = expand_spectrum(kang, point())
    away, _ = off(expansion, series_at(expansion, point()), eigenvalues(kang, point()))
    assert away.max() < 1e-4  # rounding of both, of matrices with entries of 1e10


@pytest.mark.parametrize(('speed', 'friction', 'sizes'), [
    (2.0, 0.2, {1, 2, 3}), (5.0, 0.42, {1, 2, 4}), (20.0, 0.42, {1, 5})])
def test_many_points_at_once_are_each_of_them(kang: BrakeModel, speed: float, friction: float,
                                              sizes: set[int]) -> None:
    """Singles and pairs in order, eigenvalues of larger blocks in whatever order."""
    start = kang.operating_point(rotor_speed=speed, pressure=7.84e5, friction=friction)
    expansion, generator = expand_spectrum(kang, start), np.random.default_rng(1)
    assert set(expansion.sizes.tolist()) == sizes
    points = [near(start, step, generator) for step in (0.0, 0.01, 0.03, 0.1, 0.3)]
    together = expansion.eigenvalues(np.array([at.coefficients() for at in points]))
    for found, at in zip(together, points, strict=True):
        # next to an exceptional point an eigenvalue is the root of its rounding
        np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(
            series_at(expansion, at)), rtol=1e-12, atol=1e-5)


def test_an_expansion_cannot_be_changed(kang: BrakeModel) -> None:
    expansion = expand_spectrum(kang, point())
    for array in (expansion.series, expansion.scales, expansion.centre, expansion.mirrored):
        assert not array.flags.writeable


# ---------------------------------------------------------------- rates of the error

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
    roots = series_at(expansion, at)
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
        (root,) = series_at(expansion, point(contact_stiffness=k))
        return float(abs(root - exact))

    large, small = error(0.4), error(0.2)
    assert small > 1e-6  # no rounding
    # the ratio of successive errors is 2^(degree + 1), less a part in the step
    assert np.log2(large / small) == pytest.approx(degree + 1.0, abs=0.35)
