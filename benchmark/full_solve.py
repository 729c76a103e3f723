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
What one assessment costs: the eigensolution, the vectors, the whole; medians, one BLAS thread.

Run: python benchmark/full_solve.py
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Callable  # noqa: I100
import platform
import time

import numpy as np
import scipy

from squeal_core import BrakeModel
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import BrakeMonitor, Sample
from squeal_core.stability.eigensolution import complex_modes, eigenvalues
from squeal_core.stability.eigenvectors import mode_vectors  # noqa: I100


def median(task: Callable[[], object], repeats: int = 101) -> float:
    """Return the median time of a task [ms], the first call left out."""
    task()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


def main() -> None:
    model = BrakeModel.load('kang2009')
    point = model.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    n = model.size
    state = np.block([[np.zeros((n, n)), np.eye(n)],
                      [-model.stiffness(point), -model.damping(point)]])
    worst = complex_modes(model, point).unstable[0].eigenvalue
    settings = read_settings({'brakes': ['fl']})
    monitor = BrakeMonitor(settings.brakes[0], settings, model)
    for signal, value in (('rotor_speed', 20.0), ('pressure', 7.84e5), ('friction', 0.42)):
        monitor.receive(signal, Sample(1, value))  # type: ignore[arg-type]
    tasks: dict[str, Callable[[], object]] = {
        'numpy.linalg.eigvals of the whole state': lambda: np.linalg.eigvals(state),
        'eigenvalues': lambda: eigenvalues(model, point),
        'complex_modes': lambda: complex_modes(model, point),
        'mode_vectors of one mode': lambda: mode_vectors(model, point, worst),
        'assessment of a braking brake': lambda: monitor.assess(1)}
    reference = median(tasks['numpy.linalg.eigvals of the whole state'])
    print(f'{platform.processor() or platform.machine()}, Python {platform.python_version()}, '
          f'numpy {np.__version__}, scipy {scipy.__version__}, N = {n}, one BLAS thread')
    for name, task in tasks.items():
        value = median(task)
        print(f'{name:42} {value:7.2f} ms   {value / reference:5.2f} of eigvals')


if __name__ == '__main__':
    main()
