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

"""Options of `squeal report`."""

import argparse

from squeal_ros.cli.command_parser import add_force

DESCRIPTION = ('Write one HTML page of what `squeal replay` wrote: what is known, squeal events, '
               'charts, timeline, worst mode. Of several results it says the differences first, '
               'of a fleet it shows vehicles, brakes, mileage, operating regions, recordings. '
               'Exit code 0: done; 1: no squeal risk is known in any of them, and the page says '
               'so; 2: the input is bad.')


def add_options(p: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    p.add_argument('results', nargs='+', metavar='OUT', help='folder that `squeal replay` wrote, '
                   'of one or many recordings, or a summary.json; several are compared; or the '
                   'folder of `squeal fleet`')
    p.add_argument('--pages', metavar='all|none|N', help='of the folder of a fleet: how many of '
                   'its recordings get a page of their own, the worst first (default 20)')
    p.add_argument('-o', '--output', default='report.html', metavar='PAGE.html',
                   help='default report.html')
    p.add_argument('--sound', nargs='+', metavar='MEASURED.csv', help='measured squeal, as '
                   '`squeal listen` writes it, on the clock of the recordings: compared with the '
                   'predicted one')
    p.add_argument('--stretch', type=float, nargs=2, metavar=('T0', 'T1'),
                   help='of the timeline: s as in events.csv, or from the start of the recording '
                   '(default: the whole recording with the worst event)')
    add_force(p)
    p.add_argument('--json', action='store_true')
