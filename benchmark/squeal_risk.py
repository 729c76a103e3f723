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
The squeal risk of brake applications against independent brakes that are solved in full.

Run: python benchmark/squeal_risk.py [--model kang2009_damped] [--drive us06] [--points 4]
         [--brakes 200] [--rate 10] [--friction 0.42] [--seed 0] [--json]
     python benchmark/squeal_risk.py --over-drives

A brake has its own damping, contact stiffness, friction, slope and N*, drawn from the prior, and
scatter of this application; its modes come from a full solution at each tick and are followed by
frequency. An application's risk is the fraction of brakes in which a mode's build-up exceeds N*.
It is compared with that of the ensemble of 64 members and of 1024, by the emulator of the model,
and so is the instability probability at the middle tick. Exits with 1 where one of 64 is off by
more than 0.1 and three of its errors and the brakes' standard errors.

--over-drives instead prints the table of docs/explanation/risk.md: the largest risk in each brake
application of US06 and WLTC, at three kinds of friction.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Iterator  # noqa: I100
from dataclasses import replace
import json
import math
import sys

from checking import check_options, said
from drives import braking_samples, BrakingSample
import numpy as np

from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.build_up import saturation_energy
from squeal_core.risk.emulator_file import find_emulator
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.risk.squeal_risk import RiskResult, SquealRisk
from squeal_core.risk.tracked_build_up import TrackedBuildUp
from squeal_core.stability.eigensolution import SQUEAL_BAND

PRIOR = EnsemblePrior()
COUNTS = (64, 1024)
LONGEST = 40  # ticks


def applications(model: BrakeModel, drive: str, rate: float) -> Iterator[list[BrakingSample]]:
    """Yield the samples of each brake application of the front left brake."""
    own: list[BrakingSample] = []
    for sample in braking_samples(model, drive, rate=rate):
        if own and sample.time - own[-1].time > 1.5e9 / rate:
            yield own
            own = []
        own.append(sample)
    yield own


def operating_points(model: BrakeModel, samples: list[BrakingSample], z: FloatArray,
                     friction: float | None) -> list[OperatingPoint]:
    """Return where a brake of standard normal coordinates (7,) operates."""
    points = []
    shift = PRIOR.friction * z[2] + PRIOR.friction_scatter * z[6]
    for sample in samples:
        nominal = model.operating_point(
            rotor_speed=sample.rotor_speed, pressure=sample.pressure,
            friction=(friction or sample.friction) + shift)
        points.append(replace(
            nominal, friction_slope=nominal.friction_slope * min(max(
                1.0 + PRIOR.slope * z[3], 0.0), 2.0),
            contact_stiffness=nominal.contact_stiffness * math.exp(
                PRIOR.contact_stiffness * z[1]),
            damping_scale=math.exp(PRIOR.damping * z[0] + PRIOR.damping_scatter * z[5])))
    return points


