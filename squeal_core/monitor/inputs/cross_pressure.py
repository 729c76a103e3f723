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

"""Evidence against the pressure of a brake, from other brakes, deceleration and its slew."""

from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

from squeal_core.monitor.inputs.cross_evidence import Contradiction, though, Wheel
from squeal_core.monitor.inputs.cross_motion import Motion, SLOW_TURNS
from squeal_core.monitor.settings import MonitorSettings

_BAR = 1e5  # Pa
_SECOND = 1_000_000_000
_SURELY = 3.0  # times `contradicting_pressure`: no trailing residual pressure
_SHARE_OF_OTHERS = 0.15  # axles differ by design
_FAST_TURNS = 18  # in half a second (18 Hz; ABS has 15)
_LEAPS = 3  # in a second
_SURELY_BRAKING = 5.0 * _BAR
_LEARNING = 2.0 * _BAR  # least pressures from which shares are learned


def against_pressure(wheel: Wheel, motion: Motion, end: int,
                     settings: MonitorSettings) -> list[Contradiction]:
    """Return the evidence of other brakes against a pressure, the soonest reported first."""
    reference = None if math.isnan(wheel.own['pressure'].mean) else _braking_reference(
        wheel, settings)
    return [] if reference is None else [*_quiet(wheel, reference, motion, settings),
                                         *_too_low(wheel, reference, motion, end, settings)]


def pressure_agrees(wheel: Wheel, wheels: Sequence[Wheel], settings: MonitorSettings) -> bool:
    """Return whether a pressure is at least as high as other brakes suggest."""
    if wheel.doubts['pressure'].kind == 'deceleration' and not any(
            other.own['pressure'].smooth >= _SURELY_BRAKING for other in wheels):
        return False
    own, partner = wheel.own['pressure'], wheel.partner
    if not own.mean >= settings.release_pressure:
        return False
    expected = (partner.smooth if partner is not None and not math.isnan(partner.smooth)
                else wheel.share * _mean_pressure(wheel.others))
    least = max(_BAR, (settings.axle_pressure_ratio + 0.05) * expected - 0.5 * _BAR)
    return own.smooth >= least


