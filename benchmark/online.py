"""What the online engine costs, against numpy's eigvals in the same process; one BLAS thread.

Run: python benchmark/online.py [--drives us06 ...] [--sizes 30 60 ...]

Every figure is a ratio: time of `numpy.linalg.eigvals` of the whole 2N x 2N state matrix, taken
again and again between the measured calls, over the time of what is measured.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse
from collections.abc import Callable, Sequence
import platform
import time

from drives import braking_points, DRIVES
import numpy as np
import scipy

from squeal_core import BrakeModel
from squeal_core.operating_point import OperatingPoint
from squeal_core.tabulation import TableSettings, Tabulation

_EVERY = 400  # calls between two reference solves
_DELAY = 30  # solves, as a node of one brake at 100 Hz has it


def reference(model: BrakeModel, point: OperatingPoint) -> float:
    """Return the time of one reference solve [s]."""
    n = model.size
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-model.stiffness(point), -model.damping(point)]])
    start = time.perf_counter()
    np.linalg.eigvals(state)
    return time.perf_counter() - start


def timed(model: BrakeModel, points: Sequence[OperatingPoint],
          task: Callable[[OperatingPoint], object]) -> tuple[np.ndarray, float]:
    """Return the time of each call and the median of the reference solves between them [s]."""
    times, solves = np.empty(len(points)), []
    for i, point in enumerate(points):
        if i % _EVERY == 0:
            solves.append(reference(model, point))
        start = time.perf_counter()
        task(point)
        times[i] = time.perf_counter() - start
    return times, float(np.median(solves))


def report(name: str, times: np.ndarray, solve: float, engine: Tabulation, full: int) -> None:
    late = np.quantile(times, 0.999) / solve
    print(f'  {name:24} {solve * len(times) / times.sum():7.1f} {solve / np.median(times):8.1f} '
          f'{late:8.2f} {times.max() / solve:7.2f} {full:6} {len(engine.anchors):7} '
          f'{engine.nbytes / 1e6:6.1f}')


def drive(model: BrakeModel, name: str, brakes: int, delay: int) -> None:
    """Print what a drive costs from an empty table, and again with the table it left."""
    points = braking_points(model, name, brakes=brakes)
    engine = Tabulation(model, TableSettings(delay=delay * brakes))
    print(f'{name}, {brakes} of 4 brakes, {len(points)} braking samples, '
          f'{"anchors made while waiting" if not delay else f"delay {delay * brakes} solves"}')
    before = 0
    for temperature in ('cold', 'warm'):
        times, solve = timed(model, points, lambda point: engine.complex_modes(point).unstable)
        report(temperature, times, solve, engine, engine.statistics.full - before)
        before = engine.statistics.full
    engine.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--drives', nargs='*', default=DRIVES, choices=DRIVES)
    parser.add_argument('--model', default='kang2009')
    arguments = parser.parse_args()
    model = BrakeModel.load(arguments.model)
    print(f'{platform.processor() or platform.machine()}, Python {platform.python_version()}, '
          f'numpy {np.__version__}, scipy {scipy.__version__}, N = {model.size}, one BLAS thread; '
          'times as ratios to numpy.linalg.eigvals')
    print(f'  {"":24} {"total x":>7} {"median x":>8} {"p99.9 /":>8} {"max /":>7} {"full":>6} '
          f'{"anchors":>7} {"MB":>6}')
    for name in arguments.drives:
        drive(model, name, 1, 0)
        drive(model, name, 1, _DELAY)
        drive(model, name, 4, _DELAY)


if __name__ == '__main__':
    main()
