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
What an assessment costs while braking: modes, risk and the margins' share, tables warm.

Run: python benchmark/assessment.py [--drive us06] [--brakes 4] [--seconds 120]

The braking samples of a drive at 100 Hz go through `evaluate_brakes` twice, as the monitor has it,
all brakes of a tick at once: first the tables are laid down while the caller waits, then each call
is timed; the margins' searches go on within some of them. Times are of one brake, those of a tick
over the brakes in it, in ms and over that of `numpy.linalg.eigvals` of the whole state matrix,
solved again and again in between.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Callable
from dataclasses import replace
from itertools import groupby
from operator import attrgetter
import platform
import time
from typing import Any

from drives import braking_samples, BrakingSample, DRIVES
import numpy as np
from online import reference
import scipy

from squeal_core import BrakeModel
from squeal_core.monitor import brake_stability as sliding
from squeal_core.monitor.brake_stability import BrakeEvaluator
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.risk.margin import SlidingConditions

RATE = 100.0  # Hz
_EVERY = 200  # ticks between two reference solves


class Stopwatch:
    """Adds up the time of calls to some methods, by name, over the brakes they are for."""

    def __init__(self) -> None:
        self.times: dict[str, list[float]] = {}

    def watch(self, owner: Any, method: str, name: str) -> None:
        """Time the calls of a method whose first argument is a list, of a brake each."""
        call, times = getattr(owner, method), self.times.setdefault(name, [])

        def timed(brakes: Any, *arguments: Any) -> Any:
            start = time.perf_counter()
            try:
                return call(brakes, *arguments)
            finally:
                times.append((time.perf_counter() - start) / len(brakes))

        setattr(owner, method, timed)


def vehicle(model: BrakeModel,
            settings: MonitorSettings) -> tuple[VehicleStability, list[BrakeEvaluator]]:
    engines = VehicleStability(model, settings)
    return engines, [BrakeEvaluator(engines, settings, one.name) for one in settings.brakes]


def run(brakes: list[BrakeEvaluator], way: list[BrakingSample],
        between: Callable[[], None] = lambda: None) -> None:
    for i, (now, samples) in enumerate(groupby(way, attrgetter('time'))):
        if i % _EVERY == 0:
            between()
        sliding.evaluate_brakes([(brakes[at.brake], SlidingConditions(
            rotor_speed=at.rotor_speed, pressure=at.pressure, friction=at.friction))
            for at in samples], now)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--drive', default='us06', choices=DRIVES)
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--brakes', type=int, default=4, choices=(1, 2, 3, 4))
    parser.add_argument('--seconds', type=float, default=120.0, help='of braking')
    arguments = parser.parse_args()
    model = BrakeModel.load(arguments.model)
    settings = replace(read_settings({}), rate=RATE, anchor_delay=0.0, risk_delay=0.0)
    way = braking_samples(model, arguments.drive, brakes=arguments.brakes, rate=RATE)
    way = way[:round(arguments.seconds * RATE * arguments.brakes)]
    engines, brakes = vehicle(model, settings)
    run(brakes, way)
    point = model.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    watch, solves = Stopwatch(), []
    watch.watch(engines.modes, 'complex_modes_of', 'modes')
    watch.watch(engines.risks, 'assess_together', 'risk')
    watch.watch(sliding, 'evaluate_brakes', 'assessment')
    run(brakes, way, lambda: solves.append(reference(model, point)))
    solve = float(np.median(solves))
    print(f'{platform.processor() or platform.machine()}, Python {platform.python_version()}, '
          f'numpy {np.__version__}, scipy {scipy.__version__}, N = {model.size}, one BLAS thread, '
          f'eigvals {1e3 * solve:.2f} ms')
    print(f'{arguments.drive}, {len(way)} assessments of {arguments.brakes} brakes, '
          f'{len(engines.modes.anchors)} anchors, {len(engines.risks.cells)} cells')
    print(f'  {"":18} {"calls":>7} {"median ms":>10} {"mean":>7} {"p99":>7} '
          f'{"eigvals / median":>17}')
    for name, times in watch.times.items():
        middle, last = np.quantile(times, (0.5, 0.99))
        print(f'  {name:18} {len(times):7} {1e3 * middle:10.3f} {1e3 * np.mean(times):7.3f} '
              f'{1e3 * last:7.3f} {solve / middle:17.1f}')
    engines.close()


if __name__ == '__main__':
    main()
