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
Speed of `squeal replay` on hours of driving: four brakes at 10 Hz in US06 cycles.

Run: python benchmark/recordings.py [--cycles 6] [--friction 1.3]

The cycles are replayed as one recording and as one recording each. Times are those of the command
as a process of its own with all that it starts; memory is the peak of its first process, of one
cycle and of all.
"""

import argparse
import os
from pathlib import Path
import subprocess
import sys
from tempfile import TemporaryDirectory
import time

from squeal_ros.recordings.bags.bag_reader import Bag
from squeal_ros.recordings.bags.bag_writer import BagWriter

START = 1_764_000_000  # s
PAUSE = 602  # s from one cycle to the next
BRAKES = ('front_left', 'front_right', 'rear_left', 'rear_right')


def squeal(*arguments: object) -> tuple[float, float, float]:
    """Run a command; return elapsed and processor time [s], peak memory [MB]."""
    begun = time.perf_counter()
    process = subprocess.Popen([sys.executable, '-m', 'squeal_ros.cli', *map(str, arguments)],
                               stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        raise SystemExit(f'squeal {arguments[0]} ended with {process.returncode}')
    return (time.perf_counter() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e3)


def copy(cycle: Bag, kinds: dict[str, str], out: BagWriter, seconds: int) -> None:
    """Write a cycle once more, so much later."""
    for topic, now, message, _ in cycle.messages(kinds):
        if hasattr(message, 'header'):
            message.header.stamp.sec += seconds
        out.write(topic, kinds[topic], now + seconds * 1_000_000_000, message)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--cycles', type=int, default=6, help='of ten minutes (default 6)')
    parser.add_argument('--friction', type=float, default=1.3,
                        help='factor on the friction, so that there are events (default 1.3)')
    options = parser.parse_args()
    with TemporaryDirectory() as name:
        folder = Path(name)
        squeal('drive', 'us06', '--offline', '--record', folder / 'us06.mcap')
        cycle = Bag(folder / 'us06.mcap')
        kinds = {topic: next(iter(types)) for topic, types in cycle.types.items()}
        (folder / 'each').mkdir()
        with BagWriter(folder / 'all.mcap') as out:
            for number in range(options.cycles):
                copy(cycle, kinds, out, START + number * PAUSE)
        for number in range(options.cycles):
            with BagWriter(folder / 'each' / f'drive_{number}.mcap') as out:
                copy(cycle, kinds, out, START + number * PAUSE)
        config = folder / 'monitor.yaml'
        config.write_text('/**: {ros__parameters: {model: kang2009_damped, ' + ', '.join(
            f'{brake}: {{friction: {{scale: {options.friction}}}}}' for brake in BRAKES) + '}}')
        for words, recording in (('one cycle', folder / 'each' / 'drive_0.mcap'),
                                 ('all as one recording', folder / 'all.mcap'),
                                 ('all as one each', folder / 'each')):
            elapsed, cpu, memory = squeal('replay', recording, '-o', folder / words.replace(
                ' ', '_'), '--config', config)
            print(f'{words}: {elapsed:.1f} s, {cpu:.1f} s of processor time, peak memory '
                  f'{memory:.0f} MB', flush=True)


if __name__ == '__main__':
    main()
