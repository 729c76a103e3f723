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

"""Files that a replay writes: bag, table, events, brake applications, summary."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, ExitStack
from dataclasses import dataclass, field
import json
from pathlib import Path
from typing import Any

from squeal_core.common.json_values import plain
from squeal_core.common.output import check_target, Output, OutputFiles
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.drive_summary import DriveSummary
from squeal_core.monitor.results.history import AssessmentRecord, CsvWriter
from squeal_core.monitor.results.record_tables import write_records
from squeal_core.monitor.results.result_files import FORMAT, ResultPaths, TableFormat
from squeal_core.monitor.results.result_summary import file_hash, sources_of
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.node.messages import LATCHED
from squeal_ros.recordings.bags.bag_writer import BagWriter
from squeal_ros.recordings.replay.event_details import with_details
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_report import ReplayReport
from squeal_ros.recordings.replay.serialised_outputs import serialised_outputs
from squeal_ros.recordings.replay.tick_record import Recorder, TickRecord


@dataclass
class Outputs:
    """
    Writes the files of a replay, all or none; keeps no rows.

    Parameters
    ----------
    path : Path or ResultPaths
        Of the bag of what the node publishes, the others then beside it; or of each file.
    settings : MonitorSettings
    overwrite : bool
        Whether existing files may be replaced.
    node : str
        Whose topics are written.
    sources : mapping, optional
        `sources_of` model and settings, where they are known already.
    tables : tuple of str
        Formats of the table of ticks: 'csv', 'parquet'.

    Attributes
    ----------
    recorder : Recorder
        Of the ticks that were written.
    events : list of SquealEvent
        What `events.csv` holds, once it is written.

    """

    path: Path | ResultPaths
    settings: MonitorSettings
    overwrite: bool = False
    node: str = '/squeal_monitor'
    sources: Mapping[str, Any] | None = None
    tables: tuple[TableFormat, ...] = ('csv',)
    recorder: Recorder = field(init=False)
    events: list[SquealEvent] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self.recorder = Recorder(self.settings, self.node)
        self.paths = self.path if isinstance(self.path, ResultPaths) else ResultPaths.beside(
            self.path)

    @property
    def summary(self) -> DriveSummary:
        """Return the counts over the ticks written so far."""
        return self.recorder.summary

    def check(self, inputs: Sequence[str | Path] = ()) -> None:
        """
        Refuse, before any work, outputs that could not be written, or would replace an input.

        Parameters
        ----------
        inputs : sequence of paths
            What the replay reads; of a folder each file.

        """
        for path in self._written:
            check_target(path, overwrite=self.overwrite, inputs=inputs, folder=(
                path == self.paths.bag and path.suffix != '.mcap'))

    @property
    def _written(self) -> tuple[Path, ...]:
        """Return the paths of written files; the summary, without which it is none, last."""
        return (self.paths.bag, *self._tables.values(), self.paths.events,
                self.paths.applications, self.paths.summary)

    @property
    def _tables(self) -> dict[TableFormat, Path]:
        """Return the tables of ticks by their format."""
        return {kind: self.paths.table if kind == 'csv' else self.paths.parquet
                for kind in self.tables}

    def write(self, ticks: Iterable[tuple[Assessment, ...]]) -> None:
        """Write bag and tables of all ticks; counts them in `summary` and finds the events."""
        self.write_records(map(self.recorder.record, ticks))

    def write_records(self, records: Iterable[TickRecord], replay: Replay | None = None) -> None:
        """
        Write the records of all ticks.

        Parameters
        ----------
        records : iterable of TickRecord
            Taken into `recorder` by the time they end.
        replay : Replay, optional
            That they are of, for the details of events and the summary; neither without it.

        """
        with OutputFiles(overwrite=self.overwrite) as files:
            tables = {kind: files.add(path, probe=True) for kind, path in self._tables.items()}
            events, applications = (files.add(path, probe=True) for path in (
                self.paths.events, self.paths.applications))
            with BagWriter(self.paths.bag, files, latched=LATCHED) as bag:
                summary = files.add(self.paths.summary) if replay else None  # is committed last
                self._write_ticks(records, tables, bag)
            result = self.recorder.detector.events
            self.events = result if replay is None else with_details(result, replay)
            write_records(events.partial, SquealEvent, self.events)
            write_records(applications.partial, ApplicationRecord,
                          self.recorder.applications.applications)
            if replay and summary:
                summary.partial.write_text(
                    json.dumps(plain(self._summary_json(replay)), indent=1), encoding='utf-8')

    def _write_ticks(self, records: Iterable[TickRecord], tables: Mapping[TableFormat, Output],
                     bag: BagWriter) -> None:
        with ExitStack() as stack:
            writers = [stack.enter_context(_opened(kind, table.partial))
                       for kind, table in tables.items()]
            for record in records:
                for row in record.rows:
                    for write in writers:
                        write(row)
                bag.write_serialised(record.time, serialised_outputs(self.node, record))

    def report(self, replay: Replay, events: Sequence[SquealEvent] | None = None) -> ReplayReport:
        """Return the report of a replay that was written, by default with its own events."""
        return ReplayReport(self.summary, self.events if events is None else events,
                            replay.findings, replay.notes, self._sources(replay)['risk_basis'])

    def _sources(self, replay: Replay) -> Mapping[str, Any]:
        if self.sources is None:
            self.sources = sources_of(replay.model, self.settings)
        return self.sources

    def _summary_json(self, replay: Replay) -> dict[str, Any]:
        path = replay.recording.path
        # a stop is not to wait for a long recording to be read once more
        digest, size = (None, None) if replay.partial else file_hash(path)
        return {
            'format': FORMAT,
            'recording': {'name': recording_name(path), 'path': str(path),
                          'kind': replay.recording.kind, 'sha256': digest, 'bytes': size,
                          'start_s': replay.start * 1e-9, 'end_s': replay.end * 1e-9},
            **self._sources(replay), 'partial': replay.partial,
            'report': self.report(replay).as_json(), 'inputs': replay.quality.as_json()}


@contextmanager
def _opened(kind: TableFormat, path: Path) -> Iterator[Callable[[AssessmentRecord], None]]:
    """Yield a function that writes a row into a table of a format."""
    if kind == 'parquet':
        from squeal_core.monitor.results.parquet_table import ParquetWriter
        with ParquetWriter(path) as rows:
            yield rows.write
    else:
        with path.open('w', encoding='utf-8', newline='') as file:
            yield CsvWriter(file).write


def recording_name(path: Path) -> str:
    """Return the name of a recording: of its folder, or of its file without the suffix."""
    at = path.resolve()
    return at.name if at.is_dir() else at.stem
