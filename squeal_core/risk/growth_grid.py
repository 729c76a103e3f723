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

"""A grid of operating points around an envelope, and the coefficients of the model at them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint, OperatingPoints
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.uncertainty import InputUncertainty

SPEED_STEP, PRESSURE_STEP = 0.1, 0.2  # of the logarithms
FRICTION_STEP = 0.01  # half a standard deviation of the default uncertainty
STIFFNESS_STEP = 0.04 / 3.0  # of ln k_c: flutter islands are a few hundredths wide
_DEVIATIONS = 3.0  # standard deviations of friction and ln k_c that the grid covers
_FINER = 4  # times finer friction where k_c is certain: growth sets in like a square root


@dataclass(frozen=True, eq=False)
class GrowthGrid:
    """
    Operating points of a model, by four axes.

    The friction slope follows the model's friction law, the contact stiffness is a factor times
    the model's at the pressure.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    rotor_speed, contact_pressure : arrays
        Evenly spaced by their logarithms [rad/s], [Pa].
    friction : array
        Evenly spaced [-].
    stiffness_factor : array
        Contact stiffness over the model's, evenly spaced by its logarithm [-].

    """

    model: BrakeModel
    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    stiffness_factor: FloatArray

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Return the number of points along each axis."""
        return (self.rotor_speed.size, self.contact_pressure.size, self.friction.size,
                self.stiffness_factor.size)

    @property
    def steps(self) -> FloatArray:
        """Distance of neighbours along each axis (4,), of logarithms but for friction."""
        return np.array([axis[1] - axis[0] if axis.size > 1 else 1.0 for axis in (
            np.log(self.rotor_speed), np.log(self.contact_pressure), self.friction,
            np.log(self.stiffness_factor))])

    def coefficients(self, places: IndexArray) -> FloatArray:
        """Return the model's coefficients, (P, 9), at grid points given by index (P, 4)."""
        speed, pressure, friction, factor = (axis[place] for axis, place in zip(
            (self.rotor_speed, self.contact_pressure, self.friction, self.stiffness_factor),
            places.T, strict=True))
        return self._points(speed, pressure, friction, factor).coefficients().T

    def between(self, low: IndexArray, high: IndexArray) -> OperatingPoint:
        """Return the operating point midway between two grid points given by index (4,)."""
        speed, pressure, friction, factor = ((axis[a], axis[b]) for axis, a, b in zip(
            (self.rotor_speed, self.contact_pressure, self.friction, self.stiffness_factor),
            low, high, strict=True))
        return self._points(
            np.sqrt([speed[0] * speed[1]]), np.sqrt([pressure[0] * pressure[1]]),
            np.array([0.5 * sum(friction)]), np.sqrt([factor[0] * factor[1]]))[0]

    def _points(self, speed: FloatArray, pressure: FloatArray, friction: FloatArray,
                factor: FloatArray) -> OperatingPoints:
        slope, stiffness = sliding_laws(self.model, speed, pressure, friction)
        return OperatingPoints.of(
            rotor_speed=speed, friction=friction, contact_pressure=pressure, friction_slope=slope,
            contact_stiffness=factor * stiffness)


@dataclass(frozen=True)
class GridBox:
    """Part of a grid: index of its first point along each axis, and of the one after its last."""

    low: tuple[int, ...]
    high: tuple[int, ...]

    @property
    def size(self) -> IndexArray:
        """Return the number of points along each axis."""
        return np.subtract(self.high, self.low)

    @property
    def slices(self) -> tuple[slice, ...]:
        return tuple(map(slice, self.low, self.high))

    @property
    def places(self) -> IndexArray:
        """Index (P, 4) of all points."""
        return np.stack(np.meshgrid(*map(np.arange, self.low, self.high), indexing='ij'),
                        axis=-1).reshape(-1, 4)

    def halves(self, axis: int) -> tuple['GridBox', 'GridBox']:
        middle = (self.low[axis] + self.high[axis]) // 2
        return (GridBox(self.low, (*self.high[:axis], middle, *self.high[axis + 1:])),
                GridBox((*self.low[:axis], middle, *self.low[axis + 1:]), self.high))

    def around(self, parts: Sequence['GridBox']) -> 'GridBox | None':
        """Return the smallest box with all of this one that lies in some parts."""
        low, high = (np.array([getattr(part, end) for part in parts]).reshape(-1, 4)
                     for end in ('low', 'high'))
        low, high = np.maximum(low, self.low), np.minimum(high, self.high)
        meets = (low < high).all(axis=1)
        if not meets.any():
            return None
        return GridBox(tuple(low[meets].min(axis=0).tolist()),
                       tuple(high[meets].max(axis=0).tolist()))


