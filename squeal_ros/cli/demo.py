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

"""The demo: player, node and replay together, from a drive cycle to a plot."""

from collections.abc import Iterator
from contextlib import contextmanager
import ctypes
from dataclasses import dataclass
import os
from pathlib import Path
import signal
import socket
import subprocess
import sys

import numpy as np
from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.common.output import check_target, make_folder, OutputFiles
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.history import AssessmentRecord, CsvWriter, read_rows
from squeal_core.monitor.results.result_files import ResultPaths
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.vehicle.vehicle_model import BrakeSignals
from squeal_core.view.table import DriveDisplay
from squeal_ros.cli.drive_signals import ORIGIN
from squeal_ros.cli.player import BrakePlayer
from squeal_ros.recordings.bags.bag_writer import BagWriter
from squeal_ros.recordings.recording_files import open_recording
from squeal_ros.recordings.replay.agreement import Agreement, agreement
from squeal_ros.recordings.replay.evaluation_process import write_replay
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_outputs import Outputs
from squeal_ros.recordings.replay.replay_report import ReplayReport

NAMESPACE = '/squeal_demo'
MODEL = 'kang2009_damped'  # squeals in some brakings; kang2009 itself is unstable in nearly all
_START_UP = 120.0  # s that the node may take to subscribe, on a machine that is busy
_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_RANGE, _LOCALHOST = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST'
_DOMAINS = 100  # of those whose ports are below the ones that the kernel gives to anyone
_HELD_PORT = 47000  # one for each domain
_FIRST_PORT, _PORTS_PER_DOMAIN = 7410, 250  # DDSI-RTPS 9.6.2: of a domain's first participant
_PARTICIPANTS = 8  # of a domain, whose ports are tried


@dataclass(frozen=True, kw_only=True)
class DemoFiles:
    """Files of a demo in its folder."""

    folder: Path

    @property
    def inputs(self) -> Path:
        """Return the path of the input bag."""
        return self.folder / 'inputs.mcap'

    @property
    def outputs(self) -> Path:
        """Return the path of the output bag of the replay."""
        return self.folder / 'outputs.mcap'

    @property
    def table(self) -> Path:
        """Return the path of the CSV table of the replay."""
        return self.outputs.with_suffix('.csv')

    @property
    def live_table(self) -> Path:
        """Return the path of the CSV table of the live node."""
        return self.folder / 'live.csv'

    @property
    def plot(self) -> Path:
        """Return the path of the plot of the drive."""
        return self.folder / 'drive.png'

    def described(self) -> Iterator[tuple[str, Path]]:
        """Yield the description of each file, and its path."""
        yield 'plot of the drive', self.plot
        yield 'recorded inputs', self.inputs
        yield 'table of the node', self.live_table
        yield 'replayed outputs', self.outputs
        yield 'their table', self.table
        paths = ResultPaths.beside(self.outputs)
        yield 'their events', paths.events
        yield 'their brake applications', paths.applications
        yield 'summary of the replay', paths.summary

    def prepare(self, *, force: bool) -> None:
        """
        Make room for a new demo; files of an earlier one are removed only if they may be.

        Raises
        ------
        OutputError
            For files that are there, or a folder that cannot be written to.

        """
        make_folder(self.folder)
        for _, path in self.described():
            check_target(path, overwrite=force)
        for _, path in self.described():  # no mixture of two demos if this one fails
            path.unlink(missing_ok=True)

    def replayed_rows(self) -> Iterator[AssessmentRecord]:
        """Yield the replayed assessments, on the drive's time."""
        return map(on_drive_time, read_rows(self.table))

    def live_rows(self) -> Iterator[AssessmentRecord]:
        """Yield the assessments of the node, on the drive's time."""
        return map(on_drive_time, read_rows(self.live_table))


@dataclass(frozen=True)
class LiveDrive:
    """Ticks of the node during the drive: done and lost."""

    ticks_done: int
    ticks_lost: int


@contextmanager
def own_domain() -> Iterator[int]:
    """
    Reserve a ROS domain that no other process of this machine is in.

    A participant binds the UDP port that its domain and number give; those of the first numbers
    are tried, as number 0 may have left. Two demos that start at once are kept apart by a port
    that each holds.
    """
    start = os.getpid()
    for offset in range(_DOMAINS):
        domain = (start + offset) % _DOMAINS + 1
        if str(domain) == os.environ.get('ROS_DOMAIN_ID'):
            continue
        with socket.socket() as held:
            try:
                held.bind(('127.0.0.1', _HELD_PORT + domain))
                for number in range(_PARTICIPANTS):
                    with socket.socket(type=socket.SOCK_DGRAM) as probe:
                        probe.bind(('', _FIRST_PORT + _PORTS_PER_DOMAIN * domain + 2 * number))
            except OSError:
                continue
            yield domain
            return
    raise SquealError(f'all ROS domains from 1 to {_DOMAINS} are in use; end some of their '
                      'processes')


