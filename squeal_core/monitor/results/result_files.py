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

"""
The files of a replayed recording: tables of its ticks, events and applications, and a summary.

A result is a folder with `table.csv`, `events.csv`, `applications.csv`, `summary.json`, or files
beside each other that have a name before these: `NAME.csv`, `NAME.events.csv`,
`NAME.applications.csv` and `NAME.summary.json`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias

from squeal_core.common.bounded_reader import read_text_bounded
from squeal_core.common.partial_files import PARTIAL, REPLACED
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history import AssessmentRecord, read_rows
from squeal_core.monitor.results.history_columns import HistoryBlock, read_blocks
from squeal_core.monitor.results.record_tables import MAX_BYTES, read_records, REMEDY, ResultError
from squeal_core.monitor.results.squeal_events import SquealEvent

FORMAT = 1
TableFormat: TypeAlias = Literal['csv', 'parquet']
SUMMARY = 'summary.json'
SOURCE_FILES = ('model', 'table', 'emulator', 'calibration', 'signals', 'types')
"""Files that a result rests on, by their keys in its summary."""


class ResultPaths(NamedTuple):
    """Paths of the files of one result."""

    bag: Path
    table: Path
    parquet: Path
    events: Path
    applications: Path
    summary: Path

    @classmethod
    def in_folder(cls, folder: Path) -> 'ResultPaths':
        """Return the paths in a recording's own folder."""
        return cls(*(folder / name for name in (
            'outputs.mcap', 'table.csv', 'table.parquet', 'events.csv', 'applications.csv',
            SUMMARY)))

    @classmethod
    def beside(cls, bag: Path) -> 'ResultPaths':
        """Return those that have the name of a bag of outputs."""
        stem = bag.with_suffix('') if bag.suffix == '.mcap' else bag
        return cls(bag, *(stem.with_name(f'{stem.name}{ending}') for ending in (
            '.csv', '.parquet', '.events.csv', '.applications.csv', f'.{SUMMARY}')))

    @classmethod
    def of_summary(cls, summary: Path) -> 'ResultPaths':
        """Return those that go with a `summary.json` or `NAME.summary.json`."""
        if summary.name == SUMMARY:
            return cls.in_folder(summary.parent)
        return cls.beside(summary.with_name(summary.name.removesuffix(f'.{SUMMARY}') + '.mcap'))


@dataclass(frozen=True, eq=False)
class ReplayResult:
    """
    Files of one replayed recording, read.

    Parameters
    ----------
    paths : ResultPaths
    summary : dict
        Of `summary.json`; docs/reference/results.md names the keys.
    events : tuple of SquealEvent
    applications : tuple of ApplicationRecord

    """

    paths: ResultPaths
    summary: dict[str, Any]
    events: tuple[SquealEvent, ...]
    applications: tuple[ApplicationRecord, ...]

    @property
    def name(self) -> str:
        """Name of the recording."""
        return str(self.summary['recording']['name'])

    def rows(self) -> Iterator[AssessmentRecord]:
        """
        Yield the rows of the table, one by one.

        Raises
        ------
        HistoryError
            Naming file, line and what is wrong.

        """
        if not self.paths.table.exists() and self.paths.parquet.exists():
            from squeal_core.monitor.results.parquet_table import read_parquet
            return read_parquet(self.paths.parquet)
        return read_rows(self.paths.table)

    def blocks(self, columns: Sequence[str]) -> Iterator[HistoryBlock]:
        """
        Yield the rows of the table as arrays, some thousand at once; see `read_blocks`.

        Raises
        ------
        HistoryError
            Naming file, line and what is wrong.

        """
        if not self.paths.table.exists() and self.paths.parquet.exists():
            from squeal_core.monitor.results.parquet_table import parquet_blocks
            return parquet_blocks(self.paths.parquet, columns)
        return read_blocks(self.paths.table, columns)

    @classmethod
    def load(cls, path: str | Path) -> 'ReplayResult':
        """
        Read a result.

        Parameters
        ----------
        path : path
            Its folder, or its summary.

        Raises
        ------
        ResultError
            With file, what is wrong and the remedy.

        """
        given = Path(path)
        paths = ResultPaths.in_folder(given) if given.is_dir() else ResultPaths.of_summary(given)
        return cls(paths, _read_summary(paths.summary),
                   tuple(read_records(paths.events, SquealEvent)),
                   tuple(read_records(paths.applications, ApplicationRecord)))


def find_results(paths: Sequence[str | Path]) -> list[Path]:
    """
    Return the summaries of all results in folders, or given themselves; sorted, each once.

    Raises
    ------
    ResultError
        For a path at which there is none.

    """
    result: dict[Path, Path] = {}
    for path in map(Path, paths):
        summaries = [path] if path.is_file() else sorted(
            summary for pattern in (SUMMARY, f'*.{SUMMARY}') for summary in path.rglob(pattern)
            if not any(PARTIAL in part or REPLACED in part for part in summary.parts))
        if not summaries:
            raise ResultError(path, 'holds no result of `squeal replay`' if path.is_dir()
                              else 'is not there', 'give the folder that it wrote (-o)')
        result |= {summary.resolve(): summary for summary in summaries}
    return list(result.values())


def _read_summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads(read_text_bounded(path, MAX_BYTES, ResultError))
    except (ValueError, RecursionError) as error:
        raise ResultError(path, f'is no JSON ({error})', REMEDY) from None
    if not isinstance(summary, dict) or summary.get('format') != FORMAT:
        raise ResultError(path, f'is no summary of format {FORMAT}', REMEDY)
    if not isinstance(summary.get('recording'), dict) or 'name' not in summary['recording']:
        raise ResultError(path, 'names no recording', REMEDY)
    return summary
