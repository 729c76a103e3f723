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

"""What is written of a tick, in plain values, and what is counted over the ticks of a drive."""

from collections.abc import Sequence
from typing import NamedTuple

from squeal_core.monitor.drive_summary import DriveSummary
from squeal_core.monitor.history import EventDetector
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages

BrakeNumbers = tuple[str, tuple[tuple[str, float], ...], tuple[float, ...]]


class TickRecord(NamedTuple):
    """
    A tick as it is written.

    Parameters
    ----------
    time : int
        [ns].
    brakes : list
        Of each brake its name, the numbers of its topics, and the frequencies of its unstable
        modes [Hz].
    statuses : list of StatusTexts
        Of the diagnostics: one for each brake, then that of the node.

    """

    time: int
    brakes: list[BrakeNumbers]
    statuses: list[messages.StatusTexts]

    def row(self, place: int) -> dict[str, str]:
        """Return the row of a brake in a table; its numbers are texts of the diagnostics, too."""
        status = self.statuses[place]
        return {**status.values, 'time_s': repr(self.time * 1e-9), 'brake': status.hardware_id,
                'reason': status.message, 'rotor_speed_rad_s': status.values['rotor_speed_input'],
                'pressure_pa': status.values['pressure_input']}


class Recorder:
    """
    Makes the records of a drive, tick after tick; counts the ticks and finds the events.

    Parameters
    ----------
    settings : MonitorSettings
    node : str
        Whose topics are written.

    """

    def __init__(self, settings: MonitorSettings, node: str) -> None:
        self._node = node.lstrip('/')
        self._levels = messages.Levels(settings)
        self.detector = EventDetector(settings)
        self.summary = DriveSummary(settings)

    def record(self, assessments: Sequence[Assessment]) -> TickRecord:
        """Return the record of a tick."""
        self.summary.add(assessments)
        for assessment in assessments:
            self.detector.add(assessment)
        return TickRecord(
            assessments[0].time,
            [(a.brake, messages.brake_values(a), messages.frequencies_hz(a)) for a in assessments],
            messages.statuses(self._node, assessments, self._levels.of(assessments),
                              messages.NodeStatus({'ticks_done': self.summary.ticks})))
