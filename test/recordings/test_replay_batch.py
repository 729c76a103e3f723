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

"""`squeal replay` over many recordings: results, bad ones among them, ranges, interrupts."""

from contextlib import suppress
import errno
import json
import os
from pathlib import Path
import signal
import subprocess
import time
from typing import Any

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.common.partial_files import PARTIAL  # noqa: E402
from squeal_core.monitor.results.record_tables import ResultError  # noqa: E402
from squeal_core.monitor.results.result_files import find_results, ReplayResult  # noqa: E402
from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.recordings.replay.batch_progress import BatchProgress  # noqa: E402
from squeal_ros.recordings.replay.replay_batch import plan_batch  # noqa: E402
from squeal_ros.recordings.time_range import Moment, TimeRange  # noqa: E402
from support.bags import (  # noqa: E402, I100
    braking,
    Entry,
    make,
    SECOND,
    settings_file,
    START,
    storage_file,
    write_bag,
)
from support.processes import process  # noqa: E402
from support.tables import document, signals_file, stop_text  # noqa: E402

FIX = 'sensor_msgs/msg/NavSatFix'


def drive(seconds: float) -> list[Entry]:
    """Return a drive that brakes twice, released before, between and after, with its fixes."""
    entries = braking(seconds)
    for entry in entries:
        part = (entry.time - START) / SECOND / seconds
        if entry.topic.endswith('pressure') and not (0.2 < part < 0.5 or 0.6 < part < 0.9):
            entry.message.fluid_pressure = 0.0
    return entries + [Entry('/fix', FIX, time, fix(time, number)) for number, time in enumerate(
        range(START, START + round(seconds * SECOND), SECOND))]


def fix(stamp: int, number: int) -> Any:
    """Return a fix on the way north; every other one has no position."""
    import numpy as np
    return make(FIX, header=make('std_msgs/msg/Header', frame_id='', stamp=make(
        'builtin_interfaces/msg/Time', sec=stamp // SECOND, nanosec=0)),
        status=make('sensor_msgs/msg/NavSatStatus', status=-(number % 2), service=1),
        latitude=48.0 + 0.01 * number, longitude=11.0, altitude=500.0,
        position_covariance=np.zeros(9), position_covariance_type=0)


@pytest.fixture
def week(tmp_path: Path) -> Path:
    """Return a folder of two recordings of the same name and a damaged one."""
    folder = tmp_path / 'week'
    for day in ('mon', 'tue'):
        (folder / day).mkdir(parents=True)
        write_bag(folder / day / 'drive', drive(8.0))
    damaged = storage_file(write_bag(folder / 'damaged', braking(1.0)))
    damaged.write_bytes(b'junk')
    settings_file(tmp_path / 'config.yaml')
    return folder


def command(week: Path, *options: str) -> list[str]:
    return ['replay', str(week), '-o', str(week.parent / 'out'), '--config',
            str(week.parent / 'config.yaml'), *options]


def test_a_damaged_recording_is_named_and_does_not_keep_the_others(
        week: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command(week, '--jobs', '2')) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith('squeal risk known for 100 % of the braking time')
    assert lines[0].endswith('in 2 of 3 recordings')
    assert lines[1].startswith('not replayed: ')
    assert 'damaged' in lines[1]
    assert [line.split()[0] for line in lines[2:4]] == ['mon_drive', 'tue_drive']
    first, second = map(ReplayResult.load, find_results([week.parent / 'out']))
    assert (first.summary['partial'], second.name) == (False, 'drive')
    for result in (first, second):
        one, two = result.applications
        assert (one.known_share, one.alarm, two.alarm) == (1.0, True, True)
        assert one.peak_risk == max(row.squeal_risk for row in result.rows()
                                    if row.time_s <= one.end_s)
        (event, _) = result.events
        assert one.start_s < event.start_s < one.end_s
        assert event.clock_time.startswith('2023-11-14T22:13:2')
        assert (event.mode_number, event.mechanism) == (one.mode_number, 'mode coupling')
        # between the fixes at 0 and 2 s, as that at 1 s has no position
        assert event.latitude_deg == pytest.approx(48.0 + 0.01 * (event.start_s - START / SECOND))
        assert event.longitude_deg == 11.0
        speed = result.summary['inputs'][0]
        assert (speed['messages'], speed['gaps'], round(speed['rate_hz'])) == (160, 0, 20)
    assert main(command(week)) == 2
    assert 'exists, and 1 more of 3; give --force' in capsys.readouterr().err
    assert main(command(week, '--force', '--json', '--jobs', '1', '--from', '100')) == 2
    found = json.loads(capsys.readouterr().out)
    assert (found['recordings_replayed'], found['recordings_outside']) == (0, 2)
    assert len(find_results([week.parent / 'out'])) == 2  # they stay


def test_why_a_risk_is_known_in_part_and_on_a_full_disk_what_was_asked_for(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str]) -> None:
    kept = [one for one in braking(3.0) if not (
        one.topic.endswith('pressure') and 1.5 < (one.time - START) / SECOND < 2.3)]
    write_bag(tmp_path / 'week' / 'holes', kept)
    write_bag(tmp_path / 'week' / 'whole', braking(1.0))
    settings_file(tmp_path / 'config.yaml')
    assert main(command(tmp_path / 'week', '--jobs', '1')) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines()
               if line.startswith('known in part: ')]
    assert line.startswith('known in part: holes; top reason, ')
    assert '; remedy: ' in line

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, 'No space left on device')

    monkeypatch.setattr('squeal_ros.recordings.replay.replay_outputs.write_records', full)
    for name in ('new', 'new.mcap'):
        out = tmp_path / name
        assert main(['replay', str(tmp_path / 'week' / 'whole'), '-o', str(out),
                     *command(tmp_path / 'week')[4:], '--jobs', '1']) == 2
        err = capsys.readouterr().err
        assert f'{out}{"/whole" * (name == "new")}: cannot be written (No space left' in err
        assert PARTIAL not in err
        assert not out.exists()


