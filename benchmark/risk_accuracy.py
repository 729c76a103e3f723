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
The summed risk against samples of the fast engine, at points of the US06 drive.

Run: python benchmark/risk_accuracy.py [--points 200] [--samples 20000] [--seed 0] [--json]

K09's brake squeals all along that drive in the whole squeal band, so its nine parts are looked at
one by one. Points are taken at random from the front left wheel's braking, where a few samples
find the risk of two parts at least open: between 0.05 and 0.95. At each of them the risks of all
nine are compared with the part of the samples in which a mode grows. Exits with 1 where one is
off by more than 0.02 and two standard errors of the sample.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from itertools import pairwise  # noqa: I100
import json
import math
import sys

from checking import check_options, said
from drives import braking_samples
import numpy as np

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.probability import Inputs, InputUncertainty
from squeal_core.risk.risk_table import RiskSettings, RiskTable
from squeal_core.surrogate.batch import batch_modes, OperatingPoints
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver

ENDS_HZ = (1250.0, 1500.0, 2000.0, 3000.0, 4000.0, 5000.0, 6500.0, 8000.0, 12000.0, 16000.0)
BANDS_HZ = tuple(pairwise(ENDS_HZ))
DEVIATIONS = InputUncertainty(friction=0.02, pressure=0.03, rotor_speed=0.01,
                              contact_stiffness=0.1)
PILOT = 60  # samples by which a point is taken or left
OPEN = (0.05, 0.95)
WITHIN = 0.02
UNDECIDED = (0.02, 0.98)


class Sampler:
    """Draws inputs around a point and finds the probabilities of growth among them."""

    def __init__(self, model: BrakeModel, generator: np.random.Generator) -> None:
        self._model, self._generator = model, generator
        self._table = TabulatedSolver(model, SolverSettings(audit_every=0))

    def probabilities(self, at: Inputs, count: int) -> FloatArray:
        """Return the part of the samples in which a mode of each band grows (bands,)."""
        points = [self._point(at, steps) for steps in
                  self._generator.standard_normal((count, 4)).tolist()]
        names = ('rotor_speed', 'friction', 'contact_pressure', 'contact_stiffness',
                 'friction_slope')
        found = batch_modes(self._table, OperatingPoints.of(
            **{name: [getattr(point, name) for point in points] for name in names}))
        level = found.tolerances.growth
        return np.array([np.mean(found.growth_rates(*band) > level) for band in BANDS_HZ])

    def _point(self, at: Inputs, steps: list[float]) -> OperatingPoint:
        speed, pressure, friction, stiffness = steps
        pressure = at.pressure * (1.0 + DEVIATIONS.pressure * pressure)
        nominal = self._model.contact_stiffness_at(self._model.contact_pressure(pressure))
        return self._model.operating_point(
            rotor_speed=at.rotor_speed * (1.0 + DEVIATIONS.rotor_speed * speed),
            pressure=pressure, friction=at.friction + DEVIATIONS.friction * friction,
            contact_stiffness=nominal * math.exp(DEVIATIONS.contact_stiffness * stiffness))


def places(model: BrakeModel, sampler: Sampler, generator: np.random.Generator,
           count: int) -> list[Inputs]:
    """Return points at which the risk of two bands is open, in the order of the drive."""
    drive, found = braking_samples(model, 'us06'), {}
    for place in generator.permutation(len(drive)).tolist():
        sample = drive[place]
        at = Inputs(
            rotor_speed=sample.rotor_speed, pressure=sample.pressure, friction=sample.friction,
            contact_stiffness=model.contact_stiffness_at(
                model.contact_pressure(sample.pressure)))
        pilot = sampler.probabilities(at, PILOT)
        if np.count_nonzero((pilot > OPEN[0]) & (pilot < OPEN[1])) >= 2:
            found[place] = at
            said(f'{len(found)} points taken')
        if len(found) == count:
            break
    return [found[place] for place in sorted(found)]


def compared(model: BrakeModel, sampler: Sampler, points: list[Inputs],
             samples: int) -> tuple[FloatArray, FloatArray]:
    """Return the risks, and what the samples say of them (points, bands)."""
    tables = [RiskTable(model, band, RiskSettings(memory=20e6)) for band in BANDS_HZ]
    engine, risks, parts = TabulatedSolver(model), [], []
    for at in points:
        modes = engine.complex_modes(model.operating_point(
            rotor_speed=at.rotor_speed, pressure=at.pressure, friction=at.friction))
        risks.append([table.assess(at, modes, DEVIATIONS).probability for table in tables])
        parts.append(sampler.probabilities(at, samples))
        said(f'{len(risks)} of {len(points)} points compared')
    return np.array(risks), np.array(parts)


def figures(risks: FloatArray, parts: FloatArray, samples: int) -> dict[str, float]:
    """Return what the comparison comes to."""
    off = np.abs(risks - parts)
    errors = np.sqrt(np.maximum(parts * (1.0 - parts), 1.0 / samples) / samples)
    worst = int(off.argmax())
    return {
        'points': len(risks), 'samples': samples, 'comparisons': off.size,
        'undecided': int(np.count_nonzero((parts >= UNDECIDED[0]) & (parts <= UNDECIDED[1]))),
        'largest_difference': float(off.flat[worst]),
        'two_standard_errors_there': 2.0 * float(errors.flat[worst]),
        'rms': float(np.sqrt(np.mean(off**2))),
        'beyond': int(np.count_nonzero(off > WITHIN + 2.0 * errors))}


def main() -> int:
    parser = check_options(__doc__.strip().splitlines()[0], points=200)
    parser.add_argument('--samples', type=int, default=20_000)
    options = parser.parse_args()
    model, generator = BrakeModel.load(options.model), np.random.default_rng(options.seed)
    sampler = Sampler(model, generator)
    points = places(model, sampler, generator, options.points)
    found = figures(*compared(model, sampler, points, options.samples), options.samples)
    if options.json:
        print(json.dumps({**found, 'model': options.model, 'seed': options.seed}))
    else:
        print('\n'.join(f'{name:26} {value}' for name, value in found.items()))
    return 1 if found['beyond'] else 0


if __name__ == '__main__':
    sys.exit(main())
