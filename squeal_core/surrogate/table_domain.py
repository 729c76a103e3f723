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

"""The operating points that a table covers: rotor speed, contact pressure and friction."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import (
    MINIMUM_ROTOR_SPEED,
    OperatingPoint,
    OperatingPoints,
)
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import OperatingPointError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws

Range: TypeAlias = tuple[float, float]

ROTOR_SPEED: Range = (MINIMUM_ROTOR_SPEED, 120.0)  # rad/s, to 130 km/h
PRELOAD: Range = (100.0, 20000.0)  # N
FRICTION: Range = (0.001, 0.65)  # linings have 0.15 and more; critical values lie below
STEEPEST = 6000.0  # N s, preload times friction over rotor speed: creeping under full brakes
AXES = ('rotor_speed', 'contact_pressure', 'friction')
_LAW = 1e-9  # relative difference up to which slope and stiffness are those of the model


@dataclass(frozen=True, kw_only=True)
class TableDomain:
    """
    Envelope of a sliding brake, a box in x = (ln rotor speed, ln contact pressure, friction).

    The friction slope follows the model's friction law, the contact stiffness its table.

    Parameters
    ----------
    rotor_speed, contact_pressure, friction : (2,) floats
        Lowest and highest, above zero: rad/s, Pa, -.
    stiffness_factor : float
        Factor on the model's contact stiffness everywhere [-].
    steepest : float
        p0 mu / Omega [Pa s] from which on no cells are built: eigenvalues vary fast there, and
        no vehicle creeps under full brakes.

    Raises
    ------
    OperatingPointError
        For a range that is empty or not above zero.

    """

    rotor_speed: Range
    contact_pressure: Range
    friction: Range
    stiffness_factor: float = 1.0
    steepest: float = math.inf

    def __post_init__(self) -> None:
        for name in AXES:
            low, high = getattr(self, name)
            if not 0.0 < low < high < math.inf:
                raise OperatingPointError(f'{name}: {low:g} to {high:g} is no range; give the '
                                          'lower end first and both above 0')
        if not 0.0 < self.stiffness_factor < math.inf or not self.steepest > 0.0:
            raise OperatingPointError(f'stiffness_factor is {self.stiffness_factor:g}, steepest '
                                      f'{self.steepest:g}; give numbers above 0')

    @classmethod
    def usual(cls, model: BrakeModel, *, rotor_speed: Range = ROTOR_SPEED,
              preload: Range = PRELOAD, friction: Range = FRICTION,
              stiffness_factor: float = 1.0) -> 'TableDomain':
        """Return the usual envelope of a vehicle, 0.5-120 rad/s, 100-20,000 N, 0.001-0.65."""
        low, high = preload
        return cls(rotor_speed=rotor_speed, friction=friction, stiffness_factor=stiffness_factor,
                   steepest=STEEPEST / model.contact_area,
                   contact_pressure=(low / model.contact_area, high / model.contact_area))

    @property
    def low(self) -> FloatArray:
        """Lower corner (3,) in x."""
        return np.array([math.log(self.rotor_speed[0]), math.log(self.contact_pressure[0]),
                         self.friction[0]])

    @property
    def width(self) -> FloatArray:
        """Edges (3,) in x."""
        return np.array([math.log(self.rotor_speed[1]), math.log(self.contact_pressure[1]),
                         self.friction[1]]) - self.low

    def contains(self, centre: FloatArray, half: FloatArray) -> bool:
        """Return whether some of a box is less steep than the limit."""
        speed, pressure, friction = centre + half * (1.0, -1.0, -1.0)
        return bool(math.exp(pressure - speed) * friction < self.steepest)

    def covers(self, x: FloatArray) -> Any:
        """Return whether each place x (P, 3) of the box is less steep than the limit."""
        return np.exp(x[:, 1] - x[:, 0]) * x[:, 2] < self.steepest

    def points(self, model: BrakeModel, x: FloatArray) -> OperatingPoints:
        """Return the operating points at places x (P, 3)."""
        speed, pressure = np.exp(x[:, 0]), np.exp(x[:, 1])
        slope, stiffness = sliding_laws(model, speed, pressure, x[:, 2])
        return OperatingPoints.of(
            rotor_speed=speed, friction=x[:, 2], contact_pressure=pressure, friction_slope=slope,
            contact_stiffness=self.stiffness_factor * stiffness)

    def places(self, model: BrakeModel, points: Sequence[OperatingPoint]) -> FloatArray:
        """
        Return the places x (P, 3) of points.

        NaN where a point has not the slope, stiffness and damping that the table is built with.
        """
        x, law = places_of(points), model.friction_law
        for place, (point, friction) in enumerate(zip(points, x[:, 2].tolist(), strict=True)):
            slope = 0.0 if law is None else law.slope_at(
                model.contact_radius * point.rotor_speed, friction)
            stiffness = self.stiffness_factor * model.contact_stiffness_at(point.contact_pressure)
            if not (abs(point.friction_slope - slope) <= _LAW * abs(slope)
                    and abs(point.contact_stiffness - stiffness) <= _LAW * stiffness
                    and point.damping_scale == 1.0):
                x[place] = np.nan
        return x


def coordinates(rows: FloatArray) -> FloatArray:
    """Return the places x (P, 3) of rotor speeds, contact pressures and frictions, magnitudes."""
    x = rows.copy()
    with np.errstate(divide='ignore', invalid='ignore'):
        x[:, :2] = np.log(rows[:, :2])
    return x


def places_of(points: Sequence[OperatingPoint]) -> FloatArray:
    """
    Return the places x (P, 3) of points, whatever their slope, stiffness and damping.

    -inf at a pressure of zero; friction that does not oppose the sliding is negative.
    """
    return np.array([
        (math.log(abs(point.rotor_speed)),
         math.log(point.contact_pressure) if point.contact_pressure else -math.inf,
         math.copysign(1.0, point.rotor_speed) * point.friction)
        for point in points]).reshape(-1, 3)
