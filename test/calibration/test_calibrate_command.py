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

"""`squeal calibrate`: from a bag and a table of events to the file, and what is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.calibration.applications import Observation  # noqa: E402
from squeal_core.calibration.calibration_file import read_calibration  # noqa: E402
from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_ros.cli import calibrate_commands  # noqa: E402
from squeal_ros.cli.main import main  # noqa: E402
from support.bags import (  # noqa: E402, I100
    Entry,
    FLOAT,
    header,
    JOINTS,
    make,
    PRESSURE,
    SECOND,
    settings_file,
    START,
    write_bag,
)
from support.linear_growth import LinearGrowth  # noqa: E402
from support.rows import each  # noqa: E402
from support.sounds import sound_of, Squeal, write_wav  # noqa: E402

STOPS = 36


def stops() -> list[Entry]:
    """Return a drive of stops of 1.5 s, each at its own friction, released in between."""
    rng, found = np.random.default_rng(1), []
    for number in range(STOPS * 25):
        time = START + number * SECOND // 10
        friction = 0.36 + 0.12 * (number // 25 * 7 % STOPS) / STOPS
        pressed = 5 <= number % 25 < 20
        noise = 1.0 + 1e-3 * rng.standard_normal(3)
        found += [
            Entry('/joint_states', JOINTS, time, make(
                JOINTS, header=header(time), name=['fl_wheel_joint'], position=np.zeros(0),
                velocity=np.array([20.0 * noise[0]]), effort=np.zeros(0))),
            Entry('/fl/brake_pressure', PRESSURE, time, make(
                PRESSURE, header=header(time), fluid_pressure=(8e5 if pressed else 1e3) * noise[1],
                variance=0.0)),
            Entry('/fl/friction', FLOAT, time, make(FLOAT, data=friction * noise[2]))]
    return found


@pytest.fixture(scope='module')
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a bag, settings, and the events of stops with much friction."""
    folder = tmp_path_factory.mktemp('calibrate')
    write_bag(folder / 'drive', stops())
    settings_file(folder / 'monitor.yaml')
    rows = [f'{number * 2.5 + 1.5},fl,1660\n' for number in range(STOPS)
            if 0.36 + 0.12 * (number * 7 % STOPS) / STOPS > 0.41]
    (folder / 'events.csv').write_text(f'time_s,brake,frequency_hz\n{"".join(rows)}')
    return folder


@pytest.fixture(autouse=True)
def _emulator(monkeypatch: pytest.MonkeyPatch) -> None:
    growth = LinearGrowth([1655.0, 3210.0], [45.0, 95.0], [350.0, 600.0])
    monkeypatch.setattr(calibrate_commands, 'named_emulator', lambda *_: growth)


def run(folder: Path, *options: str, events: str = 'events.csv') -> int:
    try:
        return main(['calibrate', str(folder / 'drive'), '--events', str(folder / events),
                     '--config', str(folder / 'monitor.yaml'), '-o', str(folder / 'out.yaml'),
                     '--force', *options])
    except SystemExit as end:
        return int(end.code or 0)


def test_a_drive_with_events(folder: Path, capsys: pytest.CaptureFixture[str],
                             kang: BrakeModel) -> None:
    code = run(folder, '--from-start', '--json')
    shown = capsys.readouterr()
    assert code == 0, shown.err
    found = json.loads(shown.out)
    seen = found['observations']
    assert seen['fitted_with_squeal'] + seen['fitted_silent'] + seen['held_out'] == STOPS
    assert (seen['held_out'], seen['events_unmatched'], seen['incomplete']) == (11, 0, 0)
    assert (seen['fitted_with_squeal'], seen['with_squeal']) == (14, 20)
    assert (found['model_name'], found['likelihood_power']) == ('kang2009', 1.0)
    assert found['scores']['calibrated']['brier'] < found['scores']['base_rate']['brier']
    assert found['recordings'] == ['drive']
    ensemble = read_calibration(folder / 'out.yaml', kang)
    assert ensemble.count == 64
    assert ensemble.calibrated.startswith('calibrated with ')
    assert (folder / 'out.yaml').stat().st_size < 20_000
    # squeal begins near a friction of 0.41: 350 (mu + bias - 0.3) = 45 exp(ln damping) and more
    onset = 0.3 + 45.0 * np.exp(ensemble.ln_damping) / 350.0 - ensemble.friction_bias
    assert 0.37 < np.median(onset) < 0.42