def how_to_listen(domain: int) -> str:
    """Return instructions for a terminal to join the demo."""
    return (f'in ROS domain {domain}, namespace {NAMESPACE}; to listen: ROS_DOMAIN_ID={domain} '
            f'{_RANGE}={_LOCALHOST} ros2 topic list')


@contextmanager
def monitor_process(config: Path, settings: MonitorSettings, domain: int
                    ) -> Iterator[subprocess.Popen[bytes]]:
    """Run the node as its own process, in the demo's domain, for as long as the context lasts."""
    values = {'use_sim_time': 'true', 'diagnostics_rate': 2.0 * settings.rate,
              'rate': settings.rate, 'model': settings.model}
    process = subprocess.Popen(
        [sys.executable, '-m', 'squeal_ros.node', '--ros-args', '--log-level', 'warn',
         '--params-file', str(config), '-r', f'__ns:={NAMESPACE}', *_remapped(settings),
         *(word for name, value in values.items() for word in ('-p', f'{name}:={value}'))],
        env={**os.environ, 'ROS_DOMAIN_ID': str(domain), _RANGE: _LOCALHOST},
        start_new_session=True,  # Ctrl-C reaches the player first, which then ends the node
        preexec_fn=_end_with_parent)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _remapped(settings: MonitorSettings) -> Iterator[str]:
    """Yield the arguments that bring topics given in full into the demo's namespace."""
    for topic in sorted({source.topic for brake in settings.brakes
                         for source in brake.inputs.values() if source.topic.startswith('/')}):
        yield from ('-r', f'{topic}:={NAMESPACE}{topic}')


def _end_with_parent() -> None:
    """End this process when its parent is killed (Linux; elsewhere nothing)."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def run_live(signals: BrakeSignals, config: Path, files: DemoFiles, display: DriveDisplay, *,
             settings: MonitorSettings, speed_up: float, domain: int) -> LiveDrive:
    """Play the signals to a node of its own; record them, show and write its answers."""
    done = lost = 0
    with (OutputFiles() as outputs, monitor_process(config, settings, domain) as process,
          BrakePlayer(signals, namespace=NAMESPACE, domain=domain) as player,
          BagWriter(files.inputs, outputs) as bag,
          outputs.add(files.live_table).partial.open('w', encoding='utf-8', newline='') as file):
        table = CsvWriter(file)
        if not player.wait_for_listener(_START_UP, still_alive=lambda: process.poll() is None):
            raise SquealError(f'the monitor did not subscribe within {_START_UP:.0f} s; see what '
                              'it says above, and check the network settings')
        with display.running():
            for heard in player.play(speed_up=speed_up, lag=0.99 / settings.rate,
                                     record=bag.write):
                if process.poll() is not None:
                    raise SquealError(f'the monitor ended with code {process.returncode} during '
                                      'the drive; see what it says above')
                for progress in heard:
                    if not progress.ticks_done or not progress.rows:
                        continue  # it waits for the clock
                    for row in progress.rows:
                        table.write(row)
                    done, lost = progress.ticks_done, progress.ticks_lost
                    at = progress.rows[0].time_s - ORIGIN * 1e-9
                    speed = float(np.interp(at, signals.time, signals.vehicle_speed))
                    display.update(at, speed, progress.rows, done, lost)
    return LiveDrive(done, lost)


def replay_inputs(files: DemoFiles, settings: MonitorSettings, model: BrakeModel
                  ) -> tuple[ReplayReport, list[SquealEvent]]:
    """Replay the recorded inputs into a bag and a table beside them."""
    outputs = Outputs(files.outputs, settings)
    ticks = Replay(open_recording(files.inputs, settings), settings, model)
    write_replay(ticks, outputs, parallel=False)
    events = [event._replace(start_s=_on_drive_time(event.start_s),
                             end_s=_on_drive_time(event.end_s))
              for event in outputs.events]
    return outputs.report(ticks, events), events


def compare(files: DemoFiles) -> Agreement:
    """Compare the node's answers with the replay."""
    return agreement(files.live_rows(), files.replayed_rows())


def _on_drive_time(seconds: float) -> float:
    return round(seconds - ORIGIN * 1e-9, 6)


def on_drive_time(row: AssessmentRecord) -> AssessmentRecord:
    """Return a row with its time counted from the start of the drive."""
    return row._replace(time_s=_on_drive_time(row.time_s))


def default_config() -> Path:
    """Return the shipped settings of the monitor."""
    return resources.config_folder() / 'monitor.yaml'
