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

"""Options of `squeal signals`."""

import argparse

from squeal_ros.cli.command_parser import add_force

DESCRIPTION = ('List what a recording holds (topics and fields, columns, channels; rates, gaps, '
               'ranges), and propose the file of `squeal replay --signals`, with guesses marked. '
               'Exit code 0: a file that can be used; 1: no brake has all inputs; 2: the '
               'recording cannot be read.')


def add_options(p: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    p.add_argument('recording', metavar='RECORDING',
                   help='rosbag2 folder, .mcap, .db3, .bag, .mf4 or table of text')
    p.add_argument('-o', '--output', metavar='SIGNALS.yaml',
                   help='write the proposed file (default: print it)')
    p.add_argument('--types', metavar='FOLDER',
                   help='.msg files of message types that the bag does not define')
    add_force(p)
    p.add_argument('--json', action='store_true')
