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
What the online engine costs, against numpy's eigvals in the same process; one BLAS thread.

Run: python benchmark/online.py [--drives us06 ...] [--live 60] [--sizes 30 60 92 150 250]

Every figure is a ratio: time of `numpy.linalg.eigvals` of the whole 2N x 2N state matrix, taken
again and again between the measured calls, over the time of what is measured.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections.abc import Callable, Sequence
import math
import platform
import time
from typing import Any

from drives import braking_points, DRIVES
import numpy as np  # noqa: I100
import scipy
from sizes import sized

from squeal_core import BrakeModel
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver

_EVERY = 400  # calls between two reference solves
_DELAY = 15  # solves, as a node of one brake at 100 Hz has it


def reference(model: BrakeModel, point: OperatingPoint) -> float:
    """Return the time of one reference solve [s]."""
    n = model.size
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-model.stiffness(point), -model.damping(point)]])
    start = time.perf_counter()
    np.linalg.eigvals(state)
    return time.perf_counter() - start


def timed(model: BrakeModel, points: Sequence[OperatingPoint],
          task: Callable[[OperatingPoint], object], rate: float = math.inf
          ) -> tuple[np.ndarray, float]:
    """
    Return the time of each call and the median of the reference solves between them [s].

    With a rate the calls come as they would on the vehicle, so many a second.
    """
    times, solves, begin = np.empty(len(points)), [], time.perf_counter()
    for i, point in enumerate(points):
        if rate < math.inf:
            time.sleep(max(0.0, begin + i / rate - time.perf_counter()))
        if i % _EVERY == 0:
            solves.append(reference(model, point))
        start = time.perf_counter()
        task(point)
        times[i] = time.perf_counter() - start
    return times, float(np.median(solves))


def report(name: str, times: np.ndarray, solve: float, engine: TabulatedSolver, full: int) -> None:
    late = np.quantile(times, 0.999) / solve
    print(f'  {name:24} {solve * len(times) / times.sum():7.1f} {solve / np.median(times):8.1f} '
          f'{late:8.2f} {times.max() / solve:7.2f} {full:6} {len(engine.anchors):7} '
          f'{engine.nbytes / 1e6:6.1f}')


def drive(model: BrakeModel, name: str, brakes: int, delay: int) -> None:
    """Print what a drive costs from an empty table, and again with the table it left."""
    points = braking_points(model, name, brakes=brakes)
    engine = TabulatedSolver(model, SolverSettings(delay=delay * brakes))
    print(f'{name}, {brakes} of 4 brakes, {len(points)} braking samples, '
          f'{"anchors made while waiting" if not delay else f"delay {delay * brakes} solves"}')
    before = 0
    for temperature in ('cold', 'warm'):
        times, solve = timed(model, points, lambda point: engine.complex_modes(point).unstable)
        report(temperature, times, solve, engine, engine.statistics.full - before)
        before = engine.statistics.full
    engine.close()


def live(model: BrakeModel, name: str, seconds: float) -> None:
    """Print what the first braking seconds of a drive cost at 100 Hz, anchors made beside."""
    points = braking_points(model, name)[:round(100.0 * seconds)]
    print(f'{name}, 1 of 4 brakes, {len(points)} braking samples at 100 Hz, delay {_DELAY} solves')
    engine, before = TabulatedSolver(model, SolverSettings(delay=_DELAY)), 0
    for temperature in ('cold', 'warm'):
        times, solve = timed(model, points, lambda point: engine.complex_modes(point).unstable,
                             rate=100.0)
        report(temperature, times, solve, engine, engine.statistics.full - before)
        before = engine.statistics.full
    engine.close()


def scaling(sizes: Sequence[int]) -> None:
    """Print how solve, anchor and answer cost more with N."""
    print(f'{"N":>5} {"eigvals ms":>11} {"anchor ms":>10} {"answer us":>10} {"speed-up":>9}')
    for size in sizes:
        solve, anchor, answer = (float(np.median(t)) for t in costs(sized(size)))
        print(f'{size:5} {1e3 * solve:11.2f} {1e3 * anchor:10.1f} {1e6 * answer:10.0f} '
              f'{solve / answer:9.0f}')


def costs(model: BrakeModel) -> tuple[Any, Any, Any]:
    """Return times [s] of reference solves, of anchors, and of answers from one."""
    point = model.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    near = model.operating_point(rotor_speed=20.4, pressure=7.7e5, friction=0.422)
    engine = TabulatedSolver(model)
    engine.complex_modes(point)
    solves = np.array([reference(model, point) for _ in range(21)])
    anchors, _ = timed(model, [point] * 11, lambda q: expand_spectrum(model, q))
    answers, _ = timed(model, [near] * 401, lambda q: engine.complex_modes(q).unstable)
    return solves, anchors, answers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--drives', nargs='*', default=DRIVES, choices=DRIVES)
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--live', type=float, default=60.0, help='braking seconds, in real time')
    parser.add_argument('--sizes', nargs='*', type=int, default=(30, 60, 92, 150, 250))
    arguments = parser.parse_args()
    model = BrakeModel.load(arguments.model)
    print(f'{platform.processor() or platform.machine()}, Python {platform.python_version()}, '
          f'numpy {np.__version__}, scipy {scipy.__version__}, N = {model.size}, one BLAS thread; '
          'times as ratios to numpy.linalg.eigvals')
    print(f'  {"":24} {"total x":>7} {"median x":>8} {"p99.9 /":>8} {"max /":>7} {"full":>6} '
          f'{"anchors":>7} {"MB":>6}')
    for name in arguments.drives:
        drive(model, name, 1, 0)
        drive(model, name, 4, 0)
    if arguments.live:
        live(model, 'us06', arguments.live)
    scaling(arguments.sizes)


if __name__ == '__main__':
    main()
