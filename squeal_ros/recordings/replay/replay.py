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

"""Run the monitor of the node on a recording, on the time of recording."""

from collections.abc import Callable, Iterator
from itertools import islice

from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import Assessment, PreparedTick
from squeal_core.monitor.results.input_quality import InputQuality
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_core.monitor.vehicle_monitor import VehicleInputs
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.recording import Recording

# a longer silence of all inputs is assessed for its first part only: they are stale by then
_LONGEST_SILENCE = 10_000_000_000
_BLOCK = 256  # ticks that are evaluated at once
_LAST = (2**31 - 60) * 1_000_000_000  # ns; the seconds of a time of ROS are 32 bits


class Replay:
    """
    The monitor run on a recording, on the grid of times of the node; iterate over its ticks.

    Parameters
    ----------
    recording : Recording
        Opened for the same settings.
    settings : MonitorSettings
    model : BrakeModel
    block : int
        Ticks that are evaluated at once; the numbers are the node's, bit for bit, of any.

    Attributes
    ----------
    stopping : callable
        Of no arguments, called after each block: whether to leave the rest out.
    partial : bool
        Whether the rest was left out.
    quality : InputQuality
        Of the inputs, as far as they were read.
    start, end, read : int
        Times of recording of the first and the last message [ns], and how many were read.
    risk_warnings : tuple of str
        As of `VehicleRisk`, once ticks were evaluated.

    """

    def __init__(self, recording: Recording, settings: MonitorSettings, model: BrakeModel, *,
                 block: int = _BLOCK) -> None:
        self.settings, self.model = settings, model
        self.recording, self._block = recording, block
        self.stopping: Callable[[], bool] = lambda: False
        self.partial = False
        self.start = self.end = self.read = self._beyond = 0
        self.quality = InputQuality(settings)
        self.risk_warnings: tuple[str, ...] = ()

    @property
    def findings(self) -> list[Finding]:
        """Return the findings on the recording and the settings, as far as it was read."""
        return self.recording.findings

    @property
    def notes(self) -> list[str]:
        """Return further notes on recording and settings, as far as it was read."""
        beyond = [f'{self._beyond} messages recorded before 1970 or after January 2038, which a '
                  'time of ROS cannot hold, are left out'] if self._beyond else []
        return [*self.recording.notes, *beyond, *self.risk_warnings]

    @property
    def messages(self) -> int:
        """Return the number of messages to be read, or an estimate."""
        return self.recording.messages

    def __iter__(self) -> Iterator[tuple[Assessment, ...]]:
        """
        Yield the assessments of every tick.

        Raises
        ------
        SquealError
            For a recording that cannot be read, or holds none of the inputs.

        """
        return self.evaluated_by(VehicleEvaluator(self.model, self.settings))

    def evaluated_by(self, evaluator: VehicleEvaluator) -> Iterator[tuple[Assessment, ...]]:
        """Yield the assessments of every tick by an evaluator of these settings."""
        self.risk_warnings = evaluator.risk.warnings
        for block in self.blocks():
            yield from evaluator.complete(block)

    def blocks(self) -> Iterator[list[PreparedTick]]:
        """Yield the ticks, prepared and in blocks; raises as `__iter__`."""
        ticks = self._prepared(VehicleInputs(self.settings, self.model))
        while not self.partial and (block := list(islice(ticks, self._block))):
            self.quality.read(block)
            yield block
            self.partial = self.stopping()

    def _prepared(self, inputs: VehicleInputs) -> Iterator[PreparedTick]:
        period, tick = self.settings.period, 0
        for time, samples in self.recording.samples():
            if not 0 <= time < _LAST:
                self._beyond += 1
                continue
            first = -(-time // period)
            if tick == 0:
                tick, self.start = first, time
            if time > self.end:
                self.end = time
            self.read += 1
            if time < (tick - 1) * period:  # the clock of the recording went back
                inputs.reset()
                tick = first
            if first > tick:
                for number in range(tick, min(first, tick + _LONGEST_SILENCE // period)):
                    yield inputs.prepare(number * period)
                tick = first
            for sample in samples:
                self.quality.receive(time, *sample)
                inputs.receive(*sample)
        yield inputs.prepare(tick * period)
