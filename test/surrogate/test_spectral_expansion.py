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
from squeal_core import BrakeModel
from squeal_core.surrogate.expansion_builder import expand_spectrum
from support.engine_models import companion_roots, near, point, random_model
from support.expansions import off, series_at, SINGLE

OPERATORS = ('gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
             'negative_slope')


# ---------------------------------------------------------------- any model

@pytest.mark.parametrize('size', [1, 2, 3, 60, 150])
def test_models_of_any_size(size: int) -> None:
    model, generator = random_model(size, seed=size), np.random.default_rng(size)
    expansion = expand_spectrum(model, point())
    assert expansion.sizes.sum() + expansion.mirrored.sum() == 2 * size
    for step in (0.001, 0.01, 0.03):
        at = near(point(), step, generator)
        roots, errors = series_at(expansion, at)
        away, truth = off(expansion, roots, companion_roots(model, at))
        counted = (truth.imag > 1.0) & np.isfinite(errors)
        assert counted.any()
        assert np.all(away[counted] <= np.maximum(1.5 * errors[counted], SINGLE))


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
    for step in (0.003, 0.02):
        at = near(point(), step, generator)
        roots, errors = series_at(expansion, at)
        away, truth = off(expansion, roots, companion_roots(model, at))
        counted = (truth.imag > 1.0) & np.isfinite(errors)
        assert counted.sum() >= size - 2
        assert np.all(away[counted] <= np.maximum(1.5 * errors[counted], SINGLE))
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
    roots, errors = series_at(expansion, at)
    away, _ = off(expansion, roots, companion_roots(model, at))
    assert errors.max() < 1.0
    assert np.all(away <= np.maximum(1.5 * errors, SINGLE))


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
    (roots, errors), (others, other_errors) = (series_at(a, at) for a in (first, second))
    ours, theirs = linear_sum_assignment(np.abs(roots[:, None] - others))
    assert np.abs(roots[ours] - others[theirs]).max() < SINGLE
    assert other_errors[theirs] == pytest.approx(errors[ours], rel=0.1, abs=SINGLE)


def test_many_points_at_once_are_each_of_them(kang: BrakeModel) -> None:
    expansion, generator = expand_spectrum(kang, point()), np.random.default_rng(1)
    points = [near(point(), step, generator) for step in (0.0, 0.01, 0.03, 0.1, 0.3)]
    roots, errors = expansion.eigenvalues(np.transpose([p.coefficients() for p in points]))
    for i, at in enumerate(points):
        alone = series_at(expansion, at)
        assert roots[:, i] == pytest.approx(alone[0], rel=1e-12, abs=1e-6)
        assert errors[:, i] == pytest.approx(alone[1], rel=1e-6)


def test_an_expansion_cannot_be_changed(kang: BrakeModel) -> None:
    expansion = expand_spectrum(kang, point())
    for array in (expansion.series, expansion.coupling_ratio, expansion.scales, expansion.rounding,
                  expansion.pair_remainder.rates, *expansion.term_norms):
        assert not array.flags.writeable
    assert 10_000 < expansion.nbytes < 1_000_000


# ---------------------------------------------------------------- roots alone

@pytest.mark.parametrize(('speed', 'friction', 'sizes'), [
    (2.0, 0.2, {1, 2, 3}), (5.0, 0.42, {1, 2, 4}), (20.0, 0.42, {1, 5})])
def test_roots_alone_are_those_with_errors(kang: BrakeModel, speed: float, friction: float,
                                           sizes: set[int]) -> None:
    """At many points at once, block by block: of larger blocks in whatever order."""
    start = kang.operating_point(rotor_speed=speed, pressure=7.84e5, friction=friction)
    expansion, generator = expand_spectrum(kang, start), np.random.default_rng(2)
    assert set(expansion.sizes.tolist()) == sizes
    points = np.array([near(start, 0.05, generator).coefficients() for _ in range(6)])
    alone, (roots, _) = expansion.eigenvalues_alone(points), expansion.eigenvalues_at(points)
    place = 0
    for size in expansion.sizes.tolist():
        ours, theirs = (np.sort_complex(found[:, place:place + size]) for found in (alone, roots))
        # of matrices of 1e5 1/s, and next to an exceptional point the root of that rounding
        np.testing.assert_allclose(ours, theirs, atol=1e-9 if size < 3 else 1e-5, rtol=0.0)
        place += size
    assert place == roots.shape[1]
