"""The commands that look at more than one point: maps, loci, critical values."""

import argparse
from dataclasses import asdict
import json
import math
from pathlib import Path
import sys
from typing import Any

import numpy as np

from squeal_core.arrays import FloatArray
from squeal_core.brake_model import BrakeModel
from squeal_core.critical import critical_value
from squeal_core.errors import quoted, SquealError
from squeal_core.operating_point import OperatingPoint
from squeal_core.sweep import sweep
from squeal_core.sweep_record import save_sweep, Sweep
from squeal_core.tracking import PARAMETERS
from squeal_ros.commands import operating_point, report_progress

MOST_POINTS = 100_000


def stability_map(options: argparse.Namespace) -> int:
    """Frequencies of all modes over a parameter, or the growth rate over two."""
    model, point, axes = _start(options, 'contact_stiffness')
    record = _run(model, point, axes, options, tracked=False)
    if options.plot:
        from squeal_core.view.stability_map import plot_growth_map, plot_stability_map
        draw = plot_stability_map if len(axes) == 1 else plot_growth_map
        draw(record, options.plot, title=options.title)
    return _report(record, options)


def locus(options: argparse.Namespace) -> int:
    """Roots of modes followed over one parameter."""
    model, point, axes = _start(options, 'friction')
    if len(axes) > 1:
        raise SquealError('--over: a locus runs over one parameter; `squeal map` takes two')
    record = _run(model, point, axes, options, tracked=True)
    if options.plot:
        from squeal_core.view.locus_plot import plot_growth_rates, plot_loci
        if options.modes:
            without = None
            if options.without_rotation:
                without = _run(model, point, axes, options, tracked=True, rotation=False)
            plot_loci(record, options.modes, options.plot, without=without, title=options.title)
        else:
            plot_growth_rates(record, options.plot, title=options.title)
    return _report(record, options)


def critical(options: argparse.Namespace) -> int:
    """Where a parameter has a mode begin to grow, bracketed and confirmed."""
    model = BrakeModel.load(options.model)
    point = operating_point(model, options)
    found = critical_value(model, point, options.parameter, bounds=tuple(options.bounds))
    if options.json:
        print(json.dumps(_plain(asdict(found))))
        return 0
    print(f'{options.parameter} {found.start:g}: growth rate {found.growth_rate:+.3f} 1/s')
    for way, crossing in (('below', found.below), ('above', found.above)):
        at = '' if math.isnan(crossing.value) else (
            f'{crossing.value:.6g}, {crossing.frequency_hz:.1f} Hz: ')
        print(f'{way}: {at}{crossing.reason}')
    return 0


def verify(options: argparse.Namespace) -> int:
    """Rerun the paper: its claims, what this gives, and what is not reproduced with the reason."""
    from squeal_core import verification

    result = verification.verify(
        BrakeModel.load(options.model), progress=report_progress, workers=options.workers)
    print(json.dumps(result.to_json()) if options.json else verification.as_text(result))
    if options.figures:
        from squeal_core.view.verification_figures import write_figures
        for path in write_figures(result, options.figures, progress=report_progress):
            print(path, file=sys.stderr)
    return 0 if result.passed else 1


def _start(options: argparse.Namespace,
           default: str) -> tuple[BrakeModel, OperatingPoint, dict[str, FloatArray]]:
    model = BrakeModel.load(options.model)
    axes = dict(_axis(text) for text in options.over or [])
    if not axes:
        nominal = model.nominal_contact_stiffness
        axes = {'contact_stiffness': np.linspace(0.01, 2.0, 100) * nominal,
                'friction': np.linspace(0.0, 0.8, 81)}
        axes = {default: axes[default]}
    if options.rotor_speed is None:
        options.rotor_speed = float(axes['rotor_speed'][0]) if 'rotor_speed' in axes else 5.0
    return model, operating_point(model, options), axes


def _axis(text: str) -> tuple[str, FloatArray]:
    """Read `friction=0:0.8:81`: from, to, number of points."""
    name, _, span = text.partition('=')
    try:
        start, stop, count = span.split(':')
        if name not in PARAMETERS or not 1 <= int(count) <= MOST_POINTS:
            raise ValueError
        return name, np.linspace(float(start), float(stop), int(count))
    except ValueError:
        raise SquealError(
            f'--over: {quoted(text)} is no axis; write NAME=FROM:TO:COUNT with a name out of '
            f'{", ".join(PARAMETERS)}') from None


def _run(model: BrakeModel, point: OperatingPoint, axes: dict[str, FloatArray],
         options: argparse.Namespace, *, tracked: bool, rotation: bool = True) -> Sweep:
    return sweep(model, point, axes, rotation=rotation, tracked=tracked, workers=options.workers,
                 friction_law=options.friction_law and 'rotor_speed' in axes,
                 progress=_progress if sys.stderr.isatty() else None)


def _progress(done: int, total: int) -> None:
    end = '\n' if done == total else ''
    print(f'\r{done} of {total} points', end=end, file=sys.stderr, flush=True)


def _report(record: Sweep, options: argparse.Namespace) -> int:
    """Save what was asked for and say what there is; 1 where an interrupt cut it short."""
    if options.output:
        save_sweep(record, options.output)
    unstable = record.unstable.any(axis=-1)
    summary = {'points': len(record.points), 'done': int(record.done.sum()),
               'complete': record.complete, 'points_with_flutter': int(unstable.sum()),
               'output': options.output, 'plot': options.plot}
    if options.json:
        print(json.dumps(summary))
    else:
        print(f'{summary["done"]} of {summary["points"]} points, flutter at '
              f'{summary["points_with_flutter"]}' + ''.join(
                  f'; {Path(path)}' for path in (options.output, options.plot) if path))
    return 0 if record.complete else 1


def _plain(value: Any) -> Any:
    """Return what JSON can hold: complex numbers as [re, im], not-a-number as null."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
