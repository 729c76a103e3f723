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

"""Anchors laid down beforehand, by the library and by the command."""

from dataclasses import replace
from itertools import islice
import json
from pathlib import Path
import signal
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.common.errors import OperatingPointError
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.coverage import (
    braking_points,
    build_table,
    covered,
    Envelope,
    random_places,
)
from squeal_core.surrogate.table_file import read_table, read_table_header
from squeal_core.surrogate.tabulated_solver import TabulatedSolver
from squeal_ros.cli.main import main
from support.engine_models import point, random_model

MODEL = random_model(5, seed=6, caliper=Caliper(2.5e-3), friction_law=FrictionLaw(),
                     friction_table=FrictionTable((300.0, 500.0), (0.42, 0.40)))
ENVELOPE = Envelope(rotor_speed=(10.0, 20.0), contact_pressure=(5e5, 8e5), friction=(0.38, 0.44),
                    friction_slope=(-0.05, 0.0), contact_stiffness=(0.34e11, 0.36e11))
RANGES = ('--rotor-speed', '10', '20', '--pressure', '1e6', '2e6', '--friction', '0.38', '0.44')


@pytest.fixture(autouse=True)
def _signals() -> Any:
    """Set back what SIGTERM does, which `main` sets."""
    before = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.fixture(scope='module')
