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

"""The fast engine against the full solver: the same modes, whatever path leads to them."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
import gc
import threading
import time
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Tolerances
from squeal_core.surrogate import tabulated_solver as tabulation
from squeal_core.surrogate.expansion_builder import expand_spectrum, expansion_steps
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.steps import in_a_step, Steps
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from support.engine_models import near, point, random_model, random_point

SMALL = random_model(8, seed=3)
TOLERANCE = 0.1
# of the full solution, whose entries are up to 1e10
ROUNDING = 1e-4


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


def check(table: TabulatedSolver, points: Sequence[OperatingPoint]) -> float:
    """Compare all points with the full solver; the part that came from the table."""
    found = follow(table, points)
    for modes, at in zip(found, points, strict=True):
        compare(modes, complex_modes(table.model, at))
    return sum(modes.source == 'table' for modes in found) / len(found)


def walk(count: int, seed: int, *, step: float = 0.01) -> list[OperatingPoint]:
    """Neighbouring points, far away in the end."""
    generator, found = np.random.default_rng(seed), [point()]
    while len(found) < count:
        found.append(near(found[-1], step, generator))
    return found


# ---------------------------------------------------------------- accuracy

def test_random_points_of_the_whole_range(kang: BrakeModel) -> None:
    """benchmark/online_accuracy.py is the same over 20,000 points."""
    generator, table = np.random.default_rng(11), TabulatedSolver(kang)
    points = []
    for _ in range(15):
        start = random_point(generator, kang.contact_area)
        points += [start, *(near(start, float(step), generator)
                            for step in 10.0 ** generator.uniform(-2.7, -1.0, 19))]
    assert check(table, points) > 0.8
    assert table.statistics.tabulated + table.statistics.full == len(points)


def test_a_drive(kang: BrakeModel) -> None:
    speeds = np.linspace(25.0, 5.0, 60)
    points = [kang.operating_point(rotor_speed=speed, pressure=8e5 + 2e4 * np.sin(speed),
                                   friction=0.4 + 0.01 * np.cos(speed)) for speed in speeds]
    table = TabulatedSolver(kang)
    assert check(table, points) > 0.9
    assert table.statistics.made < 15
    again = TabulatedSolver(kang, anchors=table.anchors)
    found = follow(again, points)
    assert sum(modes.source == 'table' for modes in found) >= 54
    assert again.statistics.made <= 6


@pytest.mark.parametrize('delay', [0, 3])
@pytest.mark.parametrize('size', [1, 2, 8, 40])
def test_any_model(size: int, delay: int) -> None:
    table = TabulatedSolver(random_model(size, seed=size), SolverSettings(delay=delay))
    check(table, walk(60, seed=size))
    assert table.statistics.tabulated > 20
    table.close()


@pytest.mark.parametrize('name', ['gyroscopic', 'contact_stiffness', 'friction_couple',
                                  'radial_dissipation', 'negative_slope'])
def test_models_without_an_operator(name: str) -> None:
    table = TabulatedSolver(random_model(6, seed=1, **{name: None}))
    assert check(table, walk(30, seed=1)) > 0.5


def test_a_model_that_nothing_changes() -> None:
    table = TabulatedSolver(BrakeModel(angular_frequencies=np.array([1e3, 2e3])))
    assert check(table, [point(), point(friction=0.1), point(rotor_speed=150.0)]) == 1.0
    assert len(table.anchors) == 1


def test_coordinates_that_nothing_holds() -> None:
    """Roots at zero are exactly there, and rigid, whatever the errors of others."""
    shape = np.diag([0.0, 0.0, 1.0, 1.0])
    model = random_model(4, seed=2, angular_frequencies=[0.0, 0.0, 9e3, 2e4],
                         contact_stiffness=1e-2 * shape, friction_couple=None, gyroscopic=None)
    table = TabulatedSolver(model)
    check(table, walk(30, seed=2))
    found = table.complex_modes(point())
    assert [mode.kind for mode in found.modes[:2]] != ['flutter', 'flutter']
    assert np.count_nonzero(found.eigenvalues == 0.0) == 2


def test_errors_are_those_of_the_modes() -> None:
    table = TabulatedSolver(SMALL, SolverSettings())
    table.complex_modes(point())
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
        table = TabulatedSolver(SMALL, SolverSettings(delay=5), anchors=[anchor],
                                tolerances=Tolerances(oscillation=1.0, growth=float(limit)))
        assert table.covers(at) == (source == 'table')
        assert table.complex_modes(at).source == source
        table.close()


# ---------------------------------------------------------------- adversarial paths

def test_jumps_across_the_range_at_every_step() -> None:
    generator = np.random.default_rng(5)
    places = [random_point(generator, 0.0055) for _ in range(12)]
    table = TabulatedSolver(SMALL, SolverSettings(delay=2))
    points = [near(places[i % 12], 1e-3, generator) for i in range(200)]
    check(table, points)
    assert table.statistics.tabulated > 50
    table.close()


def flutter_pair() -> BrakeModel:
    """Two modes that merge at mu k_c = 5e9, and a third that is far away."""
    couple = np.zeros((3, 3))
    couple[0, 1], couple[1, 0] = 1e-3, -1e-3
    return BrakeModel(
        angular_frequencies=np.sqrt([1e8, 1.1e8, 9e8]), damping_ratios=1e-4,
        friction_couple=couple, contact_stiffness=np.diag([0.0, 0.0, 1e-3]))


@pytest.mark.parametrize('delay', [0, 4])
def test_an_exceptional_point_crossed_back_and_forth(delay: int) -> None:
    table = TabulatedSolver(flutter_pair(), SolverSettings(delay=delay))
    friction = 0.5 + 0.03 * np.sin(0.1 * np.arange(300))
    points = [point(friction=float(mu), contact_stiffness=1e10) for mu in friction]
    assert check(table, points) > 0.8
    kinds = {len(modes.unstable) for modes in follow(table, points)}
    assert kinds == {0, 1}
    table.close()


def test_a_slow_drift_along_a_boundary_of_flutter() -> None:
    """The worst mode stays within 0.3 1/s of zero all along, and no verdict is wrong."""
    model, points, points_at = flutter_pair(), [], np.linspace(0.8e10, 1.25e10, 120)
    for i, stiffness in enumerate(points_at):
        low, high = 0.3, 0.7
        for _ in range(45):  # bisection for the friction at which the growth rate is zero
            middle = 0.5 * (low + high)
            at = point(friction=middle, contact_stiffness=float(stiffness))
            grows = complex_modes(model, at).mode_eigenvalues.real.max() > 0.0
            low, high = (low, middle) if grows else (middle, high)
        points.append(point(friction=low * (1.0 + 1e-6 * (-1) ** i),
                            contact_stiffness=float(stiffness)))
    table = TabulatedSolver(model, SolverSettings(delay=2))
    check(table, points)
    for at in points:
        truth, found = complex_modes(model, at), table.complex_modes(at)
        assert abs(truth.mode_eigenvalues.real.max()) < 0.3
        if abs(truth.mode_eigenvalues.real.max()) > 0.01 + TOLERANCE:
            assert len(found.unstable) == len(truth.unstable)
    table.close()


# ---------------------------------------------------------------- determinism

@pytest.mark.parametrize('delay', [0, 1, 7])
def test_the_same_points_give_the_same_numbers(monkeypatch: pytest.MonkeyPatch,
                                               delay: int) -> None:
    """Bit for bit, however long the worker takes."""
    points, runs = walk(150, seed=9, step=0.02), []
    for pause in (0.0, 0.004, 0.0):
        def slowly(model: BrakeModel, at: OperatingPoint, pause: float = pause,
                   **settings: Any) -> 'Steps[SpectralExpansion]':
            yield partial(time.sleep, pause * (1.0 + np.cos(at.rotor_speed)))
            return (yield from expansion_steps(model, at, **settings))

        monkeypatch.setattr(tabulation, 'expansion_steps', slowly)
        table = TabulatedSolver(SMALL, SolverSettings(delay=delay, audit_every=10))
        found = follow(table, points)
        runs.append(([(modes.source, modes.eigenvalues.tobytes(), modes.errors.tobytes())
                      for modes in found], table.figures()))
        table.close()
    assert runs[0] == runs[1] == runs[2]
    assert runs[0][1]['tabulated'] > 20
    assert runs[0][1]['audits'] == runs[0][1]['tabulated'] // 10


def test_an_anchor_is_used_when_its_time_has_come() -> None:
    """No sooner than in its four steps, of which each solve is kept by one at most."""
    for delay, solves in ((1, 4), (4, 4), (6, 6)):
        table = TabulatedSolver(SMALL, SolverSettings(delay=delay))
        sources = [modes.source for modes in follow(table, 10 * [point()])]
        assert sources == solves * ['full'] + (10 - solves) * ['table']
        table.close()


@pytest.mark.parametrize(('brakes', 'solves'), [(1, 12), (2, 8), (3, 6), (4, 4), (6, 6)])
def test_where_all_is_solved_in_full_an_anchor_is_due_earlier(brakes: int, solves: int) -> None:
    """An anchor costs five full solves, and a tick waits for no more of it than one a brake."""
    table = TabulatedSolver(SMALL, SolverSettings(delay=100))
    sources = [modes.source for _ in range(16) for modes in table.complex_modes_of(
        [point(friction=0.42 + 1e-3 * brake) for brake in range(brakes)])]
    assert sources == solves * ['full'] + (16 * brakes - solves) * ['table']
    table.close()


@pytest.mark.parametrize('ratios', [
    {'rotor_speed': 1.004}, {'rotor_speed': 1 / 1.004, 'contact_pressure': 1.006},
    {'friction': 1 / 1.002, 'contact_pressure': 1.003, 'rotor_speed': 1 / 1.003}])
def test_a_steady_way_is_solved_in_full_at_its_beginning_only(
        kang: BrakeModel, ratios: dict[str, float]) -> None:
    """Anchors are there before the way leads out of those made so far."""
    delay = 10
    table = TabulatedSolver(kang, SolverSettings(delay=delay))
    points = [point(**{name: getattr(point(), name) * ratio**i for name, ratio in ratios.items()})
              for i in range(250)]
    found = follow(table, points)
    sources = [modes.source for modes in found]
    # with none made ahead ten for each; some remain where a verdict hangs on an error
    assert sources[delay:].count('full') <= 4 < delay * (table.statistics.made - 1)
    for modes, at in list(zip(found, points, strict=True))[::50]:
        compare(modes, complex_modes(kang, at))
    table.close()


def test_a_warm_table_asks_for_nothing() -> None:
    """On a way that stays where the table is."""
    cold = TabulatedSolver(SMALL, SolverSettings())
    turns = np.linspace(0.0, 4.0 * np.pi, 240)
    points = [point(rotor_speed=20.0 * np.exp(0.1 * np.cos(turn)),
                    contact_pressure=7e5 * np.exp(0.1 * np.sin(turn))) for turn in turns]
    follow(cold, points)
    warm = TabulatedSolver(SMALL, SolverSettings(delay=5, tolerance=1.0), anchors=cold.anchors,
                           tolerances=Tolerances(oscillation=1.0, growth=1e-2))
    assert {modes.source for modes in follow(warm, points)} == {'table'}
    assert (warm.statistics.made, warm.statistics.full) == (0, 0)
    assert not _workers()


# ---------------------------------------------------------------- memory

def far_apart(count: int) -> list[OperatingPoint]:
    return [point(rotor_speed=2.0 * 1.5**i, contact_stiffness=0.1e11 * 1.3**i)
            for i in range(count)]


def test_the_least_recently_used_anchors_make_room() -> None:
    places = far_apart(4)
    size = expand_spectrum(SMALL, places[0]).nbytes
    table = TabulatedSolver(SMALL, SolverSettings(memory=3.9 * size))
    follow(table, [places[0], places[1], places[2], places[0]])
    assert [table.covers(at) for at in places] == [True, True, True, False]
    table.complex_modes(places[3])
    assert [table.covers(at) for at in places] == [True, False, True, True]
    assert (len(table.anchors), table.statistics.dropped) == (3, 1)
    assert table.nbytes <= 3.9 * size


def test_memory_stays_bounded_and_the_newest_anchor_is_kept() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(memory=1.0))
    for at in far_apart(4):
        assert table.complex_modes(at).source == 'table'
        assert len(table.anchors) == 1


def test_memory_after_many_updates() -> None:
    generator = np.random.default_rng(8)
    limit = 10.5 * expand_spectrum(SMALL, point()).nbytes
    table = TabulatedSolver(SMALL, SolverSettings(memory=limit, delay=2))
    places = [random_point(generator, 0.0055) for _ in range(60)]
    for i in range(3000):
        table.complex_modes(places[(i // 5) % 60])
        assert table.nbytes <= limit
    assert table.statistics.dropped > 30
    assert len(table.anchors) < 40
    table.close()


# ---------------------------------------------------------------- audits and failures

def tampered(anchor: SpectralExpansion, by: float = 1e-4) -> SpectralExpansion:
    series = np.array(anchor.series)
    series[:, 0] *= 1.0 + by  # 1 1/s at 1e4 rad/s, ten times the tolerance
    return replace(anchor, series=series)


def test_an_audit_drops_an_anchor_that_is_wrong() -> None:
    wrong = tampered(expand_spectrum(SMALL, point()))
    table = TabulatedSolver(SMALL, SolverSettings(audit_every=3, delay=5), anchors=[wrong])
    first, second, audited, after = follow(table, 4 * [point()])
    truth = complex_modes(SMALL, point())
    assert (first.source, second.source, audited.source, after.source) == (
        'table', 'table', 'full', 'full')
    assert np.array_equal(audited.eigenvalues, truth.eigenvalues)
    assert np.abs(first.mode_eigenvalues - truth.mode_eigenvalues).max() > TOLERANCE
    statistics = table.statistics
    assert (statistics.audits, statistics.mismatches, statistics.dropped) == (1, 1, 1)
    assert statistics.worst_audit > 1.0
    table.close()
    assert table.anchors == ()


def test_an_audit_keeps_an_anchor_that_is_right() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(audit_every=1))
    found = follow(table, 10 * [point()])
    assert table.statistics.audits == table.statistics.tabulated == len(found)
    assert table.statistics.mismatches == 0
    assert table.statistics.worst_audit < ROUNDING / TOLERANCE
    assert TabulatedSolver(SMALL,
                           SolverSettings(audit_every=0)).complex_modes(point()).source == 'table'


@pytest.mark.parametrize('delay', [0, 2])
def test_no_eigensolution_where_an_anchor_should_be(monkeypatch: pytest.MonkeyPatch,
                                                    delay: int) -> None:
    """The full solver answers as long as there is none."""
    def fails(*_: Any, **__: Any) -> SpectralExpansion:
        raise np.linalg.LinAlgError('Singular matrix')

    monkeypatch.setattr(tabulation, 'expansion_steps', in_a_step(fails))
    table = TabulatedSolver(SMALL, SolverSettings(delay=delay))
    found = follow(table, 30 * [point()])
    truth = complex_modes(SMALL, point())
    assert all(np.array_equal(modes.eigenvalues, truth.eigenvalues) for modes in found)
    assert table.statistics.full == 30
    assert 0 < table.statistics.failed <= 30
    monkeypatch.undo()
    sources = [modes.source for modes in follow(table, 400 * [point()])]
    assert sources[-1] == 'table'
    table.close()


def test_on_an_exceptional_point() -> None:
    """No vectors span the space there: every answer is the full solver's or as good."""
    model = BrakeModel(angular_frequencies=np.zeros(2), damping_ratios=0.0,
                       gyroscopic=np.array([[0.0, 1.0], [-1.0, 0.0]]),
                       radial_dissipation=np.diag([1.0, -1.0]))
    points = [point(rotor_speed=10.0, friction=0.5, friction_slope=0.0,
                    contact_pressure=20.0 * r) for r in (10.0, 9.0, 10.0, 11.0, 10.0)]
    table = TabulatedSolver(model)
    for at, found in zip(points, follow(table, points), strict=True):
        r = at.contact_pressure / 20.0
        exact = max(np.emath.sqrt(r * r - 100.0).real, 0.0)
        # the square root of rounding, 1e-14, is all that an eigensolution gives there
        assert found.eigenvalues.real.max() == pytest.approx(exact, abs=1e-5)


