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

"""The commands for more than one point: maps, loci, critical values."""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
import json
import math
from pathlib import Path
import sys
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import short_repr, SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.critical_parameter import critical_value, CriticalValue, Ray
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_core.stability.mechanism import without_rotation
from squeal_core.stability.parameter_paths import Law, moved, OPERATING, PARAMETERS
from squeal_core.studies.study_tasks import CriticalTask, default_bounds, LocusTask, MapTask
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_file import check_size, RECORDS, save_sweep
from squeal_core.studies.sweep_record import Sweep
from squeal_core.studies.unstable_modes import mode_names, unstable_modes
from squeal_ros.cli.arguments import (
    check_output,
    check_workers,
    DEFAULT_SPEED,
    operating_point,
    PLOT_SUFFIXES,
)
from squeal_ros.cli.axis_conflicts import refuse_without_rotation
from squeal_ros.cli.console import plain, ProgressBar, report_progress
from squeal_ros.cli.listing import points_in_words, sweep_lines, sweep_rows
from squeal_ros.cli.point_checks import (
    check_band,
    check_design_bounds,
    check_numbers,
    check_point,
    check_values,
)
from squeal_ros.cli.study_commands import is_study, study
from squeal_ros.cli.swept_axes import follows_law, read_axes, settle_point, StudySource

_Draw: TypeAlias = Callable[[Sweep], None]


def stability_map(options: argparse.Namespace) -> int:
    """Compute frequencies of all modes over a parameter, or the growth rate over two."""
    _check(options)
    source, axes, law = _start(options, 'contact_stiffness')
    if is_study(options, axes, most=2):
        check_band(options.band)
        return study(options, source, axes, MapTask(
            band=tuple(options.band), exact=options.exact, growth_error=options.error), law)
    model = source.model
    draw: _Draw | None = None
    if options.plot:
        from squeal_core.view.stability_map import plot_growth_map, plot_stability_map
        plot = plot_stability_map if len(axes) == 1 else plot_growth_map
        draw = partial(plot, path=options.plot, title=options.title,
                       overwrite=options.force)
    record = _run(model, axes, options, law, tracked=False,
                  rotation=not options.without_rotation)
    return _report(record, options, draw)


def locus(options: argparse.Namespace) -> int:
    """Follow the eigenvalues of modes over one parameter."""
    _check(options)
    if options.without_rotation and options.output:
        check_output('--output', _beside(options.output), force=options.force)
    source, axes, law = _start(options, 'friction')
    if is_study(options, axes, most=1):
        if options.plot_kind == 'bubbles':
            raise SquealError('--plot-kind bubbles: it shows one parameter of the operation')
        return study(options, source, axes, _locus_task(options, axes), law)
    model = source.model
    check_numbers(options.modes, model.size)
    draw: Callable[..., None] | None = None
    if options.plot:
        from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
        kept: dict[str, Any] = {'path': options.plot, 'title': options.title,
                                'overwrite': options.force}
        draw = (partial(_bubbles, model, options.workers, **kept) if options.plot_kind == 'bubbles'
                else partial(plot_loci, numbers=options.modes, **kept) if options.modes
                else partial(plot_growth_rates, **kept))
    record, without = _run(model, axes, options, law, tracked=True), None
    if options.without_rotation and record.complete:
        without = _run(model, axes, options, law, tracked=True, rotation=False)
        if options.output:
            save_sweep(without, _beside(options.output), overwrite=options.force)
    if draw and options.modes and options.plot_kind == 'lines':
        draw = partial(draw, without=without)
    return _report(record, options, draw, options.modes, without)


def _bubbles(model: BrakeModel, workers: int, record: Sweep, **kept: Any) -> None:
    """Draw unstable modes as bubbles, with their mechanisms and names."""
    from squeal_core.view.bubble_map import plot_bubbles
    with ProgressBar('points with their mechanisms') as progress:
        modes = unstable_modes(model, record, workers=workers, progress=progress)
    plot_bubbles(record, modes, mode_names(model, record, modes), **kept)


