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

"""`squeal modes` and `squeal critical` against solves of K09's matrices written out here."""

from contextlib import redirect_stdout
from dataclasses import replace
from functools import cache
from io import StringIO
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import Tolerances
from squeal_ros.cli.main import main
from support.commands import answer, squeal
from support.eigenvalues import companion

PRELOAD, STIFFNESS = 2000.0, 0.35e11


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
    return np.linalg.eigvals(companion(k, d))


def near(found: ComplexArray, hertz: float) -> complex:
    """Return the least stable root within 3 Hz of a frequency."""
    inside = found[np.abs(found.imag / 2.0 / np.pi - hertz) < 3.0]
    return complex(inside[inside.real.argmax()])


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
    ('13,14', 5.0, True, 1660.4), ('25,26', 5.0, False, 3197.0), ('10', 20.0, True, 857.9)])
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
    ('20', '18,19', 'below', 2524.5), ('8', '12', 'above', 1363.7)])
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


def test_a_critical_friction_says_for_which_slope(capsys: pytest.CaptureFixture[str]) -> None:
    at = ('critical', 'kang2009', '--rotor-speed', '5', '--friction', '0.42', '--modes', '13,14',
          '--bounds', '0.3', '0.45')
    lines = squeal(capsys, *at)[1].splitlines()
    assert lines[1].endswith('stable below; slope 0 s/m there')
    assert 'slope' not in lines[2]  # no boundary
    edge = answer(capsys, *at, '--friction-slope', '-0.02')['below']['value']
    line = squeal(capsys, *at, '--friction-slope', '-0.02')[1].splitlines()[1]
    assert line.endswith(f'; slope {-0.02 * edge / 0.42:.4g} s/m there, in proportion to mu')


def test_modes_say_the_brake_pressure_beside_that_of_the_contact(
        kang: BrakeModel, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    at = ('--rotor-speed', '20', '--friction', '0.42')
    plot = str(tmp_path / 'bars.png')
    lines = squeal(capsys, 'modes', 'kang2009', *at, '--pressure', '10e5', '--plot', plot,
                   '--plot-kind', 'damping')[1].splitlines()
    contact = kang.contact_pressure(10e5) / 1e5
    assert f', brake pressure 10 bar (contact {contact:.3f} bar), ' in lines[0]
    assert lines[-1] == f'written: {plot}'
    bare = str(tmp_path / 'bare.npz')
    replace(kang, caliper=None).save(bare)
    assert ', contact pressure 5.' in squeal(
        capsys, 'modes', bare, *at, '--preload', str(5.5e5 * kang.contact_area))[1]
