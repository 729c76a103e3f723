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
The noise of a vehicle by its speed and friction power, fitted to the background of a sound.

Level = 10 lg(a + b v^n + c (p v)^m): microphone and surroundings, road and wind, brakes; with the
shift in time at which this fits best.
"""

from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray, repr_with_shapes

_SAMPLES = 20_000  # that a fit needs at most
_START = (-7.0, 0.0, 2.5, 0.0, 1.0)  # ln a, ln b, n, ln c, m; of values over their largest
_LOW, _HIGH = (-30.0, -30.0, 0.5, -30.0, 0.2), (30.0, 30.0, 6.0, 30.0, 3.0)
_MEMORY = 5.0  # s over which residuals may be correlated


class NoiseFit(NamedTuple):
    """
    Shift [s] and its standard deviation [s]; unexplained noise; independent samples.

    `spread` is between the shifts of thirds of the sound [s], each of which changes as much.
    """

    shift: float
    deviation: float
    unexplained: float
    independent: float
    spread: float


@dataclass(frozen=True, eq=False)
class VehicleNoise:
    """
    Speed and friction power on a grid of time.

    Parameters
    ----------
    time : (T,) array
        Rising in equal steps [s].
    speed, power : (T,) arrays
        In any unit; NaN: not known.

    """

    time: FloatArray
    speed: FloatArray
    power: FloatArray

    __repr__ = repr_with_shapes

    def fit(self, time: FloatArray, level: FloatArray, shift: float, reach: float
            ) -> NoiseFit | None:
        """
        Fit the model to levels, at a shift near a given one; None where too little is known.

        Parameters
        ----------
        time, level : (S,) arrays
            Of the sound, in equal steps [s], [dB]; NaN: not known.
        shift, reach : float
            From the sound's clock to the grid's, and how far it may be off [s].

        """
        from scipy.optimize import least_squares
        speed, power = (np.nan_to_num(values / max(np.nanmax(values, initial=0.0), 1e-9))
                        for values in (self.speed, self.power))
        valid = np.isfinite(self.speed + self.power).astype(float)
        inside = np.interp(time + shift, self.time, valid, left=0.0, right=0.0) > 0.99
        keep = np.flatnonzero(np.isfinite(level) & inside)
        keep = keep[::max(1, keep.size // _SAMPLES)]
        if keep.size < 10 * (len(_START) + 1) or np.ptp(level[keep]) == 0.0:
            return None
        place, grid = time[keep] + (shift - self.time[0]), self.time - self.time[0]
        wanted = level[keep] - level[keep].max()

        def residual(x: FloatArray) -> FloatArray:
            v, q = (np.interp(place + x[5], grid, values) for values in (speed, power))
            return np.asarray(10.0 * np.log10(
                math.exp(x[0]) + math.exp(x[1]) * v ** x[2] + math.exp(x[3]) * q ** x[4])
                - wanted)

        result = least_squares(
            residual, [*_START, 0.0], bounds=([*_LOW, -reach], [*_HIGH, reach]),
            x_scale=[1.0, 1.0, 0.5, 1.0, 0.3, 0.3], max_nfev=100)
        rest = result.fun
        thirds = _shifts_of_thirds(place, wanted, rest + wanted, reach)
        step = float(np.median(np.diff(place)))
        memory = min(math.ceil(_MEMORY / step), rest.size - 2)
        variance = max(_sandwich(result.jac, rest, memory)[5, 5], 0.25 * np.ptp(thirds) ** 2)
        return NoiseFit(shift + float(result.x[5]), math.sqrt(variance),
                        float(np.var(rest) / np.var(wanted)), _independent(rest, memory),
                        float(np.ptp(thirds)))


def _shifts_of_thirds(time: FloatArray, level: FloatArray, model: FloatArray,
                      reach: float) -> FloatArray:
    """Return by how much thirds of a sound, in which the model changes alike, are off it [s]."""
    change = np.cumsum(np.gradient(model, time) ** 2)
    ends = np.searchsorted(change, change[-1] * np.arange(4) / 3.0)
    shifts = np.arange(-reach, reach + 0.05, 0.1)
    result = []
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        part = slice(first, max(last, first + 2))
        misfit = [np.var(level[part] - np.interp(time[part] + shift, time, model))
                  for shift in shifts]
        result.append(shifts[int(np.argmin(misfit))])
    return np.array(result)


def _sandwich(jacobian: FloatArray, residual: FloatArray, memory: int) -> FloatArray:
    """Return the covariance of parameters where residuals are correlated (Newey and West)."""
    bread = np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-10, hermitian=True)
    score = jacobian * residual[:, None]
    meat = score.T @ score
    for k in range(1, memory + 1):
        cross = (1.0 - k / (memory + 1.0)) * (score[k:].T @ score[:-k])
        meat += cross + cross.T
    return np.asarray(bread @ meat @ bread)


def _independent(residual: FloatArray, memory: int) -> float:
    """Return the number of independent samples that correlated residuals are worth."""
    rest = residual - residual.mean()
    power = max(float(rest @ rest), 1e-12)
    total = sum((1.0 - k / (memory + 1.0)) * max(float(rest[k:] @ rest[:-k]), 0.0)
                for k in range(1, memory + 1))
    return float(rest.size / (1.0 + 2.0 * total / power))
