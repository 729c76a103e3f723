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

"""`squeal listen`: its files, what it says, and what it refuses."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from squeal_core.calibration.events import read_events
from support.commands import squeal
from support.rows import each
from support.sounds import sound_of, Squeal, write_wav

RATE = 16_000


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    return write_wav(tmp_path / 'drive.wav', RATE, sound_of(
        np.random.default_rng(1), RATE, 4.0, [Squeal(1.0, 2.0, 2500.0, 15.0, harmonics=(0.2,)),
                                              Squeal(3.0, 3.05, 4000.0, 15.0)], noise=0.003))


def test_events_go_to_a_table_that_a_calibration_reads(
        sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = sound.with_name('measured.csv')
    command = ('listen', str(sound), '-o', str(table), '--start', '2026-05-04T09:30:00Z',
               '--calibration', '20Pa', '--brakes', 'fl')
    code, out, err = squeal(capsys, *command)
    assert (code, err) == (0, '')
    assert '1 squeal event' in out
    assert 'half the rate limits it' in out
    assert 'rejected 1 by duration' in out
    (event,) = read_events(table, ('fl', 'fr'))
    assert event.time == pytest.approx(1777887001.0, abs=0.05)
    assert (event.place, event.frequency_hz) == ('fl', pytest.approx(2500.0, abs=2.0))
    assert event.level_db > 70.0
    with table.open(newline='') as file:
        (row,) = csv.DictReader(file)
    assert (row['harmonics'], row['channel'], row['comment']) == ('2', '1', '')
    about = json.loads(table.with_suffix('.json').read_text())
    assert about['clock'] == 'start'
    assert about['offset_s'] == 1777887000.0
    assert [tone['rule'] for tone in about['rejected']] == ['duration']
    assert about['rejected'][0]['rule'] in about['rules']
    code, _, err = squeal(capsys, *command)
    assert code == 2
    assert 'exists; give --force' in err


def test_of_a_silent_microphone_nothing_is_known(
        sound: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The table of an earlier run goes, too: it would read as if it were of this sound."""
    table = sound.with_name('measured.csv')
    assert squeal(capsys, 'listen', str(sound), '-o', str(table))[0] == 0
    write_wav(sound, RATE, np.zeros(4 * RATE))
    code, out, _ = squeal(capsys, 'listen', str(sound), '-o', str(table), '--force', '--json')
    assert code == 1
    assert json.loads(out)['events'] is None
    assert not table.exists()
    assert json.loads(table.with_suffix('.json').read_text())['events'] is None
    _, out, _ = squeal(capsys, 'listen', str(sound), '-o', str(table), '--force')
    assert 'squeal: not known' in out
    assert ' 0 ' not in out


@each(('arguments', 'words'), [
    (('--channel', '2'), '--channel: is 2'), (('--brakes', 'fl,fr'), 'names 2 for 1 channels'),
    (('--calibration', '20'), '--calibration: is'), (('--start', 'now'), '--start: is'),
    (('--start', '0', '--sync', 'x'), 'not allowed'), (('--prominence', '2'), '--prominence'),
    (('--band', '9000', '2000'), '--band'), (('--shortest', '0'), '--shortest'),
    (('--band', '8000', '9000'), 'samples a second'), (('--sync', 'none'), 'none'),
    (('--threshold', 'nan'), '--threshold'), (('-o', 'no/x.csv'), 'does not exist'),
    (('--speed', 'none.csv'), 'none.csv')])
def test_what_is_refused_is_one_line(arguments: tuple[str, ...], words: str, sound: Path,
                                     capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(sound.parent.iterdir())
    given = () if '-o' in arguments else ('-o', str(sound.with_name('m.csv')))
    code, out, err = squeal(capsys, 'listen', str(sound), *given, *arguments)
    assert (code, out) == (2, ''), err
    assert len(err.splitlines()) == 1
    assert words in err
    assert sorted(sound.parent.iterdir()) == before
