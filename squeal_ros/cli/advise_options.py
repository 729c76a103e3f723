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

"""Options of `squeal advise`."""

import argparse

from squeal_ros.cli.command_parser import add_force, add_model, add_range

DESCRIPTION = ('Print the pressures at which a brake is quiet, by full solutions, or write a map '
               'of its risk for a control unit. Advice, never a command. Exit code 0: done; 1: no '
               'quiet pressure anywhere, or no risk in the map; 2: the input is bad.')


def add_options(p: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    add_model(p)
    p.add_argument('--rotor-speed', type=float, nargs='+', default=[5.0, 10.0, 20.0, 40.0, 80.0],
                   metavar='RAD/S', help='one or more (default 5 10 20 40 80)')
    friction = p.add_mutually_exclusive_group()
    friction.add_argument('--friction', type=float, nargs='+', metavar='MU',
                          help="one or more (default: the friction law's at each speed)")
    friction.add_argument('--temperature', type=float, metavar='DEGC',
                          help="of the disc: friction by the model's table")
    p.add_argument('--pressure', type=float, metavar='PA', help='the present one (default: none)')
    add_range(p, '--bounds', 'of the pressure, Pa (default: preload 100 to 20000 N)')
    p.add_argument('--hold', type=float, metavar='S', help='for which conditions are held, from '
                   'the noise floor (default: the setting advice_hold)')
    p.add_argument('-o', '--output', nargs='+', default=[], metavar='MAP', help='write the map of '
                   'the risk over --bounds, --speeds and --frictions: .csv, or .c (.h) for a '
                   'control unit')
    add_range(p, '--speeds', 'of the map, rad/s (default 1 to 120)')
    add_range(p, '--frictions', 'of the map (default 0.2 to 0.6)')
    p.set_defaults(speeds=[1.0, 120.0], frictions=[0.2, 0.6])
    p.add_argument('--points', type=int, nargs=3, default=(16, 12, 9), metavar=('P', 'S', 'F'),
                   help='of the map, over pressure, speed and friction (default 16 12 9)')
    p.add_argument('--config', metavar='MONITOR.yaml', help='settings of the monitor: squeal '
                   'band, growth threshold, ensemble (default: those of config/monitor.yaml)')
    p.add_argument('--workers', type=int, default=0, metavar='N', help='processes (default: one)')
    add_force(p)
    p.add_argument('--json', action='store_true')
