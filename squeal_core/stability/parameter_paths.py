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

"""Paths through operating points: one parameter moved, two points joined by a straight line."""

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError, OperatingPointError
from squeal_core.model.brake_model import BrakeModel

# damping and stiffness over the way from 0 to 1
MatrixPath: TypeAlias = Callable[[float], tuple[FloatArray, FloatArray]]
Law: TypeAlias = bool | Literal['slope']
"""Quantities that follow the friction law: none, friction and slope, or the slope alone."""
PARAMETERS = ('rotor_speed', 'friction', 'friction_slope', 'contact_pressure', 'contact_stiffness')
_COORDINATES = (*PARAMETERS, 'damping_scale')
OPERATING = (*_COORDINATES, 'preload', 'pressure')
"""Parameters of `moved`: preload [N] and brake pressure [Pa] move the contact pressure."""


def between(model: BrakeModel, start: OperatingPoint, end: OperatingPoint) -> MatrixPath:
    """Return the matrices over the straight way from one point to another."""
    speeds = start.rotor_speed, end.rotor_speed
    if speeds[0] * speeds[1] < 0.0:
        raise OperatingPointError(f'rotor_speed is {speeds} rad/s, of both signs; give one sign')

    def family(way: float) -> tuple[FloatArray, FloatArray]:
        return matrices(model, OperatingPoint(**{
            name: (1.0 - way) * getattr(start, name) + way * getattr(end, name)
            for name in _COORDINATES}))

    return family


def moved(model: BrakeModel, point: OperatingPoint, parameter: str, value: float, *,
          friction_law: Law = False) -> OperatingPoint:
    """
    Return a point with one parameter of `OPERATING` set.

    With friction its slope goes in proportion, as that of a law scaled to a measured friction;
    with contact pressure the contact stiffness, in proportion to the model's table; with
    `friction_law` friction and slope are the law's at the (new) speed, or with 'slope' the slope
    alone, scaled to the friction.
    """
    if parameter not in OPERATING:
        raise OperatingPointError(f'parameter is {parameter}; give one of {", ".join(OPERATING)}')
    if parameter in ('preload', 'pressure'):
        value = (value / model.contact_area if parameter == 'preload'
                 else model.contact_pressure(value))
        parameter = 'contact_pressure'
    there = replace(point, **{parameter: value})
    if parameter == 'friction' and point.friction != 0.0:
        there = replace(there, friction_slope=point.friction_slope * value / point.friction)
    if parameter == 'contact_pressure' and model.stiffness_table is not None:
        before, after = map(model.contact_stiffness_at, (point.contact_pressure, value))
        there = replace(there, contact_stiffness=point.contact_stiffness * after / before)
    return by_law(model, there, friction_law) if friction_law else there


def by_law(model: BrakeModel, point: OperatingPoint, law: Law = True) -> OperatingPoint:
    """Return a point with friction and slope by the model's law at its speed; see `moved`."""
    if model.friction_law is None:
        raise ModelError('friction_law: this model has none; give one, or leave friction constant')
    speed = model.contact_radius * point.rotor_speed
    friction = (abs(point.friction) if law == 'slope'
                else model.friction_law.coefficient(speed))
    return replace(point, friction=float(np.copysign(friction, speed)),
                   friction_slope=model.friction_law.slope_at(speed, friction))


def matrices(model: BrakeModel, point: OperatingPoint) -> tuple[FloatArray, FloatArray]:
    """Return damping [1/s] and stiffness [1/s^2], (N, N) each."""
    return model.damping(point), model.stiffness(point)
