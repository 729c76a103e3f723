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

"""
Speed of `squeal replay`: four brakes at 100 Hz that brake two thirds of the time.

Run: python benchmark/replay.py [--seconds 40] [--against CHECKOUT] [--table TABLE.npz]

Times are those of the command as a process of its own, on a bag and on its first quarter: their
difference, over the difference in length, leaves out what starting costs; not so the start of a
second process that evaluates, which a bag of 112 s has and a shorter one has not. With --against
the same bags are replayed by another checkout in turns. Memory is the peak of either length.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Sequence
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any, NamedTuple

import numpy as np

from squeal_core import BrakeModel  # noqa: I100
from squeal_core.stability.eigensolution import complex_modes
from squeal_ros.recordings.bags.bag_writer import BagMessages, BagWriter

BRAKES = ('front_left', 'front_right', 'rear_left', 'rear_right')
RATE = 100  # Hz
START = 1_700_000_000_000_000_000  # ns
HERE = Path(__file__).resolve().parent.parent


class Cost(NamedTuple):
    """What a replay took: processor and elapsed time [s], peak memory [MB]."""

    cpu: float
    elapsed: float
    memory: float


def inputs_at(seconds: float) -> tuple[Any, Any, float]:
    """Return rotor speeds, pressures (4,) and friction: brakings from 75 to 5 rad/s, noisy."""
    phase = seconds % 15.0
    speed = 75.0 - 7.0 * phase if phase < 10.0 else 5.0 + 14.0 * (phase - 10.0)
    pressure = 1.5e6 + 5e5 * np.sin(1.1 * seconds) if phase < 10.0 else 0.0
    noise = np.random.default_rng(round(seconds * RATE)).normal(size=(2, 4))
    return (speed + 0.02 * noise[0], pressure * np.array([1.0, 1.0, 0.8, 0.8]) + 500.0 * noise[1],
            0.42 + 0.02 * float(np.sin(0.2 * seconds)))


def write_bag(path: Path, seconds: float) -> Path:
    """Write what a vehicle publishes: one list of joints, four pressures and frictions a tick."""
    library, empty = BagMessages(), np.zeros(0)
    header, stamp = (library.type(name) for name in (
        'std_msgs/msg/Header', 'builtin_interfaces/msg/Time'))
    kinds = ('sensor_msgs/msg/JointState', 'sensor_msgs/msg/FluidPressure', 'std_msgs/msg/Float64')
    joints, pressed, number = map(library.type, kinds)
    names = [f'{brake}_wheel_joint' for brake in BRAKES]
    with BagWriter(path) as bag:
        for tick in range(round(seconds * RATE)):
            now = START + tick * 1_000_000_000 // RATE - 2_000_000
            speed, pressure, friction = inputs_at(tick / RATE)
            head = header(stamp(now // 1_000_000_000, now % 1_000_000_000), '')
            bag.write('/joint_states', kinds[0], now, joints(head, names, empty, speed, empty))
            for brake, value in zip(BRAKES, pressure.tolist(), strict=True):
                bag.write(f'/{brake}/brake_pressure', kinds[1], now, pressed(head, value, 0.0))
                bag.write(f'/{brake}/friction', kinds[2], now, number(friction))
    return path


def replayed(checkout: Path, bag: Path, config: Path, output: Path,
             options: Sequence[str]) -> Cost:
    """Replay a bag by the command of a checkout."""
    for file in output.parent.glob(f'{output.stem}.*'):
        file.unlink()
    start = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, '-m', 'squeal_ros.cli', 'replay', str(bag), '-o', str(output),
         '--config', str(config), '--rate', str(RATE), *options],
        cwd=output.parent, env={**os.environ, 'PYTHONPATH': str(checkout)},
        stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        raise SystemExit(f'{checkout}: squeal replay ended with {process.returncode}')
    return Cost(used.ru_utime + used.ru_stime, time.perf_counter() - start, used.ru_maxrss / 1e3)


def full_solve() -> float:
    """Return the median processor time of a full solution on this machine now [s]."""
    model = BrakeModel.load('kang2009')
    point = model.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    times = []
    for _ in range(21):
        start = time.process_time()
        complex_modes(model, point)
        times.append(time.process_time() - start)
    return float(np.median(times))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=40.0, help='length of the bag')
    parser.add_argument('--rounds', type=int, default=1)
    parser.add_argument('--against', type=Path, metavar='CHECKOUT', help='another version')
    parser.add_argument('--table', default='', help='of `squeal tabulate`, for this version')
    arguments, options = parser.parse_known_args()
    lengths = (0.25 * arguments.seconds, arguments.seconds)
    checkouts = {'this version': HERE}
    if arguments.against:
        checkouts['the other'] = arguments.against.resolve()
    with TemporaryDirectory() as name:
        folder = Path(name)
        bags = [write_bag(folder / f'in{i}.mcap', length) for i, length in enumerate(lengths)]
        tables = {HERE: folder / 'table.yaml', None: folder / 'none.yaml'}
        for config, table in zip(tables.values(), (arguments.table, ''), strict=True):
            config.write_text("/**:\n  ros__parameters:\n    table: '"
                              f"{table and Path(table).resolve()}'\n")
        for _ in range(arguments.rounds):
            for words, checkout in checkouts.items():
                own = checkout == HERE
                short, long = (replayed(checkout, bag, tables[HERE if own else None],
                                        folder / 'out.mcap', options if own else ())
                               for bag in bags)
                solve = full_solve()
                cpu, elapsed = (a - b for a, b in zip(long[:2], short[:2], strict=True))
                passed = lengths[1] - lengths[0]
                print(f'{words}: a second of bag takes {1e3 * cpu / passed:.0f} ms of processor '
                      f'time and {1e3 * elapsed / passed:.0f} ms in all, '
                      f'for a brake and tick {cpu / passed / RATE / 4 / solve:.4f} times '
                      f'a full solution ({1e3 * solve:.1f} ms); {lengths[1]:.0f} s took '
                      f'{long.elapsed:.1f} s; peak memory {short.memory:.0f} and '
                      f'{long.memory:.0f} MB', flush=True)


if __name__ == '__main__':
    main()
