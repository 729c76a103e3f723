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

"""The solver with a table against the full one: accuracy, verdicts, audits."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Tolerances
from squeal_core.surrogate.coverage import build_table
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from support.engine_models import near, point, random_model, random_point

SMALL = random_model(8, seed=3)
TOLERANCE = 0.1


def compare(found: ComplexModes, truth: ComplexModes) -> None:
    """Assert the same modes, in the same order and of the same kinds, as right as they say."""
    assert found.mode_eigenvalues.size == truth.mode_eigenvalues.size == found.errors.size
    away = np.abs(found.mode_eigenvalues - truth.mode_eigenvalues)
    # two modes of nearly one frequency may change places in the order
    for i in np.flatnonzero((away > TOLERANCE) & (truth.mode_eigenvalues.imag > 1.0)):
        around = truth.mode_eigenvalues[max(i - 1, 0):i + 2]
        away[i] = np.abs(found.mode_eigenvalues[i] - around).min()
        assert np.abs(np.diff(around.imag)).min() < 1.0
    counted = truth.mode_eigenvalues.imag > 1.0
    allowed = np.maximum(TOLERANCE, -0.02 * truth.mode_eigenvalues.real)
    assert np.all(away[counted] <= allowed[counted])
    for ours, theirs in zip(found.modes, truth.modes, strict=True):
        assert ours.index == theirs.index
        # within the tolerance of zero a verdict is open to both
        if abs(theirs.growth_rate) > TOLERANCE:
            assert ours.kind == theirs.kind
    assert len(found.eigenvalues) == len(truth.eigenvalues)


def follow(table: TabulatedSolver, points: Iterable[OperatingPoint]) -> list[ComplexModes]:
    return [table.complex_modes(at) for at in points]


def check(model: BrakeModel, points: Sequence[OperatingPoint]) -> float:
    """Compare a table over some points with the full solver; the fraction that it answers."""
    table = TabulatedSolver(model)
    build_table(table, points[::5])
    found = follow(table, points)
    for modes, at in zip(found, points, strict=True):
        compare(modes, complex_modes(model, at))
    assert table.statistics.tabulated + table.statistics.full == len(points)
    return sum(modes.source == 'table' for modes in found) / len(found)


def walk(count: int, seed: int, *, step: float = 0.01) -> list[OperatingPoint]:
    """Neighbouring points, far away in the end."""
    generator, found = np.random.default_rng(seed), [point()]
    while len(found) < count:
        found.append(near(found[-1], step, generator))
    return found


# ---------------------------------------------------------------- accuracy

def test_random_points_of_the_whole_range(kang: BrakeModel) -> None:
    generator = np.random.default_rng(11)
    points = []
    for _ in range(4):
        start = random_point(generator, kang.contact_area)
        points += [start, *(near(start, float(step), generator)
                            for step in 10.0 ** generator.uniform(-2.7, -1.0, 19))]
    assert check(kang, points) > 0.6


@pytest.mark.parametrize('size', [1, 2, 8, 40])
def test_any_model(size: int) -> None:
    assert check(random_model(size, seed=size), walk(40, seed=size)) > 0.5


@pytest.mark.parametrize('name', ['gyroscopic', 'contact_stiffness', 'friction_couple',
                                  'radial_dissipation', 'negative_slope'])
def test_models_without_an_operator(name: str) -> None:
    assert check(random_model(6, seed=1, **{name: None}), walk(30, seed=1)) > 0.5


def test_a_model_that_nothing_changes() -> None:
    model = BrakeModel(angular_frequencies=np.array([1e3, 2e3]))
    assert check(model, [point(), point(friction=0.1), point(rotor_speed=150.0)]) == 1.0


def test_coordinates_that_nothing_holds() -> None:
    """Roots at zero are exactly there, and rigid, whatever the errors of others."""
    shape = np.diag([0.0, 0.0, 1.0, 1.0])
    model = random_model(4, seed=2, angular_frequencies=[0.0, 0.0, 9e3, 2e4],
                         contact_stiffness=1e-2 * shape, friction_couple=None, gyroscopic=None)
    found = TabulatedSolver(
        model, anchors=[expand_spectrum(model, point())]).complex_modes(point())
    assert found.source == 'table'
    assert [mode.kind for mode in found.modes[:2]] != ['flutter', 'flutter']
    assert np.count_nonzero(found.eigenvalues == 0.0) == 2


def test_errors_are_those_of_the_modes() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(), anchors=[expand_spectrum(SMALL, point())])
    at = near(point(), 0.01, np.random.default_rng(0))
    found = table.complex_modes(at)
    assert found.source == 'table'
    roots, errors = table.anchors[0].eigenvalues(np.array(at.coefficients())[:, None])
    for root, error in zip(found.mode_eigenvalues, found.errors, strict=True):
        assert errors[np.flatnonzero(roots[:, 0] == root), 0].tolist() == [error]
    assert found.errors.max() <= TOLERANCE
    assert complex_modes(SMALL, at).errors.tolist() == [0.0] * 8
    assert complex_modes(SMALL, at).source == 'full'


def test_no_verdict_hangs_on_an_error() -> None:
    """Where a growth rate is within its error of the limit, the full solver answers."""
    anchor, at = expand_spectrum(SMALL, point()), near(point(), 0.008, np.random.default_rng(1))
    roots, errors = (values[:, 0] for values in anchor.eigenvalues(
        np.array(at.coefficients())[:, None]))
    place = int(errors.argmax())
    assert 1e-3 < errors[place] < TOLERANCE
    for limit, source in ((roots[place].real + 0.5 * errors[place], 'full'),
                          (roots[place].real - 0.5 * errors[place], 'full'),
                          (roots.real.max() + 1.0, 'table')):
        table = TabulatedSolver(SMALL, SolverSettings(), anchors=[anchor],
                                tolerances=Tolerances(oscillation=1.0, growth=float(limit)))
        assert table.covers(at) == (source == 'table')
        assert table.complex_modes(at).source == source


def flutter_pair() -> BrakeModel:
    """Two modes that merge at mu k_c = 5e9, and a third that is far away."""
    couple = np.zeros((3, 3))
    couple[0, 1], couple[1, 0] = 1e-3, -1e-3
    return BrakeModel(
        angular_frequencies=np.sqrt([1e8, 1.1e8, 9e8]), damping_ratios=1e-4,
        friction_couple=couple, contact_stiffness=np.diag([0.0, 0.0, 1e-3]))


def test_an_exceptional_point_crossed_back_and_forth() -> None:
    friction = 0.5 + 0.03 * np.sin(0.1 * np.arange(100))
    points = [point(friction=float(mu), contact_stiffness=1e10) for mu in friction]
    assert check(flutter_pair(), points) > 0.8


def test_on_an_exceptional_point() -> None:
    """No vectors span the space there: every answer is the full solver's or as good."""
    model = BrakeModel(angular_frequencies=np.zeros(2), damping_ratios=0.0,
                       gyroscopic=np.array([[0.0, 1.0], [-1.0, 0.0]]),
                       radial_dissipation=np.diag([1.0, -1.0]))
    points = [point(rotor_speed=10.0, friction=0.5, friction_slope=0.0,
                    contact_pressure=20.0 * r) for r in (10.0, 9.0, 10.0, 11.0, 10.0)]
    table = TabulatedSolver(model)
    build_table(table, points)
    for at, found in zip(points, follow(table, points), strict=True):
        r = at.contact_pressure / 20.0
        exact = max(np.emath.sqrt(r * r - 100.0).real, 0.0)
        # the square root of rounding, 1e-14, is all that an eigensolution gives there
        assert found.eigenvalues.real.max() == pytest.approx(exact, abs=1e-5)


