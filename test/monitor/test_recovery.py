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

"""When a fault of an input is over: within one `max_age`, or a latch that says until when."""

from collections.abc import Callable, Iterator
import math
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.vehicle_monitor import Reading, Sample
from support.brake_monitors import GOOD, monitor, SECOND, TICK

RATE, LENGTH, BEGIN = 50, 12, 4  # Hz, s, s
MAX_AGE = 0.5  # s
TIME = np.arange(0.0, LENGTH, 1.0 / RATE)
NOISE = np.random.default_rng(1).standard_normal(TIME.size)
HEALTHY: dict[str, tuple[Signal, Any]] = {
    'braking from 60 rad/s': ('rotor_speed', 60.0 - 4.0 * TIME + 0.03 * NOISE),
    'slow': ('rotor_speed', 5.0 + 0.03 * NOISE), 'at rest': ('rotor_speed', 0.0 * TIME),
    'backwards': ('rotor_speed', TIME - 20.0 + 0.03 * NOISE),
    'braked': ('pressure', 20e5 + 2e5 * TIME + 2e3 * NOISE),
    'released': ('pressure', 50.0 * NOISE),
    'brakings': ('pressure', np.maximum(20e5 * np.sin(2.0 * TIME), 0.0) + 50.0 * NOISE),
    'friction': ('friction', 0.4 + 1e-3 * NOISE), 'warming': ('temperature', 400.0 + TIME)}
FAULTS: dict[str, Callable[[Any], Any]] = {
    'other sign': lambda v: -v, 'rpm': lambda v: v * 60.0 / math.tau,
    'rad/s taken for rpm': lambda v: v * math.tau / 60.0, 'km/h': lambda v: 1.2 * v,
    'thirtyfold': lambda v: 30.0 * v, 'beyond': lambda v: 0.0 * v + 500.0,
    'bar': lambda v: 1e-5 * v, 'psi': lambda v: 1.45e-4 * v, 'dead': lambda v: 0.0 * v,
    'absolute': lambda v: v + 101325.0, 'vacuum': lambda v: v - 9.5e4,
    'NaN': lambda v: math.nan * v, 'frozen': lambda v: 0.0 * v + v[0],
    'alternating': lambda v: v * (np.arange(v.size) // 2 % 2),
    'drifting': lambda v: v * (1.0 + np.linspace(0.0, 3.0, v.size))}


def readings(signal: Signal, values: Any, silent: slice) -> Iterator[tuple[float, Reading]]:
    """Yield the seconds since the start and what is known of the input."""
    watch = monitor(**{'a.temperature.topic': '/t'})
    watch._latest.update({name: value for name, value in GOOD.items() if name != signal})
    one = watch._inputs[signal]
    quiet = np.zeros(TIME.size, bool)
    quiet[silent] = True
    for count, value in enumerate(values.tolist()):
        stamp = TICK + count * SECOND // RATE
        if not quiet[count]:
            one.receive(Sample(stamp, value), sliding=True, others=3 * count)
        yield count / RATE, one.read(stamp)


@pytest.mark.parametrize('healthy', HEALTHY)
@pytest.mark.parametrize('fault', FAULTS)
def test_every_recovery_is_within_max_age_or_says_until_when(fault: str, healthy: str) -> None:
    signal, sound = HEALTHY[healthy]
    for seconds in (0.3, 2.0):
        for silence in (0.0, 0.3):
            values = sound.copy()
            first, last = BEGIN * RATE, round((BEGIN + seconds) * RATE)
            values[first:last] = FAULTS[fault](values[first:last])
            silent = slice(first - round(silence * RATE), first)
            for time, reading in readings(signal, values, silent):
                if time > BEGIN + seconds + MAX_AGE and reading.status != 'good':
                    assert ', until ' in reading.detail, (time, reading)


def test_silence_and_a_sign_that_flips_cost_no_minute() -> None:
    signal, sound = HEALTHY['backwards']
    values = np.where(TIME < BEGIN, -sound, sound)
    late = [reading.status for time, reading in readings(
        signal, values, slice(round((BEGIN - 0.3) * RATE), BEGIN * RATE))
        if time > BEGIN + MAX_AGE]
    assert set(late) == {'good'}


def test_a_speed_that_was_too_low_by_the_factor_of_rpm_is_believed_when_it_is_right() -> None:
    signal, sound = HEALTHY['braking from 60 rad/s']
    values = np.where(np.abs(TIME - 6.0) < 1.0, sound * math.tau / 60.0, sound)
    late = [reading.status for time, reading in readings(signal, values, slice(0, 0))
            if time > 7.0 + MAX_AGE]
    assert set(late) == {'good'}
