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

"""Motion of a vehicle, by the speeds of its wheels that are believed."""

from collections.abc import Sequence
import math
from typing import NamedTuple

from squeal_core.monitor.inputs.cross_evidence import Wheel

_SECOND = 1_000_000_000
# spread of wheel speeds without slip or turn: of an axle, of all (tyres differ); rad/s besides
_ROLLING, _ROLLING_ALL, FLICKER = 0.02, 0.04, 0.5
LATE = 0.05, 0.3  # s by which sensors may differ in delay: usually, at most
SLOW_TURNS = 3  # of a pressure in a second, from which on it swings


class Motion(NamedTuple):
    """
    Motion of the vehicle in one step, by the speeds that are believed.

    Parameters
    ----------
    fastest : float
        Of the wheels [rad/s]; NaN where none is known.
    fall : float
        How fast most wheels slow, over 0.3 s [rad/s^2].
    mean_fall : float
        The same over 1 s.
    rolling : bool
        All wheels turn alike: no slip, no turn.
    swinging : bool
        Some pressure goes up and down, as ABS does.

    """

    fastest: float
    fall: float
    mean_fall: float
    rolling: bool
    swinging: bool


def motion_of(wheels: Sequence[Wheel], end: int) -> Motion:
    """Return the motion of the vehicle in the step that ends at a time [ns]."""
    known = [wheel for wheel in wheels if not math.isnan(wheel.speed)]
    speeds = [wheel.speed for wheel in known]
    if not known:
        return Motion(math.nan, 0.0, 0.0, False, False)
    falls = [wheel.windows['rotor_speed'].fall(6) for wheel in known]
    means = [wheel.windows['rotor_speed'].fall(19) for wheel in known]
    middle = (len(known) - 1) // 2
    fall, mean_fall = sorted(falls)[middle], sorted(means)[middle]
    fastest = max(speeds)
    flicker = FLICKER + LATE[0] * abs(fall)
    rolling = fastest - min(speeds) <= _ROLLING_ALL * fastest + flicker and not any(
        wheel.partner is not None
        and abs(wheel.speed - wheel.partner.speed) > _ROLLING * fastest + flicker
        for wheel in known)
    swinging = any(wheel.windows['pressure'].swings.turns(end, _SECOND) >= SLOW_TURNS
                   for wheel in wheels)
    return Motion(fastest, fall, mean_fall, rolling, swinging)
