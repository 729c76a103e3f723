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

"""Brake signals of a vehicle in a drive cycle, for the commands that play, tabulate, simulate."""

from dataclasses import replace

from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.vehicle.drive_cycle import DriveCycle, read_drive_cycle
from squeal_core.vehicle.vehicle import Vehicle
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle
from squeal_ros.cli.arguments import shipped
from squeal_ros.cli.console import warn


def cycle_and_vehicle(cycle: str, vehicle: str) -> tuple[DriveCycle, Vehicle]:
    """Read a drive cycle and a vehicle: files, or those shipped by that name."""
    return (read_drive_cycle(shipped('drive_cycles', cycle, '.csv'), warn=warn),
            read_vehicle(shipped('vehicles', vehicle, '.yaml'), warn=warn))


def signals_of(cycle: DriveCycle, vehicle: Vehicle, model: BrakeModel, *, rate: float,
               duration: float | None = None) -> BrakeSignals:
    """Return brake signals of a cycle or its first seconds; friction by the model's table."""
    if duration is not None:
        kept = cycle.time <= cycle.time[0] + duration
        cycle = replace(cycle, time=cycle.time[kept], speed=cycle.speed[kept])
    if model.friction_table is None:
        raise SquealError('this model has no friction table over temperature; add '
                          'friction.temperature_table to its brake description and build it again')
    return brake_signals(cycle, vehicle, model.friction_table, rate=rate)