def grid_over(model: BrakeModel, uncertainty: InputUncertainty, *,
              rotor_speed: tuple[float, float], contact_pressure: tuple[float, float],
              friction: tuple[float, float]) -> tuple[GrowthGrid, slice]:
    """
    Return the grid over an envelope and its uncertainty, and which of its frictions are nominal.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    uncertainty : InputUncertainty
        Standard deviations of the inputs.
    rotor_speed, contact_pressure, friction : (2,) floats
        Lowest and highest nominal values [rad/s], [Pa], [-].

    """
    nominal, step = _friction_steps(uncertainty)
    beyond = math.ceil(_DEVIATIONS * uncertainty.friction / step - 1e-9)
    below = min(beyond, int(friction[0] / step + 1e-9))
    nodes = math.ceil((friction[1] - friction[0]) / nominal - 1e-9) + 1
    per = round(nominal / step)
    frictions = friction[0] + step * np.arange(-below, (nodes - 1) * per + 1 + beyond)
    return GrowthGrid(
        model, _geometric(rotor_speed, SPEED_STEP), _geometric(contact_pressure, PRESSURE_STEP),
        np.maximum(frictions, 0.0), stiffness_factors(uncertainty.contact_stiffness),
    ), slice(below, below + (nodes - 1) * per + 1, per)


def grid_around(model: BrakeModel, uncertainty: InputUncertainty, rotor_speed: float,
                contact_pressure: float, friction: float) -> tuple[GrowthGrid, int]:
    """Return a grid around one operating point and the index of its friction; others are 1."""
    grid, nominal = grid_over(
        model, uncertainty, friction=(friction, friction),
        rotor_speed=(rotor_speed, rotor_speed), contact_pressure=(
            contact_pressure, contact_pressure))
    three = np.array([-0.5, 0.0, 0.5])
    return replace(grid, rotor_speed=rotor_speed * np.exp(SPEED_STEP * three),
                   contact_pressure=contact_pressure * np.exp(PRESSURE_STEP * three)
                   ), nominal.start


def stiffness_factors(deviation: float) -> FloatArray:
    """Return contact stiffnesses over the nominal one for a standard deviation of ln k_c."""
    if deviation == 0.0:
        return np.ones(1)
    step = min(STIFFNESS_STEP, max(0.4 * deviation, 0.004) / 3.0)
    count = round(_DEVIATIONS * deviation / step)
    return np.asarray(np.exp(step * np.arange(-count, count + 1)))


def _friction_steps(uncertainty: InputUncertainty) -> tuple[float, float]:
    """Return the step of nominal frictions, and that of the grid, which divides it."""
    if uncertainty.friction == 0.0:
        return FRICTION_STEP, FRICTION_STEP
    finer = 1 if uncertainty.contact_stiffness else _FINER
    wanted = min(0.5 * uncertainty.friction, FRICTION_STEP) / finer
    return FRICTION_STEP, FRICTION_STEP / math.ceil(FRICTION_STEP / wanted)


def _geometric(ends: Sequence[float], step: float) -> FloatArray:
    count = math.ceil(math.log(ends[1] / ends[0]) / step - 1e-9) + 1
    return np.geomspace(ends[0], ends[1], count)