# ---------------------------------------------------------------- threads

_OTHERS: set[threading.Thread] = set()  # of tests before, in this process


@pytest.fixture(autouse=True)
def _threads_of_others() -> None:
    _OTHERS.clear()
    _OTHERS.update(threading.enumerate())


def _workers() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate()
            if thread.name.startswith('anchors') and thread not in _OTHERS]


def _ended(threads: Sequence[threading.Thread]) -> bool:
    for thread in threads:
        thread.join(timeout=600.0)
    return not any(thread.is_alive() for thread in threads)


def test_no_thread_is_left_after_close() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(delay=2))
    follow(table, walk(20, seed=1, step=0.1))
    workers = _workers()
    assert len(workers) == 1
    table.close()
    assert _ended(workers)
    table.close()
    assert table.complex_modes(
        point(rotor_speed=150.0)).mode_eigenvalues.size == 8  # and it goes on
    table.close()
    assert not _workers()


def test_no_thread_is_left_without_close() -> None:
    table = TabulatedSolver(SMALL, SolverSettings(delay=2))
    follow(table, walk(20, seed=1, step=0.1))
    workers = _workers()
    assert workers
    del table
    gc.collect()
    assert _ended(workers)


def test_without_delay_there_is_no_thread() -> None:
    follow(TabulatedSolver(SMALL), walk(20, seed=1))
    assert not _workers()