def write_table(path: Path, numbers: range) -> None:
    """Write the bag's stops of these numbers as a German table, times from 0."""
    entries = stops()[75 * numbers.start:75 * numbers.stop]
    values = [entry.message.velocity[0] if entry.type == JOINTS else
              entry.message.fluid_pressure / 1e5 if entry.type == PRESSURE else entry.message.data
              for entry in entries]
    lines = ['Zeit;Drehzahl;Druck;Reibwert', 's;rad/s;bar;-', *(
        ';'.join(f'{cell:.6f}'.replace('.', ',') for cell in (0.1 * i, *row))
        for i, row in enumerate(zip(*[iter(values)] * 3, strict=True)))]
    path.parent.mkdir(exist_ok=True)
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')


def test_a_folder_of_tables_with_signals(folder: Path, capsys: pytest.CaptureFixture[str],
                                         tmp_path: Path) -> None:
    """
    The stops of the bag in tables of two days, named alike, with the brake of the signals.

    The table of events is in the folder, too.
    """
    half = STOPS // 2
    write_table(tmp_path / 'monday' / 'drive.csv', range(half))
    write_table(tmp_path / 'tuesday' / 'drive.csv', range(half, STOPS))
    signals, events = tmp_path / 'signals.yaml', tmp_path / 'monday' / 'events.csv'
    assert main(['signals', str(tmp_path / 'monday' / 'drive.csv'), '-o', str(signals)]) == 0
    assert 'brake:' in signals.read_text()
    rows = (folder / 'events.csv').read_text().splitlines()[1:]
    lines = [f'{float(time) % (half * 2.5):g},brake,{pitch},'
             f'{"monday_drive" if float(time) < half * 2.5 else "tuesday_drive"}'
             for time, _, pitch in (row.split(',') for row in rows)]
    events.write_text('\n'.join(['time_s,brake,frequency_hz,recording', *lines]))
    capsys.readouterr()

    def calibrated(*recordings: str) -> int:
        return main(['calibrate', *recordings, '--signals', str(signals), '--events', str(events),
                     '--from-start', '-o', str(tmp_path / 'out.yaml'), '--force', '--json'])

    assert calibrated(str(tmp_path / 'm*'), str(tmp_path / 'tuesday')) == 0
    found = json.loads(capsys.readouterr().out)
    seen = found['observations']
    assert found['recordings'] == ['monday_drive', 'tuesday_drive']
    assert (seen['with_squeal'], seen['events_unmatched'], seen['incomplete']) == (20, 0, 0)
    assert seen['fitted_with_squeal'] + seen['fitted_silent'] + seen['held_out'] == STOPS
    assert calibrated(str(folder / 'drive')) == 2  # columns for a bag
    assert 'signals.yaml names columns' in capsys.readouterr().err


def test_a_sound_in_place_of_events(folder: Path, capsys: pytest.CaptureFixture[str],
                                    tmp_path: Path) -> None:
    """Stops that squealed are heard in noise; those after the end of the sound do not count."""
    heard = [number for number in range(STOPS)
             if 0.36 + 0.12 * (number * 7 % STOPS) / STOPS > 0.41]
    sound = sound_of(np.random.default_rng(0), 8000, 71.0, [
        Squeal(number * 2.5 + 1.2, number * 2.5 + 1.8, 1660.0, 20.0) for number in heard])
    write_wav(tmp_path / 'stops.wav', 8000, sound)

    def run_sound(name: str) -> dict[str, Any]:
        code = main(['calibrate', str(folder / 'drive'), '--sound', str(tmp_path / name),
                     '--config', str(folder / 'monitor.yaml'), '-o', str(folder / 'out.yaml'),
                     '--force', '--from-start', '--json', '--held-out', '0'])
        shown = capsys.readouterr()
        assert code == 0, shown.err
        return dict(json.loads(shown.out))

    found = run_sound('stops.wav')
    seen = found['observations']
    listened = [number for number in range(STOPS) if number * 2.5 + 2.0 < 71.0]
    assert seen['fitted_with_squeal'] == len(set(heard) & set(listened))
    assert seen['fitted_with_squeal'] + seen['fitted_silent'] == len(listened) < STOPS
    assert found['events_file'] == 'stops.wav'
    assert main(['listen', str(tmp_path / 'stops.wav'), '-o', str(tmp_path / 'measured.csv')]) == 0
    capsys.readouterr()
    assert run_sound('measured.csv')['observations'] == seen
    about = json.loads((tmp_path / 'measured.json').read_text())
    (tmp_path / 'measured.json').write_text(json.dumps(about | {'clock': 'sync'}))
    assert main(['calibrate', str(folder / 'drive'), '--sound', str(tmp_path / 'measured.csv'),
                 '--config', str(folder / 'monitor.yaml'), '-o', str(tmp_path / 'out.yaml')]) == 2
    error = capsys.readouterr().err
    assert 'is on no clock' in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / 'out.yaml').exists()


