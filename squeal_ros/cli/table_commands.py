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

"""The command that builds the table of a model before the drive."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
import json
from pathlib import Path
import sys
import time
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError, SquealError, TableFileError
from squeal_core.common.output import make_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import read_settings
from squeal_core.risk.emulator_file import emulator_path
from squeal_core.surrogate.build_checkpoint import BuildCheckpoint
from squeal_core.surrogate.coverage_report import (
    CoverageReport,
    measure_coverage,
    with_coverage,
)
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_cell import TableTolerances
from squeal_core.surrogate.table_domain import (
    FRICTION,
    places_of,
    PRELOAD,
    ROTOR_SPEED,
    TableDomain,
)
from squeal_core.surrogate.table_file import cached_path, read_table_header, write_table
from squeal_ros.cli.arguments import check_output, check_workers, positive
from squeal_ros.cli.console import plain, ProgressBar, time_left
from squeal_ros.cli.drive_signals import drive_and_vehicle, signals_of
from squeal_ros.cli.growth_commands import tabulate_growth
from squeal_ros.cli.point_checks import check_point
from squeal_ros.cli.table_info import coverage_lines

_DRIVE_RATE = 20.0  # samples a second
_SPECIAL = ('rotor_speed', 'pressure', 'preload', 'friction', 'stiffness_factor', 'drive')


def tabulate(options: argparse.Namespace) -> int:
    """Build a table, measure its coverage, write it; 1 where it has gaps."""
    _check(options)
    model = BrakeModel.load(options.model)
    if options.growth_only:
        return tabulate_growth(model, options)
    domain = _domain(model, options)
    tolerances = TableTolerances.of(model, growth=options.tolerance)
    points = driven_points(model, options) if options.drive else None
    x = places_of(points) if points else None
    output = Path(options.output) if options.output else cached_path(model)
    checkpoint = BuildCheckpoint.of(output, model, domain, tolerances, x, say=_say)
    make_folder(output.parent)
    try:
        table = _table(model, domain, tolerances, points, options.workers, checkpoint)
        report = measure_coverage(table, model, x=x)
    except KeyboardInterrupt:
        _say(f'{checkpoint.count} rows of boxes are kept beside {output}; the same command goes '
             'on from there')
        raise
    write_table(with_coverage(table, report), model, output,
                overwrite=options.force or not options.output)
    checkpoint.remove()
    if not options.no_growth:
        try:
            tabulate_growth(model, options, quiet=True)
        except ModelError as error:
            _say(f'no growth emulator: {error}')
    return _print(options, table, report, output)


def _say(text: str) -> None:
    print(f'squeal: {text}', file=sys.stderr)


def _table(model: BrakeModel, domain: TableDomain, tolerances: TableTolerances,
           points: Sequence[OperatingPoint] | None, workers: int,
           checkpoint: BuildCheckpoint) -> ExpansionTable:
    kept, begun = checkpoint.count, time.monotonic()
    with ProgressBar('rows of boxes') as progress:

        def show(done: int, total: int) -> None:
            progress(done, total, time_left(begun, done - kept, total - kept))

        return build_table(model, domain, tolerances=tolerances, points=points, workers=workers,
                           progress=show, checkpoint=checkpoint)


def _check(options: argparse.Namespace) -> None:
    """Refuse before the work options with which it would fail afterwards."""
    if options.output:
        _check_output(options)
    for name in ('tolerance', 'duration', 'stiffness_factor'):
        if getattr(options, name) is not None:
            positive(f'--{name.replace("_", "-")}', getattr(options, name))
    check_workers(options.workers)
    check_point(options)
    special = _special(options)
    if special and options.growth_only:
        raise SquealError(f'--{special[0].replace("_", "-")}: is of the table, and --growth-only '
                          'builds none; leave one of them out')
    if special and not options.output:
        raise SquealError(f'--{special[0].replace("_", "-")}: give an --output too; the cache '
                          'keeps the table of the usual envelope')


def _check_output(options: argparse.Namespace) -> None:
    path = Path(options.output)
    if not options.no_growth:
        check_output('--output', emulator_path(path), ('.npz',), force=options.force)
    if options.growth_only:
        return
    if path.is_file() and path.suffix == '.npz' and not options.force:
        try:
            read_table_header(path)
        except TableFileError as error:
            raise SquealError(f'--output: {path} {error.what}; give another name, or --force to '
                              'replace it') from None
    check_output('--output', path, ('.npz',), force=options.force,
                 inputs=(resources.find('models', options.model, '.npz'),))


def _special(options: argparse.Namespace) -> list[str]:
    """Return the options by which a table is not that of the usual envelope."""
    return [name for name in _SPECIAL if getattr(options, name) not in (None, 1.0)]


def _domain(model: BrakeModel, options: argparse.Namespace) -> TableDomain:
    preload = options.preload or PRELOAD
    if options.pressure:
        low, high = (model.contact_area * model.contact_pressure(value)
                     for value in options.pressure)
        preload = low, high
    return TableDomain.usual(
        model, rotor_speed=tuple(options.rotor_speed or ROTOR_SPEED), preload=tuple(preload),
        friction=tuple(options.friction or FRICTION), stiffness_factor=options.stiffness_factor)


def driven_points(model: BrakeModel, options: Any) -> list[OperatingPoint]:
    """Return the points at which the four brakes slide under load during a drive."""
    signals = signals_of(*drive_and_vehicle(options.drive, options.vehicle), model,
                         rate=_DRIVE_RATE, duration=options.duration)
    limits = read_settings({})
    sliding = ((signals.pressure >= limits.release_pressure)
               & (np.abs(signals.rotor_speed) >= limits.minimum_rotor_speed))
    values: list[FloatArray] = [array[sliding] for array in (
        signals.rotor_speed, signals.pressure, signals.friction)]
    if not values[0].size:
        raise SquealError(f'--drive: {options.drive} never brakes; give another cycle or a longer '
                          '--duration')
    return [model.operating_point(rotor_speed=speed, pressure=pressure, friction=friction)
            for speed, pressure, friction in np.column_stack(values).tolist()]


def _print(options: argparse.Namespace, table: ExpansionTable, report: CoverageReport,
           output: Path) -> int:
    megabytes = output.stat().st_size / 1e6
    if options.json:
        summary: dict[str, Any] = {
            'output': str(output), 'cells': len(table.cells), 'megabytes': megabytes,
            'memory_megabytes': table.nbytes / 1e6, **table.about, **asdict(report)}
        print(json.dumps(plain(summary)))
    else:
        print(f'{output}: {len(table.cells)} cells, {megabytes:.1f} MB')
        for line in coverage_lines(asdict(report), drive=options.drive):
            print(line)
    return 0 if report.answered >= 0.95 else 1
