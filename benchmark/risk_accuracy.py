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
The precomputed risk against full solutions of samples, at random points of the usual envelope.

Run: python benchmark/risk_accuracy.py [--points 40] [--samples 512] [--friction 0.15 0.65]
         [--seed 0] [--json]

In the whole squeal band K09's brake is unstable nearly everywhere, so the band is cut into nine
parts. At each point the samples, drawn once for all parts, are solved in full. Where at least one
part has an open risk (0.03 to 0.97), the map around the point, with its nodes at random places, is
built for one of these parts and compared with the fraction of samples in which a mode grows.
Exits with 1 where one is off by more than 0.02 and two standard errors of the sample.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Sequence  # noqa: I100
from itertools import pairwise
import json
import math
import sys

from checking import check_options, said
import numpy as np
from scipy.stats import norm, qmc

from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.growth_grid import FRICTION_STEP, PRESSURE_STEP, SPEED_STEP
from squeal_core.risk.map_builder import build_operating_map, criterion_of
from squeal_core.risk.uncertainty import InputUncertainty, RiskParameters
from squeal_core.stability.eigensolution import eigenvalues

ENDS_HZ = (1250.0, 1500.0, 2000.0, 3000.0, 4000.0, 5000.0, 6500.0, 8000.0, 12000.0, 16000.0)
UNCERTAINTY = InputUncertainty(
    friction=0.02, pressure=0.03, rotor_speed=0.01, contact_stiffness=0.1)
PARTS = tuple(RiskParameters(band_hz=band, growth_threshold=0.01, uncertainty=UNCERTAINTY)
              for band in pairwise(ENDS_HZ))
LOW, HIGH = (1.0, 100.0), (120.0, 2e4)  # rotor speed, preload
LEAST = 0.001  # friction at which maps begin
OPEN = (0.03, 0.97)
WITHIN = 0.02


def sampled(model: BrakeModel, place: FloatArray, samples: int, seed: int) -> FloatArray:
    """Return the fraction of samples in which a mode of each part grows (parts,)."""
    assert model.caliper is not None
    speed, preload, friction = place.tolist()
    pressure = preload / model.caliper.preload(1.0)
    criteria = [criterion_of(model, part) for part in PARTS]
    grows = np.zeros(len(PARTS))
    deviation = min(UNCERTAINTY.friction, 0.5 * friction)
    for z in norm.ppf(qmc.Sobol(4, seed=seed).random(samples)).tolist():
        there = pressure * (1.0 + UNCERTAINTY.pressure * z[0])
        nominal = model.contact_stiffness_at(model.contact_pressure(there))
        found = eigenvalues(model, model.operating_point(
            rotor_speed=speed * (1.0 + UNCERTAINTY.rotor_speed * z[1]), pressure=there,
            friction=max(friction + deviation * z[2], 0.0),
            contact_stiffness=nominal * math.exp(UNCERTAINTY.contact_stiffness * z[3])))
        grows += [criterion.excess(found).max() > 0.0 for criterion in criteria]
    return np.asarray(grows / samples)


def mapped(model: BrakeModel, place: FloatArray, part: RiskParameters, shift: FloatArray) -> float:
    """Return the risk by the cell of a map that has the point at a place (3,) of the unit cube."""
    steps = np.array([SPEED_STEP, PRESSURE_STEP, FRICTION_STEP])
    low = np.array([*np.log(place[:2]), place[2]]) - shift * steps
    high = low + 0.999 * steps  # one cell
    speed, preload = (tuple(np.exp(ends).tolist()) for ends in zip(low[:2], high[:2], strict=True))
    found = build_operating_map(model, part, rotor_speed=speed, preload=preload,
                                friction=(max(float(low[2]), LEAST), float(high[2])), checks=0)
    return float(found.risk_at(place[0], place[1] / model.contact_area, place[2]))


def compared(model: BrakeModel, points: int, samples: int, seed: int,
             frictions: Sequence[float]) -> FloatArray:
    """Return the risks by the map and by the samples (n, 2), one row for each open point."""
    rng, found = np.random.default_rng(seed), []
    for number in range(points):
        place = np.array([*np.exp(rng.uniform(np.log(LOW), np.log(HIGH))),
                          rng.uniform(*frictions)])
        risks = sampled(model, place, samples, number)
        open_ = np.flatnonzero((risks > OPEN[0]) & (risks < OPEN[1]))
        if open_.size:
            part = int(rng.choice(open_))
            found.append((mapped(model, place, PARTS[part], rng.random(3)), risks[part]))
        said(f'{number + 1} of {points} points, open: {len(found)}')
    return np.array(found).reshape(-1, 2)


def figures(risks: FloatArray, samples: int) -> dict[str, float]:
    """Return what the comparison comes to."""
    off = np.abs(risks[:, 0] - risks[:, 1])
    errors = np.sqrt(np.maximum(risks[:, 1] * (1.0 - risks[:, 1]), 1.0 / samples) / samples)
    return {'open_points': len(risks), 'samples': samples,
            'largest_difference': float(off.max(initial=0.0)),
            'rms': float(np.sqrt(np.mean(off**2))) if off.size else 0.0,
            'beyond': int(np.count_nonzero(off > WITHIN + 2.0 * errors))}


def main() -> int:
    parser = check_options(__doc__.strip().splitlines()[0], points=40)
    parser.add_argument('--samples', type=int, default=512)
    parser.add_argument('--friction', type=float, nargs=2, default=(0.15, 0.65))
    options = parser.parse_args()
    model = BrakeModel.load(options.model)
    risks = compared(model, options.points, options.samples, options.seed, options.friction)
    found = figures(risks, options.samples)
    if options.json:
        print(json.dumps({**found, 'model': options.model, 'seed': options.seed}))
    else:
        print('\n'.join(f'{name:26} {value}' for name, value in found.items()))
    return 1 if found['beyond'] else 0


if __name__ == '__main__':
    sys.exit(main())
