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

"""Options of `squeal listen`."""

import argparse

from squeal_ros.cli.command_parser import add_force, add_range

DESCRIPTION = ('Find squeal in a sound, or in a scaled acceleration: tones 15 dB above their '
               'spectral neighbourhood in 1.25 to 16 kHz; whine, horn, alarm and music are '
               'rejected by rules. Exit code 0: listened; 1: nothing is known of the sound, or '
               'of its clock, which is said; 2: the input cannot be used.')


def add_options(p: argparse.ArgumentParser) -> None:
    p.add_argument('sound', metavar='SOUND', help='WAV or FLAC')
    p.add_argument('-o', '--output', default='measured.csv', metavar='MEASURED.csv',
                   help='table of events; the JSON goes beside it (default measured.csv)')
    add_force(p)
    clock = p.add_mutually_exclusive_group()
    clock.add_argument('--start', metavar='STAMP', help='when the sound starts: ISO 8601 with a '
                       "zone, or seconds since 1970 (default: the file's bext chunk)")
    clock.add_argument('--sync', metavar='RESULT', help='result of `squeal replay` of the same '
                       'drive: the clock is found by the noise of rolling and braking, or by '
                       'strokes of the pedal')
    p.add_argument('--speed', metavar='RESULT|SPEED.csv', help='speed over time, by which whine '
                   'of the wheels is told: a result of `squeal replay`, or time_s,speed_m_s on '
                   'the clock of the sound (default: that of --sync)')
    p.add_argument('--channel', type=int, action='append', default=[], metavar='N',
                   help='from 1 on; may be repeated (default: all)')
    p.add_argument('--brakes', metavar='NAME,NAME', help='at which the microphones of the '
                   'channels are')
    p.add_argument('--calibration', metavar='VALUE', help='of a sample of full scale, as 2.5Pa, '
                   '490m/s2 or 50g; or level of a sine that reaches it, as 124dB')
    p.add_argument('--threshold', type=float, metavar='DB', help='level of an event: 70 dB(A) '
                   'with a calibration, else -70 dB(A) re a sine at full scale; 120 dB re '
                   '1 um/s^2')
    p.add_argument('--prominence', type=float, default=15.0, metavar='DB',
                   help='over the spectral neighbourhood (default 15)')
    add_range(p, '--band', 'Hz (default 1250 16000)')
    p.add_argument('--shortest', type=float, default=0.1, metavar='S',
                   help='duration of an event (default 0.1)')
    p.add_argument('--json', action='store_true')
