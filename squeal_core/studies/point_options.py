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

"""What says where a brake operates, before there is a model: of one model it is a point."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.parameter_paths import by_law, Law, moved

DEFAULT_PRELOAD = 2000.0  # N, K09 table 1
_LAST = ('friction_slope', 'contact_stiffness')  # what another parameter would carry along


@dataclass(frozen=True, kw_only=True)
class PointOptions:
    """
    Options of an operating point, as commands take them.

    Parameters
    ----------
    rotor_speed : float
        [rad/s]
    friction : float, optional
        None: the model's friction law at this speed.
    friction_slope : float, optional
        [s/m]; None: zero with a given friction, else the law's.
    friction_law : bool
        The law's slope, scaled to the given friction.
    preload, pressure : float, optional
        [N] of one pad, or [Pa]; 2000 N where both are None.
    contact_stiffness : float, optional
        [N/m^3]; None: the model's at this contact pressure.
    damping_scale : float
        Factor on the model's damping [-].

    """

    rotor_speed: float
    friction: float | None = None
    friction_slope: float | None = None
    friction_law: bool = False
    preload: float | None = None
    pressure: float | None = None
    contact_stiffness: float | None = None
    damping_scale: float = 1.0

    def at(self, model: BrakeModel) -> OperatingPoint:
        """Return the operating point of a model."""
        law = model.friction_law
        speed = model.contact_radius * self.rotor_speed
        friction, slope = self.friction, self.friction_slope
        if law is None and (friction is None or self.friction_law):
            raise SquealError('this model has no friction law; give --friction and '
                              '--friction-slope')
        if slope is None:
            slope = 0.0
            if law is not None and (self.friction_law or friction is None):
                slope = law.slope_at(speed,
                                     law.coefficient(speed) if friction is None else friction)
        if friction is None:
            assert law is not None
            friction = law.coefficient(speed)
        contact_pressure = self._preload(model) / model.contact_area
        return OperatingPoint(
            rotor_speed=self.rotor_speed, friction=math.copysign(friction, self.rotor_speed),
            friction_slope=slope, contact_pressure=contact_pressure,
            contact_stiffness=model.contact_stiffness_at(contact_pressure)
            if self.contact_stiffness is None else self.contact_stiffness,
            damping_scale=self.damping_scale)

    def _preload(self, model: BrakeModel) -> float:
        if self.pressure is None:
            return DEFAULT_PRELOAD if self.preload is None else self.preload
        if model.caliper is None:
            raise SquealError('--pressure: this model has no caliper; give --preload')
        return model.caliper.preload(self.pressure)


def point_with(model: BrakeModel, point: OperatingPoint, values: Mapping[str, float],
               friction_law: Law) -> OperatingPoint:
    """Return a point with parameters set, and friction and slope by the law where they follow."""
    for name in sorted(values, key=lambda name: name in _LAST):
        point = moved(model, point, name, float(values[name]))
    return by_law(model, point, friction_law) if friction_law else point


def brake_pressure(model: BrakeModel, point: OperatingPoint) -> float | None:
    """Return the brake pressure at a point [Pa]; None of a model without a caliper."""
    if model.caliper is None:
        return None
    return point.contact_pressure / model.contact_pressure(1.0)