def test_a_range_of_time(week: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By seconds, by the clock, by date: the second application, and what is beyond the end."""
    bag, out = week / 'mon' / 'drive', week.parent / 'part.mcap'
    for begin, end in (('4.5', '20'), ('22:13:24.5', '22:14'),
                       ('2023-11-14T22:13:24.5', '2023-11-14T23:14:00+01:00')):
        assert main(['replay', str(bag), '-o', str(out), '--force', '--from', begin, '--to', end,
                     *command(week)[4:]]) == 0
        assert f'note: --from {begin} --to {end}: the recording ends ' in capsys.readouterr().out
        result = ReplayResult.load(week.parent / 'part.summary.json')
        (one,) = result.applications
        assert one.start_s == pytest.approx(START / SECOND + 4.8, abs=0.11)
        assert result.summary['recording']['start_s'] == pytest.approx(START / SECOND + 4.5)
    for begin, end, said in (('soon', '5', 'seconds from the start'), ('5', '4', 'later time'),
                             ('9', '12', 'has nothing in --from 9 --to 12')):
        assert main(['replay', str(bag), '-o', str(out), '--force', '--from', begin, '--to', end,
                     *command(week)[4:]]) == 2
        assert said in capsys.readouterr().err
    night = Moment.read('--to', '00:05').at(START + 106 * 60 * SECOND, bag)  # from 23:59:20 on
    assert night == START + (111 * 60 + 40) * SECOND
    assert TimeRange.read(None, None) is None


def test_parquet_has_the_rows_of_the_csv(week: Path) -> None:
    pytest.importorskip('pyarrow', reason='needs pyarrow')
    bag, out = week / 'mon' / 'drive', week.parent / 'out'
    assert main(['replay', str(bag), '-o', str(out), *command(week, '--table', 'both')[4:]]) == 0
    result = ReplayResult.load(out / 'drive')
    columns = ('pressure_pa', 'squeal_risk')
    rows, blocks = repr(list(result.rows())), list(result.blocks(columns))
    result.paths.table.unlink()
    assert repr(list(result.rows())) == rows
    assert repr(list(result.blocks(columns))) == repr(blocks)
    assert len(rows) > 10_000


def test_an_interrupt_leaves_what_is_done(week: Path, monkeypatch: pytest.MonkeyPatch,
                                          capsys: pytest.CaptureFixture[str]) -> None:
    """In the second of three, whose first block is written and marked as partial."""
    taken = BatchProgress.set_part

    def struck(progress: BatchProgress, place: int, part: float) -> None:
        taken(progress, place, part)
        if place == 1 and 0.0 < part < 1.0:
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr(BatchProgress, 'set_part', struck)
    damaged = storage_file(week / 'damaged')
    damaged.unlink()
    assert main(command(week, '--jobs', '1', '--rate', '50')) == 130
    said = capsys.readouterr()
    assert 'partial: mon_drive, its first 5 s' in said.out
    assert 'not begun: 1 of 3 recordings' in said.out
    (result,) = map(ReplayResult.load, find_results([week.parent / 'out']))
    assert result.summary['partial'] is True
    assert len(list(result.rows())) == 256
    assert sorted(path.name for path in (week.parent / 'out').iterdir()) == ['mon_drive']


@pytest.mark.skipif(os.name != 'posix', reason='needs signals')
@pytest.mark.parametrize('number', [signal.SIGTERM, signal.SIGKILL])
def test_worker_processes_are_stopped(number: signal.Signals, week: Path) -> None:
    """Once both write: told to end they write what they have; killed, nothing reads as whole."""
    out = week.parent / 'out'
    bags = week.parent / 'bags'
    for name in ('one', 'two'):
        write_bag(bags / name, drive(16.0))  # neither is done before the other is begun
    with process(['-m', 'squeal_ros.cli', *command(bags, '--jobs', '2', '--rate', '1000')],
                 stdout=subprocess.PIPE, text=True, start_new_session=True) as started:
        writing = 0
        while writing < 2:
            assert started.poll() is None
            time.sleep(0.01)
            with suppress(FileNotFoundError):  # a folder may be renamed while it is looked into
                writing = sum(path.stat().st_size > 0
                              for path in out.glob(f'*{PARTIAL}/table.csv*'))
        started.send_signal(number)
        said = started.stdout.read()
        assert started.wait() == (130 if number == signal.SIGTERM else -number)
    if number == signal.SIGTERM:
        assert sum(line.startswith('partial: ') for line in said.splitlines()) == 2
        found = [ReplayResult.load(path).summary['partial'] for path in find_results([out])]
        assert found == [True, True]
    else:
        with pytest.raises(ResultError, match='holds no result'):
            find_results([out])


def test_names_of_results(tmp_path: Path) -> None:
    """As few folders as tell them apart; storage of two kinds beside each other by its suffix."""
    paths = [tmp_path / name for name in (
        'a/x/drive.mcap', 'b/x/drive.mcap', 'a.mcap', 'A.csv', 'b.mcap', 'a_b.mcap', 'a/b.mcap')]
    names = [one.name for one in plan_batch(paths, tmp_path)]
    assert names[:4] == ['a_x_drive', 'b_x_drive', 'a_mcap', 'A_csv']
    assert len({name.casefold() for name in names}) == 7


def test_tables_and_bags_with_one_file_of_signals(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Inputs with a column and a topic each; of bags a file of columns alone says nothing."""
    (tmp_path / 'week').mkdir()
    write_bag(tmp_path / 'week' / 'drive', braking(1.0))
    (tmp_path / 'week' / 'stop.csv').write_text(stop_text())
    columns = document()
    topics = {'rotor_speed': {'topic': 'joint_states', 'unit': 'rad/s', 'field':
                              'velocity[name=fl_wheel_joint]'},
              'pressure': {'topic': 'fl/brake_pressure', 'unit': 'Pa'},
              'friction': {'topic': 'fl/friction', 'unit': '-'}}
    both = document(clock={**columns['clock'], 'stamp': 'header'})
    both['brakes'] = {'fl': {signal: [one, topics[signal]] if signal in topics else one
                             for signal, one in columns['brakes']['fl'].items()}, 'fr': topics}
    both = json.loads(json.dumps(both))  # YAML without aliases
    settings_file(tmp_path / 'config.yaml')
    for name, content, brakes in (('both', both, {'fl', 'fr'}), ('columns', columns, {'fl'})):
        signals = signals_file(tmp_path / f'{name}.yaml', content)
        assert main([*command(tmp_path / 'week', '--signals', str(signals), '--jobs', '1'),
                     '--force']) == 0
        drive_result, stop_result = map(ReplayResult.load, find_results([tmp_path / 'out']))
        assert set(drive_result.summary['report']['brakes']) == brakes
        assert set(stop_result.summary['report']['brakes']) == {'fl'}
        assert stop_result.summary['settings'] != drive_result.summary['settings']
    assert 'columns.yaml names columns alone' in ' '.join(drive_result.summary['report']['notes'])
    assert main(['replay', str(tmp_path / 'week' / 'drive'), '-o', str(tmp_path / 'one'),
                 '--signals', str(signals)]) == 2
    assert 'is a bag, and' in capsys.readouterr().err
