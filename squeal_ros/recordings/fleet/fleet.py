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


"""A fleet: results of many recordings, kept by their contents, and tables over all of them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
import os
from pathlib import Path
import pickle
from typing import Any

from squeal_core.common.errors import in_one_line, SquealError
from squeal_core.common.output import make_folder, OutputError
from squeal_core.common.partial_files import clear_leftovers, PARTIAL
from squeal_core.monitor.results.fleet_files import FleetFolder, is_fleet, MANIFEST, RECORDINGS
from squeal_core.monitor.results.result_summary import file_hash
from squeal_ros.recordings.fleet.fleet_engine import FleetEngine, FleetLost
from squeal_ros.recordings.fleet.fleet_tables import Member, write_tables
from squeal_ros.recordings.fleet.fleet_task import (
    content_key,
    evaluate_recording,
    Evaluated,
    recording_digest,
)
from squeal_ros.recordings.fleet.fleet_vehicles import VehicleRow, vehicles_of
from squeal_ros.recordings.replay.replay_batch import plan_batch, ReplayTask

INTERRUPTED = 'the run was interrupted; run it again: what is finished is kept'


@dataclass
class FleetRun:
    """
    One run over the recordings of a fleet.

    Parameters
    ----------
    task : ReplayTask
        What is done with each, with absolute paths.
    recordings : sequence of Path
        Absolute.
    folder : Path
        Of the results.
    vehicles : sequence of VehicleRow
    given : sequence of Path
        Files and folders that name the recordings, absolute.
    show : callable
        Told the phase, and which recordings ended by name; returns whether to go on.

    Attributes
    ----------
    computed, kept : int
        Results that this run wrote, and that were there; one for all copies of a recording.
    lost : str
        Why the run did not come to the rest; empty where it came to all.

    """

    task: ReplayTask
    recordings: Sequence[Path]
    folder: Path
    vehicles: Sequence[VehicleRow] = ()
    given: Sequence[Path] = ()
    show: Callable[[str, Sequence[str]], bool] = lambda phase, names: True
    computed: int = field(default=0, init=False)
    kept: int = field(default=0, init=False)
    lost: str = field(default='', init=False)

    def __post_init__(self) -> None:
        _check_folder(self.folder)
        self._results = make_folder(self.folder / RECORDINGS)
        self.paths = {one.name: one.path for one in plan_batch(self.recordings, self._results)}
        self._digests: dict[str, str] = {}
        self._keys: dict[str, str] = {}
        self._results_of: dict[str, Evaluated] = {}
        self._errors: dict[str, str] = {}
        self._before = {folder.name for folder in self._results.iterdir()}

    def evaluate(self, engine: FleetEngine) -> None:
        """Evaluate new recordings; record those that fail or are not reached."""
        self.task.sources  # noqa: B018 - what is wrong is said once, and hashed once
        try:
            self._read(engine)
            self._evaluate(engine)
        except FleetLost as error:
            self.lost = str(error)
        clear_leftovers(self._results)
        self._take_what_is_there()
        if not self.lost and len(self._results_of) + len(self._errors) < len(self.paths):
            self.lost = INTERRUPTED

    def _take_what_is_there(self) -> None:
        """Take results that were not reported: of an earlier run, or of a worker cut off."""
        untold = {key: self._results / key for name, key in self._keys.items()
                  if name not in self._results_of and name not in self._errors}
        result = {key: Evaluated(str(folder), file_hash(folder)[0])
                  for key, folder in untold.items() if folder.is_dir()}
        self._results_of |= {name: result[key] for name, key in self._keys.items()
                             if key in result}
        self.kept += len(self._before & result.keys())
        self.computed += len(result.keys() - self._before)

    def _read(self, engine: FleetEngine) -> None:
        jobs = {name: (str(path),) for name, path in self.paths.items()}
        for name, result in engine.results(recording_digest, jobs, self._going_on('read')):
            if isinstance(result, Exception):
                self._errors[name] = _words(self.paths[name], result)
            else:
                self._digests[name] = result
            self.show('read', [name])

    def _evaluate(self, engine: FleetEngine) -> None:
        names: dict[str, list[str]] = {}
        for name, path in self.paths.items():
            if digest := self._digests.get(name):
                key = content_key(self.task, path, digest)
                names.setdefault(key, []).append(name)
                self._keys[name] = key
        expected, packed = self._expected(), pickle.dumps(self.task)
        jobs = {key: (packed, str(self.paths[own[0]]), str(self._results / key),
                      expected.get(key, '')) for key, own in names.items()}
        for key, result in engine.results(evaluate_recording, jobs, self._going_on('evaluated')):
            error = _words(self.paths[names[key][0]], result) if isinstance(
                result, Exception) else result.error
            first = str(self.paths[names[key][0]])
            for name in names[key]:
                if error:
                    self._errors[name] = error.replace(first, str(self.paths[name]))
                else:
                    self._results_of[name] = result
            if not error:
                self.computed += result.written
                self.kept += not result.written
            self.show('evaluated', names[key])

    def _going_on(self, phase: str) -> Callable[[], bool]:
        return lambda: self.show(phase, ())

    def _expected(self) -> dict[str, str]:
        """Return the SHA-256 of the results of an earlier run, by their keys."""
        try:
            return {Path(record.result).name: record.result_sha256
                    for _, record in FleetFolder.load(self.folder).rows(RECORDINGS)}
        except SquealError:  # none, or of another version: they are taken as they are
            return {}

    def write(self) -> dict[str, Any]:
        """Write the tables over all that is evaluated, and the manifest; return it."""
        rows = vehicles_of(self.paths, self.vehicles, self.given)
        return write_tables(self.folder, [
            self._member(name, path, rows[name]) for name, path in self.paths.items()],
            {'sources': self.task.sources, 'partial': self.lost}, self.task.tables)

    def _member(self, name: str, path: Path, row: VehicleRow) -> Member:
        result = self._results_of.get(name)
        if result is None:
            return Member(name, path, row, self._digests.get(name, ''),
                          error=self._errors.get(name, self.lost), reached=name in self._errors)
        return Member(name, path, row, self._digests[name], Path(result.path), result.sha256)


def absolute(path: str | Path) -> Path:
    """Return a path that any worker finds."""
    return Path(os.path.abspath(path))


def recordings_outside(recordings: Sequence[Path], folder: Path) -> list[Path]:
    """Return the absolute paths of recordings, but for what is in the folder of results."""
    at = folder.resolve()
    return [absolute(path) for path in recordings if not path.resolve().is_relative_to(at)]


def _check_folder(folder: Path) -> None:
    """Refuse a folder that holds anything else than results of a fleet."""
    if folder.is_dir() and not is_fleet(folder):
        other = [path.name for path in folder.iterdir()
                 if path.name != RECORDINGS and PARTIAL not in path.name]
        if other:
            raise OutputError(folder, f'holds {other[0]} and no {MANIFEST}',
                              'give a new folder, or one that `squeal fleet` wrote')


def _words(path: Path, error: Exception) -> str:
    text = in_one_line(error, 300)
    return text if str(path) in text else f'{path}: {text}' if isinstance(
        error, SquealError | OSError) else f'{path}: {type(error).__name__}: {text}'


def fleet_summary(manifest: Mapping[str, Any], run: FleetRun) -> dict[str, Any]:
    """Return the outcome of a run, as plain data; docs/howto/fleet.md names the keys."""
    return {key: manifest[key] for key in (
        'recordings_found', 'recordings_evaluated', 'recordings_copied', 'recordings_failed',
        'recordings_not_reached', 'recordings_with_notes', 'totals', 'failures')} | {
        'results_computed': run.computed, 'results_kept': run.kept, 'lost': run.lost or None,
        'output': str(run.folder)}
