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

"""The commands over many points, as a user calls them, against solves written out here."""

from contextlib import redirect_stdout
import csv
from functools import cache, partial
from io import StringIO
import json
import math
import os
from pathlib import Path
import pty
import signal
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.assembly import build as building
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.studies.sweep_file import load_sweep
from squeal_ros.cli import sweep_commands as analysis
from squeal_ros.cli.console import ProgressBar
from squeal_ros.cli.main import main

COMMANDS = ('build', 'info', 'modes', 'map', 'locus', 'critical', 'verify', 'settings', 'replay',
            'drive', 'demo', 'tabulate')
PRELOAD, STIFFNESS = 2000.0, 0.35e11


@pytest.fixture(autouse=True)
def _signals() -> Any:
    """Set back what SIGTERM does, which `main` sets."""
    before = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, before)


def squeal(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = main(arguments)
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> Any:
    code, out, err = squeal(capsys, *arguments, '--json')
    assert code == 0, err
    return json.loads(out, parse_constant=pytest.fail)


def matrices(kang: BrakeModel, speed: float, friction: float, slope: float = 0.0, *,
             rotation: bool = True) -> tuple[ComplexArray, ComplexArray]:
    """D and K of K09 written out, not by `BrakeModel`."""
    load, w = PRELOAD / kang.contact_area, kang.angular_frequencies
    d, k = np.diag(2.0 * 0.002 * w), np.diag(w**2)
    if rotation:
        d = (d + speed * kang.gyroscopic + load * friction / speed * kang.radial_dissipation
             + load * slope * kang.negative_slope)
    return d, k + STIFFNESS * (kang.contact_stiffness + friction * kang.friction_couple)


def roots(d: ComplexArray, k: ComplexArray) -> ComplexArray:
    n = len(d)
    return np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-k, -d]]))


def near(found: ComplexArray, hertz: float) -> complex:
    """Return the least stable root within 3 Hz of a frequency."""
    inside = found[np.abs(found.imag / 2.0 / np.pi - hertz) < 3.0]
    return complex(inside[inside.real.argmax()])


# ---------------------------------------------------------------- options

@pytest.mark.parametrize('command', COMMANDS)
def test_every_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, '--help'])
    assert ended.value.code == 0
    assert f'usage: squeal {command}' in capsys.readouterr().out


FEW = ['--over', 'friction=0:0.6:3']


@pytest.mark.parametrize(('arguments', 'words'), [
    (['map', *FEW, '-o', 'x.txt'], '--output: x.txt is of no kind that is known'),
    (['map', *FEW, '-o', 'no/x.npz'], '--output: no/x.npz: is in a folder that does not exist'),
    (['map', *FEW, '--plot', 'x.foo'], '--plot: x.foo is of no kind'),
    (['locus', *FEW, '--plot', 'no/x.png'], '--plot: no/x.png: is in a folder'),
    (['map', *FEW, *FEW], '--over: friction, friction; give each one once'),
    (['map', '--over', 'friction=0:nan:3'], 'friction=0:nan:3'),
    (['map', '--over', 'friction=0:1:200000'], 'at most 100000 points'),
    (['map', '--over', 'mu=0:1:2'], 'contact_stiffness'),
    (['map', '--over', 'rotor_speed=1:5:2', '--friction-slope', '-0.1'], 'give --friction too'),
    (['map', *FEW, '--workers', '-1'], '--workers: is -1'),
    (['map', *FEW, '--fast', '--workers', '2'], 'leave --workers off'),
    (['locus', *FEW, '--over', 'rotor_speed=1:5:2'], '`squeal map` takes two'),
    (['locus', *FEW, '--modes', '25,93'], '1 to 92'),
    (['critical', '--rotor-speed', '5', '--modes', '0'], '1 to 92'),
    (['critical', '--rotor-speed', '5', '--parameter', 'mu'], "'mu'")])
