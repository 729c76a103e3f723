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

"""Replay in two processes: the same outputs, and nothing left when either one ends."""

from collections.abc import Iterator
import os
from pathlib import Path
import signal
import subprocess
import sys

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.rosbag2 import Reader  # noqa: E402
from squeal_core.common.errors import SquealError  # noqa: E402
from squeal_core.common.output import check_target  # noqa: E402
from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_core.monitor.settings import MonitorSettings, read_settings  # noqa: E402
from squeal_core.monitor.vehicle_monitor import PreparedTick  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import BagError  # noqa: E402
from squeal_ros.recordings.replay import evaluation_process  # noqa: E402
from squeal_ros.recordings.replay.evaluation_process import write_replay  # noqa: E402
from squeal_ros.recordings.replay.replay import Replay  # noqa: E402
from squeal_ros.recordings.replay.replay_outputs import Outputs  # noqa: E402
from support.bags import braking, replay_of, storage_file, write_bag  # noqa: E402, I100
from support.processes import process  # noqa: E402


@pytest.fixture
def settings() -> MonitorSettings:
    return read_settings({'brakes': ['fl']})


ENDINGS = ('csv', 'events.csv', 'applications.csv', 'summary.json')


def contents(path: Path) -> list[tuple[str, str, int, bytes]]:
    with Reader(path) as reader:
        return [(c.topic, c.msgtype, time, data) for c, time, data in reader.messages()]


@pytest.mark.parametrize('brakes', [('fl',), ('fl', 'fr', 'rl')])
def test_the_same_outputs_as_of_one_process(tmp_path: Path, brakes: tuple[str, ...],
                                            kang: BrakeModel,
                                            monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluation_process, '_MANY_MESSAGES', 0)
    settings = read_settings({'brakes': [*brakes]})
    bag = write_bag(tmp_path / 'bag', [
        entry for number, brake in enumerate(brakes)
        for entry in braking(3.0, joint=f'{brake}_wheel_joint', topics=f'/{brake}',
                             pressure=(8 - number) * 1e5)])
    outputs = {}
    for parallel in (False, True):
        folder = tmp_path / str(parallel)
        folder.mkdir()
        replay = replay_of(bag, settings, kang)
        written = outputs[parallel] = Outputs(folder / 'out.mcap', settings)
        write_replay(replay, written, parallel=parallel)
        assert replay.findings == []
        assert sorted(path.name for path in folder.iterdir()) == sorted([
            'out.mcap', *(f'out.{end}' for end in ENDINGS)])
    one, two = outputs.values()
    assert contents(one.path) == contents(two.path) != []
    for path, other in zip(one.paths, two.paths, strict=True):
        if path.suffix == '.csv':
            assert path.read_bytes() == other.read_bytes()
    assert repr(one.events) == repr(two.events)
    assert (one.summary.brakes, one.summary.ticks) == (two.summary.brakes, 31)
    assert [*two.summary.brakes] == [*brakes]
    assert repr(one.recorder.applications.applications) == repr(
        two.recorder.applications.applications)


def test_short_bags_are_left_to_one_process(tmp_path: Path, settings: MonitorSettings,
                                            kang: BrakeModel,
                                            monkeypatch: pytest.MonkeyPatch) -> None:
    replay = replay_of(write_bag(tmp_path / 'bag', braking(1.0)), settings, kang)
    assert replay.messages == 60
    monkeypatch.setattr(evaluation_process, '_EvaluationProcess', None)
    write_replay(replay, Outputs(tmp_path / 'out.mcap', settings))
    monkeypatch.setattr(evaluation_process, '_FEW_MESSAGES', 60)
    monkeypatch.setattr(os, 'cpu_count', lambda: 1)
    write_replay(replay, Outputs(tmp_path / 'other.mcap', settings))
    monkeypatch.setattr(os, 'cpu_count', lambda: 2)
    with pytest.raises(TypeError):  # there is no other process
        write_replay(replay, Outputs(tmp_path / 'third.mcap', settings))


def test_errors_of_either_process_leave_nothing(tmp_path: Path, settings: MonitorSettings,
                                                kang: BrakeModel) -> None:
    bag = write_bag(tmp_path / 'bag', braking(2.0))
    (tmp_path / 'out.csv').write_text('kept')
    with pytest.raises(SquealError, match=r'out\.csv: exists; give --force'):
        write_replay(replay_of(bag, settings, kang), Outputs(tmp_path / 'out.mcap', settings),
                     parallel=True)
    damaged = replay_of(bag, settings, kang)
    file = storage_file(bag)
    file.write_bytes(b'junk')
    with pytest.raises(BagError, match='cannot be read'):
        write_replay(damaged, Outputs(tmp_path / 'new.mcap', settings), parallel=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['bag', 'out.csv']


def test_a_process_that_is_killed_is_an_error(tmp_path: Path, settings: MonitorSettings,
                                              kang: BrakeModel,
                                              monkeypatch: pytest.MonkeyPatch) -> None:
    replay = replay_of(write_bag(tmp_path / 'bag', braking(2.0)), settings, kang, block=1)
    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen
    monkeypatch.setattr(subprocess, 'Popen',
                        lambda *a, **k: started.append(popen(*a, **k)) or started[-1])

    def blocks(every: Iterator[list[PreparedTick]]) -> Iterator[list[PreparedTick]]:
        yield next(every)
        started[0].kill()
        yield from every

    monkeypatch.setattr(replay, 'blocks', lambda: blocks(Replay.blocks(replay)))
    with pytest.raises(SquealError, match='ended with code -9'):
        write_replay(replay, Outputs(tmp_path / 'out.mcap', settings), parallel=True)


_ENDLESS = """
from itertools import cycle
from pathlib import Path
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import read_settings
from squeal_ros.interrupts import InterruptOnce
from squeal_ros.recordings.recording_files import open_recording
from squeal_ros.recordings.replay.evaluation_process import write_replay
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_outputs import Outputs
settings = read_settings({'brakes': ['fl']})
replay = Replay(open_recording('bag', settings), settings, BrakeModel.load('kang2009'), block=1)
whole, said = list(replay.blocks()), []
def blocks():
    for block in cycle(whole):
        if not said and [*Path().glob('*.squeal-part')]:
            said.append(print('on', flush=True))
        yield block
replay.blocks = blocks
with InterruptOnce():
    write_replay(replay, Outputs(Path('out.mcap'), settings), parallel=True)
"""


@pytest.mark.skipif(os.name != 'posix', reason='needs signals')
@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGINT])
def test_nothing_is_left_when_the_reading_process_ends(number: signal.Signals,
                                                       tmp_path: Path) -> None:
    write_bag(tmp_path / 'bag', braking(1.0))
    with process(['-c', _ENDLESS], {**os.environ, 'PYTHONPATH': os.pathsep.join(sys.path)},
                 cwd=tmp_path, text=True, stdout=subprocess.PIPE,
                 stderr=subprocess.PIPE) as started:
        on = started.stdout.readline()  # files are being written
        assert on == 'on\n', started.communicate()[1]
        started.send_signal(number)
        _, said = started.communicate()  # the other process holds the pipe of the errors, too
    assert said.count('Traceback') == (number != signal.SIGKILL)  # that of the script above
    if number == signal.SIGKILL:
        check_target(tmp_path / 'next.mcap')  # as the next run does
    assert [path.name for path in tmp_path.iterdir()] == ['bag']
