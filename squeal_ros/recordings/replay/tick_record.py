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

"""Record of a tick in plain values, and counts over the ticks of a drive."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

from squeal_core.monitor.alarm_events import AlarmEvents
from squeal_core.monitor.results.drive_applications import ApplicationDetector
from squeal_core.monitor.results.drive_summary import DriveSummary
from squeal_core.monitor.results.history import AssessmentRecord, row_of
from squeal_core.monitor.results.squeal_events import EventDetector
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.tick_turns import is_due
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages
from squeal_ros.node.state_message import serialised_state

_SECOND = 1_000_000_000


class TickRecord(NamedTuple):
    """
    A tick as it is written.

    Parameters
    ----------
    time : int
        [ns].
    rows : list of AssessmentRecord
        One a brake.
    states : list of bytes
        Likewise, as squeal_msgs/BrakeSqueal.
    statuses : list of StatusTexts
        Of the diagnostics, those that are due at this tick.
    events : list of StatusTexts
        Of `~/events`: alarms that began or ended.

    """

    time: int
    rows: list[AssessmentRecord]
    states: list[bytes]
    statuses: list[messages.StatusTexts]
    events: list[messages.StatusTexts]

    @classmethod
    def joined(cls, parts: 'Sequence[TickRecord]') -> 'TickRecord':
        """Return the record of a tick from those of its brakes, in their order."""
        return cls(parts[0].time, *([*chain.from_iterable(lists)]
                                    for lists in zip(*(part[1:] for part in parts), strict=True)))


class Recorder:
    """
    Makes the records of a drive; counts the ticks, finds events and brake applications.

    Parameters
    ----------
    settings : MonitorSettings
    node : str
        Whose topics are written.
    part : slice
        The brakes of the settings whose records it makes; the last one's has the node's status.

    Attributes
    ----------
    unknown_risk : str
        Why no squeal risk is known of any brake; empty where it is.

    """

    def __init__(self, settings: MonitorSettings, node: str, part: slice = slice(None)) -> None:
        self._node = node.lstrip('/')
        self._first, self._count = part.start or 0, len(settings.brakes)
        settings = replace(settings, brakes=settings.brakes[part])
        self._alarms = AlarmEvents(settings)
        self._levels: list[int] = []
        self.unknown_risk = ''
        self._period = settings.period
        self._interval = round(_SECOND / settings.diagnostics_rate)
        self.detector = EventDetector(settings)
        self.applications = ApplicationDetector(settings)
        self.summary = DriveSummary(settings)

    def add_brakes(self, other: 'Recorder') -> None:
        """Add the records of other brakes of the same ticks."""
        self.detector.add_brakes(other.detector)
        self.applications.add_brakes(other.applications)
        self.summary.add_brakes(other.summary)

    def record(self, assessments: Sequence[Assessment]) -> TickRecord:
        """Return the record of a tick."""
        self.summary.add(assessments)
        rows = [*map(row_of, assessments)]
        for assessment, row in zip(assessments, rows, strict=True):
            alarm = self.detector.add(row, assessment.time)
            self.applications.add(row, self.summary.slides(assessment), alarm=alarm,
                                  risk=assessment.application_risk)
        events = [messages.event_status(self._node, event)
                  for event in self._alarms.update(assessments)]
        return TickRecord(
            assessments[0].time, rows,
            [*map(serialised_state, assessments)], [*self._statuses(assessments)], events)

    def _statuses(self, assessments: Sequence[Assessment]) -> Iterator[messages.StatusTexts]:
        """
        Yield the diagnostics that are due, as the node publishes them.

        Each status once an interval, one after the other, and that of a brake on a change of its
        level; all at the first tick.
        """
        time, count = assessments[0].time, self._count
        levels, before = messages.levels(assessments, self._alarms), self._levels
        self._levels = levels
        due = [not before or is_due(time, self._period, self._interval, place, count + 1)
               for place in range(count + 1)]
        for place, (assessment, level) in enumerate(zip(assessments, levels, strict=True)):
            if due[self._first + place] or level != before[place]:
                yield messages.brake_status(self._node, assessment, level)
        if due[count] and self._first + len(assessments) == count:
            said = (messages.WARN, self.unknown_risk) if self.unknown_risk else ()
            yield messages.NodeStatus({'ticks_done': self.summary.ticks}, *said).of(self._node)
