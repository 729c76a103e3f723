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

"""Options of `squeal drive`, and those of a drive that `squeal demo` shares."""

import argparse

from squeal_ros.cli.command_parser import add_force

DESCRIPTION = ('Play a drive cycle (CSV) or a schedule of brake applications (YAML) as brake '
               'signals of four wheels on ROS topics; or, with --offline, record it without ROS '
               'and faster than real time, for `squeal replay`.')


def add_options(p: argparse.ArgumentParser) -> None:
    add_cycle(p)
    p.add_argument('--rate', type=float, default=10.0, metavar='HZ',
                   help='samples a second (default 10)')
    p.add_argument('--speed-up', type=float, default=1.0, metavar='X', help='default 1')
    p.add_argument('--wall-time', action='store_true',
                   help='stamp with the system clock, publish no /clock (speed-up 1)')
    p.add_argument('--record', metavar='BAG', help='record the signals: FILE.mcap, or a folder')
    p.add_argument('--offline', action='store_true',
                   help='only record, without ROS and as fast as it goes')
    add_force(p)
    p.add_argument('--namespace', default='')


def add_cycle(p: argparse.ArgumentParser) -> None:
    """Add the drive cycle: a shipped name or a file."""
    p.add_argument('cycle', nargs='?', default='us06', metavar='DRIVE',
                   help='CSV of time_s and speed_m_s or speed_km_h, YAML of a schedule, or a '
                   'shipped name (default us06)')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml')
    p.add_argument('--model', default='kang2009', metavar='MODEL',
                   help='whose friction table the signals follow')
    p.add_argument('--duration', type=float, metavar='S', help='only the first seconds')
