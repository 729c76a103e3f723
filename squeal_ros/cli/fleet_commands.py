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


"""`squeal fleet`: run the monitor on the recordings of a fleet, on many processors."""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
import json
from pathlib import Path
import time
from typing import Any

from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.common.output import make_folder
from squeal_core.common.wording import counted, percent_down
from squeal_ros import interrupts
from squeal_ros.cli.arguments import MOST_WORKERS, positive
from squeal_ros.cli.console import plain, ProgressBar, time_left
from squeal_ros.cli.replay_commands import found_recordings, replay_task, size_of
from squeal_ros.recordings.fleet.fleet import absolute, fleet_summary, FleetRun, recordings_outside
from squeal_ros.recordings.fleet.fleet_engine import FleetEngine
from squeal_ros.recordings.fleet.fleet_vehicles import read_vehicles
from squeal_ros.recordings.recording import RecordingError
from squeal_ros.recordings.replay.replay_batch import ReplayTask

_MOST_RETRIES, _MOST_LINES = 100, 40


def fleet(options: argparse.Namespace) -> int:
    """Evaluate the recordings of a fleet."""
    engine = _engine(options)
    vehicles = read_vehicles(options.vehicles) if options.vehicles else ()
    task, folder = _everywhere(replay_task(options)), absolute(options.output)
    recordings = recordings_outside(found_recordings(options, task), folder)
    if not recordings:
        raise RecordingError(options.recordings[0], 'holds results of this fleet only',
                             'give recordings')
    with ProgressBar('recordings') as bar:
        progress = _Progress(bar)
        run = FleetRun(task, recordings, make_folder(folder), vehicles,
                       [*map(absolute, options.recordings)], progress)
        progress.begin(run.paths)
        with interrupts.StopAtNext(progress.stop), engine:
            run.evaluate(engine)
    manifest = run.write()
    _print(options, manifest, run)
    if progress.stopping:
        raise KeyboardInterrupt
    if not manifest['recordings_evaluated']:
        return 2
    totals = manifest['totals']
    return 1 if manifest['failures'] or totals['braking_s'] > totals['risk_known_s'] == 0.0 else 0


def _engine(options: argparse.Namespace) -> FleetEngine:
    for name, value, least, most in (('--workers', options.workers, 1, MOST_WORKERS),
                                     ('--retries', options.retries, 0, _MOST_RETRIES)):
        if not least <= value <= most:
            raise SquealError(f'{name}: is {value}; give {least} to {most}')
    return FleetEngine(options.scheduler, workers=options.workers, retries=options.retries,
                       timeout=positive('--timeout', options.timeout),
                       stall=positive('--stall', options.stall))


def _everywhere(task: ReplayTask) -> ReplayTask:
    """Return the task with paths that do not depend on a process's folder."""
    settings = task.settings
    files: dict[str, Any] = {name: str(absolute(value)) for name in (
        'model', 'table', 'growth_emulator', 'calibration')
             for value in [getattr(settings, name)] if value and Path(value).is_file()
             and not (name == 'model' and value in resources.names('models', '.npz'))}
    return replace(task, settings=replace(settings, **files),
                   types=absolute(task.types) if task.types else None)


class _Progress:
    """Shows the progress of a run and the time left; a signal stops the run."""

    def __init__(self, bar: ProgressBar) -> None:
        self._bar, self._phase = bar, ''
        self.stopping = False

    def stop(self) -> None:
        if not self._phase:
            raise KeyboardInterrupt  # as it connects: nothing has begun
        self.stopping = True

    def begin(self, paths: Mapping[str, Path]) -> None:
        self._sizes = {name: size_of(path) for name, path in paths.items()}

    def __call__(self, phase: str, names: Sequence[str]) -> bool:
        if phase != self._phase:
            self._phase, self._begun, self._ended, self._done = phase, time.monotonic(), 0, 0
        self._ended += len(names)
        self._done += sum(self._sizes[name] for name in names)
        self._bar(self._ended, len(self._sizes), f' {phase}' + (
            ', stopping' if self.stopping else time_left(
                self._begun, self._done, sum(self._sizes.values()))))
        return not self.stopping


def _print(options: argparse.Namespace, manifest: dict[str, Any], run: FleetRun) -> None:
    summary = fleet_summary(manifest, run)
    print(json.dumps(plain(summary)) if options.json else '\n'.join(_lines(summary)))


def _lines(summary: Mapping[str, Any]) -> Iterator[str]:
    totals = summary['totals']
    failures = [one for one in summary['failures'] if one['reached']]
    where = f'{summary["recordings_evaluated"]} of {summary["recordings_found"]} recordings'
    if totals['braking_s']:
        yield (f'squeal risk known for {percent_down(totals["risk_known_share"])} of the braking '
               f'time ({totals["risk_known_s"]:.1f} of {totals["braking_s"]:.1f} s of all brakes) '
               f'in {where}')
    else:
        yield f'no braking in {where}, so nothing to assess'
    if summary['lost']:
        yield f'stopped: {summary["lost"]}'
    if summary['recordings_not_reached']:
        yield f'not reached: {counted(summary["recordings_not_reached"], "recording")}'
    for one in failures[:_MOST_LINES]:
        yield f'not evaluated: {one["recording"]}: {one["error"]}'
    if len(failures) > _MOST_LINES:
        yield f'and {len(failures) - _MOST_LINES} more: see failures.csv'
    if summary['recordings_with_notes']:
        yield (f'{counted(summary["recordings_with_notes"], "recording")} with notes, as of '
               'damage: see notes in recordings.csv')
    yield (f'{counted(summary["results_computed"], "result")} computed, '
           f'{summary["results_kept"]} kept from earlier runs; copies of other recordings, '
           f'which count once: {summary["recordings_copied"]}')
    yield (f'total: {totals["duration_s"] / 3600.0:.2f} h; '
           f'{counted(totals["events"], "squeal event")}; '
           f'{totals["applications_with_alarm"]} of {totals["applications"]} brake applications '
           f'with an alarm, {totals["applications"] - totals["applications_known"]} not known')
    yield f'written: {summary["output"]}; `squeal report {summary["output"]}` makes its page'
