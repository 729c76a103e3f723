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
A table against full solutions: coverage, errors, verdicts, drives, memory and time of an answer.

Run: python benchmark/table.py TABLE.npz [--model kang2009] [--points 20000] [--seed 1]
     [--rotor-speed LOW HIGH] [--preload LOW HIGH] [--friction LOW HIGH]

Random points are even in ln rotor speed, ln preload and friction, in other ranges than those of
the table if given. Errors are of growth rates above -5 1/s, and of all kept modes over what is
allowed. Exits with 1 where an error is beyond 0.1 1/s or a verdict is wrong.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Callable
import resource
import sys
from time import perf_counter
from types import SimpleNamespace

import numpy as np
from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_domain import places_of
from squeal_core.surrogate.table_file import read_table
from squeal_core.surrogate.tabulated_solver import deviation, TabulatedSolver
from squeal_ros.cli.table_commands import driven_points

DRIVES = ('us06', 'wltc_3b', 'chicago_trip')
NEAR = -5.0  # 1/s, growth rates that could matter
LIMIT = 0.1  # 1/s
CHUNK = 2000


def main() -> int:
    """Print all figures; 1 where a limit is not kept."""
    options = _options()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    model = BrakeModel.load(options.model)
    begun = perf_counter()
    table = read_table(options.table, model)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f'{len(table.cells)} cells, read in {perf_counter() - begun:.2f} s, memory '
          f'{(after - before) / 1e3:.0f} MB more')
    _time(table, model)
    for drive in DRIVES:
        points = driven_points(model, SimpleNamespace(
            drive=drive, vehicle='midsize', duration=None))
        answered = table.evaluate(places_of(points), Tolerances.of(model)).answered
        print(f'{drive}: {answered.mean():.3%} of {len(points)} sliding points answered')
    return _errors(table, model, _random(model, options))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument('table')
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--points', type=int, default=20_000)
    parser.add_argument('--seed', type=int, default=1)
    for name, ends in (('rotor-speed', (1.0, 120.0)), ('preload', (100.0, 20_000.0)),
                       ('friction', (0.15, 0.65))):
        parser.add_argument(f'--{name}', type=float, nargs=2, default=ends)
    return parser.parse_args()


def _random(model: BrakeModel, options: argparse.Namespace) -> FloatArray:
    shares = np.random.default_rng(options.seed).random((options.points, 3))
    low, high = np.array([np.log(options.rotor_speed),
                          np.log(np.array(options.preload) / model.contact_area),
                          options.friction]).T
    return np.asarray(low + (high - low) * shares)


def _time(table: ExpansionTable, model: BrakeModel) -> None:
    """Print warm medians of an answer and of a full solution, taken in turns."""
    x = table.domain.low + table.domain.width * np.random.default_rng(0).random((40, 3))
    points = table.domain.points(model, x[table.evaluate(x, Tolerances.of(model)).answered])
    solver = TabulatedSolver(model, table, audit_every=0)
    full, single = [], []
    for i in range(len(points)):
        point = points[i]
        full.append(_seconds(lambda at=point: complex_modes(model, at)))
        single += [_seconds(lambda at=point: solver.solve(at)) for _ in range(20)]
    company = [points[i] for i in range(4)]
    four = np.median([_seconds(lambda: solver.solve_all(company)) for _ in range(100)])
    answer, whole = np.median(single), np.median(full)
    print(f'full solution {1e3 * whole:.2f} ms, an answer {1e6 * answer:.0f} us: '
          f'{whole / answer:.0f} times as fast; four brakes {1e6 * four:.0f} us')
    many = table.domain.low + table.domain.width * np.random.default_rng(2).random((20_000, 3))
    spent = _seconds(lambda: table.evaluate(many, Tolerances.of(model)))
    print(f'arrays of 20,000 random points: {1e6 * spent / len(many):.1f} us a point')


def _seconds(call: Callable[[], object]) -> float:
    begun = perf_counter()
    call()
    return perf_counter() - begun


def _errors(table: ExpansionTable, model: BrakeModel, x: FloatArray) -> int:
    """Compare all answers with full solutions; 1 where one is wrong."""
    limits = Tolerances.of(model)
    count = answered = missed = invented = 0
    near = allowed = band = 0.0
    for part in np.array_split(x, max(1, len(x) // CHUNK)):
        found, points = table.evaluate(part, limits), table.domain.points(model, part)
        listed = found.listed()
        for place in np.flatnonzero(found.answered).tolist():
            ours = listed[place]
            truth = complex_modes(model, points[place], tolerances=limits)
            theirs = truth.mode_eigenvalues
            away = np.abs(ours.mode_eigenvalues[:, None] - theirs)
            nearest = theirs[away.argmin(axis=1)].real
            off = np.abs(ours.mode_eigenvalues.real - nearest)[nearest > NEAR]
            near = max(near, float(off.max(initial=0.0)))
            allowed = max(allowed, deviation(ours, truth, table.tolerances))
            missed += len(truth.unstable) > len(ours.unstable)
            invented += len(truth.unstable) < len(ours.unstable)
            one, other = (m.worst_in(1250.0, 16e3) for m in (ours, truth))
            if other is not None:
                band = max(band, abs(one.growth_rate - other.growth_rate) if one else np.inf)
        count, answered = count + len(part), answered + int(found.answered.sum())
        print(f'{count} random points: {answered / count:.3%} answered; largest error of a growth '
              f'rate above {NEAR:g} 1/s {near:.4f} 1/s, of all kept modes {allowed:.3f} of the '
              f'tolerance, of the least stable mode in the band {band:.4f} 1/s; unstable modes '
              f'missed {missed}, invented {invented}', flush=True)
    return int(near > LIMIT or missed + invented > 0)


if __name__ == '__main__':
    sys.exit(main())
