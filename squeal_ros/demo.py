"""The demo: player, node and replay together, from a drive cycle to a picture."""

from collections.abc import Iterator
from contextlib import contextmanager
import ctypes
from dataclasses import dataclass, replace
from pathlib import Path
import signal
import subprocess
import sys

import numpy as np

from squeal_core import resources
from squeal_core.brake_model import BrakeModel
from squeal_core.drive_cycle import DriveCycle
from squeal_core.errors import SquealError
from squeal_core.history import Row
from squeal_core.settings import load_settings, MONITOR_KEYS, MonitorSettings
from squeal_core.vehicle import brake_signals, BrakeSignals, Vehicle
from squeal_core.view.table import DriveDisplay
from squeal_ros.bag import BagWriter
from squeal_ros.drive import BrakePlayer, ORIGIN
from squeal_ros.replay import Outputs, replay

_START_UP = 30.0  # s that the node may take to subscribe
_RATES = ('margin_rate', 'margin_full_rate')  # of work beside the assessments
_DELAYS = ('anchor_delay', 'risk_delay')  # in which something is made, in real time
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


@dataclass(frozen=True, kw_only=True)
class DemoFiles:
    """What a demo leaves in its folder."""

    folder: Path

    @property
    def inputs(self) -> Path:
        return self.folder / 'inputs.mcap'

    @property
    def outputs(self) -> Path:
        return self.folder / 'outputs.mcap'

    @property
    def picture(self) -> Path:
        return self.folder / 'drive.png'

    def clear(self) -> None:
        """Make room for a new demo: only files a demo wrote are removed."""
        self.folder.mkdir(parents=True, exist_ok=True)
        for path in (self.inputs, self.outputs, self.outputs.with_suffix('.csv'), self.picture):
            path.unlink(missing_ok=True)


@dataclass(frozen=True)
class LiveDrive:
    """What was heard of the node while the drive ran."""

    rows: tuple[Row, ...]
    ticks_done: int
    ticks_lost: int


@contextmanager
def monitor_process(config: Path, settings: MonitorSettings
                    ) -> Iterator[subprocess.Popen[bytes]]:
    """Run the node as its own process for as long as the context lasts."""
    values = {'use_sim_time': 'true', 'diagnostics_rate': 2.0 * settings.rate, **{
        name: getattr(settings, name) for name in ('rate', *_DELAYS, *_RATES)}}
    process = subprocess.Popen(
        [sys.executable, '-m', 'squeal_ros.node', '--ros-args', '--log-level', 'warn',
         '--params-file', str(config),
         *(word for name, value in values.items() for word in ('-p', f'{name}:={value}'))],
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


def _end_with_parent() -> None:
    """Have the kernel end this process when its parent is killed (Linux; elsewhere nothing)."""
    if sys.platform == 'linux':
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def signals_of(cycle: DriveCycle, vehicle: Vehicle, model: BrakeModel, *, rate: float,
               duration: float | None = None) -> BrakeSignals:
    """Return brake signals of a cycle or its first seconds; friction by the model's table."""
    if duration is not None:
        kept = cycle.time <= cycle.time[0] + duration
        cycle = replace(cycle, time=cycle.time[kept], speed=cycle.speed[kept])
    if model.friction_table is None:
        raise SquealError('this model has no friction table over temperature; add '
                          'friction.temperature_table to its brake description and build it again')
    return brake_signals(cycle, vehicle, model.friction_table, rate=rate)


def run_live(signals: BrakeSignals, config: Path, inputs: Path, display: DriveDisplay, *,
             settings: MonitorSettings, speed_up: float) -> LiveDrive:
    """Play the signals to a node of its own, record them, show and keep what it says."""
    rows: list[Row] = []
    done = lost = 0
    with (monitor_process(config, settings) as process, BrakePlayer(signals) as player,
          BagWriter(inputs) as bag):
        if not player.wait_for_listener(_START_UP, still_alive=lambda: process.poll() is None):
            raise SquealError(f'the monitor did not subscribe within {_START_UP:.0f} s; see what '
                              'it says above, and check ROS_DOMAIN_ID and the network settings')
        with display.running():
            for heard in player.play(speed_up=speed_up, record=bag.write):
                if process.poll() is not None:
                    raise SquealError(f'the monitor ended with code {process.returncode} during '
                                      'the drive; see what it says above')
                for progress in heard:
                    rows.extend(progress.rows)
                    done, lost = progress.ticks_done, progress.ticks_lost
                    at = progress.rows[0].time_s - ORIGIN * 1e-9
                    speed = float(np.interp(at, signals.time, signals.vehicle_speed))
                    display.update(at, speed, progress.rows, done, lost)
    return LiveDrive(tuple(rows), done, lost)


def replay_inputs(files: DemoFiles, settings: MonitorSettings, model: BrakeModel) -> list[Row]:
    """Replay the recorded inputs into a bag and a table beside them."""
    outputs = Outputs(files.outputs, settings)
    outputs.write(replay(files.inputs, settings, model))
    return outputs.rows


def on_drive_time(row: Row) -> Row:
    """Return a row with its time counted from the start of the drive."""
    return replace(row, time_s=round(row.time_s - ORIGIN * 1e-9, 6))


def default_config() -> Path:
    """Return the shipped settings of the monitor."""
    return resources.config_folder() / 'monitor.yaml'


def demo_settings(config: Path, rate: float, speed_up: float) -> MonitorSettings:
    """Return the settings under which the demo's node runs: time runs faster, work does not."""
    settings = load_settings(config)
    factors = {**dict.fromkeys(_DELAYS, speed_up), **dict.fromkeys(_RATES, 1.0 / speed_up)}
    scaled = {key.name: min(max(factors[key.name] * getattr(settings, key.name), key.minimum),
                            key.maximum) for key in MONITOR_KEYS if key.name in factors}
    return replace(settings, rate=rate, **scaled)
