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

"""Inputs over whole drives: no false alarm on them, and wrong units are told."""

import math
from typing import Any

import numpy as np
import pytest
from squeal_core.common.resources import config_folder
from squeal_core.monitor.inputs.plausibility import BarGuard, RPM
from squeal_core.monitor.vehicle_monitor import Sample
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle
from support.brake_monitors import monitor, SECOND, small_model, TICK
from support.guards import judged, speeds
from support.vehicle_streams import TABLE

CYCLES = ('us06', 'wltc_3b', 'chicago_trip')


def drive(name: str, rate: float) -> BrakeSignals:
    return brake_signals(read_drive_cycle(config_folder() / 'drive_cycles' / f'{name}.csv'),
                         read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml'), TABLE,
                         rate=rate)


def watched(signals: BrakeSignals, brake: int, read: Any, **parameters: Any) -> None:
    """Feed a drive to a brake; `read` sees every input after each step."""
    watch = monitor(small_model(friction_table=TABLE), **parameters)
    columns = {name: getattr(signals, name)[:, brake].tolist() for name in watch._inputs}
    for step, seconds in enumerate(signals.time.tolist()):
        stamp = TICK + round(seconds * SECOND)
        for name, values in columns.items():
            watch.receive(name, Sample(stamp, values[step]))
        read(stamp, {name: one.read(stamp) for name, one in watch._inputs.items()})


@pytest.mark.parametrize('name', CYCLES)
def test_no_false_alarm_on_a_drive(name: str) -> None:
    def read(stamp: int, readings: Any) -> None:
        assert {r.status for r in readings.values()} == {'good'}, readings

    signals = drive(name, 20.0)
    for brake in (0, 2) if name == 'us06' else (0,):  # the rear one where it brakes hardest
        watched(signals, brake, read, **{'a.temperature.topic': '/t'})


def test_no_false_alarm_on_a_drive_as_coarse_sensors_see_it() -> None:
    """Noise, and steps of 0.1 bar, 0.05 rad/s and 0.01: the drive with the hardest braking."""
    def read(stamp: int, readings: Any) -> None:
        assert {r.status for r in readings.values()} == {'good'}, readings

    exact, random = drive('us06', 50.0), np.random.default_rng(4)

    def seen(values: Any, noise: float, step: float) -> Any:
        noisy = values + noise * random.standard_normal(values.shape)
        return np.where(values == 0.0, 0.0, step * np.round(noisy / step))

    coarse = BrakeSignals(
        exact.time, exact.vehicle_speed, exact.brakes, temperature=exact.temperature,
        rotor_speed=seen(exact.rotor_speed, 0.05, 0.05),
        pressure=seen(exact.pressure, 3e3, 1e4), friction=seen(exact.friction, 0.0, 0.01))
    watched(coarse, 0, read)


@pytest.mark.parametrize('name', CYCLES)
def test_a_drive_in_wrong_units_is_told(name: str) -> None:
    """Told for most of what would have been a number; within the first hard manoeuvres."""
    signals = drive(name, 10.0)
    numbers: dict[str, int] = {'bar': 0, 'rpm': 0}
    braked = (signals.pressure[:, 0] > 0.5e5).tolist()
    turning = (signals.rotor_speed[:, 0] > 0.5).tolist()
    for kind, guard, values in (
            ('bar', BarGuard(500.0), signals.pressure[:, 0] * 1e-5),
            ('rpm', speeds(), signals.rotor_speed[:, 0] / RPM)):
        wanted = braked if kind == 'bar' else turning
        limit = 400.0 if kind == 'rpm' else math.inf
        said = judged(guard, values.tolist(), 10.0)
        numbers[kind] = sum(not text and w and v <= limit
                            for text, w, v in zip(said, wanted, values, strict=True))
        numbers[f'{kind} of'] = sum(wanted)
    assert numbers['bar'] <= 10  # one second: the first ten samples
    assert numbers['rpm'] < 0.25 * numbers['rpm of']
