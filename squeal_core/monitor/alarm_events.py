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

"""Starts and ends of the squeal alarms of a vehicle's brakes, from its assessments."""

from collections.abc import Iterable
from dataclasses import dataclass
import math
from typing import Literal, TypeAlias

from squeal_core.common.wording import risk_in_words
from squeal_core.monitor.alarm import Alarm
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.settings import MonitorSettings

Kind: TypeAlias = Literal['start', 'end']
_SAY_IT = ('steady', 'not sliding')  # states whose reasons say why there is no risk
_OF_ALARMS = ('risk_warning', 'risk_hysteresis', 'risk_hold', 'squeal_band_low_hz',
              'squeal_band_high_hz', 'noise_floor_nm')  # settings whose change ends alarms


@dataclass(frozen=True, kw_only=True)
class AlarmEvent:
    """
    Start or end of the squeal alarm of a brake.

    Parameters
    ----------
    kind : str
        'start' or 'end'.
    brake : str
    time : int
        Tick at which the alarm began or ended [ns].
    since : int
        Tick at which it began [ns].
    risk : float
        Squeal risk at `time` [-]; NaN: not known.
    peak_risk : float
        Largest one since it began [-].
    modes : tuple of int
        Numbers of the coupled modes that most probably squeal, by frequency at mu = 0: at the
        start, and at the end those of the largest risk.
    frequency_hz : float
        Their frequency.
    cause : str
        Why it began or ended, in words.

    """

    kind: Kind
    brake: str
    time: int
    since: int
    risk: float
    peak_risk: float
    modes: tuple[int, ...]
    frequency_hz: float
    cause: str

    @property
    def duration(self) -> float:
        """Time since the alarm began [s]."""
        return (self.time - self.since) * 1e-9

    @property
    def in_words(self) -> str:
        """Return the event in a line."""
        modes = '/'.join(map(str, self.modes))
        pitch = f'mode {modes} at {self.frequency_hz:.0f} Hz' if modes else 'no mode known'
        if self.kind == 'start':
            return f'squeal probable, risk {risk_in_words(self.risk)}: {pitch}; {self.cause}'
        return (f'squeal alarm over after {self.duration:.1f} s, risk up to '
                f'{risk_in_words(self.peak_risk)}: {pitch}; {self.cause}')


class AlarmEvents:
    """
    The alarms of a vehicle's brakes, tick after tick.

    Parameters
    ----------
    settings : MonitorSettings
        `risk_warning`, `risk_hysteresis` and `risk_hold` decide.

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._alarms = {brake.name: Alarm.of(settings) for brake in settings.brakes}
        self._up: dict[str, AlarmEvent] = {}  # with the largest risk up to now
        self._settings = settings
        self._changed: dict[str, str] = {}  # settings since which a risk is below its level

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings; an alarm that is up stays up by the new ones."""
        names = [name for name in _OF_ALARMS
                 if getattr(settings, name) != getattr(self._settings, name)]
        self._settings = settings
        if names:
            self._changed |= {brake: ', '.join(names) for brake in self._up
                              if not self._alarms[brake].held}
        for alarm in self._alarms.values():
            alarm.update_settings(settings.risk_warning, settings.risk_hysteresis,
                                  settings.risk_hold)

    def is_up(self, brake: str) -> bool:
        """Return whether the alarm of a brake is up."""
        return brake in self._up

    def update(self, assessments: Iterable[Assessment]) -> list[AlarmEvent]:
        """Take the assessments of a tick; return the alarms that began or ended."""
        changes = [self._updated(result) for result in assessments]
        return [change for change in changes if change is not None]

    def end(self, assessments: Iterable[Assessment]) -> list[AlarmEvent]:
        """End all alarms, as nothing is known in these assessments; return those ended."""
        self._changed.clear()
        ended = [_ended(self._up.pop(result.brake), result) for result in assessments
                 if self.is_up(result.brake)]
        for event in ended:
            self._alarms[event.brake].end()
        return ended

    def _updated(self, result: Assessment) -> AlarmEvent | None:
        brake, before = result.brake, self._up.get(result.brake)
        if not self._alarms[brake].update(result.time, result.risk):
            if before is None:
                return None
            del self._up[brake]
            return _ended(before, result, self._changed.pop(brake, ''))
        if not self._alarms[brake].held:
            self._changed.pop(brake, None)
        if before is None:
            self._up[brake] = started = _started(result)
            return started
        if result.risk > before.peak_risk:
            self._up[brake] = _started(result, since=before.since)
        return None


def _started(result: Assessment, since: int | None = None) -> AlarmEvent:
    risk = result.risk_result
    return AlarmEvent(
        kind='start', brake=result.brake, time=result.time,
        since=result.time if since is None else since, risk=result.risk, peak_risk=result.risk,
        modes=risk.modes if risk else (),
        frequency_hz=risk.result.frequency_hz if risk else math.nan, cause=_conditions(result))


def _ended(before: AlarmEvent, result: Assessment, changed: str = '') -> AlarmEvent:
    cause = 'brake released' if result.state == 'released' else 'the risk fell'
    if math.isnan(result.risk):
        lost = '' if result.state in _SAY_IT else 'whether it squeals is no longer known: '
        cause = lost + result.reason
    if changed and result.state == 'steady':
        cause = f'the settings changed ({changed})'
    return AlarmEvent(
        kind='end', brake=result.brake, time=result.time, since=before.since, risk=result.risk,
        peak_risk=before.peak_risk, modes=before.modes, frequency_hz=before.frequency_hz,
        cause=cause)


def _conditions(result: Assessment) -> str:
    """Return the conditions that raised the risk, in words: build-up, growth and inputs."""
    speed, pressure = result.inputs['rotor_speed'].value, result.inputs['pressure'].value
    now = ' now, after growing,' if result.growth_rate < 0.0 else ''  # a build-up outlasts growth
    return (f'build-up {result.build_up:.1f} nepers, growth {result.growth_rate:+.1f} 1/s{now} at '
            f'{speed:.1f} rad/s, {pressure / 1e5:.1f} bar, friction {result.friction:.3f}')