def model_path(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp('models') / 'small.npz'
    MODEL.save(path)
    return str(path)


# ---------------------------------------------------------------- the envelope

def test_points_fill_the_ranges() -> None:
    points = list(islice(ENVELOPE.points(MODEL, random_places(1)), 2000))
    for name, (low, high) in ENVELOPE.ranges.items():
        values = np.array([getattr(at, name) for at in points])
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high >= values.max() > high - 0.01 * (high - low)
        middle = np.sqrt(low * high) if name in (
            'rotor_speed', 'contact_pressure', 'contact_stiffness') else 0.5 * (low + high)
        # half of the points on either side, to four deviations of a count
        assert np.mean(values < middle) == pytest.approx(0.5, abs=0.045)


def test_the_corners() -> None:
    low, high = ENVELOPE.points(MODEL, [np.zeros(5), np.ones(5)])
    for name, ends in ENVELOPE.ranges.items():
        assert (getattr(low, name), getattr(high, name)) == pytest.approx(ends, rel=1e-12)


def test_what_is_not_given_follows_the_model() -> None:
    lining = replace(MODEL, stiffness_table=StiffnessTable((5e5, 8e5), (1e10, 4e10)))
    free = replace(ENVELOPE, friction_slope=None, contact_stiffness=None)
    for at in islice(free.points(lining, random_places(2)), 20):
        assert at.contact_stiffness == lining.contact_stiffness_at(at.contact_pressure)
        assert at.friction_slope == FrictionLaw().slope_at(
            lining.contact_radius * at.rotor_speed, at.friction)
    for at in islice(free.points(replace(MODEL, friction_law=None), random_places(2)), 5):
        assert at.friction_slope == 0.0


@pytest.mark.parametrize(('changes', 'part'), [
    ({'rotor_speed': (20.0, 10.0)}, 'rotor_speed: 20 to 10 is no range; give the lower end'),
    ({'friction': (0.0, 0.4)}, 'friction: 0 to 0.4 is no range'),
    ({'contact_pressure': (1e5, np.inf)}, 'contact_pressure: 100000 to inf is no range'),
    ({'contact_stiffness': (np.nan, 1e10)}, 'contact_stiffness: nan to 1e'),
    ({'friction_slope': (0.1, -0.1)}, 'friction_slope: 0.1 to -0.1')])
def test_ranges_that_are_none(changes: dict[str, Any], part: str) -> None:
    with pytest.raises(OperatingPointError, match=part):
        replace(ENVELOPE, **changes)
    assert replace(ENVELOPE, friction=(0.4, 0.4)).friction == (0.4, 0.4)


# ---------------------------------------------------------------- laying down

def test_what_was_laid_down_covers_other_points() -> None:
    table = TabulatedSolver(MODEL)
    summary = build_table(table, ENVELOPE.points(MODEL, random_places(0)), coverage=0.9)
    assert summary.complete
    assert summary.points >= 1000
    tests = list(islice(ENVELOPE.points(MODEL, random_places(1)), 300))
    share = covered(table, tests, 300)
    # 0.9, less three deviations of a count of 300
    assert share > 0.85
    answered = [at for at in tests if table.covers(at)]
    assert len(answered) == round(300 * share)
    for at in answered[::20]:
        found, truth = table.complex_modes(at), complex_modes(MODEL, at)
        assert found.source == 'table'
        assert np.abs(found.mode_eigenvalues - truth.mode_eigenvalues).max() <= max(
            0.1, 1.5 * found.errors.max())


def test_covered_points_need_no_anchor() -> None:
    table = TabulatedSolver(MODEL)
    calls: list[tuple[int, int]] = []
    summary = build_table(table, 5 * [point()] + 5 * [point(contact_stiffness=1e10)],
                          progress=lambda *figures: calls.append(figures))
    assert (len(table.anchors), summary.points, summary.undecided) == (2, 10, 0)
    assert calls == [(1, i) for i in range(1, 6)] + [(2, i) for i in range(6, 11)]


@pytest.mark.parametrize('limits', [{'most': 3}, {'memory': 3.5}])
def test_it_ends_at_its_limits(limits: dict[str, float]) -> None:
    size = TabulatedSolver(MODEL)
    build_table(size, [point()])
    table = TabulatedSolver(MODEL)
    points = [point(rotor_speed=2.0 * 2.0**i) for i in range(8)]
    memory = limits.pop('memory', 1e3) * size.nbytes
    summary = build_table(table, points, memory=memory, **limits)  # type: ignore[arg-type]
    assert not summary.complete
    assert len(table.anchors) == 3
    assert all(table.covers(at) for at in points[:3])


def test_a_point_on_a_boundary_is_left_to_the_full_solver() -> None:
    """Its own anchor would not decide there, so none is kept."""
    model = BrakeModel(angular_frequencies=np.sqrt([1e8, 1.1e8]), damping_ratios=0.0,
                       contact_stiffness=np.diag([1e-3, 0.0]))
    for growth, undecided in ((0.0, 1), (0.01, 0)):  # growth rates are zero
        table = TabulatedSolver(model, tolerances=Tolerances(oscillation=1.0, growth=growth))
        assert build_table(table, [point()]).undecided == undecided
        assert len(table.anchors) == 1 - undecided


def test_braking_points_of_a_drive() -> None:
    points = braking_points(MODEL, [10.0, 0.1, 10.0, 12.0], [1e6, 1e6, 0.0, 2e6], 4 * [0.4],
                            release_pressure=5e4, minimum_rotor_speed=0.5)
    assert points == [MODEL.operating_point(rotor_speed=10.0, pressure=1e6, friction=0.4),
                      MODEL.operating_point(rotor_speed=12.0, pressure=2e6, friction=0.4)]


# ---------------------------------------------------------------- the command

def test_the_command_lays_down_an_envelope(model_path: str, tmp_path: Path,
                                           capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    assert main(['tabulate', model_path, '-o', str(path), *RANGES, '--json']) == 0
    shown = capsys.readouterr()
    summary = json.loads(shown.out, parse_constant=pytest.fail)
    assert shown.err == ''
    anchors = read_table(path, MODEL)
    assert summary['anchors'] == len(anchors) > 1
    assert summary['megabytes'] == path.stat().st_size / 1e6
    assert summary['coverage'] >= 0.95
    assert summary['envelope']['rotor_speed'] == [10.0, 20.0]
    preload = 2.5e-3 * np.array([1e6, 2e6]) / MODEL.contact_area
    assert summary['envelope']['contact_pressure'] == pytest.approx(preload)
    assert read_table_header(path)['about']['coverage'] == summary['coverage']
    table = TabulatedSolver(MODEL, anchors=anchors)
    tests = [MODEL.operating_point(rotor_speed=speed, pressure=1.4e6, friction=mu)
             for speed in (11.0, 14.0, 19.0) for mu in (0.39, 0.43)]
    assert sum(map(table.covers, tests)) >= 5


def test_the_command_gives_the_same_again(model_path: str, tmp_path: Path) -> None:
    files = [tmp_path / f'{i}.npz' for i in range(2)]
    for path in files:
        assert main(['tabulate', model_path, '-o', str(path), *RANGES, '--seed', '3']) == 0
    assert len({read_table_header(path)['hash'] for path in files}) == 1


def test_the_command_lays_down_a_drive(model_path: str, tmp_path: Path,
                                       capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / 'table.npz')
    assert main(['tabulate', model_path, '-o', path, '--drive', 'us06', '--duration', '40']) == 0
    assert ' anchors, ' in capsys.readouterr().out
    about = read_table_header(path)['about']
    assert (about['drive'], about['coverage'] >= 0.95) == ('us06', True)


def test_less_than_asked_is_a_bad_answer(model_path: str, tmp_path: Path,
                                         capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / 'table.npz')
    arguments = ['tabulate', model_path, '-o', path, '--rotor-speed', '1', '100', '--preload',
                 '100', '10000', '--friction', '0.1', '0.8', '--most', '2']
    assert main(arguments) == 1
    assert 'ended by --most or --memory' in capsys.readouterr().out
    assert len(read_table(path, MODEL)) == 2


@pytest.mark.parametrize(('arguments', 'part'), [
    ([], '--rotor-speed, --friction and --pressure or --preload: not all are given'),
    (RANGES[:6], 'not all are given'), ((*RANGES, '--drive', 'us06'), '--drive: says all, and'),
    ((*RANGES, '--coverage', '1.0'), '--coverage: is 1; give a part'),
    ((*RANGES, '--most', '0'), '--most is 0'), ((*RANGES, '--seed', '-1'), '--seed -1'),
    ((*RANGES, '--tolerance', '0'), '--tolerance: is 0.0'),
    ((*RANGES, '--memory', 'nan'), '--memory: is nan'),
    ((*RANGES[:-2], '0.5', '0.4'), 'friction: 0.5 to 0.4 is no range'),
    (('--drive', 'none'), 'none'), (('--drive', 'us06', '--duration', '2'), 'never brakes')])
def test_what_the_command_refuses(model_path: str, tmp_path: Path, arguments: Any, part: str,
                                  capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    assert main(['tabulate', model_path, '-o', str(path), *arguments]) == 2
    text = capsys.readouterr().err
    assert part in text
    assert len(text.splitlines()) == 1
    assert not path.exists()


@pytest.mark.parametrize('path', ['none/table.npz', 'table.csv'])
def test_where_it_cannot_write(model_path: str, tmp_path: Path, path: str,
                               capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['tabulate', model_path, '-o', str(tmp_path / path), *RANGES]) == 2
    assert '--output: ' in capsys.readouterr().err
