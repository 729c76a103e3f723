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

"""Options of `squeal sensitivity`."""

import argparse

from squeal_ros.cli.command_parser import add_force, add_point, mode_numbers

DESCRIPTION = ('Say what to change on a brake: growth rate, critical friction and squeal risk per '
               'per cent of each dimension, material and contact property. What a model is affine '
               'in needs no finite elements; for the rest its parts are solved again (some '
               'minutes the first time, solutions are kept).')


def add_options(p: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    p.add_argument('model', metavar='MODEL|BRAKE.yaml', help='a model, a brake description, or a '
                   'shipped name')
    add_point(p, needs_speed=False)
    p.add_argument('--drive', metavar='CYCLE|RESULT', help='the worst operating points of a '
                   'drive cycle, of a schedule or of a result folder of squeal replay')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml',
                   help='of a cycle or schedule (default midsize)')
    p.add_argument('--modes', type=mode_numbers, default=[], metavar='13,14',
                   help='mode numbers, by frequency at mu = 0; default: the least stable')
    p.add_argument('--count', type=int, default=1, metavar='N',
                   help='of least stable modes, where none is given (default 1)')
    p.add_argument('--only', nargs='+', default=[], metavar='PATH', help='parameters whose path '
                   'begins so, as disc or contact.angle (default: all)')
    p.add_argument('--braking', type=float, default=3.0, metavar='S',
                   help='of the brake application whose risk is computed (default 3)')
    p.add_argument('--no-risk', action='store_true', help='growth and critical friction alone')
    p.add_argument('--plot', metavar='FILE', help='tornado chart, .png, .svg or .pdf')
    p.add_argument('--split-doublet', type=int, metavar='N', help='masses on the disc that split '
                   'its doublet of N nodal diameters, instead of the parameters')
    amount = p.add_mutually_exclusive_group()
    amount.add_argument('--split', type=float, metavar='%', help='of the two frequencies, '
                        'in per cent (default 1)')
    amount.add_argument('--grams', type=float, metavar='G', help='of each mass')
    add_force(p)
    p.add_argument('--workers', type=int, default=0, metavar='N', help='processes (default: one)')
    p.add_argument('--json', action='store_true')
