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

"""Growth rates along friction, on a grid of rotor speeds and pressures, as they are needed."""

from collections.abc import Callable
import math

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray

_STEP = 0.02  # of friction
_STEPS = np.array([0.1, 0.2])  # of ln rotor speed, ln pressure
_LOWEST = -1e4  # 1/s, for no mode at all


class FrictionScan:
    """
    Where friction makes a brake unstable, roughly: interpolated between points of a grid.

    A row of frictions is looked up when a brake first operates beside it, and kept.

    Parameters
    ----------
    growth : callable
        Growth rates (n,) [1/s] at rows (n, 3) of rotor speed [rad/s], pressure [Pa] and
        friction; NaN: not known.
    friction : (2,) floats
        Bounds.

    """

    def __init__(self, growth: Callable[[FloatArray], FloatArray],
                 friction: tuple[float, float]) -> None:
        self._growth = growth
        low, high = friction
        self.friction = np.linspace(low, high, max(math.ceil((high - low) / _STEP), 1) + 1)
        self._rows: dict[tuple[int, int], FloatArray] = {}

    def along_friction(self, rotor_speed: FloatArray, pressure: FloatArray) -> FloatArray:
        """Return growth rates (P, F) [1/s] at all frictions; NaN: not known."""
        places = np.log(np.stack([rotor_speed, pressure], axis=1)) / _STEPS
        corners = np.floor(places).astype(np.intp)
        (a, b), sides = (places - corners).T[..., None], ((0, 0), (0, 1), (1, 0), (1, 1))
        self._look_up(corners, sides)
        low, right, up, both = (np.array([self._rows[i, j] for i, j in (corners + side).tolist()])
                                for side in sides)
        return np.asarray((1.0 - a) * ((1.0 - b) * low + b * right)
                          + a * ((1.0 - b) * up + b * both))

    def _look_up(self, corners: IndexArray, sides: tuple[tuple[int, int], ...]) -> None:
        """Look up the rows of these grid points that are not known yet."""
        wanted = {(i, j) for side in sides for i, j in (corners + side).tolist()}
        missing = sorted(wanted - self._rows.keys())
        if not missing:
            return
        points = np.exp(np.array(missing) * _STEPS)
        count = self.friction.size
        found = self._growth(np.column_stack([
            np.repeat(points, count, axis=0), np.tile(self.friction, len(missing))]))
        self._rows |= zip(missing, np.maximum(found, _LOWEST).reshape(-1, count), strict=True)
