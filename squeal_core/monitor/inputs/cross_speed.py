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

"""Evidence against the speed of a wheel, from the other wheels."""

from collections.abc import Iterator
import math
from typing import NamedTuple

from squeal_core.monitor.inputs.cross_evidence import Contradiction, though, Wheel
from squeal_core.monitor.inputs.cross_motion import FLICKER, LATE, Motion
from squeal_core.monitor.settings import MonitorSettings

_LEAST_SPEED = 5.0  # rad/s; below it sensors of wheel speed differ
_TURNING = 250.0, 0.6  # (rad/s)^2 and largest: a turn at 1 g spreads wheel speeds by 200 / speed^2
_OTHER_AXLE = 1.5  # the spread by a turn over that of the other axle
_AXLES_APART = 1.6  # by which wheel speeds of two axles differ as no vehicle turns


class _Pair(NamedTuple):
    """The slower and the faster one of the wheels that a wheel is compared with."""

    slow: Wheel
    fast: Wheel
    only_partner: bool = False


def against_speed(wheel: Wheel, motion: Motion, settings: MonitorSettings
                  ) -> tuple[list[Contradiction], bool]:
    """Return the evidence against the speed of a wheel, and whether others turn alike."""
    own = abs(wheel.own['rotor_speed'].mean)
    pair = _pair(wheel) if settings.wheel_speed_tolerance else None
    if pair is None or math.isnan(own) or _allowed(own, pair, wheel, motion, settings):
        result = list(_slow_axle(wheel, own, settings))
        return result, pair is not None and not result and not math.isnan(own)
    braking = wheel.own['pressure'].smooth >= settings.release_pressure
    if own > pair.fast.speed:
        kind, after = 'fast', settings.slip_time if braking else settings.single_brake_time
    elif braking:
        kind, after = 'slow', settings.lock_time
    elif pair.only_partner:
        kind, after = 'slow', settings.single_brake_time
    else:
        at_rest = own < settings.minimum_rotor_speed
        kind, after = 'slow', settings.contradiction_time if at_rest else settings.slip_time
    other = pair.slow if own < pair.slow.speed else pair.fast
    return [Contradiction(kind, after, though(wheel, other, 'rotor_speed'))], False


def _pair(wheel: Wheel) -> _Pair | None:
    """Return the wheels that a wheel is compared with; None where no comparison is possible."""
    partner = wheel.partner
    if partner is not None and math.isnan(partner.speed):
        partner = None
    others = [other for other in wheel.others if not math.isnan(other.speed)]
    if partner is not None and others:
        reference = max(others, key=_speed)
        slow, fast = (partner, reference) if partner.speed <= reference.speed else (
            reference, partner)
    elif partner is not None:
        slow = fast = partner
    elif len(others) >= 2:
        slow = fast = sorted(others, key=_speed)[(len(others) - 1) // 2]
    else:
        return None
    return None if slow.speed < _LEAST_SPEED else _Pair(
        slow, fast, partner is not None and not others)


def _allowed(own: float, pair: _Pair, wheel: Wheel, motion: Motion,
             settings: MonitorSettings) -> bool:
    """Return whether the speed of a wheel [rad/s] fits the wheels it is compared with."""
    slow, fast, only_partner = pair
    share, flicker = 1.0 + settings.wheel_speed_tolerance, 2.0 * FLICKER
    if slow.speed / share - flicker <= own <= fast.speed * share + flicker:
        return True  # in a turn, or while they slow, even more is allowed
    turning = min(_TURNING[0] / max(motion.fastest, 1.0)**2, _TURNING[1])
    if wheel.partner is not None and not math.isnan(wheel.partner.speed) and not only_partner:
        turning = min(max(_spread(other) for other in wheel.others
                          if not math.isnan(other.speed)) or turning, turning)
    share += turning
    flicker += LATE[1] * abs(motion.fall)
    return slow.speed / share - flicker <= own <= fast.speed * share + flicker


def _speed(wheel: Wheel) -> float:
    return wheel.speed


def _spread(wheel: Wheel) -> float:
    """Return the effect of a turn on the wheels of one axle, by those of another; 0: not known."""
    partner = wheel.partner
    if partner is None or math.isnan(partner.speed):
        return 0.0
    slow, fast = sorted((wheel.speed, partner.speed))
    return _OTHER_AXLE * min(fast / max(slow, 0.1) - 1.0, 1.0) + 1e-9


def _slow_axle(wheel: Wheel, own: float, settings: MonitorSettings) -> Iterator[Contradiction]:
    """Yield the evidence against both wheels of an axle: another axle turns much faster."""
    partner = wheel.partner
    if (not settings.wheel_speed_tolerance or partner is None
            or wheel.own['pressure'].smooth >= settings.release_pressure):
        return
    for other in wheel.others:
        opposite = other.partner
        if (opposite is not None and 2.0 * _LEAST_SPEED <= opposite.speed <= other.speed
                and _AXLES_APART * max(own, partner.speed) < opposite.speed
                and other.speed <= 1.13 * opposite.speed):
            # wheels that spin in snow while the others stand do so for a while
            after = settings.single_brake_time * (
                1.0 if own >= settings.minimum_rotor_speed else 4.0)
            yield Contradiction('slow axle', after, though(wheel, other, 'rotor_speed'))
            return