def test_what_would_fail_later_is_refused_before_any_work(
        arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    for work in ('sweep', 'critical_value'):
        monkeypatch.setattr(analysis, work, lambda *_, **__: pytest.fail('work was begun'))
    command, *rest = arguments
    code, out, err = squeal(capsys, command, 'kang2009', *rest)
    assert (code, out) == (2, '')
    assert len(err.splitlines()) == 1
    assert words in err
    assert not list(tmp_path.iterdir())


def test_numbers_that_are_none(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(['locus', 'kang2009', '--modes', '25,x'])
    assert ended.value.code == 2
    assert "'25,x' are no numbers of modes; write 13,14" in capsys.readouterr().err


def test_figures_go_to_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / 'file').write_text('')
    code, _, err = squeal(capsys, 'verify', '--figures', str(tmp_path / 'file'))
    assert code == 2
    assert 'is no folder' in err


# ---------------------------------------------------------------- build

def test_a_build_ends_with_its_audit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                     capsys: pytest.CaptureFixture[str]) -> None:
    """Coarse on purpose: the same checks in the answer, in the file and in `info`."""
    monkeypatch.setattr(building, 'build_model', partial(
        building.build_model, disc_order=2, pad_elements=(3, 6, 1), contact_points=2))
    path = str(tmp_path / 'coarse.npz')
    checks = answer(capsys, 'build', 'kang2009', '-o', path)['audit']
    kept = answer(capsys, 'info', path)['provenance']['audit']
    assert checks == kept
    names = [check['name'] for check in checks]
    assert {'doublets without partner', 'contact quadrature', 'basis truncation to 60%',
            'basis truncation to 80%', 'backward error'} <= set(names)
    assert {f'{kind} of radial_dissipation' for kind in ('symmetry', 'definiteness')} <= set(names)
    _, out, _ = squeal(capsys, 'info', path)
    for check in checks:
        assert check['passed'] == (check['value'] <= check['limit'])
        (line,) = [line for line in out.splitlines() if f' {check["name"]} ' in line]
        assert (line.split()[1] == 'ok') == check['passed']
    code, _, err = squeal(capsys, 'build', 'kang2009', '-o', str(tmp_path / 'no' / 'a.npz'))
    assert code == 2
    assert 'is in a folder that does not exist' in err


# ---------------------------------------------------------------- modes

@cache
def modes_by_falling_friction() -> list[dict[str, Any]]:
    """Return what the command says of each mode at 20 rad/s."""
    shown = StringIO()
    with redirect_stdout(shown):
        assert main(['modes', 'kang2009', '--rotor-speed', '20', '--friction', '0.42',
                     '--friction-slope', '-0.02', '--json']) == 0
    return list(json.loads(shown.getvalue(), parse_constant=pytest.fail)['modes'])


def test_modes_say_how_far_they_can_be_trusted(kang: BrakeModel) -> None:
    d, k = matrices(kang, 20.0, 0.42, -0.02)
    size = len(d)
    for mode in modes_by_falling_friction():
        if mode['kind'] == 'rigid':
            assert mode['condition'] is mode['error_bound'] is None  # not bounded
            continue
        assert 0.0 <= mode['backward_error'] < 1e-12
        assert mode['condition'] >= 1.0
        root = complex(mode['growth_rate'], 2.0 * math.pi * mode['frequency_hz'])
        norm = abs(root)**2 + abs(root) * np.linalg.norm(d) + np.linalg.norm(k)
        assert mode['error_bound'] == pytest.approx(
            mode['backward_error'] * mode['condition'] * abs(root), rel=1e-9)
        # least singular value of the pencil over its size, the best backward error there is
        if mode['kind'] == 'flutter':
            left, singular, right = np.linalg.svd(root**2 * np.eye(size) + root * d + k)
            assert singular[-1] / norm < 1e-12
            turn = abs(left[:, -1].conj() @ (2.0 * root * np.eye(size) + d) @ right[-1].conj())
            assert mode['condition'] == pytest.approx(norm / abs(root) / turn, rel=1e-4)


def test_modes_carry_the_paper_s_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    still = answer(capsys, 'modes', 'kang2009', '--rotor-speed', '5', '--friction', '0.42',
                   '--without-rotation')
    assert still['rotation'] is False
    assert still['point']['rotor_speed'] == 5.0
    assert [m['identity'] for m in still['modes']][12:14] == ['13/14'] * 2  # fig. 12: merged
    code, out, _ = squeal(capsys, 'modes', 'kang2009', '--rotor-speed', '5', '--friction', '0.42')
    assert code == 0
    rows = [line.split()[:3] for line in out.splitlines()[3:]]
    assert rows == [['26', '26', 'flutter'], ['13', '13', 'flutter']]


