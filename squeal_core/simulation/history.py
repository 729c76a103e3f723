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


"""Operating histories: where the brakes of a transient operate over time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.brake.operating_point import (
    MINIMUM_ROTOR_SPEED,
    OperatingPoint,
    OperatingPoints,
    RELEASE_PRESSURE,
)
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import ModelError, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws

_SIGNALS = ('rotor_speed', 'contact_pressure', 'friction', 'friction_slope', 'contact_stiffness')


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingHistory:
    """
    Inputs of B brakes at T times, linear between them.

    Parameters
    ----------
    brakes : tuple of str
        Names of the columns.
    time : (T,) array
        Rising [s].
    rotor_speed, contact_pressure, friction, friction_slope, contact_stiffness : (T, B) arrays
        [rad/s], negative backwards; p0 [Pa]; mu [-], positive; mu_v [s/m]; k_c [N/m^3].
    least_pressure : float
        p0 [Pa] below which a brake is released.

    Examples
    --------
    >>> from squeal_core import BrakeModel
    >>> history = OperatingHistory.of_signals(
    ...     BrakeModel.load('kang2009'), ('front',), time=[0.0, 1.0], rotor_speed=[[20.0], [10.0]],
    ...     pressure=[[0.0], [1e6]], friction=[[0.4], [0.4]], slope=[[0.0], [0.0]])
    >>> float(history.at(0.5).rotor_speed[0])
    15.0
    >>> history.sliding(0.0), history.sliding(0.5)
    (array([False]), array([ True]))

    """

    brakes: tuple[str, ...]
    time: FloatArray
    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    friction_slope: FloatArray
    contact_stiffness: FloatArray
    least_pressure: float = 0.0

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        object.__setattr__(self, 'time', readonly(self.time))
        if self.time.ndim != 1 or self.time.size < 2 or not np.all(np.diff(self.time) > 0.0):
            raise SquealError(f'time: shape {self.time.shape}; give at least two rising times')
        for name in _SIGNALS:
            values = readonly(getattr(self, name))
            object.__setattr__(self, name, values)
            if values.shape != (self.time.size, len(self.brakes)) \
                    or not np.isfinite(values).all():
                raise SquealError(f'{name}: shape {values.shape}, or values that are not '
                                  f'finite; give {(self.time.size, len(self.brakes))} of numbers')

    @classmethod
    def ramps(cls, start: Sequence[OperatingPoint], end: Sequence[OperatingPoint],
              duration: float, brakes: tuple[str, ...] = ()) -> 'OperatingHistory':
        """Return ramps from one operating point to another, of each brake; or constant inputs."""
        values = {name: np.array([[getattr(point, name) for point in points]
                                  for points in (start, end)]) for name in _SIGNALS}
        values['friction'] = np.abs(values['friction'])
        return cls(brakes=brakes or tuple(f'brake_{i + 1}' for i in range(len(start))),
                   time=np.array([0.0, duration]), least_pressure=0.0, **values)

    @classmethod
    def of_signals(cls, model: BrakeModel, brakes: tuple[str, ...], *, time: FloatArray,
                   rotor_speed: FloatArray, pressure: FloatArray, friction: FloatArray,
                   slope: FloatArray | None = None) -> 'OperatingHistory':
        """
        Return the history of brakes from the signals of a vehicle.

        Parameters
        ----------
        model : BrakeModel
            Its caliper, contact stiffness and friction law.
        brakes : tuple of str
            Names of the columns.
        time : (T,) array
            [s].
        rotor_speed, pressure, friction : (T, B) arrays
            [rad/s], [Pa] of brake pressure, [-].
        slope : (T, B) array, optional
            mu_v [s/m]; that of the friction law, scaled to the friction, where None.

        """
        if model.caliper is None:
            raise ModelError('caliper: this model has none, so a pressure says nothing; give '
                             'operating points')
        speed = np.asarray(rotor_speed, dtype=float)
        friction = np.asarray(friction, dtype=float)
        p0 = np.asarray(pressure, dtype=float) * model.contact_pressure(1.0)
        by_law, stiffness = sliding_laws(model, speed, p0, friction)
        return cls(brakes=brakes, time=time, rotor_speed=speed, contact_pressure=p0,
                   friction=friction, friction_slope=by_law if slope is None else slope,
                   contact_stiffness=stiffness,
                   least_pressure=model.contact_pressure(RELEASE_PRESSURE))

    @classmethod
    def side_by_side(cls, histories: Sequence['OperatingHistory']) -> 'OperatingHistory':
        """Return histories of one brake each that all start at 0 s; constant after their ends."""
        starts = [float(one.time[0]) for one in histories]
        time = np.unique(np.concatenate([
            one.time - start for one, start in zip(histories, starts, strict=True)]))
        return cls(
            brakes=tuple(f'brake_{i + 1}' for i in range(len(histories))), time=time,
            least_pressure=histories[0].least_pressure,
            **{name: np.column_stack([
                np.interp(time, one.time - start, getattr(one, name)[:, 0])
                for one, start in zip(histories, starts, strict=True)]) for name in _SIGNALS})

    def at(self, time: float) -> OperatingPoints:
        """Return the points of all brakes at a time [s]; constant before and after the history."""
        after = int(np.clip(np.searchsorted(self.time, time), 1, self.time.size - 1))
        before = after - 1
        share = np.clip((time - self.time[before]) / (self.time[after] - self.time[before]),
                        0.0, 1.0)
        speed, pressure, friction, slope, stiffness = (
            (1.0 - share) * getattr(self, name)[before] + share * getattr(self, name)[after]
            for name in _SIGNALS)
        return OperatingPoints.of(
            rotor_speed=speed, contact_pressure=pressure, friction=np.copysign(friction, speed),
            friction_slope=slope, contact_stiffness=stiffness)

    def sliding(self, time: float) -> NDArray[np.bool_]:
        """Return a mask (B,) of the brakes that slide under load at a time [s]."""
        points = self.at(time)
        loaded = (points.contact_pressure > 0.0) & (
            points.contact_pressure >= self.least_pressure)
        return np.asarray(loaded & (np.abs(points.rotor_speed) >= MINIMUM_ROTOR_SPEED))

    @property
    def mean_stiffness(self) -> float:
        """Mean k_c over loaded samples, or over all [N/m^3]."""
        loaded = self.contact_pressure > self.least_pressure
        return float(self.contact_stiffness[loaded].mean() if loaded.any()
                     else self.contact_stiffness.mean())