def _locus_task(options: argparse.Namespace, axes: dict[str, FloatArray]) -> LocusTask:
    if not options.modes:
        raise SquealError('--modes: give the modes to follow, as 13,14, over more than one '
                          'parameter or a dimension')
    if min(options.modes) < 1:
        raise SquealError(f'--modes: {short_repr(options.modes)}; give numbers of modes, from 1')
    return LocusTask(numbers=tuple(options.modes), along=next(iter(axes)) in OPERATING)


def critical(options: argparse.Namespace) -> int:
    """Find the critical values of a parameter, bracketed and confirmed."""
    source = StudySource(options.model, cache_of(options))
    check_point(options)
    check_band(options.band)
    parameter = source.parameter('--parameter', options.parameter)
    _check_bounds(options, parameter, source)
    axes = read_axes(options.over or [], source)
    along = follows_law(source.has_friction_law, options, parameter)
    refuse_without_rotation(options, parameter, axes, along, load_counts=source.load_counts)
    if axes or parameter not in PARAMETERS:
        return _critical_study(options, source, axes, along)
    if options.output or options.plot:
        raise SquealError('--output, --plot: one critical value is printed; sweep with --over')
    model = source.model
    check_numbers(options.modes, model.size)
    if options.without_rotation:
        model = without_rotation(model)
    options.rotor_speed = DEFAULT_SPEED if options.rotor_speed is None else options.rotor_speed
    point = operating_point(model, options)
    ray = partial(moved, model, point, options.parameter, friction_law=along)
    result = critical_value(
        model, point, options.parameter,
        options.bounds or default_bounds(point, options.parameter),
        numbers=options.modes, band_hz=tuple(options.band), ray=ray)
    if options.json:
        print(json.dumps(plain({**asdict(result), 'modes': options.modes, 'friction_law': along,
                                'rotation': not options.without_rotation,
                                'point': asdict(point)})))
    else:
        _print_critical(result, point, along, ray)
    return 0


def _print_critical(result: CriticalValue, point: OperatingPoint, law: Law, ray: Ray) -> None:
    slope = {True: 'friction and slope by the law', 'slope': 'slope by the law'}.get(
        law, f'friction {point.friction:.4g}, slope {point.friction_slope:.4g} s/m')
    print(f'{result.parameter} {result.start:g}: growth rate {result.growth_rate:+.3f} 1/s '
          f'({slope})')
    for way, crossing in (('below', result.below), ('above', result.above)):
        there = '' if result.parameter != 'friction' or math.isnan(crossing.value) else (
            f'; slope {ray(crossing.value).friction_slope:.4g} s/m there'
            + (', in proportion to mu' if point.friction_slope else ''))
        print(f'{way}: {crossing.reason}{there}')


def _check_bounds(options: argparse.Namespace, parameter: str, source: StudySource) -> None:
    if parameter in PARAMETERS:
        check_values(f'--bounds of {parameter}', parameter, options.bounds or ())
        return
    if parameter in OPERATING:
        raise SquealError(f'--parameter: {parameter} is none to search along; give one of '
                          f'{", ".join(PARAMETERS)}, or a path of the brake description')
    start = source.require_design(parameter).number(parameter)
    if options.modes:
        raise SquealError(f'--modes: along {parameter} any mode in --band is meant; leave it out, '
                          f'narrow --band, or search along {", ".join(PARAMETERS)}')
    check_design_bounds(parameter, start, options.bounds)


def _critical_study(options: argparse.Namespace, source: StudySource,
                    axes: dict[str, FloatArray], along: Law) -> int:
    """Compute critical values at each point of a grid, or along a dimension."""
    _check(options)
    if options.parameter in axes:
        raise SquealError(f'--over: {options.parameter} is what is searched along; leave it out')
    law = settle_point(options, axes, source, options.parameter)
    return study(options, source, axes, CriticalTask(
        parameter=options.parameter, bounds=tuple(options.bounds) if options.bounds else None,
        numbers=tuple(options.modes), band=tuple(options.band), law=along), law)


