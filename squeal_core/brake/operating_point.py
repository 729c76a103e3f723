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

"""The operating point, and the scalars with which it multiplies the model's matrices."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray, IndexArray, readonly, repr_with_shapes
from squeal_core.common.errors import OperatingPointError


class Coefficients(NamedTuple):
    """
    Factors of the affine family (K09 eq. 36): D = d C + g G0 + r R0 + ..., K = W + a A0 + ...

    Each is named as the array of `BrakeModel` that it multiplies. The last three are 1 and k_c
    times (1, mu) at the damping scale 1; K09 has no contact damping.

    Attributes
    ----------
    gyroscopic : float
        Omega [rad/s].
    radial_dissipation : float
        p0 mu / Omega [Pa s/rad].
    negative_slope : float
        p0 mu_v [Pa s/m].
    contact_stiffness : float
        k_c [N/m^3].
    friction_couple : float
        mu k_c [N/m^3].
    follower : float
        p0 mu [Pa].
    material_damping : float
        The damping scale [-].
    contact_damping : float
        Damping scale times k_c [N/m^3].
    contact_damping_couple : float
        Damping scale times mu k_c [N/m^3].

    """

    gyroscopic: float
    radial_dissipation: float
    negative_slope: float
    contact_stiffness: float
    friction_couple: float
    follower: float
    material_damping: float
    contact_damping: float
    contact_damping_couple: float


DASHPOTS = {'contact_stiffness': 'contact_damping', 'friction_couple': 'contact_damping_couple'}
"""Damping coefficients that are those of a stiffness times the damping scale: of one layer."""
DAMPING = ('gyroscopic', 'radial_dissipation', 'negative_slope', 'material_damping',
           *DASHPOTS.values())
"""Coefficients of D; the others are those of K."""


def coefficients_of(point: Any) -> tuple[Any, ...]:
    """Return the factors in the order of `Coefficients`: of one point or of arrays."""
    load = point.contact_pressure * point.friction
    couple = point.friction * point.contact_stiffness
    return (point.rotor_speed, load / point.rotor_speed,
            point.contact_pressure * point.friction_slope, point.contact_stiffness, couple, load,
            point.damping_scale, point.damping_scale * point.contact_stiffness,
            point.damping_scale * couple)


@dataclass(frozen=True, kw_only=True)
class OperatingPoint:
    """
    Steady sliding under load.

    Parameters
    ----------
    rotor_speed : float
        Omega [rad/s], not zero: the linearisation needs steady sliding. For a disc turning
        backwards give a negative speed and a negative friction (friction opposes sliding).
    friction : float
        mu [-].
    friction_slope : float
        mu_v = d mu / d v [s/m].
    contact_pressure : float
        p0, preload over contact area [Pa].
    contact_stiffness : float
        k_c per area [N/m^3].
    damping_scale : float
        Factor on the damping of components, supports and contact layer; 1 is the model's [-].

    Raises
    ------
    OperatingPointError
        For a value that is not finite, a speed of zero, a negative pressure, stiffness or scale.

    References
    ----------
    K09 eqs (38), (A.3)-(A.7): see `BrakeModel`.

    Examples
    --------
    >>> from squeal_core import OperatingPoint
    >>> point = OperatingPoint(rotor_speed=20.0, friction=0.4, contact_pressure=5e5,
    ...                        contact_stiffness=1e10)
    >>> point.coefficients().friction_couple
    4000000000.0

    """

    rotor_speed: float
    friction: float
    friction_slope: float = 0.0
    contact_pressure: float
    contact_stiffness: float
    damping_scale: float = 1.0

    def __post_init__(self) -> None:
        if not math.isfinite(self.rotor_speed + self.friction + self.friction_slope
                             + self.contact_pressure + self.contact_stiffness
                             + self.damping_scale):
            self._refuse_what_is_not_finite()
        if self.rotor_speed == 0.0:
            raise OperatingPointError(
                'rotor_speed is 0 rad/s; steady sliding needs a speed other than zero')
        if min(self.contact_pressure, self.contact_stiffness, self.damping_scale) < 0.0:
            name = next(name for name in ('contact_pressure', 'contact_stiffness',
                                          'damping_scale') if getattr(self, name) < 0.0)
            raise OperatingPointError(
                f'{name} is {getattr(self, name):g}; give zero or a positive number')

    def _refuse_what_is_not_finite(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not math.isfinite(value):
                raise OperatingPointError(f'{item.name} is {value}; give a finite number')

    def coefficients(self) -> Coefficients:
        """Return what multiplies the model's arrays; K09 eqs (38), (A.3)-(A.7)."""
        return Coefficients(*coefficients_of(self))


@dataclass(frozen=True, eq=False)
class OperatingPoints:
    """
    Steady sliding under load at P points; each field as in `OperatingPoint`, (P,).

    Speeds not zero, pressures and contact stiffnesses above zero; not checked.
    """

    rotor_speed: FloatArray
    friction: FloatArray
    contact_pressure: FloatArray
    contact_stiffness: FloatArray
    friction_slope: FloatArray
    damping_scale: FloatArray

    __repr__ = repr_with_shapes

    @classmethod
    def of(cls, *, rotor_speed: ArrayLike, friction: ArrayLike, contact_pressure: ArrayLike,
           contact_stiffness: ArrayLike, friction_slope: ArrayLike = 0.0,
           damping_scale: ArrayLike = 1.0) -> 'OperatingPoints':
        """Return points of arrays that are broadcast together."""
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(value, float)) for value in (
            rotor_speed, friction, contact_pressure, contact_stiffness, friction_slope,
            damping_scale)))
        return cls(*(readonly(array) for array in arrays))

    @classmethod
    def stacked(cls, points: Sequence[OperatingPoint]) -> 'OperatingPoints':
        """Return the arrays of single points."""
        return cls(**{item.name: readonly([getattr(point, item.name) for point in points])
                      for item in fields(cls)})

    def take(self, places: IndexArray) -> 'OperatingPoints':
        """Return those at some places."""
        return OperatingPoints(**{item.name: getattr(self, item.name)[places]
                                  for item in fields(self)})

    def __len__(self) -> int:
        return int(self.rotor_speed.size)

    def __getitem__(self, place: int) -> OperatingPoint:
        return OperatingPoint(**{item.name: float(getattr(self, item.name)[place])
                                 for item in fields(self)})

    def __iter__(self) -> Iterator[OperatingPoint]:
        return map(self.__getitem__, range(len(self)))

    def coefficients(self) -> FloatArray:
        """Return (9, P), as `OperatingPoint.coefficients`."""
        return np.stack(coefficients_of(self))


RELEASE_PRESSURE = 0.5e5
"""Brake pressure below which a brake is released, by default [Pa]."""
MINIMUM_ROTOR_SPEED = 0.5
"""Rotor speed below which a disc does not slide steadily, by default [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class SlidingConditions:
    """
    Inputs of a sliding brake.

    Parameters
    ----------
    rotor_speed : float
        [rad/s]; negative for a disc turning backwards.
    pressure : float
        Brake pressure [Pa].
    friction : float
        mu [-], positive.
    contact_stiffness : float, optional
        k_c [N/m^3]; the model's at this pressure where None.

    """

    rotor_speed: float
    pressure: float
    friction: float
    contact_stiffness: float | None = None
