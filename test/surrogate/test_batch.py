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

"""Many points at once: the same modes as one by one, from few anchors."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.batch import BatchModes, BatchSolver, OperatingPoints
from squeal_core.surrogate.table_cell import TableTolerances


def around(model: BrakeModel, count: int, spread: float, seed: int = 0) -> OperatingPoints:
    """Points around one of a drive, all five parameters off."""
    ways = np.random.default_rng(seed).uniform(-spread, spread, (5, count))
    return OperatingPoints.of(
        rotor_speed=20.0 * np.exp(ways[0]), friction=0.42 * np.exp(ways[1]),
        contact_pressure=7e5 * np.exp(ways[2]), contact_stiffness=(
            model.nominal_contact_stiffness * np.exp(0.2 * ways[3])),
        friction_slope=-0.01 * np.exp(ways[4]))


def single(model: BrakeModel, points: OperatingPoints) -> ComplexArray:
    return np.array([complex_modes(model, points[i]).mode_eigenvalues for i in range(len(points))])


def check(found: BatchModes, expected: ComplexArray) -> None:
    """Within what each root is said to be off by, and rounding."""
    assert (np.abs(found.mode_eigenvalues - expected) <= found.errors + 1e-5).all()


def test_points_are_what_their_parameters_say(kang: BrakeModel) -> None:
    points = around(kang, 20, 0.5)
    assert len(points) == 20
    expected = np.array([points[i].coefficients() for i in range(20)]).T
    assert points.coefficients() == pytest.approx(expected, rel=1e-12)
    one = OperatingPoints.of(rotor_speed=5.0, friction=0.4, contact_pressure=1e5,
                             contact_stiffness=[1e10, 2e10])
    assert len(one) == 2
    assert one[1].contact_stiffness == 2e10
    with pytest.raises(ValueError, match='read-only'):
        one.friction[0] = 1.0


def test_a_cloud(kang: BrakeModel) -> None:
    solver, points = BatchSolver(kang), around(kang, 60, 0.1)
    found, expected = solver.modes(points), single(kang, points)
    check(found, expected)
    assert np.count_nonzero(found.full) < 30
    assert 1 <= len(solver.expansions) <= 8
    made = len(solver.expansions)
    again = solver.modes(points)  # what has been made serves
    assert np.count_nonzero(again.full) <= np.count_nonzero(found.full)
    assert len(solver.expansions) == made
    check(again, expected)


def test_contact_damping_and_damping_scales(kang: BrakeModel) -> None:
    """Points of one scale share expansions, whichever the others are."""
    damped = replace(kang, contact_retardation_time=8e-6)
    near = around(damped, 40, 0.05)
    points = replace(near, damping_scale=np.where(np.arange(40) % 2, 0.5, 1.0))
    solver = BatchSolver(damped)
    found, expected = solver.modes(points), single(damped, points)
    check(found, expected)
    assert {one.point.damping_scale for one in solver.expansions} == {0.5, 1.0}
    assert np.count_nonzero(found.full) < 20
    assert np.abs(expected - single(kang, points)).max() > 10.0  # 1/s, so damping counts


def test_scattered_points_are_solved_in_full(kang: BrakeModel) -> None:
    solver = BatchSolver(kang)
    points = around(kang, 6, 1.5)
    found = solver.modes(points)
    assert found.full.all()
    assert solver.expansions == []
    assert (found.mode_eigenvalues == single(kang, points)).all()
    assert (found.errors == 0.0).all()


def test_growth_in_a_band(kang: BrakeModel) -> None:
    points = around(kang, 40, 0.1, seed=1)
    found = BatchSolver(kang).modes(points)
    for band in ((1250.0, 16000.0), (3000.0, 4000.0)):
        growth, places = found.growth_rates(*band), found.least_stable(*band)
        for i in range(0, 40, 8):
            worst = complex_modes(kang, points[i]).least_stable(*band)[0]
            assert growth[i] == pytest.approx(worst.growth_rate, abs=0.1)  # the tolerance
            assert places[i] + 1 == worst.index
    assert (found.least_stable(2e5, 3e5) == -1).all()
    assert (found.growth_rates(2e5, 3e5) == -np.inf).all()


def real_roots_model(**changes: Any) -> BrakeModel:
    """Six modes: one without stiffness that diverges, one overdamped, two that flutter."""
    couple, slope = np.zeros((6, 6)), np.zeros((6, 6))
    couple[4, 5], couple[5, 4] = 2e-3, -2e-3
    slope[0, 0] = 1e-3
    return BrakeModel(**{
        'angular_frequencies': np.array([0.0, 400.0, 6e3, 9e3, 12.5e3, 12.9e3]),
        'damping_ratios': np.array([0.0, 2.0, 0.01, 0.01, 0.002, 0.002]),
        'friction_couple': couple, 'negative_slope': slope, 'nominal_contact_stiffness': 1e10,
        'radial_dissipation': 1e-8 * np.eye(6), **changes})


def test_modes_that_do_not_oscillate() -> None:
    model = real_roots_model()
    points = around(model, 60, 0.15)
    found = BatchSolver(model).modes(points)
    expected = single(model, points)
    check(found, expected)
    assert not found.full.all()
    assert (found.mode_eigenvalues[:, 0].imag == 0.0).all()
    assert (found.mode_eigenvalues[:, 0].real > 1e-2).any()


def test_verdicts_do_not_hang_on_errors() -> None:
    """Points within their error of the edge of growth are solved in full."""
    model = real_roots_model()
    solver = BatchSolver(model, errors=TableTolerances(growth=1e3, decay=10.0))
    points = around(model, 400, 0.5)
    found, expected = solver.modes(points), single(model, points)
    level = Tolerances.of(model).growth
    assert ((found.mode_eigenvalues.real > level) == (expected.real > level)).all()


def test_same_points_same_numbers(kang: BrakeModel) -> None:
    points = around(kang, 30, 0.1)
    first, second = (BatchSolver(kang).modes(points) for _ in range(2))
    assert (first.mode_eigenvalues == second.mode_eigenvalues).all()
    assert (first.errors == second.errors).all()