def full(model: BrakeModel, samples: list[BrakingSample], z: FloatArray,
         friction: float | None) -> tuple[float, bool]:
    """Return the largest build-up of a brake, and whether it is unstable at the middle tick."""
    points = operating_points(model, samples, z, friction)
    tracked, largest, grows = TrackedBuildUp.of(model, points[0]), 0.0, []
    tracked.release(2 * samples[0].time - samples[1].time)
    for sample, point in zip(samples, points, strict=True):
        eigenvalues = complex_modes(model, point).oscillatory
        frequency = eigenvalues.imag / (2.0 * np.pi)
        eigenvalues = eigenvalues[(frequency >= SQUEAL_BAND[0]) & (frequency <= SQUEAL_BAND[1])]
        cap = float(saturation_energy(point.contact_pressure, point.contact_stiffness))
        largest = max(largest, float(tracked.update(sample.time, eigenvalues, cap).max()))
        grows.append(bool(eigenvalues.real.max() > 0.0))
    return largest, grows[len(grows) // 2]


def emulated(emulator: GrowthEmulator, model: BrakeModel, samples: list[BrakingSample],
             count: int, friction: float | None) -> list[RiskResult]:
    """Return the results of an ensemble at each tick."""
    risk = SquealRisk(emulator, prior_ensemble(replace(PRIOR, count=count)))
    load = [model.contact_pressure(sample.pressure) for sample in samples]
    application, found = ApplicationRisk(risk), []
    application.release(2 * samples[0].time - samples[1].time)
    for sample, one in zip(samples, load, strict=True):
        result = application.update(sample.time, risk.growth(
            sample.rotor_speed, one, friction or sample.friction,
            model.contact_stiffness_at(one)))
        if result is not None:  # None outside the emulator
            found.append(result)
    assert found, 'outside the emulator'
    return found


def over_drives(emulator: GrowthEmulator, model: BrakeModel, rate: float) -> None:
    """Print the risks of all brake applications of drives: count, quantiles, stated error."""
    for drive in ('us06', 'wltc_3b'):
        every = [own for own in applications(model, drive, rate) if len(own) > 1]
        for friction in (0.35, None, 0.45):
            ends = [emulated(emulator, model, samples, COUNTS[0], friction)[-1]
                    for samples in every]
            low, middle, high = np.quantile([one.peak_risk for one in ends], (0.1, 0.5, 0.9))
            print(f'| {drive} | {friction or "by temperature"} | {len(ends)} | {low:.2f}, '
                  f'{middle:.2f}, {high:.2f} | {np.mean([one.error for one in ends]):.2f} |',
                  flush=True)


def main() -> int:
    parser = check_options(__doc__.strip().splitlines()[0], points=4)
    parser.set_defaults(model='kang2009_damped')
    parser.add_argument('--drive', default='us06')
    parser.add_argument('--brakes', type=int, default=200)
    parser.add_argument('--rate', type=float, default=10.0)
    parser.add_argument('--friction', type=float, help="instead of the drive's")
    parser.add_argument('--over-drives', action='store_true', help='print the table of risks')
    options = parser.parse_args()
    model = BrakeModel.load(options.model)
    shipped = find_emulator(model)
    assert shipped is not None, 'this model has no emulator; run squeal tabulate --growth-only'
    emulator, rng = shipped[1], np.random.default_rng(options.seed)
    if options.over_drives:
        over_drives(emulator, model, options.rate)
        return 0
    every = [own[:LONGEST] for own in applications(model, options.drive, options.rate)
             if len(own) >= 8]
    rows, failed = [], False
    for number in rng.permutation(len(every))[:options.points].tolist():
        samples = every[number]
        brakes = []
        for one, z in enumerate(rng.standard_normal((options.brakes, 7))):
            audible = max(PRIOR.audible_build_up + PRIOR.audible_build_up_deviation * z[4], 1.0)
            largest, grows = full(model, samples, z, options.friction)
            brakes.append((largest > audible, grows))
            said(f'application {number}: {one + 1} brakes')
        wanted = np.mean(brakes, axis=0)
        few, many = (emulated(emulator, model, samples, count, options.friction)
                     for count in COUNTS)
        middle = len(samples) // 2
        row = {'application': number, 'ticks': len(samples), 'full': float(wanted[0]),
               '64': few[-1].peak_risk, 'error': few[-1].error, '1024': many[-1].peak_risk,
               'unstable full': float(wanted[1]),
               'unstable 64': few[middle].instability_probability}
        rows.append(row)
        sampled = math.sqrt(max(wanted[0] * (1.0 - wanted[0]), 0.01) / options.brakes)
        failed |= abs(row['64'] - row['full']) > 0.1 + 3.0 * math.hypot(sampled, row['error'])
        if not options.json:
            print('  '.join(f'{name} {value:.3g}' for name, value in row.items()), flush=True)
    if options.json:
        print(json.dumps(rows))
    return int(failed)


if __name__ == '__main__':
    sys.exit(main())
