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

"""Precomputed risk and growth rate over rotor speed, contact pressure and friction."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import product
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr
from squeal_core.common.arrays import FloatArray, IndexArray, readonly
from squeal_core.risk.uncertainty import InputUncertainty, RiskParameters

Axis: TypeAlias = Literal['rotor_speed', 'contact_pressure', 'friction']
AXES: tuple[Axis, ...] = ('rotor_speed', 'contact_pressure', 'friction')
ARRAYS = (*AXES, 'score', 'growth')
_CORNERS = np.array(list(product((0, 1), repeat=3)))  # of a cell (8, 3)
_ROUNDING = 1e-9  # of a grid step, by which a point may be outside


@dataclass(frozen=True)
class MapError:
    """
    Difference between a map's risks and direct integrations at check points.

    Parameters
    ----------
    points : int
        Number of check points.
    largest, rms : float
        Largest difference and root mean square [-].

    """

    points: int
    largest: float
    rms: float


@dataclass(frozen=True, eq=False)
class OperatingMap:
    """
    Risk and growth rate on a grid of operating points.

    Parameters
    ----------
    parameters : RiskParameters
        Squeal band, growth threshold and uncertainty that the risk is for.
    rotor_speed, contact_pressure : arrays
        Grid, evenly spaced by their logarithms [rad/s], [Pa].
    friction : array
        Grid, evenly spaced [-].
    score : (speeds, pressures, frictions) array
        Standard normal quantile of the probability that a mode in the band grows [-]; this, and
        not the probability, is nearly linear between grid points.
    growth : (speeds, pressures, frictions) array
        Largest growth rate of an oscillating mode in the band at the nominal contact stiffness
        [1/s]; where the largest is outside, minus its distance to the band [rad/s].
    error : MapError
        Of the risk.

    """

    parameters: RiskParameters
    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    score: Any
    growth: Any
    error: MapError

    @property
    def nbytes(self) -> int:
        """Size of the arrays [bytes]."""
        return int(self.score.nbytes + self.growth.nbytes)

    def risk_at(self, rotor_speed: ArrayLike, contact_pressure: ArrayLike,
                friction: ArrayLike) -> FloatArray:
        """
        Return the risk at operating points, NaN outside the map.

        Parameters
        ----------
        rotor_speed : array_like
            Magnitude [rad/s].
        contact_pressure : array_like
            [Pa].
        friction : array_like
            Friction coefficient [-].

        """
        return np.asarray(ndtr(self._interpolated(
            self._score, rotor_speed, contact_pressure, friction)))

    def growth_along_friction(self, rotor_speed: FloatArray,
                              contact_pressure: FloatArray) -> FloatArray:
        """Return growth rates (P, F) [1/s] at all frictions of the map, NaN outside."""
        places = np.log([rotor_speed, contact_pressure])
        first, steps, intervals = (values[:2, None] for values in self._axes)
        places = (places - first) / steps
        inside = ((places >= -_ROUNDING) & (places <= intervals + _ROUNDING)).all(axis=0)
        cells = np.where(inside, places, 0.0).astype(np.intp)
        cells = np.minimum(np.maximum(cells, 0), intervals - 1)
        a, b = np.where(inside, places - cells, np.nan)[..., None]
        rows, pressures = self._growth.reshape(-1, self.friction.size), self.contact_pressure.size
        corner = pressures * cells[0] + cells[1]
        near, far = ((1.0 - b) * rows.take(place, axis=0) + b * rows.take(place + 1, axis=0)
                     for place in (corner, corner + pressures))
        return np.asarray((1.0 - a) * near + a * far)

    @cached_property
    def _score(self) -> FloatArray:
        return readonly(self.score)

    @cached_property
    def _growth(self) -> FloatArray:
        return readonly(self.growth)

    @cached_property
    def _axes(self) -> tuple[FloatArray, FloatArray, IndexArray]:
        """Return the first value, the step and the number of intervals of each axis."""
        axes = (np.log(self.rotor_speed), np.log(self.contact_pressure), self.friction)
        intervals = np.array([axis.size - 1 for axis in axes])
        first, last = (np.array([axis[end] for axis in axes]) for end in (0, -1))
        return first, (last - first) / intervals, intervals

    def _interpolated(self, values: FloatArray, *point: ArrayLike) -> FloatArray:
        """Return values between grid points, linear along each axis."""
        speed, pressure, friction = np.broadcast_arrays(*(np.asarray(x, float) for x in point))
        first, steps, intervals = (axis[:, None] for axis in self._axes)
        places = np.empty((3, speed.size))
        with np.errstate(divide='ignore', invalid='ignore'):
            places[0], places[1] = np.log(speed.ravel()), np.log(pressure.ravel())
            places[2] = friction.ravel()
            places = (places - first) / steps
        inside: Any = ((places >= -_ROUNDING) & (places <= intervals + _ROUNDING)).all(axis=0)
        places = np.where(inside, places, 0.0)
        cells = np.minimum(np.maximum(places.astype(np.intp), 0), intervals - 1)
        strides = np.array([values[0].size, values.shape[2], 1])
        corners = (strides @ cells) + (_CORNERS @ strides)[:, None]
        parts = places - cells
        weights = np.where(_CORNERS[..., None], parts, 1.0 - parts).prod(axis=1)
        found = weights * values.take(corners)
        while len(found) > 1:  # in an order that does not depend on the number of points
            found = found[::2] + found[1::2]
        return np.asarray(np.where(inside, found[0], np.nan).reshape(speed.shape))

    def header(self) -> dict[str, Any]:
        """Return the contents of a file's header: all but the arrays."""
        return {'parameters': asdict(self.parameters), 'error': asdict(self.error)}

    def arrays(self) -> dict[str, Any]:
        """Return the arrays of a file, by name."""
        return {name: getattr(self, name) for name in ARRAYS}

    @classmethod
    def of(cls, header: Mapping[str, Any], arrays: Mapping[str, Any]) -> 'OperatingMap':
        """
        Return the map of a header and arrays, as `header` and `arrays` give them.

        Raises
        ------
        ValueError
            For contents that are not those of a map.

        """
        try:
            parameters, error = header['parameters'], header['error']
            low, high = map(float, parameters['band_hz'])
            found = cls(
                parameters=RiskParameters(
                    band_hz=(low, high), growth_threshold=float(parameters['growth_threshold']),
                    uncertainty=InputUncertainty(**{
                        name: float(value) for name, value in parameters['uncertainty'].items()})),
                rotor_speed=readonly(arrays['rotor_speed']),
                contact_pressure=readonly(arrays['contact_pressure']),
                friction=readonly(arrays['friction']),
                score=np.asarray(arrays['score'], np.float32),
                growth=np.asarray(arrays['growth'], np.float32),
                error=MapError(int(error['points']), float(error['largest']),
                               float(error['rms'])))
        except (KeyError, TypeError, AttributeError) as wrong:
            raise ValueError(f'no operating map ({type(wrong).__name__}: {wrong})') from None
        found._check()
        return found

    def _check(self) -> None:
        shape = tuple(getattr(self, name).size for name in AXES)
        for name in AXES:
            axis = getattr(self, name)
            if axis.ndim != 1 or axis.size < 2 or not (np.diff(axis) > 0.0).all():
                raise ValueError(f'no operating map: {name} does not rise')
        if self.score.shape != shape or self.growth.shape != shape:
            raise ValueError(f'no operating map: score is {self.score.shape}, its axes {shape}')
