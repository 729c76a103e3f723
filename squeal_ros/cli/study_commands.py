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

"""Maps, loci and critical values over any number of parameters, of the operation and design."""

import argparse
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
import json
import math
from pathlib import Path
import time
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.common.wording import counted
from squeal_core.common.worker_processes import run_jobs
from squeal_core.stability.parameter_paths import Law, OPERATING, PARAMETERS
from squeal_core.studies.study import Run, run_study
from squeal_core.studies.study_checkpoint import StudyCheckpoint
from squeal_core.studies.study_file import row_names, rows_of, save_study
from squeal_core.studies.study_record import Study
from squeal_core.studies.study_spec import StudySpec
from squeal_core.studies.study_tasks import CriticalTask, LocusTask, MapTask
from squeal_core.surrogate.grid_columns import EXPANSION, FULL, IMPOSSIBLE
from squeal_ros.cli.arguments import point_options
from squeal_ros.cli.console import note, plain, ProgressBar, warn
from squeal_ros.cli.listing import points_in_words
from squeal_ros.cli.swept_axes import StudySource

MOST_PRINTED = 10_000  # points without a file
MOST_POINTS = 100_000_000  # 9 GB of figures, and a day of two cores by local expansions
_MOST_WARNINGS = 3  # of one kind
_FEW = 20_000  # points of a map of one or two parameters that are all solved in full


def is_study(options: argparse.Namespace, axes: dict[str, FloatArray], most: int) -> bool:
    """Return whether parameters or points exceed those of a sweep of full solutions."""
    return (len(axes) > most or not set(axes) <= set(PARAMETERS)
            or math.prod(map(len, axes.values())) > _FEW or bool(options.scheduler)
            or getattr(options, 'exact', False) or getattr(options, 'error', None) is not None)


def study(options: argparse.Namespace, source: StudySource, axes: dict[str, FloatArray],
          task: MapTask | LocusTask | CriticalTask, law: Law) -> int:
    """Compute a study, save it and say what there is; 1 where an interrupt cut it short."""
    points = math.prod(map(len, axes.values()))
    if points > MOST_POINTS:
        raise SquealError(f'--over: {points:.3g} points are too many; give {MOST_POINTS:.0e} at '
                          'most, in several studies if need be')
    if not options.output and not options.plot and points > MOST_PRINTED:
        raise SquealError(f'{points} points are too many to print; give --output FILE')
    path = getattr(task, 'parameter', OPERATING[0])
    built = source.described or not {*axes, path} <= set(OPERATING)
    spec = StudySpec(
        source=source.require_design(path) if built else source.model, axes=axes, task=task,
        options=point_options(options), law=law, cache=source.cache,
        rotation=not getattr(options, 'without_rotation', False))
    checkpoint = (StudyCheckpoint(Path(options.output), spec.key, say=note)
                  if options.output else None)
    doubts = dict[str, None]()
    begun = time.monotonic()
    with ProgressBar('points') as bar, _runner(options) as run:
        result = run_study(
            spec, run, checkpoint=checkpoint, warn=lambda text: doubts.setdefault(text),
            progress=bar.timed)
    _warn_some(list(doubts))
    return _report(result, options, checkpoint, time.monotonic() - begun)


@contextmanager
def _runner(options: argparse.Namespace) -> Iterator[Run]:
    """Yield a function that runs jobs: in processes of this machine, or on a scheduler."""
    if not options.scheduler:
        yield partial(run_jobs, workers=options.workers)
        return
    from squeal_ros.recordings.fleet.fleet_engine import FleetEngine  # asks for Dask

    with FleetEngine(options.scheduler) as engine:
        def run(function: Any, jobs: Any) -> Iterator[tuple[int, Any]]:
            named = {str(key): job for key, job in jobs.items()}
            for key, result in engine.results(function, named, lambda: True):
                if isinstance(result, BaseException):
                    raise result
                yield int(key), result

        yield run


