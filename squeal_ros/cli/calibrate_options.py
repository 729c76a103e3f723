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

"""Options of `squeal calibrate`."""

import argparse
import os

from squeal_core.calibration.hearing_model import HearingModel
from squeal_ros.cli.command_parser import add_force
from squeal_ros.cli.replay_options import add_reading_options, RECORDINGS

DESCRIPTION = ('Fit the ensemble of brakes to measured squeal: recordings of brake signals and a '
               'table of events (time_s, frequency_hz, and brake, level_db, recording where '
               'known). A brake application without an event counts as silent. Exit code 0: '
               'calibrated; 1: written, but not to be trusted, which is said; 2: the input '
               'cannot be used.')


def add_options(p: argparse.ArgumentParser) -> None:
    p.add_argument('recordings', nargs='+', metavar='RECORDING', help=RECORDINGS)
    heard = p.add_mutually_exclusive_group(required=True)
    heard.add_argument('--events', metavar='EVENTS.csv')
    heard.add_argument('--sound', metavar='SOUND', help='in place of events: what `squeal listen` '
                       'wrote (.csv), or a sound, which is listened to (.wav, .flac); brake '
                       'applications outside of its time do not count')
    p.add_argument('-o', '--output', required=True, metavar='CALIBRATION.yaml')
    add_force(p)
    add_reading_options(p)
    p.add_argument('--emulator', metavar='EMULATOR.npz',
                   help='default: the one found for the model')
    _listening(p)
    _hearing(p)
    p.add_argument('--held-out', type=float, default=1.0 / 3.0, metavar='FRACTION',
                   help='of the applications with squeal and of the silent ones, kept for the '
                   'scores (default 1/3; 0, or fewer than 20 events: none)')
    p.add_argument('--seed', type=int, default=0, metavar='N', help='of the draws (default 0)')
    p.add_argument('--workers', type=int, default=os.cpu_count() or 1, metavar='N',
                   help='processes for long recordings (default: one for each core)')
    p.add_argument('--json', action='store_true')


def _listening(p: argparse.ArgumentParser) -> None:
    p.add_argument('--from-start', action='store_true', help='times of events count from the '
                   'start of their recording, not on its clock')
    p.add_argument('--offset', type=float, default=0.0, metavar='S',
                   help='to add to the times of events')
    p.add_argument('--from', type=float, dest='from_', metavar='S',
                   help='from when on somebody listened, as times of events')
    p.add_argument('--to', type=float, metavar='S', help='until when')
    p.add_argument('--brakes', metavar='NAME,NAME', help='that were listened to (default: all)')
    p.add_argument('--minimum-level', type=float, metavar='DB',
                   help='level below which an event does not count (default: all count)')


def _hearing(p: argparse.ArgumentParser) -> None:
    usual = HearingModel()
    for option, what in (('--detection', 'probability that a squeal is noted'),
                         ('--false-alarm', 'probability of an event without squeal'),
                         ('--label-error', 'probability that an application is noted wrong'),
                         ('--frequency-tolerance', 'relative standard deviation of a pitch')):
        name = option.removeprefix('--').replace('-', '_')
        p.add_argument(option, type=float, default=getattr(usual, name), metavar='X',
                       help=f'{what} (default {getattr(usual, name):g})')
