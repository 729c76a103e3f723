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

"""Summary of a drive: braking that was assessed or has a risk, reasons; holds no rows."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
import math
import re

from squeal_core.monitor.assessment import Assessment, State
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings

_NUMBER = re.compile(r'[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|\bnan\b|\binf\b)')
_MOST_REASONS = 200  # different ones of a brake; the words of further ones are not kept
# unknown for less than this in sum is a start-up or a lost message, shorter than a brake
# application [s]
_BRIEF = 1.0
_AT_REST: tuple[State, ...] = ('released', 'not sliding')


@dataclass
class Reason:
    """
    Reason for ticks of a brake without a number.

    Parameters
    ----------
    text : str
        As the first such tick gave it, with its values.
    state : str
    inputs : tuple of str
        Inputs without a good reading at that tick.
    details : str
        What is wrong with them, as their readings say.
    since : float
        Time of that tick [s].
    ticks, braking : int
        All such ticks, and those of them at which braking is not excluded.

    """

    text: str
    state: State
    inputs: tuple[Signal, ...]
    details: str
    since: float
    ticks: int = 0
    braking: int = 0


@dataclass
class BrakeSummary:
    """
    Ticks of one brake.

    A tick counts as braking where pressure and rotor speed, as far as they are known, do not
    exclude that the disc slides under load: the pressure is not known to be below
    `release_pressure`, nor the speed below `minimum_rotor_speed`.

    Parameters
    ----------
    states : Counter
        Ticks by state.
    sliding : int
        Ticks known to be of sliding under load, assessed or not.
    unknown : int
        Ticks at which braking is neither known nor excluded.
    starting : int
        Ticks before anything was known, not counted as unknown because they were few.
    risks : int
        Ticks of sliding under load whose squeal risk is known.
    incomplete : int
        Of these, those whose brake application was seen in part only.
    total_risk, peak_risk : float
        Sum and largest of these risks [-].
    unknown_risks : Counter
        Ticks of sliding under load whose squeal risk is not known, by the reason why.

    """

    name: str
    period: float
    states: Counter[State] = field(default_factory=Counter)
    sliding: int = 0
    unknown: int = 0
    starting: int = 0
    risks: int = 0
    incomplete: int = 0
    total_risk: float = 0.0
    peak_risk: float = math.nan
    unknown_risks: Counter[str] = field(default_factory=Counter)
    reasons: dict[str, Reason] = field(default_factory=dict)

    @property
    def assessed(self) -> int:
        return self.states['steady']

    @property
    def braking(self) -> int:
        return self.sliding + self.unknown

    @property
    def share(self) -> float:
        """Assessed part of the braking time; NaN where there was no braking."""
        return self.assessed / self.braking if self.braking else math.nan

    @property
    def risk_share(self) -> float:
        """Part of the braking time with a known squeal risk; NaN where there was no braking."""
        return self.risks / self.braking if self.braking else math.nan

    @property
    def mean_risk(self) -> float:
        """Mean squeal risk while braking, where it is known [-]; NaN where it never is."""
        return self.total_risk / self.risks if self.risks else math.nan

    @property
    def never_assessed(self) -> bool:
        """
        Return whether no tick was assessed although the brake slid under load, or may have.

        What is not known for less than a second in sum, in a drive in which it is known else
        that the brake was released or at rest, does not count.
        """
        if self.assessed:
            return False
        ever_known = self.starting + self.unknown < self.states.total()
        return bool(self.sliding) or not ever_known or self.unknown * self.period > _BRIEF

    @property
    def never_known(self) -> bool:
        """Return whether no risk was known although the brake slid under load, or may have."""
        return self.never_assessed or bool(self.assessed and not self.risks)

    def ranked(self) -> list[Reason]:
        """Return the reasons, those that cost most braking time first."""
        return sorted(self.reasons.values(), key=lambda r: (-r.braking, -r.ticks))


class DriveSummary:
    """
    Counts the assessments of a drive, tick after tick.

    Parameters
    ----------
    settings : MonitorSettings

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._settings = settings
        self._period = settings.period
        self.ticks = 0
        self.silence = 0.0  # s between ticks that were left out, as nothing came for long
        self._last: int | None = None
        self.brakes: Mapping[str, BrakeSummary] = {
            brake.name: BrakeSummary(brake.name, self._period * 1e-9)
            for brake in settings.brakes}

    def add(self, assessments: Sequence[Assessment]) -> None:
        """Take the assessments of a tick."""
        self.ticks += 1
        time = assessments[0].time
        if self._last is not None and time > self._last + self._period:
            self.silence += (time - self._last - self._period) * 1e-9
        self._last = time
        for assessment in assessments:
            self._count(self.brakes[assessment.brake], assessment)

    def add_brakes(self, other: 'DriveSummary') -> None:
        """Add the counts of other brakes at the same ticks."""
        self.brakes = {**self.brakes, **other.brakes}

    def _count(self, brake: BrakeSummary, result: Assessment) -> None:
        known_before = brake.states.total() > brake.unknown
        brake.states[result.state] += 1
        sliding = self.slides(result)
        if sliding is None:
            brake.unknown += 1
        else:
            brake.sliding += sliding
            if not known_before and brake.unknown * brake.period <= _BRIEF:
                brake.starting, brake.unknown = brake.unknown, 0
        if result.state == 'steady':
            _take_risk(brake, result)
        elif result.state not in _AT_REST:
            _note(brake, result, braking=sliding is not False)

    def slides(self, result: Assessment) -> bool | None:
        """Return whether a brake slides under load; None where its inputs do not tell."""
        if result.state == 'steady' or result.state in _AT_REST:
            return result.state == 'steady'
        if all(reading.status == 'good' for reading in result.inputs.values()):
            return None  # the inputs contradict something else
        pressure = _value(result.inputs.get('pressure'))
        speed = abs(_value(result.inputs.get('rotor_speed')))
        limits = self._settings
        if pressure < limits.release_pressure or speed < limits.minimum_rotor_speed:
            return False
        return None if math.isnan(pressure) or math.isnan(speed) else True

    @property
    def states(self) -> Counter[State]:
        """Ticks by state, of all brakes together."""
        return sum((brake.states for brake in self.brakes.values()), Counter())

    @property
    def braking_time(self) -> float:
        """Braking time of all brakes together [s]."""
        return sum(brake.braking * brake.period for brake in self.brakes.values())

    @property
    def assessed_time(self) -> float:
        """Assessed time of all brakes together [s]."""
        return sum(brake.assessed * brake.period for brake in self.brakes.values())

    @property
    def share(self) -> float:
        """Assessed part of the braking time of all brakes; NaN where there was no braking."""
        return self.assessed_time / self.braking_time if self.braking_time else math.nan

    @property
    def known_time(self) -> float:
        """Time with a known squeal risk, of all brakes together [s]."""
        return sum(brake.risks * brake.period for brake in self.brakes.values())

    @property
    def risk_share(self) -> float:
        """Part of the braking time of all brakes with a known squeal risk; NaN: no braking."""
        return self.known_time / self.braking_time if self.braking_time else math.nan

    @property
    def incomplete_share(self) -> float:
        """Part of it whose brake application was seen in part only; NaN: no braking."""
        incomplete = sum(brake.incomplete * brake.period for brake in self.brakes.values())
        return incomplete / self.braking_time if self.braking_time else math.nan

    @property
    def never_known(self) -> tuple[str, ...]:
        """Names of the brakes whose squeal risk was never known while it should have been."""
        return tuple(name for name, brake in self.brakes.items() if brake.never_known)

    @property
    def never_assessed(self) -> tuple[str, ...]:
        """Names of the brakes that were never assessed while they should have been."""
        return tuple(name for name, brake in self.brakes.items() if brake.never_assessed)


