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

"""Brake applications in a recording, through the input channels of the monitor."""

from collections.abc import Iterable
import math

import numpy as np
from squeal_core.calibration.applications import BrakeApplication
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import Assessment, AssessmentContext
from squeal_ros.recordings.replay.replay import Replay

_AT_REST = ('released', 'not sliding')
_GAP = 1.5  # periods between two ticks of one application, beyond which a tick is missing
_UNKNOWN = (math.nan,) * 4

_Row = tuple[float, float, float, float, float]


class ApplicationCollector:
    """
    Collects the brake applications in prepared ticks.

    An application goes from the first tick at which the brake may slide under load to the tick
    before it is released or stands. Ticks at which that is not known are kept as such.

    Parameters
    ----------
    recording : str
        Name of the recording.
    model : BrakeModel
        With a caliper.
    period : float
        Of the ticks [s].

    Attributes
    ----------
    applications : list of BrakeApplication
    start : float
        Time of the first tick [s]; NaN before it.
    ticks : int
        Known ticks of sliding under load.

    """

    def __init__(self, recording: str, model: BrakeModel, period: float) -> None:
        self._recording, self._model, self._period = recording, model, period
        self._open: dict[str, list[_Row]] = {}
        self.applications: list[BrakeApplication] = []
        self.start = math.nan
        self.ticks = 0

    def add(self, ticks: Iterable[tuple[Assessment | AssessmentContext, ...]]) -> None:
        """Take further ticks."""
        for tick in ticks:
            for one in tick:
                self._add(one)

    def _add(self, one: Assessment | AssessmentContext) -> None:
        time = one.time * 1e-9
        self.start = time if math.isnan(self.start) else min(self.start, time)
        rows = self._open.get(one.brake, [])
        if rows and not rows[-1][0] < time:  # the clock went back
            self._end(one.brake)
        if isinstance(one, Assessment) and one.state in _AT_REST:
            self._end(one.brake)
            return
        rows = self._open.setdefault(one.brake, [])
        if rows and time - rows[-1][0] > _GAP * self._period:
            rows.append((rows[-1][0] + self._period, *_UNKNOWN))
        rows.append((time, *self._values(one)))

    def _values(self, one: Assessment | AssessmentContext) -> tuple[float, float, float, float]:
        if isinstance(one, Assessment):
            return _UNKNOWN
        at = one.conditions
        temperature = one.inputs.get('temperature')
        self.ticks += 1
        return (at.rotor_speed, self._model.contact_pressure(at.pressure), at.friction,
                temperature.value if temperature and temperature.is_believed else math.nan)

    def _end(self, brake: str) -> None:
        rows = self._open.pop(brake, [])
        if any(math.isfinite(row[1]) for row in rows):
            self.applications.append(BrakeApplication(brake, self._recording, *np.array(rows).T))

    def finish(self) -> list[BrakeApplication]:
        """End what is open and return all applications in the order of their starts."""
        for brake in list(self._open):
            self._end(brake)
        return sorted(self.applications, key=lambda one: (one.time[0], one.brake))


def collect_applications(replay: Replay, recording: str) -> ApplicationCollector:
    """
    Return the brake applications in a recording.

    Raises
    ------
    BagError
        For a bag that cannot be read, or has no message on the topics of the settings.

    """
    collector = ApplicationCollector(recording, replay.model, replay.settings.period * 1e-9)
    for block in replay.blocks():
        collector.add(block)
    collector.applications = collector.finish()
    return collector
