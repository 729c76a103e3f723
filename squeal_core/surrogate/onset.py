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

"""What the next application of released brakes will ask for, made ready before it comes."""

from collections import deque
from collections.abc import Sequence

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.surrogate.neighbours import alike
from squeal_core.surrogate.tabulated_solver import TabulatedSolver

_EVERY = 3  # calls from one look to the next: it costs as much as an answer
_RUNGS, _RATIO = 6, 1.9  # of pressures, from one to the next: as far as an anchor reaches
_FIRST = 1.5  # times the pressure at which a brake counts as released
_LEAST = 2e4  # Pa, that is taken for that pressure where it is less
_REMEMBERED = 64  # points, at which nothing is made again


class Onset:
    """
    Anchors from light to firm pressure at the speeds and frictions of released brakes.

    Parameters
    ----------
    table : TabulatedSolver

    """

    def __init__(self, table: TabulatedSolver) -> None:
        self._table = table
        self._calls = 0
        self._asked: deque[OperatingPoint] = deque(maxlen=_REMEMBERED)

    def look(self, brakes: Sequence[tuple[float, float]], release_pressure: float) -> None:
        """
        Go on by a call: every so often another pressure is looked at.

        Parameters
        ----------
        brakes : sequence of (rotor speed, friction)
            Of those that are released while the vehicle moves [rad/s], [-].
        release_pressure : float
            At which they are [Pa].

        """
        self._calls += 1
        point = None
        if self._calls % _EVERY == 0:
            turn, rung = divmod(self._calls // _EVERY, _RUNGS)
            speed, friction = brakes[turn % len(brakes)]
            point = self._table.model.operating_point(
                rotor_speed=speed, friction=friction,
                pressure=_FIRST * max(release_pressure, _LEAST) * _RATIO**rung)
            if any(alike(point, other) for other in self._asked):
                point = None
        if self._table.expect(point, len(brakes)) and point is not None:
            self._asked.append(point)