def against_slew(wheel: Wheel, end: int, settings: MonitorSettings
                 ) -> tuple[list[Contradiction], bool]:
    """Return the evidence against a pressure by its own slew, and whether it is steady again."""
    if not settings.pressure_slew:
        return [], True
    swings = wheel.windows['pressure'].swings
    if swings.is_calm(end):
        return [], True
    fast = swings.turns(end, _SECOND // 2, 0.3)
    recent = swings.leaps(end, _SECOND // 2, settings.pressure_slew)
    leaps = swings.leaps(end, _SECOND, settings.pressure_slew) if recent else 0
    if fast >= _FAST_TURNS or leaps >= _LEAPS:
        return [Contradiction('leaping', 0.0, 'alternates faster than brake hydraulics do: '
                              f'{max(fast, leaps)} times in the last second')], False
    return [], not recent and not fast


class _Reference(NamedTuple):
    """A brake that brakes, and the limits of the comparison with it."""

    wheel: Wheel
    ratio: float  # least fraction of its pressure that is believed
    margin: float  # Pa
    established: bool  # further brakes brake as well
    usual: float = 0.0  # pressure that other axles and the share of this one let expect [Pa]


def _braking_reference(wheel: Wheel, settings: MonitorSettings) -> _Reference | None:
    """Return the brake that contradicts a low pressure; None if none does."""
    least = settings.contradicting_pressure
    partner = wheel.partner
    if not least:
        return None
    if partner is not None and not math.isnan(partner.pressure):
        if partner.pressure < least:
            return None
        usual = wheel.share * _mean_pressure(wheel.others)
        established = (not 0.0 < usual < 0.5 * least) and _others_brake(wheel, settings)
        return _Reference(
            partner, settings.axle_pressure_ratio, _BAR, established, usual)
    known = [other for other in wheel.others if not math.isnan(other.pressure)]
    braking = sorted((other for other in known if other.pressure >= least),
                     key=lambda other: other.smooth)
    if len(braking) < 2 or 2 * len(braking) <= len(known):
        return None
    return _Reference(braking[(len(braking) - 1) // 2], _SHARE_OF_OTHERS, 0.2 * _BAR, True)


def _others_brake(wheel: Wheel, settings: MonitorSettings) -> bool:
    """Return whether another axle brakes on both sides: no intervention at single wheels."""
    for other in wheel.others:
        if other.pressure >= settings.release_pressure:
            opposite = other.partner
            if opposite is None or math.isnan(opposite.pressure):
                return True
            if (opposite.pressure >= settings.release_pressure
                    and opposite.smooth <= 2.0 * other.smooth <= 4.0 * opposite.smooth):
                return True
    return False


def _one_sided(wheel: Wheel, ratio: float) -> bool:
    """Return whether another axle brakes less on one side too, as on a split-friction road."""
    return any(other.partner is not None and other.is_first == wheel.is_first
               and other.smooth < ratio * other.partner.smooth for other in wheel.others)


def _mean_pressure(wheels: Sequence[Wheel]) -> float:
    """Return the mean pressure of the brakes that are known [Pa]; 0 without one."""
    known = [wheel.smooth for wheel in wheels if not math.isnan(wheel.smooth)]
    return sum(known) / len(known) if known else 0.0


def learn_share(wheel: Wheel, motion: Motion) -> None:
    """Learn the pressure of a brake over that of other axles, while both sides agree."""
    partner = wheel.partner
    if partner is None or motion.swinging or wheel.given_share or wheel.smooth < _LEARNING:
        return
    others = _mean_pressure(wheel.others)
    if min(wheel.smooth, partner.smooth, others) >= _LEARNING and (
            abs(wheel.smooth - partner.smooth) <= 0.1 * max(wheel.smooth, partner.smooth)):
        share = wheel.smooth / others
        wheel.share += (0.02 if wheel.share else 1.0) * (share - wheel.share)


def _quiet(wheel: Wheel, reference: _Reference, motion: Motion,
           settings: MonitorSettings) -> Iterator[Contradiction]:
    """Yield the evidence against a pressure that reads released."""
    own = wheel.own['pressure']
    if own.mean >= settings.release_pressure or own.high >= settings.contradicting_pressure:
        return
    text = though(wheel, reference.wheel, 'pressure')
    if reference.established:
        if motion.rolling and not motion.swinging:
            yield Contradiction('quiet', settings.contradiction_time, text)
        yield Contradiction('quiet in a slip', settings.slip_time, text)
    if (motion.mean_fall > 1.0
            and reference.wheel.pressure >= _SURELY * settings.contradicting_pressure):
        yield Contradiction('quiet while one brakes', settings.single_brake_time, text)


def _too_low(wheel: Wheel, reference: _Reference, motion: Motion, end: int,
             settings: MonitorSettings) -> Iterator[Contradiction]:
    """Yield the evidence against a pressure that is a fraction of the other's."""
    own, other = wheel.own['pressure'], reference.wheel
    if own.smooth >= reference.ratio * other.smooth - reference.margin or not motion.rolling:
        return
    if 0.0 < reference.ratio * reference.usual - reference.margin <= own.smooth:
        return  # as high as ever: it is the other one that brakes more
    text = though(wheel, other, 'pressure')
    if not motion.swinging:
        if reference.established:
            yield Contradiction('low', settings.slip_time, text, adds_up=True)
        elif (motion.mean_fall > 1.0 and not _one_sided(wheel, reference.ratio)
                and other.pressure >= _SURELY * settings.contradicting_pressure):
            yield Contradiction('low while one brakes', settings.single_brake_time, text)
    elif (other.windows['pressure'].swings.turns(end, _SECOND) < SLOW_TURNS
            and max(own.means) >= 0.7 * other.pressure):
        yield Contradiction('alternating', settings.slip_time, f'alternates, {text}')


def against_all_pressures(wheels: Sequence[Wheel], motion: Motion,
                          settings: MonitorSettings) -> Iterator[Contradiction]:
    """Yield the evidence against all pressures: a deceleration that is beyond them."""
    pressures = [p for wheel in wheels if not math.isnan(p := wheel.own['pressure'].mean)]
    if not settings.unbraked_deceleration or len(pressures) < 2:
        return
    highest = max(pressures)
    most = settings.unbraked_deceleration + (
        settings.deceleration_per_pressure * 1e-6 * max(highest, 0.0))  # which is per MPa
    if motion.fall > most:
        yield Contradiction(
            'deceleration', 0.7, f'though rotor_speed of the wheels, {motion.fastest:.4g} rad/s, '
            f'falls by {motion.fall:.4g} rad/s^2 and no pressure is above {highest:.4g} Pa',
            until='until it reads 100000 Pa or more while a brake reads 500000 Pa')