def _value(reading: Reading | None) -> float:
    """Return the believed value of an input: NaN where it is not known."""
    return reading.value if reading is not None and reading.is_believed else math.nan


def _take_risk(brake: BrakeSummary, result: Assessment) -> None:
    """Take the risk of a brake that slides under load, or why it is not known."""
    risk = result.risk_result
    if math.isnan(result.risk):
        brake.unknown_risks[risk.unknown if risk else result.reason] += 1
        return
    brake.risks += 1
    brake.incomplete += bool(risk and risk.result.incomplete)
    brake.total_risk += result.risk
    brake.peak_risk = max(result.risk, brake.peak_risk)  # the first stays beside NaN


def _note(brake: BrakeSummary, result: Assessment, *, braking: bool) -> None:
    key = f'{result.state}: {_NUMBER.sub("#", result.reason)}'  # one for all values and ages
    if key not in brake.reasons and len(brake.reasons) >= _MOST_REASONS:
        key = f'{result.state}: for other reasons'
    if key not in brake.reasons:
        bad = [(signal, reading) for signal, reading in result.inputs.items()
               if reading.status != 'good']
        brake.reasons[key] = Reason(
            result.reason, result.state, tuple(signal for signal, _ in bad),
            '; '.join(f'{r.status} {r.detail}' for _, r in bad), result.time * 1e-9)
    brake.reasons[key].ticks += 1
    brake.reasons[key].braking += braking


def worst_reason(brakes: Iterable[BrakeSummary]) -> tuple[Reason, BrakeSummary] | None:
    """Return the reason that cost most braking time, and its brake; None where there is none."""
    ranked = [(brake.ranked()[0], brake) for brake in brakes if brake.reasons]
    return min(ranked, key=lambda pair: (-pair[0].braking, -pair[0].ticks), default=None)
