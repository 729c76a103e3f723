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

"""Checks across brakes: what vehicles do is left alone."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from support.checked_cars import told
from support.vehicle_streams import (
    BAR,
    Drive,
    FL,
    FR,
    FRONT,
    LEFT,
    locked,
    REAR,
    RL,
    scaled,
    Sensor,
    shipped,
    SIGNALS,
    single_wheel,
    stop,
    stream,
    turning,
    with_abs,
)

STOP, HARD = stop(60.0, 12.0), stop(60.0, 9.0, front=60.0)
COASTING = stop(60.0, 1.0, front=0.0, hold=8.0)
FAIR: dict[str, Drive] = {
    'ABS at all wheels': with_abs(STOP, range(4)),
    'ABS to zero and no slip seen': with_abs(STOP, range(4), depth=1.0, slip=0.0),
    'ABS at one wheel': with_abs(STOP, [FL], depth=1.0),
    'ABS at 8 Hz': with_abs(STOP, FRONT, frequency=8.0, depth=1.0),
    'two grips': with_abs(with_abs(HARD, LEFT, grip=0.1, depth=0.9, slip=0.3), [FR], depth=0.3),
    'ice on the left': with_abs(HARD, LEFT, grip=0.03, depth=1.0, slip=0.4, frequency=3.0),
    'two grips, rear axle by the lower': with_abs(with_abs(
        HARD, [FL], grip=0.08, depth=1.0, slip=0.3, frequency=4.0), REAR, grip=0.2, depth=0.8),
    'two grips, no slip seen': scaled(HARD, 'pressure', [0.1, 1.0, 0.1, 1.0]),
    'ESP at one wheel': single_wheel(COASTING, [FL], 30.0, 4.0, 5.0),
    'ESP at one side': single_wheel(COASTING, LEFT, 30.0, 4.0, 6.0),
    'ESP while braking': single_wheel(STOP, [FL], 30.0, 4.0, 5.0),
    'torque vectoring': turning(single_wheel(COASTING, [RL], 15.0, 4.0, 8.0), 30.0),
    'torque vectoring while braking': turning(single_wheel(STOP, [RL], 15.0, 4.0, 7.0), 30.0),
    'rear axle recuperates': scaled(STOP, 'pressure', [1.0, 1.0, 0.0, 0.0]),
    'front axle recuperates': scaled(STOP, 'pressure', [0.0, 0.0, 1.0, 1.0]),
    'all axles recuperate': scaled(stop(60.0, 9.5), 'pressure', 0.0),
    'parking brake': single_wheel(COASTING, REAR, 20.0, 4.0, 8.0),
    'parking brake locks': locked(single_wheel(COASTING, REAR, 20.0, 4.0, 6.0), REAR, 4.5, 6.0),
    'proportioning': replace(HARD, pressure=np.where(
        [False, False, True, True], np.minimum(HARD.pressure, 9.0 * BAR), HARD.pressure)),
    'residual pressure': replace(STOP, pressure=np.maximum(STOP.pressure, 0.8 * BAR)),
    'residual pressure of one': replace(STOP, pressure=np.maximum(
        STOP.pressure, np.array([2.5, 0.0, 0.0, 0.0]) * BAR * (STOP.time > 5.0)[:, None])),
    'spare wheel': scaled(STOP, 'rotor_speed', [1.11, 1.0, 1.0, 1.0]),
    'spare wheel behind': scaled(STOP, 'rotor_speed', [1.0, 1.0, 1.0, 1.11]),
    'one wheel locks': locked(STOP, [FL], 4.0, 6.0),
    'rear axle locks': locked(STOP, REAR, 4.0, 7.0),
    'three wheels lock': locked(stop(60.0, 2.0, front=60.0, hold=8.0), [FL, FR, RL], 4.0, 7.0),
    'all wheels lock': locked(stop(60.0, 2.0, front=60.0, hold=8.0), range(4), 4.0, 7.0),
    'turning circle': turning(stop(15.0, 3.0, front=8.0), 4.0),
    'turning circle, reversing': scaled(
        turning(stop(15.0, 3.0, front=8.0), 4.0), 'rotor_speed', -1.0),
    'a bend at 1 g': turning(stop(45.0, 3.0, front=8.0), 22.0),
    'hill descent': replace(stop(20.0, 0.1, front=10.0, hold=20.0)),
}


@pytest.mark.parametrize('name', FAIR)
def test_what_vehicles_do_is_left_alone(name: str) -> None:
    pulses = any(word in name for word in ('ABS', 'grip', 'ice'))
    sensors = dict.fromkeys(SIGNALS, Sensor(50.0 if pulses else 25.0))
    assert told(stream(FAIR[name], sensors)) == {}


def spun(speeds: Sequence[float]) -> Drive:
    """Return a vehicle that stands while some of its wheels spin for 6 s."""
    rest = scaled(stop(20.0, 1.0, front=0.0, hold=8.0), 'rotor_speed', 0.0)
    spinning = np.clip(np.minimum(rest.time - 3.0, 9.0 - rest.time), 0.0, 1.0)
    return replace(rest, rotor_speed=spinning[:, None] * np.array(speeds))


@pytest.mark.parametrize('speeds', [(40.0, 0.0, 0.0, 0.0), (40.0, 38.0, 0.0, 0.0)])
def test_wheels_that_spin_are_left_alone(speeds: Sequence[float]) -> None:
    assert told(stream(spun(speeds))) == {}


def coarse(wheel: int, signal: str) -> Sensor:
    """Pressures in steps of 1 bar at 10 Hz; other rates, delays and steps at each wheel."""
    return {'pressure': Sensor(10.0, 0.05 * wheel, 0.013 * wheel, 1e4, 1e5),
            'rotor_speed': Sensor((10.0, 25.0, 12.5, 20.0)[wheel], 0.03 * wheel, 0.007, 0.1, 0.5),
            'friction': Sensor(4.0, 0.1 * wheel, 0.0, 0.03, 0.01)}[signal]


def brakings(drive: Drive) -> list[tuple[float, float]]:
    """Return begin and end [s] of all times that a vehicle slows by its brakes."""
    slows = (drive.pressure[:, FL] > 0.0) & (drive.rotor_speed[:, FL] > 0.0)
    times = drive.time[slows]
    breaks = np.flatnonzero(np.diff(times) > 3.0)
    return list(zip(times[np.append(0, breaks + 1)].tolist(),
                    times[np.append(breaks, -1)].tolist(), strict=True))


@pytest.mark.parametrize('name', ['us06', 'wltc_3b', 'chicago_trip'])
def test_shipped_drives_as_coarse_sensors_see_them_are_left_alone(name: str) -> None:
    drive = shipped(name, 20.0)
    for start, end in brakings(drive):
        part = drive.part(start - 2.0, end + 1.0)
        assert told(stream(part, coarse), 5.0, stuck_changes=1e6) == {}, start
