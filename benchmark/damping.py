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
How often the brake is unstable while it brakes, by its damping.

The tables of docs/explanation/risk.md.

Run: python benchmark/damping.py [--rate 2] [--json]

First the shipped damped brake over the shipped drives, at two constant frictions: samples and
brake applications with a mode that grows in the squeal band. Then the share of unstable samples of
US06 for damping ratios of 0.2 to 0.8 %, the loss factor of the contact being that of the brake.
The friction slope is the friction law's, scaled to the friction; every sample is one operating
point, solved in full. Exits with 1 where the brake is not quiet
in most applications at the lower friction, or squeals in none at the higher one.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Sequence
from dataclasses import replace
import json
import os
import sys

from checking import said
from drives import braking_samples, BrakingSample, DRIVES
import numpy as np

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.common.worker_processes import run_jobs
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND

FRICTIONS = (0.35, 0.45)
RATIOS = (0.002, 0.0035, 0.005, 0.0065, 0.008)
GROWTH = 0.01  # 1/s, from which on a mode counts as unstable
_CHUNK = 50  # samples a worker takes at a time


def growth_rates(model: BrakeModel, samples: Sequence[BrakingSample],
                 friction: float | None) -> FloatArray:
    """Return the largest growth rate in the squeal band at each sample [1/s]."""
    points = [model.operating_point(rotor_speed=sample.rotor_speed, pressure=sample.pressure,
                                    friction=friction or sample.friction) for sample in samples]
    jobs = {start: (model, points[start:start + _CHUNK])
            for start in range(0, len(points), _CHUNK)}
    found = dict(run_jobs(_growth_rates, jobs, os.cpu_count() or 1))
    return np.concatenate([found[start] for start in jobs])


def _growth_rates(model: BrakeModel, points: Sequence[OperatingPoint]) -> list[float]:
    found = [complex_modes(model, point).worst_in(*SQUEAL_BAND) for point in points]
    return [-np.inf if mode is None else mode.growth_rate for mode in found]


def applications(samples: Sequence[BrakingSample], rate: float) -> IndexArray:
    """Return the number of the brake application that each sample is of."""
    times = np.array([1e-9 * sample.time for sample in samples])
    return np.concatenate([[0], np.cumsum(np.diff(times) > 1.5 / rate)])


def measure(rate: float) -> dict[str, list[list[float | str]]]:
    """Return the rows of both tables."""
    model = BrakeModel.load('kang2009_damped')
    samples = {drive: braking_samples(model, drive, rate=rate) for drive in DRIVES}
    by_drive: list[list[float | str]] = []
    for drive, own in samples.items():
        of = applications(own, rate)
        row: list[float | str] = [drive, len(own), int(of.max()) + 1]
        for friction in FRICTIONS:
            grows = growth_rates(model, own, friction) > GROWTH
            row += [float(grows.mean()), np.unique(of[grows]).size]
        by_drive.append(row)
        said(drive)
    by_ratio: list[list[float | str]] = []
    for ratio in RATIOS:
        other = replace(model, damping_ratios=ratio)
        by_ratio.append([ratio, *(
            float((growth_rates(other, samples['us06'], friction) > GROWTH).mean())
            for friction in (FRICTIONS[0], None, FRICTIONS[1]))])
        said(f'damping ratio {ratio}')
    return {'by_drive': by_drive, 'by_ratio': by_ratio}


def table(found: dict[str, list[list[float | str]]]) -> str:
    """Return both tables as text."""
    lines = [f'{"drive":14}{"samples":>8}{"brakings":>10}' + ''.join(
        f'{f"unstable at {friction}":>20}{"brakings":>10}' for friction in FRICTIONS)]
    lines += [f'{row[0]:14}{row[1]:8}{row[2]:10}{row[3]:20.1%}{row[4]:10}{row[5]:20.1%}{row[6]:10}'
              for row in found['by_drive']]
    lines += [f'{"damping ratio":14}{"at 0.35":>10}{"drive":>10}{"at 0.45":>10}  unstable on US06']
    return '\n'.join(lines + [f'{row[0]:<14.2%}' + ''.join(f'{share:10.1%}' for share in row[1:])
                              for row in found['by_ratio']])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--rate', type=float, default=2.0, metavar='HZ', help='of the samples')
    parser.add_argument('--json', action='store_true')
    options = parser.parse_args()
    found = measure(options.rate)
    print(json.dumps(found) if options.json else table(found))
    quiet = all(2 * row[4] < row[2] for row in found['by_drive'])  # type: ignore[operator]
    return 0 if quiet and any(row[6] for row in found['by_drive']) else 1


if __name__ == '__main__':
    sys.exit(main())
