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

"""`squeal advise`: quiet pressures of a brake, and the map of its risk for a control unit."""

import argparse
from collections.abc import Iterator
from dataclasses import asdict
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common import resources
from squeal_core.common.errors import SquealError
from squeal_core.common.version import __version__
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.advice import AdviceSettings, bar, PressureAdvice, PressureAdviser
from squeal_core.monitor.settings import band_of, load_settings, MonitorSettings, read_settings
from squeal_core.monitor.vehicle_risk import OUTSIDE, VehicleRisk
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.studies.advice_files import FORMATS, write_advice_map
from squeal_core.studies.advice_map import advice_map, NOTICE
from squeal_core.surrogate.table_domain import PRELOAD
from squeal_core.surrogate.table_file import model_hash
from squeal_ros.cli.arguments import check_output, check_workers, positive
from squeal_ros.cli.console import plain, ProgressBar
from squeal_ros.cli.point_checks import check_point

MOST_POINTS = 100_000  # of a map


def advise(options: argparse.Namespace) -> int:
    """Print quiet pressures, or write the map."""
    _check(options)
    model = BrakeModel.load(options.model)
    chosen = load_settings(options.config) if options.config else read_settings({})
    if model.caliper is None:
        raise SquealError(f'{options.model}: has no caliper, so a pressure says nothing to it; '
                          'build it with one')
    hold = chosen.advice_hold if options.hold is None else options.hold
    risks = VehicleRisk(model, chosen)
    if options.output:
        return _map(model, chosen, risks, hold, options)
    result = _quiet(model, chosen, risks.squeal_risk, hold, options)
    if options.json:
        print(json.dumps(plain({'model': options.model, 'notice': NOTICE, 'hold': hold,
                                'points': [_as_json(*one) for one in result]})))
    else:
        print(NOTICE)
        for at, advice in result:
            print('\n'.join(_lines(at, advice, hold)))
    return 0 if any(advice.intervals for _, advice in result) else 1


def _check(options: argparse.Namespace) -> None:
    """Refuse before the work options with which it would fail afterwards."""
    check_point(options)
    check_workers(options.workers)
    for path in options.output:
        check_output('--output', path, FORMATS, force=options.force,
                     inputs=(resources.find('models', options.model, '.npz'),))
    if options.hold is not None:
        positive('--hold', options.hold)
    for name in ('bounds', 'speeds', 'frictions'):
        low, high = getattr(options, name) or (1.0, 2.0)
        if not 0.0 < low < high < math.inf:
            raise SquealError(f'--{name}: {low:g} to {high:g}; give two positive numbers that '
                              'rise')
    if min(options.points) < 2 or math.prod(options.points) > MOST_POINTS:
        raise SquealError(f'--points: {options.points}; give at least 2 for each axis and at most '
                          f'{MOST_POINTS} in all')


def _bounds(model: BrakeModel, options: argparse.Namespace) -> tuple[float, float]:
    """Return those of the pressure [Pa]."""
    assert model.caliper is not None
    per_pressure = model.caliper.preload(1.0)
    low, high = options.bounds or (force / per_pressure for force in PRELOAD)
    return low, high


def _quiet(model: BrakeModel, chosen: MonitorSettings, risk: SquealRisk | None, hold: float,
           options: argparse.Namespace) -> list[tuple[SlidingConditions, PressureAdvice]]:
    """Return the advice at each speed and friction."""
    adviser = PressureAdviser(
        model, AdviceSettings(band_hz=band_of(chosen), pressure=_bounds(model, options),
                              error=0.0, hold=hold),
        Tolerances.of(model, growth=chosen.growth_threshold), risk=risk)
    present = math.nan if options.pressure is None else options.pressure
    jobs = {place: (adviser, SlidingConditions(rotor_speed=speed, pressure=present, friction=mu))
            for place, (speed, mu) in enumerate(_speeds_and_frictions(model, options))}
    result: dict[int, PressureAdvice] = {}
    with ProgressBar('conditions') as progress:
        for place, advice in run_jobs(PressureAdviser.__call__, jobs, options.workers):
            result[place] = advice
            progress(len(result), len(jobs))
    return [(at, result[place]) for place, (_, at) in jobs.items()]


