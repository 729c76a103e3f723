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

"""A vehicle of four brakes: its masses, resistances and brakes, each number in its range."""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.common.ranges import Ends, hint

_GRAVITY = 9.80665  # m/s^2, standard
_FACTORS: Ends = (0.1, 10.0)


class VehicleError(SquealError):
    """A vehicle that cannot be used; the message has place, value and remedy."""


def _quantity(key: str, possible: Ends, usual: Ends, dimension: str = '', scale: float = 1.0,
              offset: float = 0.0) -> Any:
    """Declare a number: its key and ranges as in the file; SI value = scale * number + offset."""
    return field(metadata={'key': key, 'possible': possible, 'usual': usual,
                           'dimension': dimension, 'scale': scale, 'offset': offset})


@dataclass(frozen=True)
class Vehicle:
    """
    A vehicle of four brakes, in SI units.

    Parameters
    ----------
    mass, wheel_radius, wheel_inertia : float
        [kg], [m], [kg m^2] of one wheel.
    frontal_drag_area, air_density, rolling_resistance : float
        Drag coefficient times area [m^2], [kg/m^3], rolling force over weight [-].
    engine_drag, engine_drag_fade_speed : float
        Closed-throttle engine at the wheels [N], fading to zero with speed below this [m/s].
    front_brake_share : float
        Share of the brake force on the front axle at equal friction.
    piston_diameter, caliper_efficiency, effective_radius : float
        Of each brake: [m], clamping force over pressure times piston area [-], [m].
    holding_pressure, holding_speed : float
        Least front pressure [Pa] while the vehicle is slower than this [m/s] and not speeding up.
    disc_heat_capacity, heat_fraction_to_disc, cooling_area : float
        Of each disc: [J/K], share of the brake's heat that enters the disc [-], [m^2].
    still_air_cooling, moving_air_cooling : float
        Heat transfer at rest, and what 1 m/s adds, growing as speed^0.8 [W/(m^2 K)].
    ambient_temperature, initial_temperature : float
        Of the air, and of the discs at the start [K].
    friction_factors : tuple of 4 floats
        Friction of each brake over that of the friction table [-].
    brakes : tuple of 4 str
        Names: front left, front right, rear left, rear right.

    Raises
    ------
    VehicleError
        If a number is outside its range, or there are not four factors and four names.

    """

    mass: float = _quantity('mass_kg', (100.0, 1e5), (300.0, 4e4), 'mass')
    wheel_radius: float = _quantity('wheel_radius_m', (0.1, 1.0), (0.2, 0.6), 'length')
    wheel_inertia: float = _quantity('wheel_inertia_kg_m2', (0.0, 100.0), (0.1, 30.0))
    frontal_drag_area: float = _quantity('frontal_drag_area_m2', (0.0, 20.0), (0.2, 10.0))
    air_density: float = _quantity('air_density_kg_per_m3', (0.0, 2.0), (0.7, 1.5))
    rolling_resistance: float = _quantity(
        'rolling_resistance', (0.0, 0.1), (0.003, 0.03), 'number')
    engine_drag: float = _quantity('engine_drag_n', (0.0, 1e4), (0.0, 4000.0), 'force')
    engine_drag_fade_speed: float = _quantity(
        'engine_drag_fade_speed_m_per_s', (0.1, 20.0), (0.5, 10.0))
    front_brake_share: float = _quantity('front_brake_share', (0.1, 0.95), (0.4, 0.9), 'number')
    piston_diameter: float = _quantity(
        'piston_diameter_mm', (5.0, 200.0), (15.0, 150.0), 'length', 1e-3)
    caliper_efficiency: float = _quantity('caliper_efficiency', (0.1, 1.0), (0.6, 1.0), 'number')
    effective_radius: float = _quantity(
        'effective_radius_mm', (20.0, 500.0), (50.0, 300.0), 'length', 1e-3)
    holding_pressure: float = _quantity(
        'holding_pressure_bar', (0.0, 100.0), (0.0, 50.0), 'pressure', 1e5)
    holding_speed: float = _quantity('holding_speed_m_per_s', (0.0, 1.0), (0.0, 0.5))
    disc_heat_capacity: float = _quantity('disc_heat_capacity_j_per_k', (100.0, 1e5), (500.0, 3e4))
    heat_fraction_to_disc: float = _quantity(
        'heat_fraction_to_disc', (0.1, 1.0), (0.5, 1.0), 'number')
    cooling_area: float = _quantity('cooling_area_m2', (0.0, 5.0), (0.01, 1.5))
    still_air_cooling: float = _quantity('still_air_cooling_w_per_m2_k', (0.0, 500.0), (1.0, 60.0))
    moving_air_cooling: float = _quantity(
        'moving_air_cooling_w_per_m2_k', (0.0, 500.0), (0.5, 60.0))
    ambient_temperature: float = _quantity(
        'ambient_temperature_degc', (-60.0, 80.0), (-40.0, 55.0), 'temperature', 1.0, 273.15)
    initial_temperature: float = _quantity(
        'initial_temperature_degc', (-60.0, 800.0), (-40.0, 250.0), 'temperature', 1.0, 273.15)
    friction_factors: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)
    brakes: tuple[str, ...] = ('front_left', 'front_right', 'rear_left', 'rear_right')

    def __post_init__(self) -> None:
        for item in fields(self):
            if item.metadata:
                _check_range(getattr(self, item.name), **item.metadata)
        for i, factor in enumerate(self.friction_factors):
            _check_range(factor, f'friction_factors[{i}]', _FACTORS)
        for key, entries in (('friction_factors', self.friction_factors),
                             ('brakes', set(self.brakes))):
            if len(entries) != 4:
                raise VehicleError(f'{key} = {list(getattr(self, key))}; give four, names all '
                                   'different: front left, front right, rear left, rear right')
        if self.effective_radius >= self.wheel_radius:
            raise VehicleError(
                f'effective_radius_mm = {1e3 * self.effective_radius:g} is no less than '
                f'wheel_radius_m = {self.wheel_radius:g}; give the radius at which the pads rub')

    def doubts(self) -> Iterator[str]:
        """Yield a text for each number that can be used but is unusual."""
        for item in fields(self):
            if item.metadata:
                yield from _doubt(getattr(self, item.name), **item.metadata)
        for i, factor in enumerate(self.friction_factors):
            yield from _doubt(factor, f'friction_factors[{i}]', _FACTORS, (0.5, 2.0), 'number')

    @property
    def pressure_split(self) -> FloatArray:
        """Pressure of each brake over the front pressure, array (4,)."""
        rear = (1.0 - self.front_brake_share) / self.front_brake_share
        return np.array([1.0, 1.0, rear, rear])

    @property
    def torque_per_pressure(self) -> float:
        """Torque of one brake over friction and pressure [N m/Pa]: two pads on one disc."""
        piston_area = math.pi * self.piston_diameter**2 / 4.0
        return 2.0 * piston_area * self.caliper_efficiency * self.effective_radius

    def resistance(self, speed: FloatArray) -> FloatArray:
        """Force of air, tyres and closed-throttle engine at a speed [m/s], in N, same shape."""
        drag = 0.5 * self.air_density * self.frontal_drag_area * speed**2
        rolling = self.rolling_resistance * self.mass * _GRAVITY
        engine = self.engine_drag * np.minimum(speed / self.engine_drag_fade_speed, 1.0)
        return np.asarray(drag + rolling + engine)

    def brake_force(self, speed: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Force the brakes must add for an acceleration [m/s^2], in N; zero where none is due."""
        return np.maximum(-self.inertia * acceleration - self.resistance(speed), 0.0)

    def deceleration(self, speed: float, force: float) -> float:
        """Return the deceleration [m/s^2] at a speed [m/s] by a force of the brakes."""
        return (force + float(self.resistance(np.array(speed)))) / self.inertia

    @property
    def inertia(self) -> float:
        """Mass, with the inertia of the wheels [kg]."""
        return self.mass + 4.0 * self.wheel_inertia / self.wheel_radius**2

    def cooling(self, speed: FloatArray) -> FloatArray:
        """Heat a disc gives to the air per kelvin above it [W/K], same shape as `speed` [m/s]."""
        moving = self.moving_air_cooling * speed**0.8  # turbulent flow
        return np.asarray(self.cooling_area * (self.still_air_cooling + moving))


def _check_range(value: float, key: str, possible: Ends, usual: Ends | None = None,
                 dimension: str = '', scale: float = 1.0, offset: float = 0.0) -> None:
    number = round((value - offset) / scale, 9)  # as in the file, free of the conversion's dust
    if not possible[0] <= number <= possible[1]:
        raise VehicleError(f'{key} = {number:g} is out of range; give {possible[0]:g} to '
                           f'{possible[1]:g}{_meant(number, usual or possible, dimension, scale)}')


def _doubt(value: float, key: str, possible: Ends, usual: Ends, dimension: str = '',
           scale: float = 1.0, offset: float = 0.0) -> Iterator[str]:
    number = round((value - offset) / scale, 9)
    if not usual[0] <= number <= usual[1]:
        yield (f'{key} = {number:g}; usual is {usual[0]:g} to {usual[1]:g}: check it'
               f'{_meant(number, usual, dimension, scale)}')


def _meant(number: float, usual: Ends, dimension: str, scale: float) -> str:
    if dimension == 'temperature':
        celsius = number - 273.15
        return f' ({number:g} K would be {celsius:g})' if usual[0] <= celsius <= usual[1] else ''
    return hint(number, dimension, scale, '', (usual[0] * scale, usual[1] * scale))
