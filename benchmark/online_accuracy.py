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
The fast engine against the full solver at random points of the whole range.

Run: python benchmark/online_accuracy.py [--points 20000] [--model kang2009] [--seed 0] [--json]

Points come in groups: a random one of the range (rotor speed 0.5-200 rad/s, preload 50-40,000 N,
friction 0.05-0.9, slope -0.3-0.1 s/m, contact stiffness 0.1-3 times nominal), and others up to
30 % away from it in every parameter. Exits with 1 where an error is beyond 0.1 1/s or a verdict is
wrong. Errors are those of growth rates that could matter, above -5 1/s, and of all others over
what is allowed: 0.1 1/s or 2 % of their decay.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from dataclasses import dataclass, fields  # noqa: I100
import json
import sys

from checking import check_options, said
import numpy as np
from scipy.optimize import linear_sum_assignment

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import complex_modes, ComplexModes
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver

GROUP = 20
LIMIT = 0.1  # 1/s
WIDEST = 0.3
OSCILLATION = 1.0  # rad/s


@dataclass
class Worst:
    """What was seen so far; errors of answers from the table alone."""

    points: int = 0
    from_table: int = 0
    worst_growth_rate: float = 0.0  # of modes above -5 1/s
    worst_of_allowed: float = 0.0
    worst_of_estimate: float = 0.0  # of errors above 1e-4 1/s
    beyond_estimate: int = 0  # points with such a root
    missed: int = 0
    invented: int = 0

    def add(self, found: ComplexModes, truth: ComplexModes) -> None:
        self.points += 1
        if found.source != 'table':
            return
        self.from_table += 1
        ours, theirs = (m.mode_eigenvalues[m.mode_eigenvalues.imag > OSCILLATION]
                        for m in (found, truth))
        errors = found.errors[found.mode_eigenvalues.imag > OSCILLATION]
        place, true = linear_sum_assignment(np.abs(ours[:, None] - theirs))
        off = np.abs(ours[place].real - theirs[true].real)
        whole = np.abs(ours[place] - theirs[true])
        growth = theirs[true].real
        self.worst_growth_rate = max(self.worst_growth_rate,
                                     float(off[growth > -5.0].max(initial=0.0)))
        self.worst_of_allowed = max(self.worst_of_allowed, float(
            (off / np.maximum(LIMIT, -0.02 * growth)).max(initial=0.0)))
        beyond = (whole / np.maximum(errors[place], 1e-12))[whole > 1e-4].max(initial=0.0)
        self.worst_of_estimate = max(self.worst_of_estimate, float(beyond))
        self.beyond_estimate += int(beyond > 1.0)
        # beyond +-0.1 1/s a verdict is not open to either
        self.missed += int(np.any((growth > LIMIT) & (ours[place].real <= 0.0)))
        self.invented += int(np.any((growth < -LIMIT) & (ours[place].real > 0.01)))
        self.missed += int(theirs.size > ours.size and bool(np.any(theirs.real > LIMIT)))

    @property
    def good(self) -> bool:
        return not self.missed and not self.invented and (
            max(self.worst_growth_rate / LIMIT, self.worst_of_allowed) <= 1.0)


def random_point(model: BrakeModel, generator: np.random.Generator) -> OperatingPoint:
    def spread(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    return OperatingPoint(
        rotor_speed=spread(0.5, 200.0), friction=generator.uniform(0.05, 0.9),
        friction_slope=generator.uniform(-0.3, 0.1),
        contact_pressure=spread(50.0, 40e3) / model.contact_area,
        contact_stiffness=model.nominal_contact_stiffness * spread(0.1, 3.0))


def near(start: OperatingPoint, generator: np.random.Generator) -> OperatingPoint:
    step = 10.0 ** generator.uniform(-2.7, np.log10(WIDEST))
    away: FloatArray = generator.uniform(-step, step, 5)
    values = {item.name: getattr(start, item.name) * float(1.0 + part)
              for item, part in zip(fields(OperatingPoint), away, strict=True)}
    values['friction_slope'] = start.friction_slope + 0.1 * float(away[2])
    return OperatingPoint(**values)


def main() -> int:
    options = check_options(__doc__.strip().splitlines()[0], points=20_000).parse_args()
    model, generator = BrakeModel.load(options.model), np.random.default_rng(options.seed)
    table, worst = TabulatedSolver(model, SolverSettings(audit_every=0)), Worst()
    while worst.points < options.points:
        start = random_point(model, generator)
        for at in (start, *(near(start, generator) for _ in range(GROUP - 1))):
            worst.add(table.complex_modes(at), complex_modes(model, at))
        said(f'{worst.points} points')
    figures = {**vars(worst), 'anchors_made': table.statistics.made, 'model': options.model,
               'modes': model.size, 'seed': options.seed}
    if options.json:
        print(json.dumps(figures))
    else:
        print('\n'.join(f'{name:20} {value}' for name, value in figures.items()))
    return 0 if worst.good else 1


if __name__ == '__main__':
    sys.exit(main())
