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

"""Squeal events in a drive: unbroken stretches of ticks at which the alarm of a brake was up."""

from collections.abc import Iterable
from datetime import datetime, UTC
import math
from typing import NamedTuple

from squeal_core.monitor.alarm import Alarm
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.settings import MonitorSettings

_CLOCKS_SET = 946_684_800.0  # s, the year 2000: before it a time is none of the day, or not set


class SquealEvent(NamedTuple):
    """
    An unbroken stretch of ticks at which a brake's alarm was up; NaN, 0 and '': not known.

    The fields are the columns of `events.csv`. The worst mode is the least stable one in the
    squeal band, at the tick of the event at which it grows fastest.

    Attributes
    ----------
    brake : str
    start_s, end_s : float
        First and last such tick, on the clock of the recording.
    clock_time : str
        The first one in ISO 8601, UTC; empty where that clock has no date.
    mode_number : int
        Of the worst mode.
    frequency_hz, growth_rate_1_s, damping_ratio : float
        Of the worst mode.
    mechanism : str
        Why the worst mode grows, as `squeal modes` labels it.
    peak_risk, build_up_nepers : float
        The largest in the event.
    rotor_speed_rad_s, pressure_pa, friction, temperature_k : float
        At the tick of the worst mode.
    latitude_deg, longitude_deg : float
        Of the vehicle at the start.

    """

    brake: str
    start_s: float
    end_s: float
    clock_time: str = ''
    mode_number: int = 0
    frequency_hz: float = math.nan
    growth_rate_1_s: float = math.nan
    damping_ratio: float = math.nan
    mechanism: str = ''
    peak_risk: float = math.nan
    build_up_nepers: float = math.nan
    rotor_speed_rad_s: float = math.nan
    pressure_pa: float = math.nan
    friction: float = math.nan
    temperature_k: float = math.nan
    latitude_deg: float = math.nan
    longitude_deg: float = math.nan


class Stretch:
    """Ticks of one brake in a row: the first, the last, the worst, and the largest values."""

    def __init__(self, row: AssessmentRecord) -> None:
        self.first = self.last = self.worst = row
        self.peak_risk, self.build_up = row.squeal_risk, row.build_up_nepers

    def add(self, row: AssessmentRecord) -> None:
        self.last = row
        if _exceeds(row.growth_rate_1_s, self.worst.growth_rate_1_s):
            self.worst = row
        self.raise_to(row.squeal_risk, row.build_up_nepers)

    def raise_to(self, risk: float, build_up: float) -> None:
        """Take values that may be the largest."""
        if _exceeds(risk, self.peak_risk):
            self.peak_risk = risk
        if _exceeds(build_up, self.build_up):
            self.build_up = build_up

    @property
    def event(self) -> SquealEvent:
        """Return the event of these ticks."""
        first, worst = self.first, self.worst
        return SquealEvent(
            brake=first.brake, start_s=first.time_s, end_s=self.last.time_s,
            clock_time=clock_time(first.time_s), mode_number=worst.worst_mode_number,
            frequency_hz=worst.worst_frequency_hz, growth_rate_1_s=worst.growth_rate_1_s,
            damping_ratio=worst.damping_ratio, peak_risk=self.peak_risk,
            build_up_nepers=self.build_up, rotor_speed_rad_s=worst.rotor_speed_rad_s,
            pressure_pa=worst.pressure_pa, friction=worst.friction,
            temperature_k=worst.temperature_k)


def _exceeds(value: float, largest: float) -> bool:
    return value > largest or (math.isnan(largest) and not math.isnan(value))


def clock_time(seconds: float) -> str:
    """Return a time of the Unix epoch in ISO 8601, UTC; empty for one before clocks were set."""
    if not _CLOCKS_SET <= seconds < 10.0 * _CLOCKS_SET:
        return ''
    return datetime.fromtimestamp(seconds, UTC).isoformat(timespec='milliseconds')


class EventDetector:
    """
    Squeal events by the alarm of the node, tick after tick; holds the events, no rows.

    Parameters
    ----------
    settings : MonitorSettings
        `risk_warning`, `risk_hysteresis` and `risk_hold` decide, as in the node's diagnostics.

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._settings = settings
        self._alarms: dict[str, Alarm] = {}
        self._open: dict[str, Stretch] = {}
        self._ended: list[SquealEvent] = []

    def add(self, row: AssessmentRecord, time: int | None = None) -> bool:
        """
        Take the next row of a brake; return whether its alarm is up.

        Parameters
        ----------
        row : AssessmentRecord
            Of the next tick of its brake.
        time : int, optional
            Of the tick [ns]; by default of the row, whose time in s is good for a microsecond.

        """
        brake = row.brake
        if brake not in self._alarms:
            self._alarms[brake] = Alarm.of(self._settings)
        present = self._open.get(brake)
        up = self._alarms[brake].update(
            round(row.time_s * 1e6) * 1000 if time is None else time, row.squeal_risk)
        if present and (not up or row.time_s < present.last.time_s):  # or time went back
            self._ended.append(self._open.pop(brake).event)
            present = None
        if present:
            present.add(row)
        elif up:
            self._open[brake] = Stretch(row)
        return up

    def add_brakes(self, other: 'EventDetector') -> None:
        """Add the events of other brakes."""
        self._alarms |= other._alarms
        self._open |= other._open
        self._ended += other._ended

    @property
    def events(self) -> list[SquealEvent]:
        """Return the events up to now, by time of start."""
        return sorted([*self._ended, *(one.event for one in self._open.values())],
                      key=lambda event: (event.start_s, event.brake))


def squeal_events(rows: Iterable[AssessmentRecord],
                  settings: MonitorSettings) -> list[SquealEvent]:
    """Return the events in the rows of a table, by time of start."""
    detector = EventDetector(settings)
    for row in rows:
        detector.add(row)
    return detector.events
