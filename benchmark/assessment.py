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
What assessing the brakes of a vehicle costs while braking: modes, margins and risk.

Run: python benchmark/assessment.py [--model kang2009] [--table TABLE.npz] [--drive us06]
[--seconds 60]

The braking samples of a drive at 100 Hz go through the monitor's evaluation, all brakes of a tick
at once; that of the risk is at 20 Hz. Processor times of one tick, in ms
and over a full solution (`numpy.linalg.eigvals` of the whole state matrix), solved again and again
in between.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Iterable
from dataclasses import replace
from itertools import groupby
from operator import attrgetter
import platform
import time
from typing import Any

from drives import braking_samples, BrakingSample, DRIVES
import numpy as np
import scipy
from squeal_core import BrakeModel
from squeal_core.monitor.assessment import AssessmentContext, PreparedTick
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_evaluator import VehicleEvaluator

RATE = 100.0  # Hz
_EVERY = 100  # ticks between two full solutions


class Stopwatch:
    """Collects the times of calls to some methods, by name."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    def watch(self, owner: Any, method: str, name: str) -> None:
        """Time the calls of a method."""
        call, times = getattr(owner, method), self.times.setdefault(name, [])

        def timed(*arguments: Any) -> Any:
            start = time.process_time()
            try:
                return call(*arguments)
            finally:
                times.append(time.process_time() - start)

        setattr(owner, method, timed)


def contexts(brakes: Iterable[BrakingSample]) -> PreparedTick:
    """Return a tick at which brakes slide under load."""
    return tuple(AssessmentContext(str(at.brake), at.time, {
        'rotor_speed': Reading('good', at.rotor_speed),
        'pressure': Reading('good', at.pressure)}, friction=at.friction) for at in brakes)


def run(evaluator: VehicleEvaluator, samples: list[BrakingSample], state: Any) -> list[float]:
    """Evaluate all brakes tick by tick; return the times of full solutions [s]."""
    solutions = []
    for i, (_, brakes) in enumerate(groupby(samples, attrgetter('time'))):
        evaluator.complete([contexts(brakes)])
        if i % _EVERY == 0:
            start = time.process_time()
            np.linalg.eigvals(state)
            solutions.append(time.process_time() - start)
    return solutions


def main() -> None:
    """Print medians and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--table', default='', help='default: the shipped or cached one')
    parser.add_argument('--drive', default='us06', choices=DRIVES)
    parser.add_argument('--brakes', type=int, default=4, choices=(1, 2, 3, 4))
    parser.add_argument('--seconds', type=float, default=60.0, help='of braking')
    options = parser.parse_args()
    model = BrakeModel.load(options.model)
    n = model.size
    settings = replace(read_settings({}), rate=RATE, table=options.table)
    samples = braking_samples(model, options.drive, brakes=options.brakes, rate=RATE)
    samples = samples[:round(options.seconds * RATE * options.brakes)]
    point = model.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-model.stiffness(point), -model.damping(point)]])
    evaluator = VehicleEvaluator(model, settings)
    run(evaluator, samples[:400], state)
    watch = Stopwatch()
    watch.watch(evaluator.stability.solver, 'solve_all', 'modes')
    watch.watch(evaluator.stability._margins, 'friction_margins', 'margins')
    watch.watch(evaluator.risk, 'evaluate', 'risk')
    watch.watch(evaluator, 'complete', 'assessment')
    solution = float(np.median(run(evaluator, samples, state)))
    print(f'{platform.processor() or platform.machine()}, Python {platform.python_version()}, '
          f'numpy {np.__version__}, scipy {scipy.__version__}, N = {n}, one BLAS thread')
    print(f'full solution {1e3 * solution:.2f} ms; {options.drive}, {len(samples)} assessments; '
          + '; '.join(evaluator.notes))
    for name, times in watch.times.items():
        middle, last = np.quantile(times, (0.5, 0.99))
        mean = float(np.mean(times))
        print(f'  {name:10} {len(times):6} ticks, mean {1e3 * mean:6.3f} ms, median '
              f'{1e3 * middle:6.3f} ms, 99 % {1e3 * last:6.3f} ms; mean over a full solution '
              f'{mean / solution:5.3f}, median {middle / solution:5.3f}')


if __name__ == '__main__':
    main()
