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

"""Replays of many recordings, each into a folder of its own, in several processes."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from squeal_core.common.errors import in_one_line, SquealError
from squeal_core.common.output import check_target, named_as, OutputError, OutputFiles
from squeal_core.common.worker_processes import run_jobs
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.result_files import ResultPaths, TableFormat
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator
from squeal_ros.recordings.recording_files import open_recording, source_kind
from squeal_ros.recordings.replay.batch_progress import BatchProgress
from squeal_ros.recordings.replay.evaluation_process import write_replay
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_outputs import Outputs, recording_name
from squeal_ros.recordings.replay.replay_report import ReplayReport
from squeal_ros.recordings.replay.task_sources import model_as_it_is, task_sources
from squeal_ros.recordings.signals.signal_settings import settings_with_signals
from squeal_ros.recordings.signals.signals_file import Kind, KINDS, Signals
from squeal_ros.recordings.time_range import OutOfRangeError, RecordingInRange, TimeRange


@dataclass(frozen=True, kw_only=True)
class ReplayTask:
    """
    Settings and options common to all recordings of a batch.

    Parameters
    ----------
    settings : MonitorSettings
        Without the signals, which take the place of their brakes.
    types, namespace, signals
        As of `open_recording`.
    span : TimeRange, optional
        Of each recording that is replayed; by default all of it.
    overwrite : bool
        Whether existing outputs may be replaced.
    tables : tuple of str
        Formats of the table of ticks.

    """

    settings: MonitorSettings
    types: str | Path | None = None
    namespace: str = '/'
    signals: Signals | None = None
    span: TimeRange | None = None
    overwrite: bool = False
    tables: tuple[TableFormat, ...] = ('csv',)

    @cached_property
    def _tasks(self) -> 'dict[Kind, ReplayTask]':
        """Tasks of recordings with columns, and with topics."""
        return {kind: replace(self, settings=settings_with_signals(self.settings, own)) if (
            own) else self
            for kind in KINDS for own in [self.signals and self.signals.of(kind)]}

    def of(self, path: Path) -> 'ReplayTask':
        """Return the task with the signals that a recording has, and their settings."""
        return self._tasks[source_kind(path)] if self.signals else self

    @cached_property
    def sources(self) -> dict[str, Any]:
        """
        Files and settings that all results rest on, with their hashes.

        Raises
        ------
        SquealError
            For a model, a table, an emulator or a calibration that cannot be used.

        """
        model, settings = model_as_it_is(self.settings.model), self.settings
        if settings.table or settings.growth_emulator or settings.calibration:
            VehicleEvaluator(model, settings)
        return task_sources(model, settings, self.signals, self.types)

    def replay(self, path: Path, stopping: Callable[[Replay], bool]) -> Replay:
        """Return the replay of a recording; `stopping` is asked with it before each block."""
        recording = open_recording(path, self.settings, types=self.types,
                                   namespace=self.namespace, signals=self.signals)
        replay = Replay(RecordingInRange(recording, self.span) if self.span else recording,
                        self.settings, model_as_it_is(self.settings.model))
        replay.stopping = partial(stopping, replay)
        return replay

    def outputs(self, paths: ResultPaths) -> Outputs:
        """Return the outputs of one recording."""
        return Outputs(paths, self.settings, overwrite=self.overwrite, sources=self.sources,
                       tables=self.tables)


@dataclass(frozen=True, kw_only=True)
class ReplayOutcome:
    """
    Outcome of one recording of a batch.

    Parameters
    ----------
    name : str
        Of its result.
    path : Path
        Of the recording.
    output : Path
        Folder of the result, or the bag of outputs.
    error : str
        Why there is no result; empty where there is.
    outside : bool
        Whether that is only because it has nothing in the range of time.
    partial : bool
        Whether the replay was stopped before the end.
    span : float
        Time between its first and last message [s].
    report : ReplayReport or None
    applications : tuple of ApplicationRecord

    """

    name: str
    path: Path
    output: Path
    error: str = ''
    outside: bool = False
    partial: bool = False
    span: float = 0.0
    report: ReplayReport | None = None
    applications: tuple[ApplicationRecord, ...] = ()


@dataclass(frozen=True)
class BatchRecording:
    """A recording of a batch: the name of its result, its path, and the folder of the result."""

    name: str
    path: Path
    output: Path


def plan_batch(recordings: Sequence[Path], results: Path) -> list[BatchRecording]:
    """Return recordings with names of their own: with as many of their folders as it takes."""
    own = {path: (path.resolve().parent, recording_name(path)) for path in recordings}
    beside = Counter((folder, name.casefold()) for folder, name in own.values())
    parts = {path: (*folder.parts[1:], path.name.replace('.', '_')
                    if beside[folder, name.casefold()] > 1 else name)
             for path, (folder, name) in own.items()}
    depth = dict.fromkeys(recordings, 1)
    names = {path: one[-1] for path, one in parts.items()}
    while doubled := [path for path in _doubles(names) if depth[path] < len(parts[path])]:
        for path in doubled:
            depth[path] += 1
            names[path] = '_'.join(parts[path][-depth[path]:])
    for number, path in enumerate(_doubles(names), start=1):  # by an accident of their folders
        names[path] += f'_{number}'
    return [BatchRecording(names[path], path, results / names[path]) for path in recordings]


def _doubles(names: Mapping[Path, str]) -> list[Path]:
    count = Counter(name.casefold() for name in names.values())
    return [path for path, name in names.items() if count[name.casefold()] > 1]


def check_batch(batch: Sequence[BatchRecording], *, overwrite: bool) -> None:
    """
    Refuse, before any work, results that could not be written, or would replace a recording.

    Raises
    ------
    OutputError
        For the first of them; of results that are there already with their number.

    """
    read = {above for one in batch for at in [one.path.resolve()] for above in (at, *at.parents)}
    there = [one for one in batch if one.output.exists()]
    if there and not overwrite:
        more = f', and {len(there) - 1} more of {len(batch)}' if len(there) > 1 else ''
        raise OutputError(there[0].output, f'exists{more}', 'give --force to replace, another '
                          '-o, or leave out these recordings')
    for one in batch:
        if one.output.resolve() in read:
            raise OutputError(one.output, 'is or holds what this command reads',
                              'give another folder')
        check_target(one.output, overwrite=overwrite, folder=True)


def run_batch(task: ReplayTask, batch: Sequence[BatchRecording], progress: BatchProgress,
              workers: int, show: Callable[[], None]) -> Iterator[ReplayOutcome]:
    """
    Yield the outcome of each recording, as it ends; a bad one does not keep the others.

    Parameters
    ----------
    task : ReplayTask
        What is done with each.
    batch : sequence of BatchRecording
        The recordings, in this order.
    progress : BatchProgress
        Of these recordings.
    workers : int
        Processes; one: this one, and of a single recording two where that is faster.
    show : callable
        Of no arguments, called now and then to show the progress.

    """
    for one in batch:
        task.of(one.path).sources  # noqa: B018 - what is wrong is said once, and hashed once
    if workers < 2 or len(batch) < 2:
        for place, one in enumerate(batch):
            if not progress.stopping:
                yield replay_one(task, progress, one, place, show=show,
                                 parallel=None if len(batch) == 1 and workers > 1 else False)
        return

    def going_on() -> bool:
        show()
        return not progress.stopping

    jobs = {place: (one, place) for place, one in enumerate(batch)}
    for _, outcome in run_jobs(
            partial(replay_one, task, progress), jobs, min(workers, len(batch)),
            while_waiting=going_on, lost=lambda place, error: _failed(batch[place], error)):
        yield outcome


def replay_one(task: ReplayTask, progress: BatchProgress, one: BatchRecording, place: int, *,
               show: Callable[[], None] = lambda: None,
               parallel: bool | None = False) -> ReplayOutcome:
    """Replay one recording into its folder; for a worker process too."""
    def stopping(replay: Replay) -> bool:
        progress.set_part(place, replay.read / max(replay.messages, 1))
        show()
        return progress.stopping

    task = task.of(one.path)
    try:
        replay = task.replay(one.path, stopping)
        with named_as(one.output), OutputFiles(overwrite=task.overwrite) as files:
            folder = files.add(one.output, folder=True).partial
            outputs = task.outputs(ResultPaths.in_folder(folder))
            write_replay(replay, outputs, parallel=parallel)
        return outcome_of(one, replay, outputs)
    except Exception as error:  # noqa: BLE001 - the others are replayed all the same
        return _failed(one, error)
    finally:
        progress.set_part(place, 1.0)


def outcome_of(one: BatchRecording, replay: Replay, outputs: Outputs) -> ReplayOutcome:
    """Return the outcome of a recording that was replayed."""
    return ReplayOutcome(
        name=one.name, path=one.path, output=one.output, partial=replay.partial,
        span=(replay.end - replay.start) * 1e-9, report=outputs.report(replay),
        applications=tuple(outputs.recorder.applications.applications))


def _failed(one: BatchRecording, error: Exception) -> ReplayOutcome:
    words = in_one_line(error) if isinstance(error, SquealError | OSError) else (
        f'{one.path}: {type(error).__name__}: {in_one_line(error, 200)}')
    return ReplayOutcome(name=one.name, path=one.path, output=one.output, error=words,
                         outside=isinstance(error, OutOfRangeError))
