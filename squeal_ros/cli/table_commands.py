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

"""The command that lays anchors down beforehand: for an envelope, or for a drive."""

import argparse
from collections.abc import Iterable
import json
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import read_settings
from squeal_core.surrogate.coverage import (
    braking_points,
    build_table,
    covered,
    Envelope,
    random_places,
    Range,
)
from squeal_core.surrogate.table_file import write_table
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import read_vehicle
from squeal_ros.cli.arguments import check_output, positive, shipped
from squeal_ros.cli.console import plain, ProgressBar, warn
from squeal_ros.cli.point_checks import check_point

_TESTS = 2000  # points at which coverage is measured
_DRIVE_RATES = 20.0, 100.0  # points a second: of anchors, and of the test
_RANGES = ('rotor_speed', 'pressure', 'preload', 'friction', 'friction_slope',
           'contact_stiffness')


def tabulate(options: argparse.Namespace) -> int:
    """Lay anchors down, write them, and say how much they cover; 1 where it is less than asked."""
    _check(options)
    model = BrakeModel.load(options.model)
    tolerance = options.tolerance or SolverSettings.of(model).tolerance
    table = TabulatedSolver(model, SolverSettings(tolerance=tolerance, audit_every=0))
    about: dict[str, Any] = {'seed': options.seed, 'tolerance': tolerance}
    laid: Iterable[OperatingPoint]
    tests: Iterable[OperatingPoint]
    if options.drive:
        about['drive'] = options.drive
        laid, tests = (_shuffled(_driven(model, options, rate), options.seed + i)
                       for i, rate in enumerate(_DRIVE_RATES))
    else:
        envelope = _envelope(model, options)
        about['envelope'] = {name: list(ends) for name, ends in envelope.ranges.items()}
        laid, tests = (envelope.points(model, random_places(options.seed + i)) for i in (0, 1))
    with ProgressBar('anchors at most') as progress:
        summary = build_table(table, laid, coverage=options.coverage, most=options.most,
                              memory=1e6 * options.memory,
                              progress=lambda anchors, _: progress(anchors, options.most))
    share = covered(table, tests, _TESTS)
    write_table(table.anchors, model, options.output, about={**about, 'coverage': share},
                overwrite=options.force)
    return _report(options, {
        'anchors': len(table.anchors), 'megabytes': Path(options.output).stat().st_size / 1e6,
        'memory_megabytes': table.nbytes / 1e6, 'points': summary.points,
        'undecided': summary.undecided, 'complete': summary.complete, 'coverage': share, **about,
        'output': options.output}, good=share >= options.coverage)


def _check(options: argparse.Namespace) -> None:
    """Refuse what would fail after the work, before it."""
    check_output('--output', options.output, ('.npz',), force=options.force,
                 inputs=(resources.find('models', options.model, '.npz'),))
    positive('--memory', options.memory)
    if options.tolerance is not None:
        positive('--tolerance', options.tolerance)
    if not 0.0 < options.coverage < 1.0:
        raise SquealError(f'--coverage: is {options.coverage:g}; give a part between 0 and 1')
    if options.most < 1 or options.seed < 0:
        raise SquealError(f'--most is {options.most}, --seed {options.seed}; give a number of '
                          'anchors from 1, and a seed from 0')
    check_point(options)
    if options.duration is not None:
        positive('--duration', options.duration)
    given = [name for name in _RANGES if getattr(options, name) is not None]
    if options.drive and given:
        raise SquealError(f'--drive: says all, and --{given[0].replace("_", "-")} is given too; '
                          'leave one of them out')
    if not options.drive and (options.rotor_speed is None or options.friction is None
                              or (options.pressure is None and options.preload is None)):
        raise SquealError('--rotor-speed, --friction and --pressure or --preload: not all are '
                          'given; give the range of each, or a --drive')


def _envelope(model: BrakeModel, options: argparse.Namespace) -> Envelope:
    def ends(name: str) -> Range | None:
        given = getattr(options, name)
        return None if given is None else (float(given[0]), float(given[1]))

    pressure: Any = ([model.contact_pressure(value) for value in options.pressure]
                     if options.preload is None
                     else [value / model.contact_area for value in options.preload])
    return Envelope(
        rotor_speed=(options.rotor_speed[0], options.rotor_speed[1]),
        contact_pressure=(pressure[0], pressure[1]),
        friction=(options.friction[0], options.friction[1]),
        friction_slope=ends('friction_slope'), contact_stiffness=ends('contact_stiffness'))


def _driven(model: BrakeModel, options: argparse.Namespace, rate: float) -> list[OperatingPoint]:
    """Return where the four brakes slide under load during a drive."""
    from squeal_ros.cli.demo import signals_of
    cycle = read_drive_cycle(shipped('drive_cycles', options.drive, '.csv'), warn=warn)
    vehicle = read_vehicle(shipped('vehicles', options.vehicle, '.yaml'), warn=warn)
    signals = signals_of(cycle, vehicle, model, rate=rate, duration=options.duration)
    limits = read_settings({})
    points = [point for brake in range(len(signals.brakes)) for point in braking_points(
        model, *(values[:, brake].tolist() for values in (
            signals.rotor_speed, signals.pressure, signals.friction)),
        release_pressure=limits.release_pressure,
        minimum_rotor_speed=limits.minimum_rotor_speed)]
    if not points:
        raise SquealError(f'--drive: {options.drive} never brakes; give another cycle or a longer '
                          '--duration')
    return points


def _shuffled(points: list[OperatingPoint], seed: int) -> list[OperatingPoint]:
    """In no order of time: an anchor made where another ends would cover half of what it can."""
    return [points[i] for i in np.random.default_rng(seed).permutation(len(points)).tolist()]


def _report(options: argparse.Namespace, summary: dict[str, Any], *, good: bool) -> int:
    if options.json:
        print(json.dumps(plain(summary)))
    else:
        print(f'{options.output}: {summary["anchors"]} anchors, {summary["megabytes"]:.1f} MB, '
              f'cover {summary["coverage"]:.1%} of {_TESTS} other points'
              f'{"" if summary["complete"] else "; ended by --most or --memory"}')
    return 0 if good else 1
