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

"""Options of `squeal replay`."""

import argparse
import os

from squeal_ros.cli.command_parser import add_force

OUTPUT = 'replayed'
RECORDINGS = 'rosbag2 folder, .mcap or .db3 file, table; folders and patterns of these'
DESCRIPTION = ('Run the monitor over recordings. Each gets a folder with the topics of the node, '
               'a table of its ticks, events, brake applications and a summary. Exit code 0: the '
               'squeal risk of every brake that braked was known; 1: that of a brake never was, '
               'or some recordings could not be read; 2: none could, or settings or output '
               'cannot be used; 130: interrupted, and what was done is written.')


def add_options(p: argparse.ArgumentParser) -> None:
    p.add_argument('recordings', nargs='+', metavar='RECORDING', help=RECORDINGS)
    p.add_argument('-o', '--output', default=OUTPUT, metavar='OUT', help='folder in which each '
                   f'recording gets its own (default {OUTPUT}); of one recording OUT.mcap too: '
                   'the other files go beside it, as OUT.csv')
    add_monitor_options(p)
    p.add_argument('--jobs', type=int, default=os.cpu_count() or 1, metavar='N', help='processes '
                   'that replay a recording each (default: one for each core); a single long '
                   'recording takes two')
    add_force(p)
    p.add_argument('--json', action='store_true')


def add_monitor_options(p: argparse.ArgumentParser) -> None:
    """Add options of reading and evaluation, and the format of the tables."""
    add_reading_options(p)
    p.add_argument('--from', dest='begin', metavar='T', help='only from here on: seconds from '
                   'the start of each recording, a time of the day as 14:05:30 (UTC), or a date '
                   'and time as 2026-05-31T14:05:30')
    p.add_argument('--to', dest='end', metavar='T', help='up to here, likewise')
    p.add_argument('--table', choices=('csv', 'parquet', 'both'), default='csv',
                   help='format of the table of ticks (default csv)')


def add_reading_options(p: argparse.ArgumentParser) -> None:
    """Add options of reading."""
    p.add_argument('--config', metavar='MONITOR.yaml', help='default: the shipped settings')
    p.add_argument('--model', metavar='MODEL', help="default: the settings' model")
    p.add_argument('--rate', type=float, metavar='HZ', help="default: the settings' rate")
    p.add_argument('--namespace', default='/', help='of the relative topics in a bag')
    p.add_argument('--signals', metavar='SIGNALS.yaml', help='which column or topic field is '
                   'which input, as `squeal signals` proposes; tables need it')
    p.add_argument('--types', metavar='FOLDER',
                   help='.msg files of message types that a bag does not define')
