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

"""Options that define an operating point, before there is a model to compute it with."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import OperatingPointError, SquealError
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


def grid_points(model: BrakeModel, point: OperatingPoint, axes: Mapping[str, Sequence[float]],
                friction_law: Law) -> tuple[list[OperatingPoint | None], str]:
    """
    Return the points of a grid, as `point_with` has each, and why one of them is impossible.

    The last axis runs fastest; an impossible point is None. What several have in common is set
    once.
    """
    names, reason = sorted(axes, key=lambda name: name in _LAST), ''

    def attempt(step: Callable[[OperatingPoint], OperatingPoint],
                before: OperatingPoint | None) -> OperatingPoint | None:
        nonlocal reason
        try:
            return None if before is None else step(before)
        except OperatingPointError as error:
            reason = str(error)
            return None

    points: list[OperatingPoint | None] = [point]
    for name in names:
        steps = [partial(moved, model, parameter=name, value=float(value))
                 for value in axes[name]]
        points = [attempt(step, before) for before in points for step in steps]
    if friction_law:
        points = [attempt(partial(by_law, model, law=friction_law), each) for each in points]
    places = np.arange(len(points)).reshape([len(axes[name]) for name in names])
    return [points[i] for i in places.transpose(
        [names.index(name) for name in axes]).ravel().tolist()], reason


def brake_pressure(model: BrakeModel, point: OperatingPoint) -> float | None:
    """Return the brake pressure at a point [Pa]; None of a model without a caliper."""
    if model.caliper is None:
        return None
    return point.contact_pressure / model.contact_pressure(1.0)
