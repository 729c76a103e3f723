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

"""Brake signals of a vehicle that follows a schedule of brake applications."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.vehicle.schedule import Conditioning, Schedule, ScheduleError, Stop, ZERO_CELSIUS
from squeal_core.vehicle.vehicle import Vehicle, VehicleError
from squeal_core.vehicle.vehicle_model import BrakeSignals

MAX_DURATION = 200_000.0  # s
_CHANGE = 2.5  # m/s^2, between applications
_RISE = 0.5  # s in which a brake is applied, and released
_RIPPLE = 0.005  # of a pressure once a revolution: disc thickness variation, assumed
_LONGEST_STEP = 0.1  # s
_NEAR = 0.5  # K by which a disc that is cooler than its start temperature is not heated
_AT_REST = 1.0  # s at the end


class DrivenStop(NamedTuple):
    """A brake application of a schedule, and when its pressure rose and was zero again [s]."""

    stop: Stop
    start: float
    end: float


@dataclass(frozen=True)
class DrivenSchedule:
    """Signals of a whole schedule, and its applications in time."""

    signals: BrakeSignals
    stops: tuple[DrivenStop, ...]

    def lines(self) -> list[str]:
        """Return the modules in words."""
        modules = dict.fromkeys(one.stop.module for one in self.stops)
        result = {name: [one for one in self.stops if one.stop.module == name] for name in modules}
        return [f'{name}: {len(own)} brake application{"s" * (len(own) > 1)}, '
                f'{own[0].start:.0f} to {own[-1].end:.0f} s'
                for name, own in result.items()]


class _Row(NamedTuple):
    """State at the end of a step; the brakes' in (4,) arrays."""

    speed: float  # m/s, negative backward
    pressure: float  # Pa, front
    temperature: FloatArray  # K
    friction: FloatArray


def drive_schedule(schedule: Schedule, vehicle: Vehicle,
                   friction_of_temperature: Callable[[FloatArray], FloatArray], *,
                   rate: float = 10.0) -> DrivenSchedule:
    """
    Compute the signals of a vehicle's brakes in a schedule.

    Before an application the front discs are brought to its start temperature: the vehicle drives
    with released brakes while they are too hot, and drags them while they are too cold, which
    are brake applications as any other. Rear discs, at less pressure, stay cooler.

    Parameters
    ----------
    schedule : Schedule
        Its applications, in their order.
    vehicle : Vehicle
        Its masses and brakes; each disc is a lump of heat, as of `brake_signals`.
    friction_of_temperature : callable
        Coefficient of friction for an array of disc temperatures [K], same shape.
    rate : float
        Samples a second [1/s].

    Raises
    ------
    ScheduleError
        For a start temperature out of reach, or a schedule that takes longer than `MAX_DURATION`.
    VehicleError
        For friction that is no positive number.

    """
    if not (math.isfinite(rate) and rate > 0.0):
        raise ScheduleError('rate', f'is {rate}', 'give a positive number, such as 10.0')
    driver = _Driver(schedule.conditioning, vehicle, friction_of_temperature, rate)
    stops = tuple(driver.follow(schedule.stops))
    return DrivenSchedule(driver.signals(), stops)