def _speeds_and_frictions(model: BrakeModel, options: argparse.Namespace
                          ) -> Iterator[tuple[float, float]]:
    law, table = model.friction_law, model.friction_table
    for speed in options.rotor_speed:
        if options.friction:
            yield from ((speed, friction) for friction in options.friction)
        elif options.temperature is not None:
            if table is None:
                raise SquealError('--temperature: this model has no friction table; give '
                                  '--friction')
            yield speed, float(table(options.temperature + 273.15))
        elif law is not None:
            yield speed, law.coefficient(model.contact_radius * speed)
        else:
            raise SquealError('this model has no friction law; give --friction')


def _as_json(at: SlidingConditions, advice: PressureAdvice) -> dict[str, Any]:
    return {'rotor_speed': at.rotor_speed, 'friction': at.friction, **asdict(advice)}


def _lines(at: SlidingConditions, advice: PressureAdvice, hold: float) -> Iterator[str]:
    yield f'{at.rotor_speed:g} rad/s, friction {at.friction:.4g}: {advice.reason}'
    if math.isnan(advice.present):
        return
    for name, pressure, confidence, towards in (
            ('below', advice.below, advice.confidence_below, -math.inf),
            ('above', advice.above, advice.confidence_above, math.inf)):
        where = 'none' if math.isnan(pressure) else f'{bar(pressure, towards)} bar'
        chance = '' if math.isnan(confidence) else (
            f', quiet for {hold:g} s with a probability of {confidence:.2f}')
        yield f'  nearest quiet pressure {name} {advice.present / 1e5:.2f} bar: {where}{chance}'


def _map(model: BrakeModel, chosen: MonitorSettings, risks: VehicleRisk, hold: float,
         options: argparse.Namespace) -> int:
    """Compute the map and write it; 1 where no risk is known anywhere."""
    if risks.squeal_risk is None and {Path(path).suffix for path in options.output} != {'.csv'}:
        raise SquealError(f'--output: C would hold no risk, as {risks.unknown}; or write a .csv, '
                          'which has growth rates')
    (low, high), (slow, fast), (least, most) = (
        _bounds(model, options), options.speeds, options.frictions)
    counts = options.points
    with ProgressBar('columns') as progress:
        result = advice_map(
            model, np.geomspace(low, high, counts[0]), np.geomspace(slow, fast, counts[1]),
            np.linspace(least, most, counts[2]), risk=risks.squeal_risk, hold=hold,
            about=_about(options.model, model, chosen, risks, hold), band_hz=band_of(chosen),
            tolerances=Tolerances.of(model, growth=chosen.growth_threshold),
            workers=options.workers, progress=progress)
    write_advice_map(result, *options.output, overwrite=options.force)
    known = int(np.isfinite(result.risk).sum())
    others = f' (the others are {OUTSIDE})' if 0 < known < result.risk.size else ''
    summary = {'output': options.output, 'points': result.risk.size, 'risks_known': known,
               'stable_points': int((result.growth_rate <= chosen.growth_threshold).sum()),
               **result.about}
    print(json.dumps(plain(summary)) if options.json else
          f'{", ".join(options.output)}: {result.risk.size} points, {known} with a risk'
          f'{others}, {summary["stable_points"]} stable')
    return 0 if known else 1


def _about(name: str, model: BrakeModel, chosen: MonitorSettings, risks: VehicleRisk,
           hold: float) -> dict[str, str]:
    """Return the description of a map, by key."""
    low, high = band_of(chosen)
    about = {
        'model': name, 'model hash': f'sha256 {model_hash(model)}',
        'made by': f'squeal_ros {__version__}',
        'risk': f'probability that the brake squeals within {hold:g} s from the noise floor where '
                f'the conditions are held; squeal band {low:g} to {high:g} Hz',
        'growth rate': 'of the least stable mode of the nominal brake, 1/s, by full solutions',
        'pressure': 'of one brake, gauge', 'friction': 'its slope over speed by the friction law'}
    risk = risks.squeal_risk
    if risk is None:
        return {**about, 'valid': f'no risk is known: {risks.unknown}'}
    return {**about, 'rests on': risk.basis, 'error of growth rates':
            f'{risk.emulator.error.rms:.2g} 1/s rms', 'valid':
            'steady sliding at points and between them; no risk is known outside the axes and '
            'outside the range of the growth emulator (`squeal info MODEL` shows it)'}