def test_why_modes_grow(kang: BrakeModel) -> None:
    """Contributions sum to the growth rate; sensitivities are differences of roots."""
    found = modes_by_falling_friction()
    growing = [m for m in found if m['mechanism']]
    assert {m['kind'] for m in growing} == {'flutter', 'divergence'}
    for mode in growing:
        assert sum(mode['contributions'].values()) == pytest.approx(mode['growth_rate'], abs=1e-9)
    worst = max((m for m in growing if m['kind'] == 'flutter'), key=lambda m: m['growth_rate'])
    step = 1e-5
    for name, speed, friction in (('friction', 0.0, step), ('rotor_speed', 20.0 * step, 0.0)):
        ends = [near(roots(*matrices(kang, 20.0 + way * speed, 0.42 + way * friction, -0.02)),
                     worst['frequency_hz']) for way in (1.0, -1.0)]
        slope = (ends[0] - ends[1]) / (2.0 * (speed or friction))
        # differences are good to the square of the step and to rounding over it
        assert worst['sensitivity'][name]['growth_rate'] == pytest.approx(slope.real, rel=1e-4)
        assert worst['sensitivity'][name]['frequency_hz'] == pytest.approx(
            slope.imag / 2.0 / math.pi, rel=1e-4)
    assert all(m['sensitivity'] is None for m in found if m['kind'] == 'stable')


# ---------------------------------------------------------------- critical values

@pytest.mark.parametrize(('numbers', 'speed', 'rotation', 'hertz'), [
    ('13,14', 5.0, True, 1660.4), ('13,14', 5.0, False, 1668.5), ('25,26', 5.0, False, 3197.0),
    ('40', 20.0, True, 5678.0), ('10', 20.0, True, 857.9)])
def test_critical_friction_of_a_pair(numbers: str, speed: float, rotation: bool, hertz: float,
                                     kang: BrakeModel,
                                     capsys: pytest.CaptureFixture[str]) -> None:
    still = [] if rotation else ['--without-rotation']
    found = answer(capsys, 'critical', 'kang2009', '--rotor-speed', str(speed), '--friction',
                   '0.42', '--modes', numbers, *still)
    edge = found['below']
    assert edge['converged']
    assert edge['frequency_hz'] == pytest.approx(hertz, abs=10.0)
    growing, calm = (near(roots(*matrices(kang, speed, friction, rotation=rotation)),
                          edge['frequency_hz']).real for friction in edge['bracket'])
    assert growing > Tolerances.of(kang).growth >= calm
    assert found['rotation'] is rotation
    assert found['above']['value'] is None


@pytest.mark.parametrize(('start', 'numbers', 'side', 'hertz'), [
    ('20', '13', 'below', 1659.0), ('20', '18,19', 'below', 2524.5), ('8', '12', 'above', 1363.7)])
def test_critical_speed_follows_the_law(start: str, numbers: str, side: str, hertz: float,
                                        kang: BrakeModel,
                                        capsys: pytest.CaptureFixture[str]) -> None:
    """Fig. 15: friction and slope are those of each speed."""
    found = answer(capsys, 'critical', 'kang2009', '--rotor-speed', start, '--parameter',
                   'rotor_speed', '--modes', numbers)
    edge = found[side]
    assert edge['converged']
    assert found['friction_law'] is True
    growth = []
    for speed in edge['bracket']:
        fall = 0.18 * math.exp(-speed * kang.contact_radius)
        growth.append(near(roots(*matrices(kang, speed, 0.32 + fall, -fall)), hertz).real)
    assert growth[0] > Tolerances.of(kang).growth >= growth[1]


