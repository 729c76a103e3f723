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

"""Brake signals of a vehicle in a drive, for the commands that play, tabulate, simulate."""

import argparse
from dataclasses import fields, replace
from pathlib import Path
from typing import TypeAlias

from squeal_core.common.errors import did_you_mean, short_repr, SquealError
from squeal_core.common.resources import find, names
from squeal_core.model.brake_model import BrakeModel
from squeal_core.vehicle.drive_cycle import DriveCycle, read_drive_cycle
from squeal_core.vehicle.schedule import read_schedule, Schedule
from squeal_core.vehicle.schedule_drive import drive_schedule
from squeal_core.vehicle.vehicle import Vehicle
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle
from squeal_ros.cli.arguments import is_there, positive, shipped
from squeal_ros.cli.console import report_progress, warn

Drive: TypeAlias = DriveCycle | Schedule
# simulated time at which a drive starts [ns]: zero would mean "no clock yet" to ROS
ORIGIN = 1_000_000_000
_OF_SCHEDULES = ('.yaml', '.yml')


def chosen_drive(options: argparse.Namespace) -> tuple[Drive, Vehicle]:
    """Return the drive and the vehicle that a command is given."""
    if options.duration is not None:
        positive('--duration', options.duration)
    return drive_and_vehicle(options.cycle, options.vehicle)


def drive_and_vehicle(drive: str, vehicle: str) -> tuple[Drive, Vehicle]:
    """Read a drive cycle or a schedule, and a vehicle: files, or those shipped by that name."""
    return (read_drive(drive), read_vehicle(shipped('vehicles', vehicle, '.yaml'), warn=warn))


def read_drive(name: str) -> Drive:
    """Read a schedule (.yaml) or a drive cycle (any other): a file, or a shipped one."""
    schedules, cycles = names('schedules', '.yaml'), names('drive_cycles', '.csv')
    if Path(name).suffix in _OF_SCHEDULES or name in schedules:
        return read_schedule(shipped('schedules', name, '.yaml'), warn=warn)
    path = find('drive_cycles', name, '.csv')
    if not is_there(path):
        raise SquealError(f'{short_repr(name)}: there is no such file, and no such drive; give a '
                          f'path, a shipped cycle ({", ".join(cycles)}) or a shipped schedule '
                          f'({", ".join(schedules)}){did_you_mean(name, [*cycles, *schedules])}')
    return read_drive_cycle(path, warn=warn)


def signals_of(drive: Drive, vehicle: Vehicle, model: BrakeModel, *, rate: float,
               duration: float | None = None) -> BrakeSignals:
    """Return brake signals of a drive or its first seconds; friction by the model's table."""
    if model.friction_table is None:
        raise SquealError('this model has no friction table over temperature; add '
                          'friction.temperature_table to its brake description and build it again')
    if isinstance(drive, Schedule):
        driven = drive_schedule(drive, vehicle, model.friction_table, rate=rate)
        report_progress('; '.join(driven.lines()))
        return driven.signals if duration is None else _first(driven.signals, duration)
    if duration is not None:
        kept = drive.time <= drive.time[0] + duration
        drive = replace(drive, time=drive.time[kept], speed=drive.speed[kept])
    return brake_signals(drive, vehicle, model.friction_table, rate=rate)


def _first(signals: BrakeSignals, duration: float) -> BrakeSignals:
    kept = signals.time <= duration
    return replace(signals, **{item.name: getattr(signals, item.name)[kept]
                               for item in fields(signals) if item.name != 'brakes'})