def _report(result: Study, options: argparse.Namespace, checkpoint: StudyCheckpoint | None,
            seconds: float) -> int:
    complete = bool(result.done.all())
    if checkpoint and complete:
        save_study(result, checkpoint.output, overwrite=options.force)
        checkpoint.remove()
    if options.plot and result.done.any():
        from squeal_core.view.study_plot import plot_study
        plot_study(result, options.plot, title=options.title, overwrite=options.force)
    summary = summary_of(result, seconds, options)
    printed = not (options.output or options.plot)
    if options.json:
        rows = {'results': list(rows_of(result))} if printed else {}
        print(json.dumps(plain({**summary, **rows})))
    else:
        if printed:
            print('\n'.join(study_lines(result)))
        print(_in_words(summary))
    _warn_some([_refused(**one) for one in result.about['impossible']])
    if not complete and checkpoint:
        warn(f'not finished: what is done is kept in {checkpoint.folder}; run this again to go on')
    return 0 if complete else 1


def _refused(points: int, reason: str, values: Mapping[str, float]) -> str:
    at = ', '.join(f'{name} = {value:g}' for name, value in values.items())
    return f'{counted(points, "point")} impossible{f" at {at}" if at else ""}: {reason}'


def _warn_some(texts: list[str]) -> None:
    for text in texts[:_MOST_WARNINGS]:
        warn(text)
    if len(texts) > _MOST_WARNINGS:
        warn(f'and {counted(len(texts) - _MOST_WARNINGS, "more warning")} of this kind')


def summary_of(result: Study, seconds: float, options: argparse.Namespace) -> dict[str, Any]:
    """Return a summary of a study's results."""
    about = result.about
    shown: dict[str, Any] = {name: about[name] for name in (
        'task', 'point', 'friction_law', 'rotation', 'parameter', 'band', 'counts', 'impossible')
        if name in about}
    squeals = {f'points_with_{kind}': int((result.columns[name] > 0).sum()) for kind, name in (
        ('squeal', 'squeal_modes'), ('flutter', 'flutter_modes'),
        ('divergence', 'divergent_modes')) if name in result.columns}
    if 'below' in result.columns:
        squeals['points_with_boundary'] = int(np.count_nonzero(
            np.isfinite(result.columns['below']) | np.isfinite(result.columns['above'])))
    return {
        'points': result.size, 'done': int(result.done.sum()), 'complete': bool(result.done.all()),
        'axes': {name: [float(v[0]), float(v[-1]), len(v)] for name, v in result.axes.items()},
        'full': result.count(FULL), 'expansion': result.count(EXPANSION),
        'impossible_points': result.count(IMPOSSIBLE),
        **squeals, **shown, 'seconds': round(seconds, 2),
        'output': options.output if result.done.all() else None,
        'plot': options.plot}


def _in_words(summary: dict[str, Any]) -> str:
    parts = [f'{summary["done"]} of {summary["points"]} points in {summary["seconds"]:.1f} s']
    parts += filter(None, [points_in_words(summary)])
    if summary['expansion']:
        counts = summary['counts']
        checked = (f'off by at most {counts["largest_error"]:.2g} 1/s at {counts["checks"]:g} '
                   'points checked' if counts['checks'] else
                   'too few to check any beside the corners of boxes')
        parts.append(f'{summary["full"]} solved in full, {summary["expansion"]} by '
                     f'{counts["expansions"]:g} local expansions ({checked})')
    if summary['impossible_points']:
        parts.append(f'{summary["impossible_points"]} impossible')
    return '; '.join([*parts, *(str(path) for path in (summary['output'], summary['plot'])
                                if path)])


def study_lines(result: Study) -> Iterator[str]:
    """Yield a table of a study: a line a point."""
    names = row_names(result)
    widths = [max(11, len(name)) for name in names]
    yield '  '.join(f'{name:>{width}}' for name, width in zip(names, widths, strict=True))
    for row in rows_of(result):
        texts = ('' if value is None else value if isinstance(value, str) else f'{value:.6g}'
                 for value in row.values())
        yield '  '.join(f'{text:>{width}}' for text, width in zip(texts, widths, strict=True))
