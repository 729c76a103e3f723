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

"""Roots next to the verdict, solved for one by one in the full problem."""

from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, eigenvalues
from squeal_core.stability.eigenvectors import refined_eigenvalue
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver

REFINED = SolverSettings(tolerance=1.0, refines=True, audit_every=0)
WITHIN = 0.5  # 1/s
# of eigenvalues of 1e5 1/s in a matrix of 1e10, as other checks of the full solution have it
ROUNDING = 1e-4


def drawn(model: BrakeModel, generator: np.random.Generator) -> OperatingPoint:
    speed, pressure = np.exp(generator.uniform(np.log((1.0, 2e5)), np.log((150.0, 8e6)))).tolist()
    return model.operating_point(rotor_speed=speed, pressure=pressure,
                                 friction=generator.uniform(0.1, 0.7))


@pytest.mark.parametrize('seed', range(4))
def test_refined_roots_are_those_of_the_full_solution(kang: BrakeModel, seed: int) -> None:
    """From guesses as far off as the series may be, or the error says that it is another."""
    generator = np.random.default_rng(seed)
    for _ in range(6):
        point = drawn(kang, generator)
        roots = eigenvalues(kang, point)
        upper = roots[roots.imag > 1.0]
        for root in upper[np.argsort(np.abs(upper.real))[:5]].tolist():
            away = generator.uniform(-0.7, 0.7) + 1j * generator.uniform(-0.7, 0.7)
            found, error = refined_eigenvalue(kang, point, root + away)
            assert np.abs(upper - found).min() <= error + ROUNDING
            if np.sort(np.abs(upper - root))[1] > 3.0:  # the next one is farther than the guess
                assert abs(found - root) <= ROUNDING
                assert error < 1e-3


def test_a_guess_that_is_no_root_shows_in_the_error() -> None:
    """Half way between two modes that nothing couples, and at a double root."""
    apart = BrakeModel(angular_frequencies=[1000.0, 1010.0], damping_ratios=0.0)
    point = OperatingPoint(rotor_speed=10.0, friction=0.4, contact_pressure=1e5,
                           contact_stiffness=1e9)
    found, error = refined_eigenvalue(apart, point, 1005j)
    assert min(abs(found - 1000j), abs(found - 1010j)) <= max(error, 1e-9)
    double = BrakeModel(angular_frequencies=[1000.0, 1000.0], damping_ratios=0.0,
                        friction_couple=np.array([[0.0, 1e-3], [0.0, 0.0]]))
    found, error = refined_eigenvalue(double, point, 1000j + 0.3)
    assert abs(found - 1000j) <= error


def test_verdicts_across_the_boundary_without_full_solves(kang: BrakeModel) -> None:
    """
    Friction in steps of 2e-5 through a critical one: hardly any point is solved in full.

    The table may err by 1 1/s there, and by errors of that size nothing is decided within it.
    """
    base = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    critical = critical_value(kang, base, 'friction', (0.05, 0.9)).below
    assert critical is not None
    points = [replace(base, friction=critical.value + 2e-5 * i) for i in range(-40, 41)]
    refining = TabulatedSolver(kang, REFINED)
    plain = TabulatedSolver(kang, replace(REFINED, refines=False))
    sources = []
    for point in points:
        found, truth = refining.complex_modes(point, refined=WITHIN), complex_modes(kang, point)
        plain.complex_modes(point)
        assert [m.index for m in found.unstable] == [m.index for m in truth.unstable]
        close = np.abs(truth.mode_eigenvalues.real) < 0.4
        close &= truth.mode_eigenvalues.imag > 1.0
        np.testing.assert_allclose(found.mode_eigenvalues[close].real,
                                   truth.mode_eigenvalues[close].real, rtol=0.0,
                                   atol=2.0 * ROUNDING)
        sources.append(found.source)
    assert sources.count('refined') > 60
    assert sources.count('full') <= 2
    assert refining.statistics.full <= plain.statistics.full


def test_far_from_the_boundary_nothing_is_refined(kang: BrakeModel) -> None:
    table, far = TabulatedSolver(kang, REFINED), 0
    for friction in np.linspace(0.1, 0.6, 26).tolist():
        point = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=friction)
        roots = complex_modes(kang, point).mode_eigenvalues
        if np.abs(roots[roots.imag > 1.0].real).min() > 1.1:  # beyond the largest error
            assert table.complex_modes(point, refined=WITHIN).source == 'table'
            far += 1
    assert far > 2


def test_a_series_that_is_elsewhere_gives_way_to_the_full_solution(
        kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """A refined root beyond the series' error: its other roots are not believed either."""
    table = TabulatedSolver(kang, REFINED)
    base = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    critical = critical_value(kang, base, 'friction', (0.05, 0.9)).below
    assert critical is not None
    point = replace(base, friction=critical.value)
    assert table.complex_modes(point, refined=WITHIN).source == 'refined'
    monkeypatch.setattr('squeal_core.surrogate.tabulated_solver.refined_eigenvalue',
                        lambda model, at, guess: (guess + 2.0, 1e-9))
    found = table.complex_modes(point, refined=WITHIN)
    assert found.source == 'full'
    np.testing.assert_array_equal(found.mode_eigenvalues,
                                  complex_modes(kang, point).mode_eigenvalues)
