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

"""The command that plays drives and schedules as brake signals, or records them at once."""

import argparse
from pathlib import Path

from squeal_core.common.errors import SquealError
from squeal_core.common.output import OutputFiles
from squeal_core.model.brake_model import BrakeModel
from squeal_core.vehicle.vehicle_model import BrakeSignals
from squeal_ros.cli.arguments import check_output, positive
from squeal_ros.cli.console import report_progress
from squeal_ros.cli.drive_signals import chosen_drive, ORIGIN, signals_of

_MOST_SAMPLES = 1000.0  # a second


def drive(options: argparse.Namespace) -> int:
    """Play a drive cycle or a schedule as brake signals, or record it without ROS."""
    _check(options)
    chosen, vehicle = chosen_drive(options)
    signals = signals_of(chosen, vehicle, BrakeModel.load(options.model), rate=options.rate,
                         duration=options.duration)
    if options.offline:
        return _record_offline(signals, options)
    return _play(chosen.name, signals, options)


def _check(options: argparse.Namespace) -> None:
    """Refuse before the work options with which it would fail afterwards."""
    if options.record:
        check_output('--record', options.record, force=options.force, inputs=(options.cycle,),
                     folder=Path(options.record).suffix != '.mcap')
    if options.offline and (not options.record or options.wall_time):
        what = 'there is no --record' if not options.record else '--wall-time is given'
        raise SquealError(f'--offline: {what}; give --record FILE.mcap, without --wall-time')
    if positive('--rate', options.rate) > _MOST_SAMPLES:
        raise SquealError(f'--rate: is {options.rate:g}; give at most {_MOST_SAMPLES:g}')
    positive('--speed-up', options.speed_up)


def _record_offline(signals: BrakeSignals, options: argparse.Namespace) -> int:
    from squeal_ros.recordings.bags.bag_writer import BagWriter
    from squeal_ros.recordings.bags.signal_bag import write_signals

    with (OutputFiles(overwrite=options.force) as files,
          BagWriter(options.record, files) as bag):
        write_signals(signals, bag, origin=ORIGIN)
    print(f'written: {options.record}, {signals.time[-1]:.1f} s of driving')
    return 0


def _play(name: str, signals: BrakeSignals, options: argparse.Namespace) -> int:
    from squeal_ros.cli.player import BrakePlayer
    from squeal_ros.recordings.bags.bag_writer import BagWriter

    speed_up = 1.0 if options.wall_time else options.speed_up
    with BrakePlayer(signals, namespace=options.namespace) as player:
        report_progress(f'playing {name}, {signals.time[-1]:.0f} s at {speed_up:g} x real time')
        if options.record:
            with (OutputFiles(overwrite=options.force) as files,
                  BagWriter(options.record, files) as bag):
                list(player.play(speed_up=speed_up, simulated=not options.wall_time,
                                 record=bag.write))
        else:
            list(player.play(speed_up=speed_up, simulated=not options.wall_time))
    return 0