def test_critical_in_words(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = squeal(capsys, 'critical', 'kang2009', '--rotor-speed', '5', '--friction',
                          '0.42', '--modes', '26', '--bounds', '0.3', '0.6')
    assert code == 0
    assert out.splitlines()[0].endswith('1/s (friction 0.42, slope 0 s/m)')
    assert out.splitlines()[1].startswith(
        'below: no stability boundary from mu = 0.42 to 0.3, unstable')


# ---------------------------------------------------------------- sweeps

RADIUS = 2.0 / 3.0 * (0.142**3 - 0.1**3) / (0.142**2 - 0.1**2)  # m, of K09's patch
LAW = [(0.32 + fall, -fall) for fall in (0.18 * math.exp(-RADIUS * speed)
                                         for speed in (2.0, 10.0))]


@pytest.mark.parametrize(('arguments', 'expected'), [
    ([], LAW), (['--friction-law'], LAW), (['--friction', '0.5'], [(0.5, 0.0)] * 2),
    (['--friction', '0.5', '--friction-slope', '-0.1'], [(0.5, -0.1)] * 2),
    # the law's slope, scaled to --friction, at each speed
    (['--friction', '0.5', '--friction-law'], [(0.5, 0.5 * s / f) for f, s in LAW])])
def test_friction_over_speed(arguments: list[str], expected: list[tuple[float, float]],
                             tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.csv'
    assert main(['map', 'kang2009', '--over', 'rotor_speed=2:10:2', '-o', str(path),
                 *arguments]) == 0
    with path.open(newline='') as file:
        rows = [row for row in csv.DictReader(list(file)[1:]) if row['index'] == '1']
    assert [float(row['rotor_speed']) for row in rows] == [2.0, 10.0]
    for row, (friction, slope) in zip(rows, expected, strict=True):
        assert float(row['friction']) == pytest.approx(friction, rel=1e-12)
        assert float(row['friction_slope']) == pytest.approx(slope, rel=1e-12)


def test_swept_friction_is_constant_over_speed(tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.npz'
    assert main(['map', 'kang2009', *FEW, '-o', str(path)]) == 0
    assert load_sweep(path).column('friction_slope').tolist() == [0.0] * 3
    assert main(['map', 'kang2009', '--over', 'friction=0.3:0.6:2', '--over',
                 'rotor_speed=2:10:2', '--friction-law', '-o', str(path), '--force']) == 0
    record = load_sweep(path)
    assert record.column('friction').tolist() == [0.3, 0.3, 0.6, 0.6]
    assert record.column('friction_slope') == pytest.approx(
        [mu * s / f for mu in (0.3, 0.6) for f, s in LAW], rel=1e-12)
    assert record.about['friction_law'] == 'slope'


def test_flutter_and_divergence_are_counted_apart(tmp_path: Path,
                                                  capsys: pytest.CaptureFixture[str]) -> None:
    """One mode that slides freely and one that vibrates, each with a slope of its own."""
    for diagonal, expected in (([1e-3, 0.0], (0, 2)), ([0.0, 1e-2], (2, 0))):
        BrakeModel(angular_frequencies=[0.0, 1e4], negative_slope=np.diag(diagonal)).save(
            tmp_path / 'two.npz')
        found = answer(capsys, 'map', str(tmp_path / 'two.npz'), '--over',
                       'friction_slope=-0.1:0:3', '--friction', '0.3')
        assert (found['points_with_flutter'], found['points_with_divergence']) == expected


def test_a_locus_with_and_without_rotation(tmp_path: Path,
                                           capsys: pytest.CaptureFixture[str]) -> None:
    files = [tmp_path / name for name in ('a.json', 'a_without_rotation.json', 'a.svg')]
    assert main(['locus', 'kang2009', '--over', 'friction=0.3:0.5:5', '--modes', '13,14',
                 '--without-rotation', '-o', str(files[0]), '--plot', str(files[2])]) == 0
    one, other = map(load_sweep, files[:2])
    assert (one.about['rotation'], other.about['rotation']) == (True, False)
    assert not one.merged(13).any()
    # it merges at 0.348, wherever the path begins
    assert other.merged(14).tolist() == [False, True, True, True, True]
    assert other.names(13).tolist()[::4] == ['13', '13/14']


def test_an_interrupt_ends_both_sweeps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                       capsys: pytest.CaptureFixture[str]) -> None:
    """The one without rotation is not begun when the first was cut short."""
    calls: list[tuple[int, int]] = []

    def stop(self: ProgressBar, done: int, total: int) -> None:
        calls.append((done, total))
        if done == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(ProgressBar, '__call__', stop)
    path = tmp_path / 'a.npz'
    assert main(['locus', 'kang2009', '--over', 'friction=0:0.5:6', '--modes', '13', '--workers',
                 '1', '--without-rotation', '-o', str(path)]) == 1
    assert calls == [(1, 6), (2, 6)]
    assert load_sweep(path).done.tolist() == [True] * 2 + [False] * 4
    assert [p.name for p in tmp_path.iterdir()] == ['a.npz']


def test_ctrl_c_at_a_terminal_keeps_what_is_done(tmp_path: Path) -> None:
    """Sent once the bar shows a few points; the file is whole and holds them."""
    ours, theirs = pty.openpty()
    path = tmp_path / 'a.npz'  # of so many points faster than a text
    with subprocess.Popen(
            [sys.executable, '-m', 'squeal_ros.cli', 'map', 'kang2009', '--over',
             'friction=0:0.8:5000', '-o', str(path), '--json'], stdout=subprocess.PIPE,
            stderr=theirs, text=True, start_new_session=True,
            env={**os.environ, 'PYTHONPATH': str(Path(__file__).parents[2])}) as process:
        os.close(theirs)
        shown = b''
        while b'] 5 of 5000 points' not in shown:
            shown += os.read(ours, 4096)
        os.killpg(process.pid, signal.SIGINT)
        output, _ = process.communicate(timeout=600)
    os.close(ours)
    summary, record = json.loads(output), load_sweep(path)
    assert process.returncode == 1
    assert shown.startswith(b'\r[---')
    assert (summary['complete'], record.complete) == (False, False)
    assert 5 <= summary['done'] == record.done.sum() < 5000
    assert np.isfinite(record.eigenvalues[record.done]).all()
