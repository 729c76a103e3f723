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

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import islice
from pathlib import Path

from squeal_core.common.output import check_target, OutputFiles
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import Assessment, PreparedTick
from squeal_core.monitor.drive_summary import DriveSummary
from squeal_core.monitor.history import CsvWriter, SquealEvent
from squeal_core.monitor.risk_warnings import risk_warnings, why_unknown
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_core.monitor.vehicle_monitor import VehicleInputs
from squeal_core.monitor.vehicle_risk import ensemble_risk
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_ros.recordings.bag_writer import BagWriter
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.recording import Recording
from squeal_ros.recordings.serialised_outputs import serialised_outputs
from squeal_ros.recordings.tick_record import Recorder, TickRecord

# a longer silence of all inputs is assessed for its first part only: they are stale by then
_LONGEST_SILENCE = 10_000_000_000
_BLOCK = 256  # ticks that are evaluated at once


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

    """

    def __init__(self, recording: Recording, settings: MonitorSettings, model: BrakeModel, *,
                 block: int = _BLOCK) -> None:
        self.settings, self.model = settings, model
        self.recording, self._block = recording, block

    @property
    def findings(self) -> list[Finding]:
        """Return what of the recording does not fit the settings, as far as it was read."""
        return self.recording.findings

    @property
    def notes(self) -> list[str]:
        """Return what else is to be known of recording and settings, as far as it was read."""
        return [*self.recording.notes, *risk_warnings(self._risk, self.settings)]

    @property
    def unknown_risk(self) -> str:
        """Return why no squeal risk is known of any brake; empty where it is."""
        return why_unknown(self._risk, self.settings)

    @cached_property
    def _risk(self) -> SquealRisk | None:
        return ensemble_risk(self.model, self.settings)

    @property
    def messages(self) -> int:
        """Return how many messages are to be read, or an estimate."""
        return self.recording.messages

    def __iter__(self) -> Iterator[tuple[Assessment, ...]]:
        """
        Yield the assessments of every tick.

        Raises
        ------
        SquealError
            For a recording that cannot be read, or holds none of the inputs.

        """
        evaluator = VehicleEvaluator(self.model, self.settings)
        for block in self.blocks():
            yield from evaluator.complete(block)

    def blocks(self) -> Iterator[list[PreparedTick]]:
        """Yield the ticks, prepared and in blocks; raises as `__iter__`."""
        ticks = self._prepared(VehicleInputs(self.settings, self.model))
        while block := list(islice(ticks, self._block)):
            yield block

    def _prepared(self, inputs: VehicleInputs) -> Iterator[PreparedTick]:
        period, tick = self.settings.period, 0
        for time, samples in self.recording.samples():
            first = -(-time // period)
            if tick == 0:
                tick = first
            if time < (tick - 1) * period:  # the clock of the recording went back
                inputs.reset()
                tick = first
            if first > tick:
                for number in range(tick, min(first, tick + _LONGEST_SILENCE // period)):
                    yield inputs.prepare(number * period)
                tick = first
            for sample in samples:
                inputs.receive(*sample)
        yield inputs.prepare(tick * period)


@dataclass
class Outputs:
    """
    Writes what the node publishes as a bag, and a table beside it as CSV; keeps no rows.

    Parameters
    ----------
    path : Path
        Of the bag.
    settings : MonitorSettings
    overwrite : bool
        Whether an existing bag and an existing table may be replaced.
    node : str
        Whose topics are written.

    """

    path: Path
    settings: MonitorSettings
    overwrite: bool = False
    node: str = '/squeal_monitor'
    recorder: Recorder = field(init=False)

    def __post_init__(self) -> None:
        self.recorder = Recorder(self.settings, self.node)

    @property
    def summary(self) -> DriveSummary:
        return self.recorder.summary

    @property
    def csv_path(self) -> Path:
        return self.path.with_suffix('.csv')

    @property
    def events(self) -> list[SquealEvent]:
        return self.recorder.detector.events

    def check(self, inputs: Sequence[str | Path] = ()) -> None:
        """
        Refuse, before any work, outputs that could not be written, or would replace an input.

        Parameters
        ----------
        inputs : sequence of paths
            What the replay reads; of a folder each file.

        """
        check_target(self.path, overwrite=self.overwrite, folder=self.path.suffix != '.mcap',
                     inputs=inputs)
        check_target(self.csv_path, overwrite=self.overwrite, inputs=inputs)

    def write(self, ticks: Iterable[tuple[Assessment, ...]]) -> None:
        """Write all ticks; counts them in `summary` and finds the events."""
        self.write_records(map(self.recorder.record, ticks))

    def write_records(self, records: Iterable[TickRecord]) -> None:
        """Write the records of all ticks."""
        with OutputFiles(overwrite=self.overwrite) as files:
            table = files.add(self.csv_path, probe=True)
            with BagWriter(self.path, files) as bag, table.partial.open(
                    'w', encoding='utf-8', newline='') as file:
                rows = CsvWriter(file)
                for record in records:
                    for row in record.rows:
                        rows.write(row)
                    bag.write_serialised(record.time, serialised_outputs(self.node, record))
