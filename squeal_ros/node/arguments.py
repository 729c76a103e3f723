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

"""Arguments of `squeal_monitor`, checked before rclpy sees them; no rclpy needed."""

import argparse
from collections.abc import Container, Sequence
import re
from typing import NoReturn

from squeal_core.common.errors import ConfigurationError, did_you_mean, short_repr
from squeal_core.common.version import __version__
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.monitor.settings import NODE_NAME, parameter_sections

_ROS = ('--params-file', '--param', '--remap', '--log-level', '--log-config-file', '--enclave')
_SHORT = ('-p', '-r', '-e')
_SWITCHES = tuple(f'--{do}-{what}-logs' for do in ('enable', 'disable')
                  for what in ('rosout', 'stdout', 'external-lib'))
_LEVELS = ('debug', 'info', 'warn', 'error', 'fatal', 'unset')
_RULE = re.compile(r'[^:]+(:[^:=]+)?:=.+', re.DOTALL)  # NAME:=VALUE, NODE:NAME:=VALUE
_USAGE = 'squeal_monitor [--ros-args --params-file MONITOR.yaml [-p NAME:=VALUE] [-r FROM:=TO]]'


class _Parser(argparse.ArgumentParser):

    def error(self, message: str) -> NoReturn:
        self.exit(2, f'{self.prog}: {message}; see {self.prog} --help\n')


def check_arguments(arguments: Sequence[str]) -> None:
    """
    End with help, version or a refusal where arguments ask for it; ROS's pass.

    Parameters
    ----------
    arguments : sequence of str
        Without the name of the program.

    Raises
    ------
    ConfigurationError
        For parameter files and rules that ROS would not take.

    """
    parser = _Parser(
        prog='squeal_monitor', usage=_USAGE, add_help=True, allow_abbrev=False,
        description='Squeal risk of the disc brakes of a vehicle, as a ROS 2 node. Settings are '
        'ROS parameters: `squeal settings` prints a file with every one explained. Ends with 0 '
        'by SIGINT or SIGTERM, with 2 and one line where it cannot start.',
        epilog='Advisory: no safety function.')
    parser.add_argument('--version', action='version', version=f'squeal_ros {__version__}')
    own, ros = _divided(arguments)
    _, unknown = parser.parse_known_args(own)
    if unknown:
        wrong = unknown[0]
        near = did_you_mean(wrong, ('--help', '--version', '--ros-args', *_ROS))
        remedy = f'{near}; see {parser.prog} --help'
        if wrong in _SHORT or wrong.partition('=')[0] in _ROS or ':=' in wrong:
            remedy = '; write --ros-args before the arguments of ROS'
        elif wrong.endswith(('.yaml', '.yml')):
            remedy = f'; give settings as --ros-args --params-file {wrong}'
        parser.exit(2, f'{parser.prog}: {wrong!r} is no argument that it takes{remedy}\n')
    _check_ros(ros)


def _divided(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments outside and inside of `--ros-args ... [--]`."""
    own: list[str] = []
    ros: list[str] = []
    into = own
    for argument in arguments:
        if argument == '--ros-args':
            into = ros
        elif into is ros and argument == '--':
            into = own
        else:
            into.append(argument)
    return own, ros


def _check_ros(arguments: Sequence[str]) -> None:
    """Refuse arguments that rcl would refuse in several lines, with places in its sources."""
    names = {NODE_NAME}
    files: list[str] = []
    for option, value in zip(arguments, [*arguments[1:], ''], strict=False):
        if option in ('-p', '--param', '-r', '--remap') and not _RULE.fullmatch(value):
            raise ConfigurationError(f'--ros-args {option}', f'is followed by {value!r}',
                                     'write NAME:=VALUE after it, without spaces')
        if option in ('-r', '--remap') and value.partition(':=')[0].endswith('__node'):
            names.add(value.partition(':=')[2])
        if option == '--log-level' and value.rpartition(':=')[2].lower() not in _LEVELS:
            raise ConfigurationError(f'--ros-args {option}', f'is followed by {value!r}',
                                     f'write one of {", ".join(_LEVELS)} after it')
        if option.startswith('--') and option not in _ROS + _SWITCHES:
            raise ConfigurationError('--ros-args', f'{option!r} is no argument of ROS',
                                     f'see squeal_monitor --help{did_you_mean(option, _ROS)}')
        if option == '--params-file':
            files.append(value)
    _check_files(files, names)


def _check_files(paths: Sequence[str], names: Container[str]) -> None:
    """Refuse files none of which says anything to this node: a misspelt name of a node would."""
    contents = [read_yaml(path, ConfigurationError, ros=True) for path in paths]
    if contents and not any(True for content in contents
                            for _ in parameter_sections(content, names)):
        raise ConfigurationError(
            paths[-1], f'has no ros__parameters for {NODE_NAME}, only {short_repr(contents[-1])}',
            f'write them below {NODE_NAME}: or /**:')
