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

"""Brake applications in a drive, and the squeal that is predicted in each."""

from dataclasses import dataclass
import math
from typing import NamedTuple

from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.squeal_events import Stretch
from squeal_core.monitor.settings import MonitorSettings

LEAST_KNOWN = 0.8  # part of an application with a known risk, from which no alarm means silence
_LONGEST_UNKNOWN = 10.0  # s after which an application of which nothing is known is over


class ApplicationRecord(NamedTuple):
    """
    A brake from the first tick known to be of sliding under load to the last.

    The fields are the columns of `applications.csv`; NaN and 0: not known. The worst mode is the
    least stable one in the squeal band, at the tick at which it grows fastest.

    Attributes
    ----------
    brake : str
    start_s, end_s : float
        First and last such tick, on the clock of the recording.
    known_share : float
        Part of the ticks in between at which the squeal risk is known.
    peak_risk, mean_risk, build_up_nepers : float
        Largest and mean risk, largest build-up.
    growth_rate_1_s, damping_ratio, frequency_hz : float
        Of the worst mode.
    mode_number : int
        Of the worst mode.
    alarm : bool or None
        Whether the alarm was up at some tick; None: it was not, and too little is known.
    rotor_speed_rad_s, rotor_speed_end_rad_s : float
        At the start and at the end.
    pressure_pa, pressure_max_pa, friction : float
        Mean, largest, mean.
    temperature_k : float
        The first that is known.

    """

    brake: str
    start_s: float
    end_s: float
    known_share: float
    peak_risk: float
    mean_risk: float
    build_up_nepers: float
    growth_rate_1_s: float
    damping_ratio: float
    frequency_hz: float
    mode_number: int
    alarm: bool | None
    rotor_speed_rad_s: float
    rotor_speed_end_rad_s: float
    pressure_pa: float
    pressure_max_pa: float
    friction: float
    temperature_k: float


@dataclass
class _Mean:
    """Mean of the known ones of some values."""

    total: float = 0.0
    count: int = 0

    def add(self, value: float) -> None:
        if not math.isnan(value):
            self.total += value
            self.count += 1

    @property
    def value(self) -> float:
        return self.total / self.count if self.count else math.nan


class _Application:
    """One brake application, tick after tick of sliding under load."""

    def __init__(self, row: AssessmentRecord) -> None:
        self.stretch = Stretch(row)
        self.ticks = self.unknown = 0  # unknown: those since the last one of sliding
        self._risk, self._pressure, self._friction = _Mean(), _Mean(), _Mean()
        self._alarm, self._largest, self._temperature = False, -math.inf, math.nan

    def add(self, row: AssessmentRecord, *, alarm: bool) -> None:
        self.ticks, self.unknown = self.ticks + self.unknown + 1, 0
        self.stretch.add(row)
        self._alarm |= alarm
        self._risk.add(row.squeal_risk)
        self._pressure.add(row.pressure_pa)
        self._friction.add(row.friction)
        self._largest = max(self._largest, row.pressure_pa)
        if math.isnan(self._temperature):
            self._temperature = row.temperature_k

    @property
    def record(self) -> ApplicationRecord:
        ticks = self.stretch
        first, last, worst, known = ticks.first, ticks.last, ticks.worst, (
            self._risk.count / self.ticks)
        return ApplicationRecord(
            brake=first.brake, start_s=first.time_s, end_s=last.time_s, known_share=known,
            peak_risk=ticks.peak_risk, mean_risk=self._risk.value,
            build_up_nepers=ticks.build_up, growth_rate_1_s=worst.growth_rate_1_s,
            damping_ratio=worst.damping_ratio, frequency_hz=worst.worst_frequency_hz,
            mode_number=worst.worst_mode_number,
            alarm=True if self._alarm else False if known >= LEAST_KNOWN else None,
            rotor_speed_rad_s=first.rotor_speed_rad_s,
            rotor_speed_end_rad_s=last.rotor_speed_rad_s, pressure_pa=self._pressure.value,
            pressure_max_pa=self._largest, friction=self._friction.value,
            temperature_k=self._temperature)


class ApplicationDetector:
    """
    Finds the brake applications of a drive, tick after tick; holds no rows.

    Ticks at which it is not known whether the brake slides under load are of an application where
    it slides before and after them; not for longer than 10 s, nor over ticks that were left out.

    Parameters
    ----------
    settings : MonitorSettings

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._period = settings.period * 1e-9
        self._open: dict[str, _Application] = {}
        self._time: dict[str, float] = {}  # of the last tick of each brake [s]
        self._ended: list[ApplicationRecord] = []

    def add(self, row: AssessmentRecord, sliding: bool | None, *, alarm: bool,
            risk: float = math.nan) -> None:
        """
        Take the next row of a brake.

        Parameters
        ----------
        row : AssessmentRecord
            Of the next tick of its brake.
        sliding : bool or None
            Whether the brake slides under load; None: not known.
        alarm : bool
            Whether its alarm is up.
        risk : float
            At a release that of the application, with half an interval that no tick saw.

        """
        brake, time = row.brake, row.time_s
        present = self._open.get(brake)
        step = time - self._time.get(brake, time)
        self._time[brake] = time
        if present and not math.isnan(risk):
            present.stretch.raise_to(risk, row.build_up_nepers)
        if present and (sliding is False or not 0.0 <= step < 1.5 * self._period
                        or present.unknown * self._period > _LONGEST_UNKNOWN):
            self._ended.append(self._open.pop(brake).record)
            present = None
        if sliding:
            present = present or self._open.setdefault(brake, _Application(row))
            present.add(row, alarm=alarm)
        elif present and sliding is None:
            present.unknown += 1

    def add_brakes(self, other: 'ApplicationDetector') -> None:
        """Add the applications of other brakes."""
        self._open |= other._open
        self._time |= other._time
        self._ended += other._ended

    @property
    def applications(self) -> list[ApplicationRecord]:
        """Return the applications up to now, by time of start."""
        return sorted([*self._ended, *(one.record for one in self._open.values())],
                      key=lambda one: (one.start_s, one.brake))
