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

"""`squeal compare`: models, variants and tables side by side."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

from squeal_core.assembly.build import build_model
from squeal_core.assembly.parts import PartCache
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.drive_risk import drive_risk, DriveRisk
from squeal_core.monitor.settings import load_settings
from squeal_core.risk.emulator_file import cached_emulator_path, find_emulator
from squeal_core.studies.brake_comparison import (
    BrakeComparison,
    compare_brakes,
    compared_model,
    compared_table,
    ComparedBrake,
    ComparedMode,
    mac_of,
)
from squeal_core.studies.point_options import brake_pressure
from squeal_core.surrogate.table_file import (
    is_table,
    model_hash,
    read_table,
    read_table_header,
)
from squeal_core.vehicle.vehicle import Vehicle
from squeal_ros.cli.arguments import (
    check_output,
    check_workers,
    is_description,
    operating_point,
    PLOT_SUFFIXES,
    positive,
    shipped,
)
from squeal_ros.cli.console import plain, ProgressBar, report_progress, warn
from squeal_ros.cli.drive_signals import Drive, drive_and_vehicle, signals_of
from squeal_ros.cli.growth_commands import build_emulator_file
from squeal_ros.cli.listing import point_in_words
from squeal_ros.cli.point_checks import check_band, check_point, check_values

_DRIVE_RATE = 2.0  # Hz, of assessments over a drive


class Given(NamedTuple):
    """One brake as it was given: its name, its model, and the file of its table if it is one."""

    name: str
    model: BrakeModel
    table: str = ''


def compare(options: argparse.Namespace) -> int:
    """Compare brakes at a point and over a drive."""
    if len(options.brakes) < 2:
        raise SquealError(f'{options.brakes[0]}: there is nothing to compare it with; give two '
                          'brakes or more')
    bounds = tuple(options.bounds or (0.0, 1.0))
    _check(options, bounds)
    driven = drive_and_vehicle(options.drive, options.vehicle) if options.drive else None
    given = _read(options.brakes)
    points = [operating_point(one.model, options) for one in given]
    compared = [_compared(one, point, bounds)
                for one, point in zip(given, points, strict=True)]
    result = compare_brakes(compared)
    risks = _risks(given, driven, options) if driven else []
    rows = shown_rows(result, options.band, every=options.all)
    if options.plot:
        from squeal_core.view.comparison_slide import plot_comparison
        plot_comparison(result, rows, risks, options.plot, title=options.title,
                        conditions=_conditions(given, points), drive=options.drive or '',
                        bounds=bounds, overwrite=options.force)
    if options.json:
        print(json.dumps(plain(_as_json(result, rows, risks, points, options))))
    else:
        print('\n'.join(_lines(result, rows, risks, _points_in_words(given, points), options)))
    return 0


def _check(options: argparse.Namespace, bounds: tuple[float, float]) -> None:
    check_point(options)
    check_band(options.band)
    check_workers(options.workers)
    if options.duration is not None:
        positive('--duration', options.duration)
    check_values('--bounds of friction', 'friction', options.bounds or (), signed=False)
    if not bounds[0] < bounds[1]:
        raise SquealError(f'--bounds: are {bounds[0]:g} and {bounds[1]:g}; give two frictions '
                          'that rise')
    files = [path for path in map(Path, options.brakes) if path.is_file()]
    check_output('--plot', options.plot, PLOT_SUFFIXES, force=options.force, inputs=files)


def _read(names: Sequence[str]) -> list[Given]:
    """Read models, build variants, and find the model of each table."""
    labels = brake_labels(names)
    parts = PartCache(resources.cache_folder())  # components that variants have in common
    models = {name: _model(name, parts) for name in names if not is_table(name)}
    return [Given(label, models[name]) if name in models
            else Given(label, _model_of(name, list(models.values())), name)
            for label, name in zip(labels, names, strict=True)]


def brake_labels(names: Sequence[str]) -> list[str]:
    """Return short names, with suffix and as many folders as tell one from the other."""
    paths = [Path(name) for name in names]
    labels = [path.stem for path in paths]
    for depth in range(1, 1 + max(len(path.parts) for path in paths)):
        labels = [label if labels.count(label) == 1 else '/'.join(path.parts[-depth:])
                  for label, path in zip(labels, paths, strict=True)]
    if len(set(labels)) < len(labels):  # the same one again
        labels = [f'{label} ({place})' for place, label in enumerate(labels, 1)]
    return labels


def _model(name: str, parts: PartCache) -> BrakeModel:
    if not is_description(name):
        return BrakeModel.load(name)
    brake = read_brake(shipped('brakes', name, '.yaml'), warn=warn)
    return build_model(brake, parts=parts,
                       progress=lambda text: report_progress(f'{name}: {text}'))


def _model_of(table: str, models: Sequence[BrakeModel]) -> BrakeModel:
    """Return the model whose table it is: of those given, else of those shipped."""
    wanted = read_table_header(table)['model']
    for model in (*models, *map(BrakeModel.load, resources.names('models', '.npz'))):
        if model_hash(model) == wanted:
            return model
    raise SquealError(f'{table}: is the table of a model that is neither given nor shipped; give '
                      'the model file, too')


def _compared(one: Given, point: OperatingPoint, bounds: tuple[float, float]) -> ComparedBrake:
    if one.table:
        return compared_table(one.name, read_table(one.table, one.model), one.model, point)
    return compared_model(one.name, one.model, point, bounds=bounds, progress=report_progress)


def _risks(given: Sequence[Given], driven: tuple[Drive, Vehicle],
           options: argparse.Namespace) -> list[DriveRisk]:
    """Return the risk of each brake over the drive, by its own friction and emulator."""
    settings = load_settings(resources.config_folder() / 'monitor.yaml')
    settings, result = replace(settings, rate=_DRIVE_RATE), []
    for one in given:
        if one.model.friction_table is None or one.model.caliper is None:
            lacks = 'caliper' if one.model.caliper is None else 'friction table over temperature'
            result.append(DriveRisk(unknown=f'this model has no {lacks}'))
            continue
        if find_emulator(one.model) is None:
            build_emulator_file(cached_emulator_path(one.model), one.model, overwrite=True,
                                workers=options.workers,
                                of=f' for the growth emulator of {one.name}')
        signals = signals_of(*driven, one.model, rate=10.0, duration=options.duration)
        with ProgressBar(f'ticks of {one.name}') as progress:
            result.append(drive_risk(one.model, signals, settings, progress))
    return result


_Row = list[ComparedMode | None]


def shown_rows(result: BrakeComparison, band_hz: tuple[float, float], *,
               every: bool = False) -> list[_Row]:
    """Return the modes of a band; those that are stable in all only where every one is wanted."""
    low, high = band_hz
    return [row for row in result.rows() if any(
        mode is not None and low <= mode.frequency_hz <= high
        and (every or mode.unstable or not math.isnan(mode.critical_friction))
        for mode in row)]


def _as_json(result: BrakeComparison, rows: Sequence[_Row], risks: Sequence[DriveRisk],
             points: Sequence[OperatingPoint], options: argparse.Namespace) -> dict[str, Any]:
    return {
        'brakes': [{
            'name': one.name, 'given': given, 'point': asdict(point),
            'matched_by': '' if place == 0 else result.matches[place - 1].basis,
            'critical_friction_known': one.boundaries_known,
            'drive_risk': asdict(risks[place]) if risks else None}
            for place, (one, given, point) in enumerate(zip(
                result.brakes, options.brakes, points, strict=True))],
        'drive': options.drive,
        'modes': [[None if mode is None else {**mode._asdict(), 'mac': mac_of(result, row, place)}
                   for place, mode in enumerate(row)] for row in rows]}


def _lines(result: BrakeComparison, rows: Sequence[_Row], risks: Sequence[DriveRisk],
           points: Sequence[str], options: argparse.Namespace) -> list[str]:
    first, lines = result.brakes[0], [*points]
    lines += [f'{other.name}: modes matched with those of {first.name} by {match.basis}'
              for other, match in zip(result.brakes[1:], result.matches, strict=True)]
    lines += [f'{one.name}: critical friction is not known, as a table does not follow modes'
              for one in result.brakes if not one.boundaries_known]
    width = max(len(one.name) for one in result.brakes)
    lines.append(f'{"brake":{width}} {"mode":>9} {"Hz":>10} {"shift %":>8} {"growth 1/s":>11} '
                 f'{"damping ratio":>14} {"critical friction":>18} {"MAC":>6}')
    for row in rows:
        lines += [_line(one.name, row[0], mode, mac_of(result, row, place), width)
                  for place, (one, mode) in enumerate(zip(result.brakes, row, strict=True))]
    if not rows:
        lines.append('no mode of the band is unstable at the point, or at any friction up to '
                     'the bound (--all lists stable ones)')
    lines += [_risk_line(one.name, risk, options.drive)
              for one, risk in zip(result.brakes, risks, strict=False)]
    return lines


def _conditions(given: Sequence[Given], points: Sequence[OperatingPoint]) -> str:
    """Return the operating point for a plot: of the first brake where they differ."""
    from squeal_core.view.slide import point_words
    words = [point_words(point, brake_pressure(one.model, point))
             for one, point in zip(given, points, strict=True)]
    return words[0] if len(set(words)) == 1 else (
        f'{given[0].name}: {words[0]}; others at their own friction, pressure and stiffness')


def _points_in_words(given: Sequence[Given], points: Sequence[OperatingPoint]) -> list[str]:
    """Return the operating point, of each brake where it is not the same for all."""
    words = [point_in_words(one.model, point) for one, point in zip(given, points, strict=True)]
    if len(set(words)) == 1:
        return words[:1]
    return [f'{one.name}: {text}' for one, text in zip(given, words, strict=True)]


def _line(name: str, first: ComparedMode | None, mode: ComparedMode | None, mac: float,
          width: int) -> str:
    if mode is None:
        return f'{name:{width}} {"none":>9}'
    shift = (f'{100.0 * (mode.frequency_hz / first.frequency_hz - 1.0):+8.2f}'
             if first is not None and first is not mode else f'{"":8}')
    critical, own = (f'{value:.4f}' if not math.isnan(value) else '-'
                     for value in (mode.critical_friction, mac))
    return (f'{name:{width}} {mode.identity:>9} {mode.frequency_hz:10.2f} {shift} '
            f'{mode.growth_rate:+11.3f} {mode.damping_ratio:+14.6f} {critical:>18} {own:>6}')


def _risk_line(name: str, risk: DriveRisk, drive: str) -> str:
    if risk.unknown:
        return f'{name}: squeal risk over {drive} is not known: {risk.unknown}'
    return (f'{name}: squeal risk over {drive}: mean {risk.mean_risk:.3f}, largest '
            f'{risk.peak_risk:.3f} while braking; alarm in {risk.alarm_s:.0f} of '
            f'{risk.braking_s:.0f} s of braking (all brakes); known for '
            f'{risk.known_share:.0%} of it')
