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
What speaks against the speed or friction of a brake, from all brakes in one step of time.

`pressure_rules` has what speaks against a pressure.
"""

from collections.abc import Iterator, Sequence
import math
from statistics import median_low
from typing import NamedTuple

from squeal_core.cross_evidence import Contradiction, Wheel
from squeal_core.settings import MonitorSettings, Signal, UNITS

_SECOND = 1_000_000_000
# spread of wheel speeds without slip or turn: of an axle, of all (tyres differ); rad/s besides
_ROLLING, _ROLLING_ALL, _FLICKER = 0.02, 0.04, 0.5
_LATE = 0.05, 0.3  # s by which sensors may differ in delay: usually, at most
_LEAST_SPEED = 5.0  # rad/s; below it sensors of wheel speed differ
_TURNING = 250.0, 0.6  # (rad/s)^2 and largest: a turn at 1 g spreads wheel speeds by 200 / speed^2
_OTHER_AXLE = 1.5  # the spread by a turn over that of the other axle
_AXLES_APART = 1.6  # by which wheel speeds of two axles differ as no vehicle turns
_SHARE_OF_OTHERS = 0.75  # of friction_ratio: axles differ by design
SLOW_TURNS = 3  # of a pressure in a second, as ABS has
_UNITS: dict[Signal, tuple[tuple[str, float], ...]] = {
    'pressure': (('kPa', 1e-3), ('hPa', 1e-2), ('MPa', 1e-6), ('psi', 1.0 / 6894.76),
                 ('bar', 1e-5)),
    'rotor_speed': (('rev/s', 1.0 / math.tau), ('rpm', 60.0 / math.tau),
                    ('deg/s', 360.0 / math.tau)),
    'friction': (('%', 100.0),)}


class Motion(NamedTuple):
    """
    How the vehicle moves in one step, by the speeds that are believed.

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
    """Return how the vehicle moves in the step that ends at a time [ns]."""
    known = [wheel for wheel in wheels if not math.isnan(wheel.speed)]
    speeds = [wheel.speed for wheel in known]
    if not known:
        return Motion(math.nan, 0.0, 0.0, False, False)
    falls = [wheel.windows['rotor_speed'].fall(6) for wheel in known]
    means = [wheel.windows['rotor_speed'].fall(19) for wheel in known]
    fall, mean_fall = median_low(falls), median_low(means)
    fastest = max(speeds)
    flicker = _FLICKER + _LATE[0] * abs(fall)
    rolling = fastest - min(speeds) <= _ROLLING_ALL * fastest + flicker and not any(
        wheel.partner is not None
        and abs(wheel.speed - wheel.partner.speed) > _ROLLING * fastest + flicker
        for wheel in known)
    swinging = any(wheel.windows['pressure'].swings.turns(end, _SECOND) >= SLOW_TURNS
                   for wheel in wheels)
    return Motion(fastest, fall, mean_fall, rolling, swinging)


# -- rotor speed

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
    flicker = 2.0 * _FLICKER + _LATE[1] * abs(motion.fall)
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


# -- friction

def against_friction(wheel: Wheel, settings: MonitorSettings) -> tuple[list[Contradiction], bool]:
    """Return what speaks against a friction, and whether it can be compared at all."""
    own = wheel.own('friction').mean
    least = settings.release_pressure
    if not settings.friction_ratio or math.isnan(own) or not (
            wheel.own('pressure').smooth >= least):
        return [], False
    partner = wheel.partner
    found, known = [], False
    if partner is not None and partner.smooth >= least and not math.isnan(partner.friction):
        known = True
        if own < settings.friction_ratio * partner.friction:
            found.append(_friction_contradiction(wheel, partner, settings))
    others = sorted((other for other in wheel.others if other.smooth >= least
                     and not math.isnan(other.friction)), key=lambda other: other.friction)
    if len(others) >= 2:
        known = True
        middle = others[(len(others) - 1) // 2]
        if not found and own < _SHARE_OF_OTHERS * settings.friction_ratio * middle.friction:
            found.append(_friction_contradiction(wheel, middle, settings))
    return found, known


def _friction_contradiction(wheel: Wheel, other: Wheel,
                            settings: MonitorSettings) -> Contradiction:
    return Contradiction('low', 2.0 * settings.contradiction_time,
                         though(wheel, other, 'friction'))


def though(wheel: Wheel, other: Wheel, signal: Signal) -> str:
    """Name the input that contradicts another, its value, and the unit that would explain it."""
    own, value = wheel.own(signal).mean, other.windows[signal].mean
    shown = f'{value:.6g} {UNITS[signal]}'.removesuffix(' -')
    hint = next((f', as {unit} given as {UNITS[signal]} would be' for unit, scale in _UNITS[signal]
                 if value and abs(own / value / scale - 1.0) < 0.06), '')
    return f'though {other.name} {signal} is {shown}{hint}'
