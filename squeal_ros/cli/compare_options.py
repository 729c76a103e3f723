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

"""Options of `squeal compare`."""

import argparse

from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_ros.cli.command_parser import add_force, add_point, add_range

DESCRIPTION = ('Compare models, variants and tables at an operating point: modes matched by MAC '
               'of their shapes (by frequency where not both carry shapes), growth, critical '
               'friction, and the squeal risk over a drive. The first is what the others are '
               'compared with.')


def add_options(p: argparse.ArgumentParser) -> None:
    p.add_argument('brakes', nargs='+', metavar='BRAKE', help='two or more: model files or '
                   'shipped names, brake descriptions (.yaml, built first), tables of `squeal '
                   'tabulate`')
    add_point(p, needs_speed=True)
    add_range(p, '--bounds', 'of the friction in which stability boundaries are looked for '
              '(default 0 1)')
    p.add_argument('--band', type=float, nargs=2, default=SQUEAL_BAND, metavar=('LOW', 'HIGH'),
                   help='Hz, of the modes that are listed; default {:g} {:g}'.format(*SQUEAL_BAND))
    p.add_argument('--all', action='store_true', help='list modes that are stable in all, too')
    p.add_argument('--drive', metavar='DRIVE', help='the squeal risk over a drive cycle or a '
                   'schedule; a growth emulator that is missing is built first, in minutes')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml')
    p.add_argument('--duration', type=float, metavar='S', help='only the first seconds')
    p.add_argument('--plot', metavar='FILE', help='a plot, .png, .svg or .pdf')
    add_force(p)
    p.add_argument('--title', default='')
    p.add_argument('--workers', type=int, default=0, metavar='N',
                   help='processes that build emulators (default: this one)')
    p.add_argument('--json', action='store_true')
