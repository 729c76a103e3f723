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


"""`squeal simulate`: files and what is refused."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile
from squeal_ros.cli.main import main
from support.rows import each

POINT = ('--rotor-speed', '20', '--pressure', '8e5', '--friction', '0.42')


def squeal(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    try:
        code = main(('simulate', *arguments))
    except SystemExit as end:  # argparse
        code = int(end.code or 0)
    shown = capsys.readouterr()
    return code, shown.out, shown.err


@pytest.mark.usefixtures('faces')
def test_a_ramp_from_a_high_floor_squeals(
        capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    folder = tmp_path / 'out'
    command = ('kang2009', '--rotor-speed', '20', '--pressure', '8e5:1e6', '--friction',
               '0.5:0.55', '--duration', '0.06', '--floor', '1e-7', '--threshold-db', '80',
               '--levels', '--json', '-o', str(folder))
    code, out, _ = squeal(capsys, *command)
    summary = json.loads(out)
    assert code == 0
    assert sorted(path.name for path in folder.iterdir()) == [
        'events.csv', 'levels.npz', 'microphone_brake.wav', 'simulation.json']
    rate, sound = wavfile.read(folder / 'microphone_brake.wav')
    assert rate == 48_000
    assert sound.shape == (2880,)
    with (folder / 'events.csv').open(newline='') as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(summary['events']) > 0
    loud = 20.0 * np.log10(np.sqrt(np.mean((20.0 * sound) ** 2)) / 20e-6)
    loudest = max(float(row['level_db']) for row in rows)  # of one mode; loud is of all
    assert loud - 12.0 < loudest < loud + 3.0
    with np.load(folder / 'levels.npz') as levels:
        assert levels['level'].shape == (6, 92, 1)
        assert levels['sliding'].all()
    code, _, err = squeal(capsys, *command)
    assert code == 2
    assert 'exists; give --force' in err


@pytest.mark.usefixtures('faces')
def test_brakes_of_a_drive(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A braking of the cycle; the rear brakes have signals of their own."""
    folder = tmp_path / 'out'
    code, out, err = squeal(
        capsys, 'kang2009', '--drive', 'us06', '--from', '36.0', '--to', '36.03', '--brakes',
        'rear_left,front_left', '--json', '-o', str(folder))
    assert code == 0, err
    summary = json.loads(out)
    assert summary['brakes'] == ['rear_left', 'front_left']
    assert summary['start_s'] == pytest.approx(36.0)
    sounds = [wavfile.read(folder / f'microphone_{name}.wav')[1] for name in summary['brakes']]
    assert all(sound.size == 1440 and sound.any() for sound in sounds)
    assert not np.array_equal(*sounds)


@each(('arguments', 'words'), [
    ((), '--rotor-speed: is missing'),
    (('--rotor-speed', '0'), 'steady sliding needs another speed'),
    (('--rotor-speed', '20', '--friction', '0.4:x'), 'is no number or ramp'),
    ((*POINT, '--duration', '0'), '--duration: is 0.0; give a positive number'),
    ((*POINT, '--duration', '1e4'), 'give at most 600 s'),
    ((*POINT, '--floor', '1'), '--floor: is 1 m'),
    ((*POINT, '--steps', '0'), '--steps: is 0'),
    ((*POINT, '--to', '3'), '--to: is of a --drive'),
    ((*POINT, '--drive', 'us06'), '--drive says where the brakes operate'),
    (('--drive', 'us06', '--brakes', 'front_leff'), 'did you mean front_left'),
    (('--drive', 'us06', '--from', '5', '--to', '4'), 'give two times that rise'),
    (('--drive', 'us06', '--from', '20', '--to', '20.5'), 'no brake slides under load'),
    (('--rotor-speed', '5', '--friction-law', '--free-pads'), 'the pads diverge at 4')])
def test_what_cannot_be_simulated(capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                  arguments: tuple[str, ...], words: str) -> None:
    code, _, err = squeal(capsys, 'kang2009', *arguments, '-o', str(tmp_path / 'none'))
    assert code == 2
    assert words in err
    assert not (tmp_path / 'none').exists()
