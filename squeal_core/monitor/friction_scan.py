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

"""Critical frictions on a grid of rotor speeds and pressures, searched as they are needed."""

from collections.abc import Callable
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray

_STEP = 0.02  # of friction
_STEPS = np.array([0.1, 0.2])  # of ln rotor speed, ln pressure
_PARTS = np.linspace(0.0, 1.0, 17)  # of such a step, in which a boundary is looked for closer
_LOWEST = -1e4  # 1/s, for no mode at all
_SIDES = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
_TINY = 1e-9  # of a weight, so that one is left where a point of the grid is met exactly


class FrictionScan:
    """
    Approximate critical frictions of a brake, interpolated between points of a grid.

    The boundaries along friction at a point of the grid are searched when a brake first operates
    beside it, and kept.

    Parameters
    ----------
    growth : callable
        Growth rates (n,) [1/s] of the least stable mode at rows (n, 3) of rotor speed [rad/s],
        pressure [Pa] and friction; NaN: not known.
    level : float
        Growth rate above which a mode is unstable [1/s].
    friction, rotor_speed, pressure : (2,) floats
        Bounds [-], [rad/s], [Pa].

    """

    def __init__(self, growth: Callable[[FloatArray], FloatArray], level: float, *,
                 friction: tuple[float, float], rotor_speed: tuple[float, float],
                 pressure: tuple[float, float]) -> None:
        self._growth, self._level = growth, level
        low, high = friction
        self._friction = np.linspace(low, high, max(math.ceil((high - low) / _STEP), 1) + 1)
        self._low, ends = np.log([rotor_speed, pressure]).T
        self._last = np.maximum(np.ceil((ends - self._low) / _STEPS).astype(np.intp), 1)
        self._critical = np.full((*(self._last + 1), self._friction.size - 1), np.nan)
        self._known = np.zeros(self._last + 1, bool)

    def nearest(self, rows: FloatArray, side: FloatArray) -> FloatArray:
        """
        Return critical frictions (P,) nearest to present ones, interpolated; infinite: none.

        Parameters
        ----------
        rows : (P, 3) array
            Of rotor speed [rad/s], pressure [Pa] and friction.
        side : (P, 1) array
            -1 for one below, 1 for one above.

        """
        places = (np.log(rows[:, :2]) - self._low) / _STEPS
        places = np.minimum(np.maximum(places, 0.0), self._last)
        corner = np.minimum(places.astype(np.intp), self._last - 1)
        i, j = (corner[:, None] + _SIDES).transpose(2, 0, 1)
        if not self._known[i, j].all():
            self._search(i, j)
        away = side[..., None] * (self._critical[i, j] - rows[:, 2:, None])
        away = np.where(away > 0.0, away, np.inf).min(axis=2)
        same = away <= away.min(axis=1, keepdims=True) + _STEP  # not of another boundary, or none
        weights = np.abs(1.0 - _SIDES - (places - corner)[:, None]).prod(axis=2) + _TINY
        mean = (weights * np.where(same, away, 0.0)).sum(axis=1) / (weights * same).sum(axis=1)
        return np.asarray(rows[:, 2] + side[:, 0] * mean)

    def _search(self, i: IndexArray, j: IndexArray) -> None:
        """Search the boundaries at those points of the grid that are not known yet."""
        wanted = np.zeros_like(self._known)
        wanted[i, j] = True
        points = np.argwhere(wanted & ~self._known)
        conditions = np.exp(self._low + points * _STEPS)

        def evaluate(asking: Any, frictions: FloatArray) -> FloatArray:
            rows = np.column_stack([np.repeat(conditions[asking], frictions.shape[1], axis=0),
                                    frictions.ravel()])
            growth = np.maximum(self._growth(rows), _LOWEST)
            return growth.reshape(frictions.shape) - self._level

        unstable = evaluate(slice(None), np.tile(self._friction, (len(points), 1))) > 0.0
        at, step = (unstable[:, 1:] != unstable[:, :-1]).nonzero()
        frictions = self._friction[step, None] + np.diff(self._friction)[step, None] * _PARTS
        excess = evaluate(at, frictions)
        self._critical[(*points[at].T, step)] = _first_zeros(frictions, excess)
        self._known |= wanted


def _first_zeros(x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the first zero of chords of y (B, n) over x, (B,); NaN where y is not known."""
    each, near = np.arange(len(x)), ((y[:, 1:] > 0.0) != (y[:, :-1] > 0.0)).argmax(axis=1)
    one, other = y[each, near], y[each, near + 1]
    return np.asarray(x[each, near] + one / (one - other) * (x[each, near + 1] - x[each, near]))