def test_few_events_stay_near_the_prior(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / 'two.yaml').write_text('/**: {ros__parameters: {brakes: [fl, fr]}}')
    (folder / 'few.csv').write_text('time_s,frequency_hz,brake,end_s,mode\n1.5,1660,fl,2,13\n')
    options = ('--from-start', '--brakes', 'fl', '--config', str(folder / 'two.yaml'))
    assert run(folder, *options, events='few.csv') == 0  # nothing is held out of one event
    shown, text = capsys.readouterr().out, (folder / 'out.yaml').read_text()
    every = 'listened to fl only; node and replay use the calibration for every brake of the model'
    assert f'{every}, fr too\n' in shown
    assert every in text
    assert 'listened_to: ["fl"]' in text
    assert 'it holds for\n# every brake of the model' in text
    assert 'model: kang2009, hash ' in shown
    assert 'fitted: 1 of 1 events (applications with squeal), 35 silent applications' in shown
    assert '1 events, fewer than 10' in shown
    assert 'stays near the prior' in shown
    assert 'damping, friction bias and N* lie on a ridge' in shown
    assert 'no scores (too few events to hold some out, fewer than 20): too few held out' in shown


def test_no_event_is_no_calibration(folder: Path, capsys: pytest.CaptureFixture[str],
                                    kang: BrakeModel) -> None:
    (folder / 'none.csv').write_text('time_s,frequency_hz\n')
    assert run(folder, '--from-start', events='none.csv') == 1
    shown = capsys.readouterr().out
    assert 'not to be trusted: no event was fitted, so the ensemble is the prior' in shown
    assert 'known best' not in shown
    found = read_calibration(folder / 'out.yaml', kang)
    assert (found.calibrated, found.likelihood_power) == ('', 0.0)


def test_held_out_are_events_and_silent_ones_alike() -> None:
    some = [Observation((i,), i >= 40, 1660.0) for i in range(60)]
    train, test = calibrate_commands._split(some, 1.0 / 3.0)
    assert [sum(one.heard for one in part) for part in (train, test)] == [14, 6]
    assert len(test) == 19
    assert calibrate_commands._split(some[:-1], 1.0 / 3.0) == (some[:-1], [])


def test_events_of_another_clock_are_told(folder: Path, capsys: pytest.CaptureFixture[str]
                                          ) -> None:
    run(folder, '--held-out', '0')
    assert 'events are in no brake application, the first at' in capsys.readouterr().err


@each(('options', 'words'), [
    (('--held-out', '0.9'), '--held-out: is 0.9; give 0 to 0.5'),
    (('--detection', '0.2'), 'detection is 0.2'),
    (('--false-alarm', '0.45', '--detection', '0.5', '--label-error', '0.6'), 'label_error is'),
    (('--brakes', 'fll'), "--brakes: 'fll' is none of the settings; give some of fl"),
    (('--from', '5', '--to', '4'), 'give two times that rise'),
    (('--from', '1', '--to', '2'), 'no brake slides under load in what was listened to'),
    (('--seed', '-1'), '--seed: is -1'),
    (('--offset', 'nan'), '--offset is nan; give a finite number'),
    (('--offset', 'inf'), '--offset is inf; give a finite number'),
    (('--from', 'nan'), '--from is nan; give a finite number'),
    (('--to', 'inf'), '--to is inf; give a finite number'),
    (('--minimum-level', 'nan'), '--minimum-level is nan; give a finite number'),
    (('-o', 'file.txt'), 'end it in .yaml, .yml'),
    (('--model', 'kang'), 'kang')])
def test_what_cannot_be_calibrated(folder: Path, capsys: pytest.CaptureFixture[str],
                                   options: tuple[str, ...], words: str) -> None:
    assert run(folder, *options) == 2
    assert words in capsys.readouterr().err


def test_a_table_needs_signals(tmp_path: Path, folder: Path,
                               capsys: pytest.CaptureFixture[str]) -> None:
    write_table(tmp_path / 'drive.csv', range(2))
    code = main(['calibrate', str(tmp_path / 'drive.csv'), '--events', str(folder / 'events.csv'),
                 '-o', str(tmp_path / 'out.yaml')])
    assert code == 2
    assert 'give --signals SIGNALS.yaml' in capsys.readouterr().err


def test_no_emulator(folder: Path, capsys: pytest.CaptureFixture[str],
                     monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibrate_commands, 'named_emulator', lambda *_: None)
    assert run(folder) == 2
    assert 'squeal tabulate kang2009 --growth' in capsys.readouterr().err
