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

"""What speaks against the speed of a wheel: the other wheels."""

from collections.abc import Iterator
import math
from typing import NamedTuple

from squeal_core.monitor.cross_evidence import Contradiction, though, Wheel
from squeal_core.monitor.cross_motion import FLICKER, LATE, Motion
from squeal_core.monitor.settings import MonitorSettings

_LEAST_SPEED = 5.0  # rad/s; below it sensors of wheel speed differ
_TURNING = 250.0, 0.6  # (rad/s)^2 and largest: a turn at 1 g spreads wheel speeds by 200 / speed^2
_OTHER_AXLE = 1.5  # the spread by a turn over that of the other axle
_AXLES_APART = 1.6  # by which wheel speeds of two axles differ as no vehicle turns


class _Span(NamedTuple):
    """Speeds that others allow a wheel [rad/s], and the wheel to be named."""

    low: float
    high: float
    wheel: Wheel
    only_partner: bool = False


def against_speed(wheel: Wheel, motion: Motion, settings: MonitorSettings
                  ) -> tuple[list[Contradiction], bool]:
    """Return what speaks against the speed of a wheel, and whether others turn alike."""
    own = abs(wheel.own('rotor_speed').mean)
    span = _span(wheel, motion, settings)
    if span is None or math.isnan(own) or span.low <= own <= span.high:
        found = list(_slow_axle(wheel, own, settings))
        return found, span is not None and not found and not math.isnan(own)
    braking = wheel.own('pressure').smooth >= settings.release_pressure
    if own > span.high:
        kind, after = 'fast', settings.slip_time if braking else settings.single_brake_time
    elif braking:
        kind, after = 'slow', settings.lock_time
    elif span.only_partner:
        kind, after = 'slow', settings.single_brake_time
    else:
        at_rest = own < settings.minimum_rotor_speed
        kind, after = 'slow', settings.contradiction_time if at_rest else settings.slip_time
    return [Contradiction(kind, after, though(wheel, span.wheel, 'rotor_speed'))], False


def _span(wheel: Wheel, motion: Motion, settings: MonitorSettings) -> _Span | None:
    """Return the speeds that a wheel may have by the others; None where they say nothing."""
    tolerance = settings.wheel_speed_tolerance
    if not tolerance:
        return None
    partner = wheel.partner
    if partner is not None and math.isnan(partner.speed):
        partner = None
    others = [other for other in wheel.others if not math.isnan(other.speed)]
    turning = min(_TURNING[0] / max(motion.fastest, 1.0)**2, _TURNING[1])
    if partner is not None and others:
        reference = max(others, key=lambda other: other.speed)
        turning = min(max(_spread(other) for other in others) or turning, turning)
        slow, fast = sorted((partner, reference), key=lambda other: other.speed)
    elif partner is not None:
        slow = fast = partner
    elif len(others) >= 2:
        slow = fast = sorted(others, key=lambda other: other.speed)[(len(others) - 1) // 2]
    else:
        return None
    if slow.speed < _LEAST_SPEED:
        return None
    share = 1.0 + tolerance + turning
    flicker = 2.0 * FLICKER + LATE[1] * abs(motion.fall)
    return _Span(slow.speed / share - flicker, fast.speed * share + flicker,
                 slow if abs(wheel.own('rotor_speed').mean) < slow.speed else fast,
                 partner is not None and not others)


def _spread(wheel: Wheel) -> float:
    """Return what a turn may do to the wheels of one axle, by those of another; 0: not known."""
    partner = wheel.partner
    if partner is None or math.isnan(partner.speed):
        return 0.0
    slow, fast = sorted((wheel.speed, partner.speed))
    return _OTHER_AXLE * min(fast / max(slow, 0.1) - 1.0, 1.0) + 1e-9


def _slow_axle(wheel: Wheel, own: float, settings: MonitorSettings) -> Iterator[Contradiction]:
    """Yield what speaks against both wheels of an axle: another axle turns much faster."""
    partner = wheel.partner
    if (not settings.wheel_speed_tolerance or partner is None
            or wheel.own('pressure').smooth >= settings.release_pressure):
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
