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

"""A vehicle whose inputs are checked across brakes, and lies of its sensors."""

from collections.abc import Iterator, Mapping
import math
from typing import Any

import numpy as np
from squeal_core.monitor.inputs.reading import Reading, Sample
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.vehicle_monitor import VehicleMonitor
from support.brake_monitors import MODEL
from support.vehicle_streams import BEGIN, Lie, NAMES, SECOND, Sensor, settings, SIGNALS, Stream

SENSORS: Mapping[str, Sensor] = dict.fromkeys(SIGNALS, Sensor(25.0))
Told = dict[tuple[int, Signal], list[tuple[float, str]]]


class Car:
    """Inputs and cross-checks of a vehicle as its monitor has them; nothing is solved."""

    def __init__(self, **changes: Any) -> None:
        self.monitor = VehicleMonitor(settings(**changes), MODEL)

    def run(self, samples: Stream, rate: float = 10.0
            ) -> Iterator[tuple[float, list[Mapping[Signal, Reading]]]]:
        """Yield the time [s] and the readings of all brakes at each tick."""
        waiting, step = 0, round(SECOND / rate)
        monitors = tuple(self.monitor.brakes.values())
        for tick in range(BEGIN + step, BEGIN + round(samples.end * SECOND), step):
            while waiting < len(samples.samples) and samples.samples[waiting][0] <= tick:
                stamp, wheel, signal, value = samples.samples[waiting]
                self.monitor.receive(NAMES[wheel], signal, Sample(stamp, value))
                waiting += 1
            readings = [monitor.read(tick) for monitor in monitors]
            yield (tick - BEGIN) / SECOND, self.monitor.cross_checks.check(tick, readings)


def told(samples: Stream, rate: float = 10.0, **changes: Any) -> Told:
    """Return when and how each input was doubted."""
    found: Told = {}
    for seconds, readings in Car(**changes).run(samples, rate):
        for wheel, inputs in enumerate(readings):
            for signal, reading in inputs.items():
                if reading.status == 'implausible':
                    found.setdefault((wheel, signal), []).append(
                        (seconds, reading.described(signal)))
    return found


def lie(change: Any) -> Lie:
    return lambda time, value, every: np.asarray(change(value) + 0.0 * value)


def alternating(period: float, value: float = 0.0) -> Lie:
    """Another publisher takes every second turn of a time [s]."""
    return lambda time, own, every: np.where(
        np.round(time / period).astype(int) % 2 == 0, own, value)


def noise(deviation: float) -> Lie:
    random = np.random.default_rng(2)
    return lambda time, own, every: deviation * random.standard_normal(time.size)


PRESSURE_LIES: dict[str, tuple[Lie, float]] = {  # and the longest time to tell it [s]
    'dead': (lie(lambda p: 0.0), 0.7), 'noise of 20 kPa': (noise(2e4), 0.7),
    'kPa': (lie(lambda p: 1e-3 * p), 0.7), 'hPa': (lie(lambda p: 1e-2 * p), 0.7),
    'psi': (lie(lambda p: p / 6894.76), 0.7), 'bar': (lie(lambda p: 1e-5 * p), 0.7),
    'MPa': (lie(lambda p: 1e-6 * p), 0.7), 'a tenth': (lie(lambda p: 0.1 * p), 2.8),
    'half': (lie(lambda p: 0.5 * p), 2.8), 'noise of 1 kPa': (noise(1e3), 0.7)}
SPEED_LIES: dict[str, tuple[Lie, float]] = {
    'dead': (lie(lambda w: 0.0), 0.7), 'm/s': (lie(lambda w: 0.33 * w), 2.2),
    'rev/s': (lie(lambda w: w / math.tau), 2.2), 'km/h': (lie(lambda w: 1.19 * w), 5.2),
    'ten more': (lie(lambda w: w + 14.0), 5.2), 'a wheel at 0.7': (lie(lambda w: 0.7 * w), 2.2)}