class _Driver:
    """Drives in small steps and keeps the state of each sample."""

    def __init__(self, conditioning: Conditioning, vehicle: Vehicle,
                 friction_of_temperature: Callable[[FloatArray], FloatArray],
                 rate: float) -> None:
        self._by, self._vehicle, self._table = conditioning, vehicle, friction_of_temperature
        self._rate = rate
        self._every = max(1, math.ceil(1.0 / (rate * _LONGEST_STEP) - 1e-9))
        self._step, self._steps = 1.0 / (rate * self._every), 0
        self._factors = np.array(vehicle.friction_factors)
        self._split = vehicle.pressure_split
        temperature = np.full(4, vehicle.initial_temperature)
        self._now = _Row(0.0, 0.0, temperature, self._friction(temperature))
        self._rows = [self._now]

    @property
    def _time(self) -> float:
        return self._steps * self._step

    @property
    def _front(self) -> float:
        """Return the mean temperature of the front discs [K]."""
        return float(self._now.temperature[:2].mean())

    def follow(self, stops: tuple[Stop, ...]) -> Iterator[DrivenStop]:
        """Drive the applications one after the other; yield each once it is over."""
        for stop in stops:
            self._condition(stop)
            start = self._time
            self._apply(stop)
            yield DrivenStop(stop, start, self._time)
            self._hold(stop.pause)
        self._reach(0.0)
        self._hold(_AT_REST)

    def signals(self) -> BrakeSignals:
        kept = self._rows[::self._every]
        speed, front, temperature, friction = map(np.array, zip(*kept, strict=True))
        rotor_speed = speed / self._vehicle.wheel_radius
        front = front * (1.0 + _RIPPLE * np.sin(np.cumsum(rotor_speed) / self._rate))
        return BrakeSignals(
            np.arange(len(kept)) / self._rate, speed, self._vehicle.brakes,
            rotor_speed=np.repeat(rotor_speed[:, None], 4, axis=1),
            pressure=front[:, None] * self._split, temperature=temperature, friction=friction)

    def _condition(self, stop: Stop) -> None:
        """Bring front discs to the start temperature, and the vehicle to the speed."""
        if math.isnan(stop.temperature):
            self._reach(stop.speed)
            return
        if stop.temperature <= self._vehicle.ambient_temperature + 1.0:
            raise self._out_of_reach(stop, 'within 1 K of ambient_temperature_degc of the '
                                     'vehicle, or below')
        latest = self._time + self._by.longest
        direction = math.copysign(1.0, stop.speed)
        cooling, heating = self._by.cooling_speed, self._by.heating_speed
        afterwards = self._lost(stop, cooling, stop.speed)
        if self._front > stop.temperature + self._lost(stop, self._now.speed, cooling) + (
                afterwards):
            self._reach(direction * cooling)
            while self._front > stop.temperature + afterwards:
                self._check(stop, latest)
                self._advance(self._now.speed, 0.0)
        elif self._front < stop.temperature - _NEAR:
            self._reach(direction * heating)
            while self._front < stop.temperature + self._lost(stop, heating, stop.speed):
                self._check(stop, latest)
                self._press(self._by.heating_pressure, self._by.heating_pressure)
            while self._now.pressure > 0.0:
                self._press(0.0, self._by.heating_pressure)
        self._reach(stop.speed)
        while self._front > stop.temperature:
            self._check(stop, latest)
            self._advance(self._now.speed, 0.0)

    def _press(self, pressure: float, full: float) -> None:
        """Take a step at constant speed towards a pressure, as fast as one rises to `full`."""
        change = full * self._step / _RISE
        self._advance(self._now.speed, min(max(
            pressure, self._now.pressure - change), self._now.pressure + change))

    def _lost(self, stop: Stop, *speeds: float) -> float:
        """Return the cooling of discs at a start temperature between two speeds [K]."""
        first, last = map(abs, speeds)
        above = stop.temperature - self._vehicle.ambient_temperature
        seconds = abs(first - last) / _CHANGE + self._step
        return float(self._vehicle.cooling(np.array(0.5 * (first + last)))) * above * seconds / (
            self._vehicle.disc_heat_capacity)

    def _check(self, stop: Stop, latest: float) -> None:
        if self._time > latest:
            raise self._out_of_reach(
                stop, f'not reached from {self._front - ZERO_CELSIUS:.0f} degC within '
                f'conditioning.longest_s = {self._by.longest:g}')

    def _out_of_reach(self, stop: Stop, why: str) -> ScheduleError:
        return ScheduleError(
            f'module {stop.module}', f'temperature_degc = {stop.temperature - ZERO_CELSIUS:g} is '
            f'{why}', 'give another temperature, or other conditions of conditioning')

    def _apply(self, stop: Stop) -> None:
        """Raise the pressure, hold it or the deceleration, release."""
        end, done = self._time + stop.duration, 0.0
        while self._time < end - 0.5 * self._step:
            done = min(1.0, done + self._step / _RISE)
            if not self._slow_down(stop, done) and stop.kind == 'deceleration':
                break
        while done > 1e-9:
            done = max(0.0, done - self._step / _RISE)
            self._slow_down(stop, done)

    def _slow_down(self, stop: Stop, fraction: float) -> bool:
        """Brake for a step with a fraction of the demand; return whether it goes on afterwards."""
        speed, now = abs(self._now.speed), self._now
        if stop.kind == 'drag':
            self._advance(now.speed, fraction * stop.pressure)
            return True
        pressure, slowing = fraction * stop.pressure, fraction * stop.deceleration
        if math.isnan(stop.pressure):
            force = float(self._vehicle.brake_force(np.array(speed), np.array(-slowing)))
            pressure = force / self._force_per_pressure if speed else 0.0
        else:
            slowing = self._vehicle.deceleration(speed, pressure * self._force_per_pressure)
        lower = max(0.0, speed - slowing * self._step)
        self._advance(math.copysign(lower, stop.speed) if lower else 0.0, pressure)
        return lower > stop.end_speed

    @property
    def _force_per_pressure(self) -> float:
        """Return the force of all brakes over the front pressure [N/Pa]."""
        torque = self._vehicle.torque_per_pressure * float(self._now.friction @ self._split)
        return torque / self._vehicle.wheel_radius

    def _reach(self, speed: float) -> None:
        """Change the speed with released brakes."""
        change = _CHANGE * self._step
        while self._now.speed != speed or self._now.pressure:
            away = speed - self._now.speed
            self._advance(self._now.speed + min(max(away, -change), change)
                          if abs(away) > change else speed, 0.0)

    def _hold(self, seconds: float) -> None:
        end = self._time + seconds
        while self._time < end - 0.5 * self._step:
            self._advance(self._now.speed, 0.0)

    def _advance(self, speed: float, pressure: float) -> None:
        """Take a step to a speed and a front pressure; heat as of `vehicle_model`."""
        now, vehicle = self._now, self._vehicle
        ends = np.array([abs(now.speed), abs(speed)])
        half = 0.5 * self._step / vehicle.disc_heat_capacity
        before, after = half * vehicle.cooling(ends)
        power = (now.pressure * ends[0] + pressure * ends[1]) * (
            vehicle.heat_fraction_to_disc * vehicle.torque_per_pressure / vehicle.wheel_radius)
        above = now.temperature - vehicle.ambient_temperature
        above = (above * (1.0 - before) + half * power * now.friction * self._split) / (
            1.0 + after)
        temperature = vehicle.ambient_temperature + above
        self._now = _Row(speed, pressure, temperature, self._friction(temperature))
        self._rows.append(self._now)
        self._steps += 1
        if self._time > MAX_DURATION:
            raise ScheduleError('schedule', f'takes more than {MAX_DURATION:g} s',
                                'give fewer applications, or closer start temperatures')

    def _friction(self, temperature: FloatArray) -> FloatArray:
        friction: FloatArray = np.asarray(self._table(temperature)) * self._factors
        if not (np.isfinite(friction).all() and friction.min() > 0.0):
            raise VehicleError(f'friction = {friction} at {temperature} K; give a table of '
                               'positive values there')
        return friction
