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

"""Assessments over time as a table: rows to and from CSV, and the squeal events in them."""

from collections.abc import Iterable, Iterator
import csv
from dataclasses import dataclass
import math
from pathlib import Path
from typing import IO, NamedTuple

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import SquealError
from squeal_core.monitor.alarm import Alarm
from squeal_core.monitor.assessment import Assessment, VALID
from squeal_core.monitor.settings import MonitorSettings

MAX_BYTES = 50_000_000_000  # rows are read one by one
MAX_LINE = 100_000  # characters


class HistoryError(SquealError):
    """A table of assessments that cannot be read."""


class AssessmentRecord(NamedTuple):
    """One assessment of one brake; the fields are the CSV's columns, NaN where not known."""

    time_s: float
    brake: str
    state: str
    rotor_speed_rad_s: float
    pressure_pa: float
    friction: float
    squeal_risk: float
    instability_probability: float
    build_up_nepers: float
    time_to_squeal_s: float
    growth_rate_1_s: float
    damping_ratio: float
    worst_frequency_hz: float
    friction_margin: float
    unstable_frequencies_hz: tuple[float, ...]
    unstable_growth_rates_1_s: tuple[float, ...]
    reason: str

    @property
    def is_valid(self) -> bool:
        """Whether the risk is a number, as of `Assessment`."""
        return self.state in VALID


_TEXTS = ('brake', 'state', 'reason')
_LISTS = ('unstable_frequencies_hz', 'unstable_growth_rates_1_s')
_COLUMNS = AssessmentRecord._fields


def row_of(assessment: Assessment) -> AssessmentRecord:
    """Return an assessment as a row."""
    return AssessmentRecord(
        time_s=assessment.time * 1e-9, brake=assessment.brake, state=assessment.state,
        rotor_speed_rad_s=assessment.inputs['rotor_speed'].value,
        pressure_pa=assessment.inputs['pressure'].value, friction=assessment.friction,
        squeal_risk=assessment.risk,
        instability_probability=assessment.instability_probability,
        build_up_nepers=assessment.build_up, time_to_squeal_s=assessment.time_to_squeal,
        growth_rate_1_s=assessment.growth_rate, damping_ratio=assessment.damping_ratio,
        worst_frequency_hz=assessment.worst_frequency_hz,
        friction_margin=assessment.friction_margin,
        unstable_frequencies_hz=assessment.unstable_frequencies_hz,
        unstable_growth_rates_1_s=assessment.unstable_growth_rates,
        reason=assessment.reason)


class CsvWriter:
    """Writes rows as they come."""

    def __init__(self, file: IO[str]) -> None:
        self._file = file
        self._writer = csv.writer(file, lineterminator='\n')
        self._writer.writerow(_COLUMNS)

    def write(self, row: AssessmentRecord) -> None:
        time, brake, state, *numbers, frequencies, growth_rates, reason = row
        fields = (repr(time), brake, state, *map(repr, numbers), ' '.join(map(repr, frequencies)),
                  ' '.join(map(repr, growth_rates)), reason)
        line = ','.join(fields)
        # csv looks at each character for what it quotes and takes ten times as long
        if line.count(',') < len(fields) and not (
                '"' in line or '\r' in line or '\n' in line):
            self._file.write(f'{line}\n')
        else:
            self._writer.writerow(fields)


def read_rows(path: str | Path) -> Iterator[AssessmentRecord]:
    """
    Yield the rows of a CSV file.

    Raises
    ------
    HistoryError
        Naming file, line and what is wrong.

    """
    try:
        with open_bounded(path, MAX_BYTES, _file_error) as file:
            reader = csv.DictReader(bounded_lines(file, MAX_LINE, lambda line: HistoryError(
                f'{path}: line {line}: has more than {MAX_LINE} characters; give a table that '
                '`squeal replay` wrote'), encoding='utf-8'))
            if tuple(reader.fieldnames or ()) != _COLUMNS:
                raise HistoryError(f'{path}: its columns are {reader.fieldnames}; '
                                   f'give a table that `squeal replay` wrote')
            for values in reader:
                yield _parse(path, reader.line_num, values)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise HistoryError(f'{path}: cannot be read ({error}); check the path') from None


