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
A vehicle in brief: from a speed trace to the pressure, heat and friction of its four brakes.

Longitudinal motion on a level road, no wheel slip: what drag, rolling and the engine leave of the
deceleration, the brakes must give. Each disc is one lump of heat.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import did_you_mean, short_repr
from squeal_core.common.ranges import Warn, warn_implausible
from squeal_core.common.yaml_reader import read_yaml
from squeal_core.vehicle.drive_cycle import DriveCycle
from squeal_core.vehicle.vehicle import Vehicle, VehicleError

_ITERATIONS = 100


@dataclass(frozen=True, eq=False)
class BrakeSignals:
    """
    Sensor signals of a vehicle's brakes during a drive.

    Parameters
    ----------
    time, vehicle_speed : arrays (n,)
        [s] and [m/s].
    brakes : tuple of 4 str
        Names of the columns below.
    rotor_speed, pressure, temperature, friction : arrays (n, 4)
        [rad/s], [Pa], [K] and [-].

    """

    time: FloatArray
    vehicle_speed: FloatArray
    brakes: tuple[str, ...]
    rotor_speed: FloatArray
    pressure: FloatArray
    temperature: FloatArray
    friction: FloatArray

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.name != 'brakes':
                object.__setattr__(self, item.name, readonly(getattr(self, item.name)))


def read_vehicle(path: str | Path, *, warn: Warn = warn_implausible) -> Vehicle:
    """
    Read a vehicle from YAML; each key is a field of `Vehicle` with the unit as a suffix.

    Parameters
    ----------
    path : path
        Where the file is.
    warn : callable
        Given a text for each number that can be used but is unusual.

    Raises
    ------
    VehicleError
        With file, key, value and remedy: no such file, key missing or unknown, value no number
        or out of range.

    """
    content = read_yaml(path, _file_error)
    try:
        if not isinstance(content, dict):
            raise VehicleError(
                f'{short_repr(content)} is no vehicle; write one "key: value" a line')
        vehicle = _vehicle(content)
    except VehicleError as error:
        raise VehicleError(f'{path}: {error}') from None
    for text in vehicle.doubts():
        warn(f'{path}: {text}')
    return vehicle


def _file_error(where: object, what: str, remedy: str) -> VehicleError:
    return VehicleError(f'{where}: {what}; {remedy}')


def brake_signals(cycle: DriveCycle, vehicle: Vehicle,
                  friction_of_temperature: Callable[[FloatArray], FloatArray], *,
                  rate: float = 100.0, tolerance: float = 1e-6) -> BrakeSignals:
    """
    Compute the signals of a vehicle's brakes while it follows a drive cycle.

    The driver compensates fade: the pressure is the one that, with the friction of the moment,
    gives the deceleration, and exactly zero where none is due. A vehicle slower than the holding
    speed and not speeding up is held with at least the holding pressure, which heats no disc.

    Parameters
    ----------
    cycle : DriveCycle
        Speed over time.
    vehicle : Vehicle
        Its masses and brakes.
    friction_of_temperature : callable
        Coefficient of friction for an array of disc temperatures [K], same shape.
    rate : float
        Samples a second [1/s].
    tolerance : float
        Largest change of any temperature in the last iteration [K].

    Raises
    ------
    DriveCycleError
        If `rate` is not a positive number.
    VehicleError
        If friction is not positive, or too steep over temperature for a solution to settle.

    """
    time, speed, acceleration = cycle.sample(rate)
    force = vehicle.brake_force(speed, acceleration)
    temperature, friction = _heat(vehicle, friction_of_temperature, vehicle.cooling(speed),
                                  force * speed, 1.0 / rate, tolerance)
    torque_per_pressure = vehicle.torque_per_pressure * (friction @ vehicle.pressure_split)
    front = force * vehicle.wheel_radius / torque_per_pressure
    held = (speed < vehicle.holding_speed) & (acceleration <= 0.0)
    front = np.where(held, np.maximum(front, vehicle.holding_pressure), front)
    return BrakeSignals(
        time, speed, vehicle.brakes, temperature=temperature, friction=friction,
        rotor_speed=np.repeat(speed[:, None] / vehicle.wheel_radius, 4, axis=1),
        pressure=front[:, None] * vehicle.pressure_split)


