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

"""The parser of commands, which names the nearest option, and options that several share."""

import argparse
from collections.abc import Sequence
import re
import sys
from typing import Any, NoReturn

from squeal_core.common.errors import did_you_mean, in_one_line

BAD_INPUT = 2  # exit code


class CommandParser(argparse.ArgumentParser):
    """Parser whose errors are one line, with the nearest option or command."""

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)
        self._negative_number_matcher = re.compile(  # argparse's own takes -1e-3 for an option
            r'^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$')
        self.set_defaults(parser=self)
        self._given: Sequence[str] = ()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        self._given = sys.argv[1:] if args is None else list(args)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        known = list(self._option_string_actions)
        for action in self._actions:
            known += list(action.choices or ())
        wrong = re.findall(r"invalid choice: '([^']*)'|(--?\w[\w-]*)", message)
        words = [a or b for a, b in wrong if (a or b) not in known]
        if 'required' in message:  # one of those may be there, but misspelt
            words += [word for word in self._given if word.startswith('--') and not any(
                option.startswith(word.partition('=')[0]) for option in known)]
        near = did_you_mean(words[0], known) if words else ''
        text = in_one_line(message, 300)
        self.exit(BAD_INPUT, f'{self.prog}: {text}{near}; see {self.prog} --help\n')


def add_range(p: argparse._ActionsContainer, option: str, what: str | None) -> None:
    """Add an option that takes the two ends of a range."""
    p.add_argument(option, type=float, nargs=2, metavar=('LOW', 'HIGH'), help=what)


def mode_numbers(text: str) -> list[int]:
    """Parse a list of mode numbers such as 3,7."""
    try:
        return [int(number) for number in text.split(',')]
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text!r} are no numbers of modes; write 13,14'
                                         ) from None


def add_without_rotation(p: argparse.ArgumentParser) -> None:
    """Add the option that leaves out the rotation effects."""
    p.add_argument('--without-rotation', action='store_true',
                   help='leave out the gyroscopic, radial and slope terms')


def add_sweep(p: argparse.ArgumentParser, default: str) -> None:
    """Add the model and the parameters of a sweep."""
    p.add_argument('model', metavar='MODEL|BRAKE.yaml',
                   help='path of a model file, a shipped name, or a brake description')
    add_point(p, needs_speed=False)
    add_study(p, default)


def add_study(p: argparse.ArgumentParser, default: str) -> None:
    """Add options of the sweep, its computation and its output."""
    p.add_argument('--over', action='append', metavar='NAME=FROM:TO:COUNT',
                   help='a parameter, or the path of a number of the brake description '
                   f'(disc.rotor_thickness_mm=14:18:5); any number of them; {default}')
    p.add_argument('-o', '--output', metavar='FILE', help='record, .npz, .csv or .json')
    p.add_argument('--plot', metavar='PNG')
    add_force(p)
    p.add_argument('--title', default='')
    p.add_argument('--workers', type=int, default=0, metavar='N', help='processes (default: one)')
    p.add_argument('--scheduler', metavar='ADDRESS', help='of a Dask cluster: tcp://HOST:8786')
    p.add_argument('--no-cache', action='store_true',
                   help="keep no solved parts of brakes in the user's cache")
    p.add_argument('--json', action='store_true')


def add_point(p: argparse.ArgumentParser, *, needs_speed: bool) -> None:
    """Add options of the operating point."""
    p.add_argument('--rotor-speed', type=float, required=needs_speed, metavar='RAD/S',
                   help=None if needs_speed else 'default 5')
    p.add_argument('--friction', type=float, metavar='MU',
                   help="default: the friction law's, at each speed")
    add_slope(p)
    load = p.add_mutually_exclusive_group()
    load.add_argument('--preload', type=float, metavar='N', help='of one pad (default 2000)')
    load.add_argument('--pressure', type=float, metavar='PA')
    p.add_argument('--contact-stiffness', type=float, metavar='N/M^3', help='default: nominal')
    add_damping_scale(p)


def add_slope(p: argparse.ArgumentParser) -> None:
    """Add the mutually exclusive options of the friction slope."""
    slope = p.add_mutually_exclusive_group()
    slope.add_argument('--friction-slope', type=float, metavar='S/M',
                       help='d mu / d v (default 0 with --friction)')
    slope.add_argument('--friction-law', action='store_true',
                       help="the law's slope, scaled to --friction where that is given")


def add_damping_scale(p: argparse.ArgumentParser) -> None:
    """Add the option of the damping scale."""
    p.add_argument('--damping-scale', type=float, default=1.0, metavar='FACTOR',
                   help="on the model's damping of components, supports and contact (default 1)")


def add_force(p: argparse.ArgumentParser) -> None:
    """Add the option to replace existing outputs."""
    p.add_argument('--force', action='store_true', help='replace existing outputs')


def add_model(p: argparse.ArgumentParser) -> None:
    """Add the argument that names a model."""
    p.add_argument('model', metavar='MODEL', help='path of a model file, or a shipped name')
