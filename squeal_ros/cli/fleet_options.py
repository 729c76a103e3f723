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


"""Options of `squeal fleet`."""

import argparse
import os

from squeal_ros.cli.replay_options import add_monitor_options

OUTPUT = 'fleet'
DESCRIPTION = ('Evaluate the recordings of a fleet, each as `squeal replay` does, on the '
               'processors of this machine or on a Dask cluster, and write tables over all of '
               'them; `squeal report` makes a page of these. What was evaluated before with the '
               'same content is kept. Exit code 0: all recordings were evaluated; 1: some could '
               'not be, and are listed, or no squeal risk was known; 2: none could, or settings, '
               'output or scheduler cannot be used; 130: interrupted, and what was done is '
               'written.')


def add_options(p: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    p.add_argument('recordings', nargs='+', metavar='RECORDING', help='file, folder or pattern, '
                   'as of `squeal replay`')
    p.add_argument('-o', '--output', default=OUTPUT, metavar='RESULTS', help='folder of results, '
                   f'a new one or that of an earlier run (default {OUTPUT})')
    p.add_argument('--vehicles', metavar='VEHICLES.csv', help='columns recording (a name or a '
                   'pattern), vehicle, mileage_km; default: the vehicle is the folder within that '
                   'of all recordings')
    engine = p.add_mutually_exclusive_group()
    engine.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                        help='processes on this machine (default: one for each core)')
    engine.add_argument('--scheduler', default='', metavar='tcp://HOST:PORT', help='of a Dask '
                        'cluster whose workers have this software, and see recordings and RESULTS')
    p.add_argument('--retries', type=int, default=3, metavar='N', help='for a recording that '
                   'fails by no fault of its own, and for a scheduler that is lost (default 3)')
    p.add_argument('--timeout', type=float, default=60.0, metavar='S', help='give up where the '
                   'scheduler does not answer, or has no worker, for so long (default 60)')
    p.add_argument('--stall', type=float, default=7200.0, metavar='S', help='give up where no '
                   'recording ends for so long (default 7200)')
    add_monitor_options(p)
    p.add_argument('--json', action='store_true')
