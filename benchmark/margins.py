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

"""
Friction margins over a drive: share that is finite, error, cost.

Run: python benchmark/margins.py TABLE [--drive us06] [--rate 2] [--checks 20]

A margin is a function of its own conditions, so the share is the same at any rate of ticks.
Critical frictions are compared with `critical_value`, which solves in full. The cost is that of
four brakes at once, in full solutions of this process.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections import Counter
from collections.abc import Sequence
from functools import partial

from drives import braking_samples, DRIVES
from full_solve import median
import numpy as np
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.monitor.friction_scan import FrictionScan
from squeal_core.monitor.margin_evaluator import MarginEvaluator, table_growth
from squeal_core.monitor.margins import Margin, MarginSettings
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, Mode, SQUEAL_BAND, Tolerances
from squeal_core.surrogate.table_file import read_table

GROWTH_THRESHOLD = 0.01  # 1/s, the default


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('table')
    parser.add_argument('--drive', choices=DRIVES, default='us06')
    parser.add_argument('--rate', type=float, default=2.0, help='of assessments [Hz]')
    parser.add_argument('--checks', type=int, default=20, help='margins that are compared')
    options = parser.parse_args()
    model = BrakeModel.load('kang2009')
    limits = Tolerances.of(model, growth=GROWTH_THRESHOLD)
    evaluator = _evaluator(model, options.table, limits)
    conditions = [SlidingConditions(rotor_speed=at.rotor_speed, pressure=at.pressure,
                                    friction=at.friction)
                  for at in braking_samples(model, options.drive, brakes=4, rate=options.rate)]
    worst = _worst(model, conditions, limits)
    found = evaluator.friction_margins(conditions, worst)
    finite = [i for i, margin in enumerate(found) if np.isfinite(margin.value)]
    print(f'{options.drive} at {options.rate:g} Hz: {len(found)} steady assessments of four '
          f'brakes, {len(finite) / len(found):.2%} with a margin')
    for reason, count in Counter(_kind_of(margin) for margin in found).most_common():
        print(f'  {count:6} {reason}')
    checks = np.random.default_rng(0).permutation(finite)[:options.checks].astype(int).tolist()
    if checks:
        _print_errors(model, limits, [(conditions[i], found[i]) for i in checks])
    _print_cost(model, evaluator, conditions[:4], worst[:4])


def _evaluator(model: BrakeModel, path: str, limits: Tolerances) -> MarginEvaluator:
    table = read_table(path, model)
    settings = MarginSettings(
        band_hz=SQUEAL_BAND, friction=table.domain.friction, rotor_speed=table.domain.rotor_speed,
        pressure=(2e4, 1.6e7), error=table.tolerances.growth)
    growth = partial(table_growth, table, model, limits, SQUEAL_BAND)
    return MarginEvaluator(model, settings, limits, growth=growth, scan=FrictionScan(
        lambda rows: growth(rows, 'squeal').real, limits.growth, friction=settings.friction,
        rotor_speed=settings.rotor_speed, pressure=settings.pressure))


def _worst(model: BrakeModel, conditions: Sequence[SlidingConditions],
           limits: Tolerances) -> list[Mode | None]:
    """Return the least stable modes by full solutions."""
    return [complex_modes(model, model.operating_point(**vars(at)), tolerances=limits).worst_in(
        *SQUEAL_BAND) for at in conditions]


def _kind_of(margin: Margin) -> str:
    if np.isfinite(margin.value):
        return 'jump' if 'jump' in margin.reason else 'stability boundary'
    return 'outside the table' if 'outside' in margin.reason else 'no stability boundary'


def _print_errors(model: BrakeModel, limits: Tolerances,
                  checks: Sequence[tuple[SlidingConditions, Margin]]) -> None:
    errors, growth = [], []
    for at, margin in checks:
        point = model.operating_point(**vars(at))
        exact = critical_value(model, point, 'friction', (0.0, 1.0), tolerances=limits).nearest
        errors.append(abs(margin.critical - exact.value))
        there = model.operating_point(rotor_speed=at.rotor_speed, pressure=at.pressure,
                                      friction=margin.critical)
        mode = complex_modes(model, there, tolerances=limits).worst_in(*SQUEAL_BAND)
        growth.append(abs(mode.growth_rate - limits.growth) if mode else np.inf)
    for name, values, unit in (('critical friction', errors, '-'),
                               ('growth rate there', growth, '1/s')):
        print(f'error of the {name} [{unit}] at {len(values)}: median {np.median(values):.2g}, '
              f'largest {max(values):.2g}')


def _print_cost(model: BrakeModel, evaluator: MarginEvaluator,
                conditions: Sequence[SlidingConditions], worst: Sequence[Mode | None]) -> None:
    point = model.operating_point(**vars(conditions[0]))
    solve = median(lambda: complex_modes(model, point))
    cost = median(lambda: evaluator.friction_margins(conditions, worst))
    print(f'margins of four brakes {cost:.3f} ms, a full solution {solve:.2f} ms: '
          f'{cost / solve:.3f} of it')


if __name__ == '__main__':
    main()