def _file_error(where: object, what: str, remedy: str) -> HistoryError:
    return HistoryError(f'{where}: {what}; {remedy}')


def _parse(path: str | Path, line: int, values: dict[str, str]) -> AssessmentRecord:
    try:
        lists = {name: tuple(map(float, values.pop(name).split())) for name in _LISTS}
        parsed = {name: value if name in _TEXTS else float(value)
                  for name, value in values.items()}
    except (TypeError, ValueError, AttributeError) as error:
        raise HistoryError(f'{path}: line {line}: {error}; mend or leave out the line') from None
    return AssessmentRecord(**parsed, **lists)  # type: ignore[arg-type]


@dataclass(frozen=True)
class SquealEvent:
    """
    An unbroken stretch of ticks at which a brake's alarm was up.

    Parameters
    ----------
    brake : str
    start, end : float
        First and last such tick [s].
    peak_risk : float
        Largest squeal risk in the event [-].
    growth_rate : float
        Largest growth rate in the event [1/s].
    frequency_hz : float
        Of the mode with that growth rate.

    """

    brake: str
    start: float
    end: float
    peak_risk: float
    growth_rate: float
    frequency_hz: float

    def extended(self, tick: '_Tick') -> 'SquealEvent':
        """Return the event with one more tick."""
        peak = max(self.peak_risk, tick.risk)  # the first stays where the second is NaN
        growth_rate, frequency = self.growth_rate, self.frequency_hz
        if math.isnan(growth_rate) or tick.growth_rate > growth_rate:
            growth_rate, frequency = tick.growth_rate, tick.frequency_hz
        return SquealEvent(self.brake, self.start, tick.time, peak, growth_rate, frequency)


class _Tick(NamedTuple):
    """Risk of a brake at a tick [s], growth rate and frequency of its worst mode."""

    brake: str
    time: float
    risk: float
    growth_rate: float
    frequency_hz: float


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
        self._open: dict[str, SquealEvent] = {}
        self._ended: list[SquealEvent] = []

    def add(self, found: Assessment) -> None:
        """Take the next assessment of a brake."""
        self._add(found.time, _Tick(found.brake, found.time * 1e-9, found.risk, found.growth_rate,
                                    found.worst_frequency_hz))

    def add_row(self, row: AssessmentRecord) -> None:
        """Take the next row of a brake, as of a table."""
        # a time in s has a microsecond of precision, ten years after 1970 and later
        self._add(round(row.time_s * 1e6) * 1000, _Tick(
            row.brake, row.time_s, row.squeal_risk, row.growth_rate_1_s, row.worst_frequency_hz))

    def _add(self, time_ns: int, tick: _Tick) -> None:
        brake = tick.brake
        if brake not in self._alarms:
            self._alarms[brake] = Alarm.of(self._settings)
        present = self._open.pop(brake, None)
        up = self._alarms[brake].update(time_ns, tick.risk)
        if present is not None and (not up or tick.time < present.end):  # or time went back
            self._ended.append(present)
            present = None
        if up:
            self._open[brake] = present.extended(tick) if present else SquealEvent(
                brake, tick.time, tick.time, *tick[2:])

    @property
    def events(self) -> list[SquealEvent]:
        """Return the events up to now, by time of start."""
        return sorted([*self._ended, *self._open.values()],
                      key=lambda event: (event.start, event.brake))


def squeal_events(rows: Iterable[AssessmentRecord],
                  settings: MonitorSettings) -> list[SquealEvent]:
    """Return the events in the rows of a table, by time of start."""
    detector = EventDetector(settings)
    for row in rows:
        detector.add_row(row)
    return detector.events
