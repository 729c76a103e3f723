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
Speed of `squeal fleet`: the same recordings with one worker and with two, in turns.

Run: python benchmark/fleet.py [--recordings 12] [--seconds 60] [--rounds 2]

Each recording is a part of a US06 cycle with four brakes at 10 Hz. Efficiency is the rate with
two workers over twice that with one, by elapsed time, which counts other work of the machine,
and the processor time with one over that with two, which does not. The time that client and
workers take to start is measured by a second run, which computes nothing, and taken off.
"""

import argparse
import os
from pathlib import Path
import statistics
from tempfile import TemporaryDirectory

from recordings import copy, squeal, START
from squeal_ros.recordings.bags.bag_reader import Bag
from squeal_ros.recordings.bags.bag_writer import BagWriter

DAY = 86_400  # s


def make(folder: Path, count: int, seconds: float) -> Path:
    """Write recordings of one vehicle, one a day."""
    squeal('drive', 'us06', '--offline', '--duration', seconds, '--record', folder / 'us06.mcap')
    cycle = Bag(folder / 'us06.mcap')
    kinds = {topic: next(iter(types)) for topic, types in cycle.types.items()}
    (folder / 'fleet').mkdir()
    for number in range(count):
        with BagWriter(folder / 'fleet' / f'drive_{number}.mcap') as out:
            copy(cycle, kinds, out, START + number * DAY)
    return folder / 'fleet'


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--recordings', type=int, default=12)
    parser.add_argument('--seconds', type=float, default=60.0, help='of each (default 60)')
    parser.add_argument('--rounds', type=int, default=2)
    options = parser.parse_args()
    work: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    with TemporaryDirectory() as name:
        folder = Path(name)
        recordings = make(folder, options.recordings, options.seconds)
        for number in range(options.rounds):
            for workers in work:
                out = folder / f'out_{number}_{workers}'
                whole, start = (squeal('fleet', recordings, '-o', out, '--workers', workers)
                                for _ in range(2))
                work[workers].append((whole[0] - start[0], whole[1] - start[1]))
                print(f'{workers} workers: {whole[0]:.1f} s, {whole[1]:.1f} s of processor time; '
                      f'again, nothing new: {start[0]:.1f} s, {start[1]:.1f} s; load '
                      f'{os.getloadavg()[0]:.1f}', flush=True)
    one, two = ([statistics.median(part) for part in zip(*work[count], strict=True)]
                for count in (1, 2))
    hours = options.recordings * options.seconds / 3600.0
    print(f'efficiency of two workers: {one[0] / two[0] / 2.0:.2f} by elapsed time, '
          f'{one[1] / two[1]:.2f} by processor time; an hour of a vehicle takes '
          f'{two[1] / hours:.0f} s of one processor')


if __name__ == '__main__':
    main()