# ---------------------------------------------------------------- audits

def tampered(anchor: SpectralExpansion, by: float = 1e-4) -> SpectralExpansion:
    series = np.array(anchor.series)
    series[:, 0] *= 1.0 + by  # 1 1/s at 1e4 rad/s, ten times the tolerance
    return replace(anchor, series=series)


def test_an_audit_drops_an_anchor_that_is_wrong() -> None:
    wrong = tampered(expand_spectrum(SMALL, point()))
    table = TabulatedSolver(SMALL, SolverSettings(audit_every=3), anchors=[wrong])
    first, second, audited, after = follow(table, 4 * [point()])
    truth = complex_modes(SMALL, point())
    assert (first.source, second.source, audited.source, after.source) == (
        'table', 'table', 'full', 'full')
    assert np.array_equal(audited.eigenvalues, truth.eigenvalues)
    assert np.abs(first.mode_eigenvalues - truth.mode_eigenvalues).max() > TOLERANCE
    assert (table.statistics.audits, table.statistics.mismatches) == (1, 1)
    assert table.statistics.worst_audit > 1.0
    assert table.anchors == ()


def test_an_audit_keeps_an_anchor_that_is_right() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(audit_every=1),
                            anchors=[expand_spectrum(SMALL, point())])
    found = follow(table, 10 * [point()])
    assert table.statistics.audits == table.statistics.tabulated == len(found)
    assert table.statistics.mismatches == 0
    assert table.statistics.worst_audit < 1e-3
