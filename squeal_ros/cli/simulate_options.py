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


"""Options of `squeal simulate`."""

import argparse

from squeal_ros.cli.command_parser import add_damping_scale, add_force, add_model, add_slope

DESCRIPTION = ('Integrate the nonlinear contact of a brake over time, from noise: at an operating '
               'point, along a ramp (FROM:TO), or in a part of a drive cycle. One second of one '
               'brake takes some 30 s.')


def add_options(p: argparse.ArgumentParser) -> None:
    add_model(p)
    p.add_argument('-o', '--output', required=True, metavar='FOLDER')
    add_force(p)
    _point(p)
    _drive(p)
    p.add_argument('--description', metavar='BRAKE.yaml', help='what the model was built from, '
                   'where it keeps no description or one that names files')
    p.add_argument('--free-pads', action='store_true',
                   help='no abutment for pads that nothing holds in plane')
    p.add_argument('--floor', type=float, default=1e-9, metavar='M',
                   help='displacement at the contact to which noise excites each mode '
                   '(default 1e-9)')
    p.add_argument('--seed', type=int, default=0, metavar='N', help='of the noise (default 0)')
    p.add_argument('--steps', type=int, default=2, metavar='N',
                   help='of integration in 10.4 us (default 2)')
    p.add_argument('--threshold-db', type=float, default=70.0, metavar='DB',
                   help='sound pressure level of an event (default 70)')
    p.add_argument('--levels', action='store_true', help='write the levels of all modes, too')
    p.add_argument('--json', action='store_true')


def _point(p: argparse.ArgumentParser) -> None:
    _ramp(p, '--rotor-speed', 'RAD/S')
    _ramp(p, '--friction', 'MU', "default: the friction law's, at each speed")
    load = p.add_mutually_exclusive_group()
    _ramp(load, '--preload', 'N', 'of one pad (default 2000)')
    _ramp(load, '--pressure', 'PA')
    add_slope(p)
    p.add_argument('--contact-stiffness', type=float, metavar='N/M^3', help='default: nominal')
    add_damping_scale(p)
    p.add_argument('--duration', type=float, metavar='S', help='default 0.5')


def _drive(p: argparse.ArgumentParser) -> None:
    p.add_argument('--drive', metavar='CYCLE',
                   help='the brakes of a vehicle in a drive cycle instead')
    p.add_argument('--vehicle', default='midsize', metavar='VEHICLE.yaml')
    p.add_argument('--from', type=float, dest='from_', metavar='S', help='of the drive cycle')
    p.add_argument('--to', type=float, metavar='S', help='of the drive cycle')
    p.add_argument('--brakes', metavar='NAME,NAME', help='of the vehicle (default: all)')


def _ramp(p: argparse._ActionsContainer, option: str, unit: str, what: str = '') -> None:
    p.add_argument(option, type=_ends, metavar=f'{unit}[:{unit}]', help=what or None)


def _ends(text: str) -> tuple[float, float]:
    """Return both ends of a ramp, which are equal where there is one number."""
    first, _, last = text.partition(':')
    try:
        return float(first), float(last or first)
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} is no number or ramp; write 0.4 or 0.3:0.5'
                                         ) from None