def _heat(vehicle: Vehicle, friction_of_temperature: Callable[[FloatArray], FloatArray],
          cooling: FloatArray, power: FloatArray, step: float,
          tolerance: float) -> tuple[FloatArray, FloatArray]:
    """
    Solve temperature and friction of the brakes together; arrays (n, 4).

    Friction only moves heat between brakes, as the deceleration gives the sum; so iterating over
    the whole drive settles in a few rounds, without a loop over the samples.
    """
    heat = vehicle.heat_fraction_to_disc * power[:, None]
    temperature = np.full((len(power), 4), vehicle.initial_temperature)
    for _ in range(_ITERATIONS):
        share = _friction(vehicle, friction_of_temperature, temperature) * vehicle.pressure_split
        share /= share.sum(axis=1, keepdims=True)
        previous, temperature = temperature, _temperature(vehicle, heat * share, cooling, step)
        if np.max(np.abs(temperature - previous)) <= tolerance:
            return temperature, _friction(vehicle, friction_of_temperature, temperature)
    raise VehicleError(f'disc temperatures did not settle to tolerance = {tolerance} K in '
                       f'{_ITERATIONS} rounds; smooth the friction table or raise the tolerance')


def _friction(vehicle: Vehicle, friction_of_temperature: Callable[[FloatArray], FloatArray],
              temperature: FloatArray) -> FloatArray:
    friction = np.asarray(friction_of_temperature(temperature), dtype=np.float64)
    friction = np.broadcast_to(friction, temperature.shape)  # a constant is a table too
    wrong = ~(np.isfinite(friction) & (friction > 0.0))
    if np.any(wrong):
        raise VehicleError(f'friction = {friction[wrong][0]} between {temperature.min():.1f} and '
                           f'{temperature.max():.1f} K; give a table of positive values there')
    return np.asarray(friction * np.array(vehicle.friction_factors))


def _temperature(
        vehicle: Vehicle, heat: FloatArray, cooling: FloatArray, step: float) -> FloatArray:
    """Integrate C dT/dt = heat - cooling (T - T_air) by the trapezoidal rule, one linear solve."""
    from scipy.linalg import solve_banded
    half = 0.5 * step / vehicle.disc_heat_capacity
    bands = np.vstack([1.0 + half * cooling, half * cooling - 1.0])
    bands[0, 0] = 1.0
    right = np.vstack([np.full((1, 4), vehicle.initial_temperature - vehicle.ambient_temperature),
                       half * (heat[1:] + heat[:-1])])
    return np.asarray(vehicle.ambient_temperature + solve_banded((1, 0), bands, right))


def _vehicle(content: dict[Any, Any]) -> Vehicle:
    keys = {item.metadata.get('key', item.name): item for item in fields(Vehicle)}
    for key, value in content.items():
        if key not in keys:
            raise VehicleError(
                f'unknown key {short_repr(key)} = {short_repr(value)}; use: {", ".join(keys)}'
                f'{did_you_mean(key, keys)}')
    values = {}
    for key, item in keys.items():
        if key not in content:
            raise VehicleError(f'key {key!r} is missing; add a line such as "{key}: ..."')
        if item.metadata:
            number = _number(key, content[key])
            values[item.name] = number * item.metadata['scale'] + item.metadata['offset']
        elif not isinstance(content[key], list):
            raise VehicleError(
                f'{key} = {short_repr(content[key])} is no list; write four in brackets')
    factors = enumerate(content['friction_factors'])
    values['friction_factors'] = tuple(_number(f'friction_factors[{i}]', x) for i, x in factors)
    values['brakes'] = tuple(str(name) for name in content['brakes'])
    return Vehicle(**values)


def _number(key: str, value: Any) -> float:
    try:
        if isinstance(value, bool):
            raise TypeError
        return float(value)  # one in quotes, too
    except (TypeError, ValueError, OverflowError):
        raise VehicleError(
            f'{key} = {short_repr(value)} is no number; write a decimal number') from None
