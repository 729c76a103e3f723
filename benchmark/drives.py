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

"""The braking samples of a drive, for the benchmarks."""

from typing import NamedTuple

from squeal_core.common.resources import config_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle

DRIVES = ('us06', 'wltc_3b', 'chicago_trip')
RELEASED = 0.5e5  # Pa, below which a brake counts as released
SLIDING = 0.5  # rad/s, from which the disc counts as sliding


class BrakingSample(NamedTuple):
    """Inputs of one brake at one time: [ns], [rad/s], [Pa], [-]."""

    time: int
    brake: int
    rotor_speed: float
    pressure: float
    friction: float


def drive_signals(model: BrakeModel, drive: str, rate: float) -> BrakeSignals:
    """Return what the shipped vehicle's sensors would show."""
    assert model.friction_table is not None
    folder = config_folder()
    return brake_signals(
        read_drive_cycle(folder / 'drive_cycles' / f'{drive}.csv'),
        read_vehicle(folder / 'vehicles' / 'midsize.yaml'), model.friction_table, rate=rate)


def braking_samples(model: BrakeModel, drive: str, *, brakes: int = 1,
                    rate: float = 100.0) -> list[BrakingSample]:
    """Return what the first brakes see at each sample at which they brake, in order."""
    signals = drive_signals(model, drive, rate)
    return [BrakingSample(round(1e9 * time), brake, float(signals.rotor_speed[i, brake]),
                          float(signals.pressure[i, brake]), float(signals.friction[i, brake]))
            for i, time in enumerate(signals.time) for brake in range(brakes)
            if signals.pressure[i, brake] >= RELEASED and signals.rotor_speed[i, brake] >= SLIDING]
