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

"""`squeal replay`: run the monitor on one or many recordings."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
import json
from pathlib import Path
import time

from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.common.output import make_folder, named_as, OutputError
from squeal_core.monitor.results.result_files import ResultPaths, TableFormat
from squeal_core.monitor.settings import load_settings, MonitorSettings, pressure_references
from squeal_ros import interrupts
from squeal_ros.cli.arguments import MOST_WORKERS, positive
from squeal_ros.cli.console import plain, ProgressBar, report_progress, time_left
from squeal_ros.recordings.recording import RecordingError
from squeal_ros.recordings.recording_files import find_recordings, source_kind
from squeal_ros.recordings.replay.batch_progress import BatchProgress
from squeal_ros.recordings.replay.batch_report import BatchReport
from squeal_ros.recordings.replay.evaluation_process import write_replay
from squeal_ros.recordings.replay.replay import Replay
from squeal_ros.recordings.replay.replay_batch import (
    BatchRecording,
    check_batch,
    outcome_of,
    plan_batch,
    ReplayOutcome,
    ReplayTask,
    run_batch,
)
from squeal_ros.recordings.signals.signals_file import read_signals, Signals
from squeal_ros.recordings.time_range import TimeRange

_MEGABYTE = 1e6
_TABLES: dict[str, tuple[TableFormat, ...]] = {
    'csv': ('csv',), 'parquet': ('parquet',), 'both': ('csv', 'parquet')}


def replay(options: argparse.Namespace) -> int:
    """Run the monitor on recordings."""
    if not 1 <= options.jobs <= MOST_WORKERS:
        raise SquealError(f'--jobs: is {options.jobs}; give 1 to {MOST_WORKERS}')
    task = replay_task(options)
    recordings = found_recordings(options, task)
    if Path(options.output).suffix == '.mcap':
        return _into_one_bag(options, task, recordings)
    return _into_folders(options, task, recordings)


def found_recordings(options: argparse.Namespace, task: ReplayTask) -> list[Path]:
    """Return the given recordings; print the reference of their pressures."""
    recordings = find_recordings(options.recordings)
    _check_signals(task.signals, recordings)
    for words in dict.fromkeys(pressure_references(task.of(path).settings)
                               for path in recordings):
        report_progress(words)
    return recordings


def replay_task(options: argparse.Namespace) -> ReplayTask:
    """Return the task by the options of `add_monitor_options`."""
    if options.table != 'csv':
        # says now which extra is missing
        import squeal_core.monitor.results.parquet_table  # noqa: F401
    return replace(monitor_task(options), span=TimeRange.read(options.begin, options.end),
                   overwrite=getattr(options, 'force', False), tables=_TABLES[options.table])


def monitor_task(options: argparse.Namespace) -> ReplayTask:
    """Return the task by --config, --model, --rate, --signals, --types and --namespace."""
    settings = load_settings(options.config or resources.config_folder() / 'monitor.yaml')
    if options.model:
        settings = replace(settings, model=options.model)
    if options.rate is not None:
        settings = replace(settings, rate=positive('--rate', options.rate))
    signals = read_signals(options.signals) if options.signals else None
    return ReplayTask(settings=settings, types=options.types, namespace=options.namespace,
                      signals=signals)


def _check_signals(signals: Signals | None, recordings: Sequence[Path]) -> None:
    """Refuse signals of columns where no recording has any."""
    if signals and not signals.of('topic') and not any(
            source_kind(path) == 'column' for path in recordings):
        raise RecordingError(recordings[0], f'is a bag, and {signals.path} names columns',
                             'name topics and fields; `squeal signals` proposes them')


def _into_one_bag(options: argparse.Namespace, task: ReplayTask,
                  recordings: Sequence[Path]) -> int:
    """Write the bag of outputs of one recording where -o says, and the other files beside it."""
    output, task = Path(options.output), task.of(recordings[0])
    if len(recordings) > 1:
        raise SquealError(f'-o: {output} is one bag, and there are {len(recordings)} recordings; '
                          'give the name of a folder')
    one = BatchRecording(output.stem, recordings[0], output)
    outputs = task.outputs(ResultPaths.beside(output))
    outputs.check((one.path, *_read(options, task.settings)))
    with named_as(output), _shown([one]) as (progress, show):
        def stopping(run: Replay) -> bool:
            progress.set_part(0, run.read / max(run.messages, 1))
            show()
            return progress.stopping

        run = task.replay(one.path, stopping)
        write_replay(run, outputs, parallel=None if options.jobs > 1 else False)
    outcome = outcome_of(one, run, outputs)
    assert outcome.report is not None
    paths = outputs.paths
    if options.json:
        print(json.dumps(plain({
            **outcome.report.as_json(), 'output': str(paths.bag), 'table': str(paths.table),
            'events_table': str(paths.events), 'applications_table': str(paths.applications),
            'summary': str(paths.summary), 'partial': outcome.partial})))
    else:
        _print_one(outcome)
        print(f'written: {paths.bag}, {paths.table} and what belongs to them')
    return _code(progress, outcome.report.good)


def _into_folders(options: argparse.Namespace, task: ReplayTask,
                  recordings: Sequence[Path]) -> int:
    """Write a folder for each recording into that of -o."""
    results = Path(options.output)
    if any(results.resolve() == path.resolve() for path in recordings):
        raise OutputError(results, 'is what this command reads', 'give another folder')
    there = results.exists()
    try:
        batch = plan_batch(recordings, make_folder(results))
        check_batch(batch, overwrite=options.force)
        with _shown(batch) as (progress, show):
            outcomes = list(run_batch(task, batch, progress, options.jobs, show))
    finally:
        if not there:
            with suppress(OSError):  # it holds results
                results.rmdir()
    outcomes.sort(key=lambda outcome: outcome.name)
    report = BatchReport(outcomes, len(batch))
    if len(batch) == 1 and not report.usable and outcomes:
        raise SquealError(outcomes[0].error)
    if options.json:
        print(json.dumps(plain({**report.as_json(), 'output': str(results)})))
    elif len(batch) == 1 and outcomes:
        _print_one(outcomes[0])
        print(f'written: {outcomes[0].output}')
    else:
        print('\n'.join(report.lines()))
        if report.usable:
            print(f'written: {results}')
    return _code(progress, report.good) if report.usable or progress.stopping else 2


def _print_one(outcome: ReplayOutcome) -> None:
    assert outcome.report is not None
    if outcome.partial:
        print(f'partial: interrupted after the first {outcome.span:.0f} s of {outcome.path}')
    print('\n'.join([*outcome.report.lines(), *outcome.report.event_lines()]))


def _code(progress: BatchProgress, good: bool) -> int:
    if progress.stopping:
        raise KeyboardInterrupt
    return 0 if good else 1


def _read(options: argparse.Namespace, settings: MonitorSettings) -> Iterator[str]:
    """Yield the files that the command reads besides recordings."""
    yield from filter(None, (options.config, options.signals, settings.model, settings.table))


@contextmanager
def _shown(batch: Sequence[BatchRecording]
           ) -> Iterator[tuple[BatchProgress, Callable[[], None]]]:
    """Yield the progress of a batch and a function that shows it; a signal stops the batch."""
    progress = BatchProgress([size_of(one.path) for one in batch])
    total, begun = max(sum(progress.sizes), 1), time.monotonic()
    words = f'MB of {len(batch)} recording{"s" * (len(batch) > 1)}'
    with ProgressBar(words) as bar, interrupts.StopAtNext(progress.stop):
        yield progress, lambda: bar(
            round(progress.done / _MEGABYTE), max(round(total / _MEGABYTE), 1),
            ', stopping' if progress.stopping else time_left(
                begun, round(progress.done), total))


def size_of(path: Path) -> int:
    """Return the size of a recording [bytes]."""
    try:
        files = [*path.iterdir()] if path.is_dir() else [path]
        return sum(file.stat().st_size for file in files if file.is_file())
    except OSError:  # that it cannot be read is said when it is opened
        return 0
