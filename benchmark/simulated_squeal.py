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
Calibration on brakes whose squeal was simulated: the figures of docs/howto/calibration.md.

Run: python benchmark/simulated_squeal.py FOLDER [--seeds 3] [--first 0] [--applications 120]
     [--folds 2] [--json]

Each seed is a brake of the prior that squeals in 15 to 85 % of its applications by the growth
emulator. What applications of 1.5 s do is integrated in the time domain, where no growth rate is
in it: squeal is an event of 70 dB. Friction (0.02) and ln damping (0.15) scatter between them, and
5 % of the labels are wrong. Each half of them, or fewer with more folds, is scored with a
calibration by the others. What was simulated, four seconds of processor time an application, is
kept in FOLDER and read from there the next time.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Iterator
import json
import math
from pathlib import Path
import sys
import time

from calibration import figures, lines, MODEL, shipped
from checking import said
import numpy as np

from squeal_core import BrakeModel
from squeal_core.calibration.applications import BrakeApplication
from squeal_core.common.arrays import FloatArray
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.ensemble import EnsemblePrior
from squeal_core.risk.risk_records import GrowthSource
from squeal_core.simulation import contact_points, first_events, OperatingHistory
from squeal_core.stability.eigensolution import SQUEAL_BAND

sys.path.insert(0, str(Path(__file__).parents[1] / 'test'))
from support.heard_brakes import (  # noqa: E402
    brake_applications,
    fitted,
    random_brake,
    Stops,
    TICK,
    Trial,
    Truth,
)

MOST = 120  # applications of a brake
WRONG = 0.05  # labels
STOPS = Stops((20.0, 95.0), friction=(0.34, 0.48), duration=(1.5, 1.5))
SCATTER = (0.02, 0.15)  # of friction and of ln damping
AUDIBLE = 5.3  # nepers from 1 nm to 70 dB, as 110 dB are 9.9
PRIOR = EnsemblePrior(audible_build_up=AUDIBLE, audible_build_up_deviation=0.0)


def history_of(model: BrakeModel, one: BrakeApplication, values: FloatArray,
               friction: float) -> OperatingHistory:
    """Return where a brake operates, from half a tick before the first to after the last."""
    time, speed, pressure, measured = (np.pad(part, 1, 'edge') for part in (
        one.time, one.rotor_speed, one.contact_pressure, one.friction))
    time[[0, -1]] += (-0.5 * TICK, 0.5 * TICK)
    own = measured + values[2] + friction
    slope, stiffness = sliding_laws(model, speed, pressure, own)
    return OperatingHistory(brakes=('fl',), time=time, **{
        name: part[:, None] for name, part in (
            ('rotor_speed', speed), ('contact_pressure', pressure), ('friction', own),
            ('friction_slope', values[3] * slope),
            ('contact_stiffness', stiffness * math.exp(values[1])))})


def simulated(model: BrakeModel, applications: list[BrakeApplication], values: FloatArray,
              rng: np.random.Generator, seed: int) -> Truth:
    """Return what applications do in the time domain; how probable it was is not known."""
    own = SCATTER * rng.standard_normal((len(applications), 2))
    begun = time.process_time()
    events = first_events(
        model, contact_points(model),
        [history_of(model, one, values, shift[0])
         for one, shift in zip(applications, own, strict=True)],
        [1000 * seed + i for i in range(len(applications))],
        damping_scales=np.exp(values[0] + own[:, 1]).tolist(),
        progress=lambda done: said(f'seed {seed}: {done} of {len(applications)} applications, '
                                   f'{time.process_time() - begun:.0f} s'))
    return Truth(np.full(len(events), np.nan), np.array([one is not None for one in events]),
                 np.array([one.frequency_hz if one else np.nan for one in events]))


def noted(truth: Truth, rng: np.random.Generator) -> Truth:
    """Return the truth with wrong labels, of events at random pitches."""
    heard = truth.squealed ^ (rng.random(truth.squealed.size) < WRONG)
    random = np.exp(rng.uniform(*np.log(SQUEAL_BAND), heard.size))
    return truth._replace(squealed=heard, frequency_hz=np.where(
        truth.squealed, truth.frequency_hz, random))


def simulated_trials(model: BrakeModel, source: GrowthSource, seed: int, count: int, folds: int,
                     folder: Path) -> Iterator[Trial]:
    """Yield the scores of each fold of one brake; keep what was simulated."""
    rng = np.random.default_rng(seed)
    applications = brake_applications(rng, MOST, STOPS)
    values = random_brake(source, applications, PRIOR, rng)
    path = folder / f'seed_{seed}_{count}.npz'
    if not path.exists():
        truth = simulated(model, applications[:count], values, np.random.default_rng(seed + 1),
                          seed)
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(path, **truth._asdict())
    with np.load(path) as kept:
        truth = Truth(**kept)
    said(f'seed {seed}: {truth.squealed.sum()} of {count} squealed')
    truth = noted(truth, rng)
    for held in np.array_split(np.random.default_rng(seed).permutation(count), folds):
        order = np.append(np.setdiff1d(np.arange(count), held), held)
        yield fitted(model, source, [applications[i] for i in order],
                     Truth(*(part[order] for part in truth)), rng, prior=EnsemblePrior(),
                     seed=seed, train=count - held.size, test=held.size, wrong=0.0, events=False)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('folder', type=Path)
    parser.add_argument('--seeds', type=int, default=3, metavar='N')
    parser.add_argument('--first', type=int, default=0, metavar='SEED')
    parser.add_argument('--applications', type=int, default=MOST, metavar='N')
    parser.add_argument('--folds', type=int, default=2, metavar='N')
    parser.add_argument('--json', action='store_true')
    options = parser.parse_args()
    model, source, begun = BrakeModel.load(MODEL), shipped(), time.process_time()
    trials = [one for seed in range(options.first, options.first + options.seeds)
              for one in simulated_trials(model, source, seed, options.applications,
                                          options.folds, options.folder)]
    row = {'scenario': 'simulated', **figures(trials),
           'seconds a seed': (time.process_time() - begun) / options.seeds}
    print(json.dumps(row) if options.json else '\n'.join(lines(row)))
    return 0


if __name__ == '__main__':
    sys.exit(main())
