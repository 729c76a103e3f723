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

"""Data quality of the inputs of a drive: messages, gaps, and the time without a good reading."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from squeal_core.monitor.assessment import PreparedTick
from squeal_core.monitor.inputs.reading import MissingValue, Sample
from squeal_core.monitor.setting_specs import Signal, UNITS
from squeal_core.monitor.settings import MonitorSettings


@dataclass
class _Input:
    """
    Counts of one input; times in ns.

    Parameters
    ----------
    longest_age : int
        Beyond which the input is stale; a longer time between two values is a gap.
    bad : Counter
        Ticks without a good reading, by the status of the reading.

    """

    longest_age: int
    messages: int = 0
    first: int = 0
    last: int = 0
    gaps: int = 0
    longest: int = 0
    bad: Counter[str] = field(default_factory=Counter)

    def receive(self, time: int) -> None:
        if self.messages:
            step = time - self.last
            if step > self.longest:
                self.longest = step
            self.gaps += step > self.longest_age
        else:
            self.first = time
        self.last = time
        self.messages += 1


class InputQuality:
    """
    Counts messages and bad readings of each input of a vehicle; holds none of them.

    Parameters
    ----------
    settings : MonitorSettings

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self._period = settings.period * 1e-9
        self._brakes = {brake.name: brake for brake in settings.brakes}
        self._inputs: dict[tuple[str, Signal], _Input] = {
            (brake.name, signal): _Input(round(1e9 * source.max_age))
            for brake in settings.brakes for signal, source in brake.inputs.items()}

    def receive(self, time: int, brake: str, signal: Signal,
                sample: Sample | MissingValue) -> None:
        """Take a sample that was recorded at a time [ns]."""
        if not isinstance(sample, MissingValue):
            self._inputs[brake, signal].receive(time)

    def read(self, ticks: Sequence[PreparedTick]) -> None:
        """Take the readings of all brakes at ticks."""
        for one in chain.from_iterable(ticks):
            for signal, reading in one.inputs.items():
                if reading.status != 'good':
                    self._inputs[one.brake, signal].bad[reading.status] += 1

    def as_json(self) -> list[dict[str, Any]]:
        """Return plain data, an entry an input; docs/reference/results.md names the keys."""
        return [self._input_json(brake, signal, one)
                for (brake, signal), one in self._inputs.items()]

    def _input_json(self, brake: str, signal: Signal, one: _Input) -> dict[str, Any]:
        source = self._brakes[brake].inputs[signal]
        span = (one.last - one.first) * 1e-9
        seconds = {status: ticks * self._period for status, ticks in one.bad.items()}
        return {'brake': brake, 'signal': signal, 'source': f'{source.topic} {source.field}',
                'unit': UNITS[signal], 'messages': one.messages,
                'rate_hz': (one.messages - 1) / span if span > 0.0 else None, 'gaps': one.gaps,
                'longest_gap_s': one.longest * 1e-9, 'stale_s': seconds.pop('stale', 0.0),
                'invalid_s': seconds}