def verify(options: argparse.Namespace) -> int:
    """Rerun the paper: its claims, our results, and claims not reproduced with the reason."""
    from squeal_core import verification

    check_workers(options.workers)
    if options.figures:
        from squeal_core.view.verification_figures import check_figures, write_figures
        check_figures(options.figures, overwrite=options.force)
    result = verification.verify(
        BrakeModel.load(options.model), progress=report_progress, workers=options.workers)
    print(json.dumps(result.to_json()) if options.json else verification.as_text(result))
    if options.figures:
        for path in write_figures(result, options.figures, overwrite=options.force,
                                  progress=report_progress):
            print(path, file=sys.stderr)
    return 0 if result.passed else 1


def _check(options: argparse.Namespace) -> None:
    """Refuse before the sweep options with which it would fail afterwards."""
    check_workers(options.workers)
    model = resources.find('models', options.model, '.npz')
    check_output('--output', options.output, RECORDS, force=options.force, inputs=(model,))
    check_output('--plot', options.plot, PLOT_SUFFIXES, force=options.force)


def _start(options: argparse.Namespace,
           default: str) -> tuple[StudySource, dict[str, FloatArray], Law]:
    """Return the brake, the swept parameters, and the quantities that follow the friction law."""
    check_point(options)
    source = StudySource(options.model, cache_of(options))
    axes = read_axes(options.over or [], source)
    if not axes:
        nominal = source.model.nominal_contact_stiffness
        axes = {'contact_stiffness': np.linspace(0.01, 2.0, 100) * nominal,
                'friction': np.linspace(0.0, 0.8, 81)}
        axes = {default: axes[default]}
    return source, axes, settle_point(options, axes, source)


def cache_of(options: argparse.Namespace) -> str | None:
    """Return the folder of solved parts of brakes."""
    return None if options.no_cache else str(resources.cache_folder())


def _run(model: BrakeModel, axes: dict[str, FloatArray], options: argparse.Namespace, law: Law, *,
         tracked: bool, rotation: bool = True) -> Sweep:
    if options.output:
        check_size(math.prod(map(len, axes.values())), model.size)
    with ProgressBar('points') as progress:
        return sweep(model, operating_point(model, options), axes, rotation=rotation,
                     tracked=tracked, workers=options.workers, friction_law=law,
                     progress=progress)


def _report(record: Sweep, options: argparse.Namespace, draw: _Draw | None,
            numbers: Sequence[int] = (), without: Sweep | None = None) -> int:
    """
    Save requested outputs and print a summary; 1 where an interrupt cut it short.

    Without a file the result itself is printed.
    """
    if options.output:
        save_sweep(record, options.output, overwrite=options.force)
    if draw and record.done.any():
        draw(record)
    flutter = record.kinds == 'flutter'
    squeal = flutter & (record.frequencies_hz >= SQUEAL_BAND[0]) & (
        record.frequencies_hz <= SQUEAL_BAND[1])
    summary = {'points': len(record.points), 'done': int(record.done.sum()),
               'complete': record.complete, 'output': options.output, 'plot': options.plot,
               **{f'points_with_{name}': int(result.any(axis=-1).sum()) for name, result in (
                   ('squeal', squeal), ('flutter', flutter),
                   ('divergence', record.kinds == 'divergence'))}}
    printed = not (options.output or options.plot)
    if options.json:
        results = {name: list(sweep_rows(result, numbers)) for name, result in (
            ('results', record), ('results_without_rotation', without)) if printed and result}
        print(json.dumps(plain({**summary, **results})))
    else:
        if printed:
            print('\n'.join(sweep_lines(record, numbers)))
        if printed and without:
            print('\n'.join(['without rotation', *sweep_lines(without, numbers)]))
        files = [str(path) for path in (options.output, options.plot) if path]
        print('; '.join([f'{summary["done"]} of {summary["points"]} points',
                         points_in_words(summary), *files]))
    return 0 if record.complete else 1


def _beside(path: str) -> Path:
    """Return the file of the sweep without rotation: locus.csv -> locus_without_rotation.csv."""
    whole = Path(path)
    return whole.with_name(f'{whole.stem}_without_rotation{whole.suffix}')
