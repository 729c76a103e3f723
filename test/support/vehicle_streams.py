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

"""
Streams of samples of a whole vehicle: healthy manoeuvres, and faults of one input or several.

Made of the shipped drives and vehicle, or of a braking in brief; then what wheels and sensors do
to them: slip, turns, ABS, single-wheel interventions, resolution, noise, delay, other rates.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
import heapq
from typing import Any

import numpy as np
from squeal_core.brake.friction import FrictionTable
from squeal_core.common.arrays import FloatArray
from squeal_core.common.resources import config_folder
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, read_vehicle

SECOND = 1_000_000_000
BEGIN = 1000 * SECOND
NAMES = ('front_left', 'front_right', 'rear_left', 'rear_right')
FL, FR, RL, RR = range(4)
FRONT, REAR, LEFT, RIGHT = (FL, FR), (RL, RR), (FL, RL), (FR, RR)
SIGNALS: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
TABLE = FrictionTable((293.15, 373.15, 473.15, 873.15), (0.38, 0.42, 0.45, 0.3))
BAR = 1e5
Seed = np.random.Generator


@dataclass(frozen=True)
class Drive:
    """True signals of four brakes: times [s], arrays (n, 4) in SI units."""

    time: FloatArray
    rotor_speed: FloatArray
    pressure: FloatArray
    friction: FloatArray

    def part(self, start: float, end: float) -> 'Drive':
        """Return what lies between two times, from zero on."""
        kept = (self.time >= start) & (self.time < end)
        return Drive(self.time[kept] - self.time[kept][0], self.rotor_speed[kept],
                     self.pressure[kept], self.friction[kept])

    def meanwhile(self, start: float, end: float) -> Any:
        return (self.time >= start) & (self.time < end)


@cache
def shipped(name: str, rate: float = 100.0) -> Drive:
    """Return a shipped drive."""
    signals = brake_signals(read_drive_cycle(config_folder() / 'drive_cycles' / f'{name}.csv'),
                            read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml'), TABLE,
                            rate=rate)
    return Drive(signals.time, signals.rotor_speed, signals.pressure, signals.friction)


def stop(speed: float = 60.0, slowing: float = 12.0, *, front: float = 30.0, before: float = 3.0,
         after: float = 3.0, hold: float | None = None, rate: float = 100.0) -> Drive:
    """Return a braking: rolling, a pressure that rises in 0.3 s, a release; [rad/s], [bar]."""
    braking = (speed / slowing - 0.5) if hold is None else hold
    time = np.arange(0.0, before + braking + after, 1.0 / rate)
    share = np.clip((time - before) / 0.3, 0.0, 1.0) * np.clip(
        (before + braking - time) / 0.3, 0.0, 1.0)
    wheel = np.maximum(speed - np.cumsum(slowing * share + 0.3) / rate, 0.0)
    pressure = front * BAR * share[:, None] * np.array([1.0, 1.0, 0.43, 0.43])
    friction = np.full((time.size, 4), 0.42) * np.array([1.0, 0.97, 1.02, 0.99])
    return Drive(time, np.repeat(wheel[:, None], 4, axis=1), pressure, friction)


# -- what wheels and brakes do

def scaled(drive: Drive, signal: str, factors: Any) -> Drive:
    """Return a drive with a signal multiplied, by (4,) or (n, 4)."""
    return replace(drive, **{signal: getattr(drive, signal) * factors})


def with_abs(drive: Drive, wheels: Sequence[int], *, frequency: float = 15.0, depth: float = 0.6,
             slip: float = 0.12, grip: float = 1.0) -> Drive:
    """
    Let ABS pulse the pressure of wheels while they brake; each slips as its pulses go.

    `grip` is the fraction of the pressure that the road under the wheel bears.
    """
    pressure, speed = drive.pressure.copy(), drive.rotor_speed.copy()
    for number, wheel in enumerate(wheels):
        wave = 0.5 + 0.5 * np.sin(2 * np.pi * frequency * drive.time + 1.7 * number)
        braking = pressure[:, wheel] > 2.0 * BAR
        pressure[:, wheel] = np.where(
            braking, grip * pressure[:, wheel] * (1.0 - depth * wave), pressure[:, wheel])
        speed[:, wheel] *= np.where(braking, 1.0 - slip * (0.3 + 0.7 * wave), 1.0)
    return replace(drive, pressure=pressure, rotor_speed=speed)


def turning(drive: Drive, radius: float, *, track: float = 1.55, base: float = 2.75) -> Drive:
    """Return the wheel speeds of a turn to the left of a radius at the rear axle [m]."""
    inner, outer = radius - track / 2.0, radius + track / 2.0
    paths = np.array([np.hypot(inner, base), np.hypot(outer, base), inner, outer]) / radius
    return scaled(drive, 'rotor_speed', paths)


def locked(drive: Drive, wheels: Sequence[int], start: float, end: float) -> Drive:
    """Lock wheels for a time; they stop within 0.1 s and turn again within 0.1 s."""
    share = np.clip(np.maximum((start + 0.1 - drive.time), drive.time - end + 0.1) / 0.1, 0.0, 1.0)
    factors = np.ones((drive.time.size, 4))
    factors[:, list(wheels)] = share[:, None]
    return scaled(drive, 'rotor_speed', factors)


def single_wheel(drive: Drive, wheels: Sequence[int], bar: float, start: float,
                 end: float) -> Drive:
    """Add pressure at wheels for a time: ESP, torque vectoring, a parking brake."""
    rise = np.clip(np.minimum(drive.time - start, end - drive.time) / 0.1, 0.0, 1.0)
    extra = np.zeros((drive.time.size, 4))
    extra[:, list(wheels)] = (bar * BAR * rise)[:, None]
    return replace(drive, pressure=drive.pressure + extra)


# -- what sensors do

@dataclass(frozen=True)
class Sensor:
    """A sensor: samples a second, delay and phase [s], noise (standard deviation), resolution."""

    rate: float = 100.0
    delay: float = 0.0
    phase: float = 0.0
    noise: float = 0.0
    resolution: float = 0.0

    def sees(self, time: FloatArray, value: FloatArray, end: float, random: Seed
             ) -> tuple[FloatArray, FloatArray]:
        """Return times and values of samples; a delayed one has the stamp of its receipt."""
        at = np.arange(self.phase, end, 1.0 / self.rate)
        seen = np.interp(at - self.delay, time, value)
        seen = seen + self.noise * random.standard_normal(at.size)
        if self.resolution:
            seen = self.resolution * np.round(seen / self.resolution)
        return at, seen


EXACT: Mapping[str, Sensor] = dict.fromkeys(SIGNALS, Sensor(100.0))
Sensors = Mapping[str, Sensor] | Callable[[int, str], Sensor]
# a change of the values a sensor gives: (times from the start [s], values, all values of the
# signal there (n, 4)) -> values
Lie = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class Fault:
    """A lie of one input of some brakes from a time on, until another [s]."""

    name: str
    signal: Signal
    wheels: tuple[int, ...]
    lie: Lie
    start: float
    end: float = np.inf


@dataclass(frozen=True)
class Stream:
    """Samples in order of receipt: time [ns], brake, signal, value."""

    samples: Sequence[tuple[int, int, Signal, float]]
    end: float  # s


def stream(drive: Drive, sensors: Sensors = EXACT, faults: Sequence[Fault] = (), *,
           seed: int = 0) -> Stream:
    """Return what sensors give of a drive; equal seeds give equal noise, whatever the faults."""
    end = float(drive.time[-1])
    each = []
    for wheel in range(4):
        for number, signal in enumerate(SIGNALS):
            sensor = sensors(wheel, signal) if callable(sensors) else sensors[signal]
            random = np.random.default_rng([seed, wheel, number])
            truth = getattr(drive, signal)
            at, seen = sensor.sees(drive.time, truth[:, wheel], end, random)
            for fault in faults:
                if fault.signal == signal and wheel in fault.wheels:
                    during = (at >= fault.start) & (at < fault.end)
                    every = np.stack([np.interp(at[during], drive.time, truth[:, other])
                                      for other in range(4)], axis=1)
                    seen[during] = fault.lie(at[during], seen[during], every)
            stamps = BEGIN + np.round(at * SECOND).astype(np.int64)
            each.append([(stamp, wheel, signal, value)
                         for stamp, value in zip(stamps.tolist(), seen.tolist(), strict=True)])
    return Stream(list(heapq.merge(*each, key=lambda sample: sample[0])), end)


def settings(**changes: Any) -> MonitorSettings:
    """Return the default settings of four brakes."""
    return read_settings(changes)


def play(samples: Stream, vehicle: VehicleMonitor, rate: float = 10.0
         ) -> Iterator[tuple[float, Any]]:
    """Hand the samples to a vehicle and yield time [s] and assessments of each tick."""
    waiting, step = 0, round(SECOND / rate)
    for tick in range(BEGIN + step, BEGIN + round(samples.end * SECOND), step):
        while waiting < len(samples.samples) and samples.samples[waiting][0] <= tick:
            stamp, wheel, signal, value = samples.samples[waiting]
            vehicle.receive(NAMES[wheel], signal, Sample(stamp, value))
            waiting += 1
        yield (tick - BEGIN) / SECOND, vehicle.assess(tick)
