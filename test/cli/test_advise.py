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

"""`squeal advise`: quiet pressures and maps, and what it refuses."""

from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from support.advised_brakes import falling, falling_growth
from support.commands import answer, squeal

AT = ['--rotor-speed', '10', '--friction', '0.3', '--bounds', '1e5', '8e6']
SMALL = ['--bounds', '1e6', '4e6', '--speeds', '5', '20', '--frictions', '0.3', '0.4',
         '--points', '3', '2', '2']


@pytest.fixture
def toy(tmp_path: Path) -> str:
    """Return the file of a brake that is quiet up to a pressure in closed form."""
    falling().save(tmp_path / 'toy.npz')
    return str(tmp_path / 'toy.npz')


def test_quiet_pressures(toy: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = answer(capsys, 'advise', toy, *AT, '--pressure', '7.9e6')
    point, = found['points']
    model = falling()
    growth = falling_growth(model, 10.0, model.contact_pressure(1.0) * point['below'], 0.3)
    assert -0.05 < growth <= 0.01  # growth_threshold
    assert point['above'] is None
    assert point['confirmed']
    assert (point['rotor_speed'], point['friction'], point['present']) == (10.0, 0.3, 7.9e6)
    assert point['intervals'][0]['low'] == pytest.approx(
        {'value': 1e5, 'kind': 'limit', 'growth_rate': falling_growth(
            model, 10.0, model.contact_pressure(1e5), 0.3), 'frequency_hz': None})
    assert found['notice'].startswith('Advice, never a command')
    code, out, _ = squeal(capsys, 'advise', toy, *AT, '--pressure', '7.9e6')
    below = np.floor(point['below'] / 1e3) / 100
    assert code == 0
    assert f'10 rad/s, friction 0.3: quiet: 1.00 to {below:.2f} bar within' in out
    assert f'nearest quiet pressure below 79.00 bar: {below:.2f} bar\n' in out
    assert 'nearest quiet pressure above 79.00 bar: none' in out


def test_over_speeds_and_frictions_in_processes(toy: str,
                                                capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ['advise', toy, '--rotor-speed', '5', '20', '--friction', '0.3', '0.4',
                 '--bounds', '1e5', '8e6']
    alone = answer(capsys, *arguments)
    assert [(p['rotor_speed'], p['friction']) for p in alone['points']] == [
        (5.0, 0.3), (5.0, 0.4), (20.0, 0.3), (20.0, 0.4)]
    assert answer(capsys, *arguments, '--workers', '2') == alone


def test_nothing_quiet_is_a_bad_answer(toy: str, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = squeal(capsys, 'advise', toy, '--rotor-speed', '10', '--friction', '0.3',
                          '--bounds', '7.5e6', '8e6')
    assert (code, 'no quiet pressure within 75.00 to 80.00 bar' in out) == (1, True)


def test_a_map_without_emulator_has_growth_rates(toy: str, tmp_path: Path,
                                                 capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.csv'
    code, out, _ = squeal(capsys, 'advise', toy, *SMALL, '-o', str(path))
    assert (code, f'{path}: 12 points, 0 with a risk, ' in out) == (1, True)
    assert 'no risk is known: no growth emulator' in path.read_text()
    code, _, error = squeal(capsys, 'advise', toy, *SMALL, '-o', str(tmp_path / 'map.c'))
    assert (code, 'would hold no risk' in error) == (2, True)


def test_map_of_the_shipped_brake(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [str(tmp_path / name) for name in ('risk.csv', 'risk.h')]
    summary = answer(capsys, 'advise', 'kang2009_damped', *SMALL, '-o', *files, '--hold', '2')
    assert (summary['points'], summary['risks_known'], summary['output']) == (12, 12, files)
    header = Path(files[1]).read_text()
    assert 'squeals within 2 s from the noise floor' in header
    assert f'model hash: sha256 {summary["model hash"].removeprefix("sha256 ")}' in header
    assert 'not calibrated' in header


@pytest.mark.parametrize(('wrong', 'words'), [
    (['--points', '1', '2', '2'], '--points: [1, 2, 2]; give at least 2 for each axis'),
    (['--bounds', '2e6', '1e6'], '--bounds: 2e+06 to 1e+06; give two positive numbers'),
    (['-o', 'map.txt'], 'end it in .csv, .c, .h'),
    (['--hold', '0'], '--hold: is 0.0; give a positive number')])
def test_what_cannot_be_is_refused(toy: str, wrong: list[str], words: str,
                                   capsys: pytest.CaptureFixture[str]) -> None:
    code, _, error = squeal(capsys, 'advise', toy, *wrong)
    assert code == 2
    assert words in error


def test_a_model_without_caliper_is_refused(tmp_path: Path,
                                            capsys: pytest.CaptureFixture[str]) -> None:
    BrakeModel(angular_frequencies=[1e4]).save(tmp_path / 'bare.npz')
    code, _, error = squeal(capsys, 'advise', str(tmp_path / 'bare.npz'))
    assert (code, 'has no caliper, so a pressure says nothing to it' in error) == (2, True)
