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
Draw how the error of the online engine grows with the distance from an anchor.

Run: python benchmark/online_error.py [-o docs/images/online_error.png]

Anchors lie at braking points of US06; each parameter is moved alone, both ways, and the worst of
all oscillating modes within reach of the squeal band is compared with a full solve.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from dataclasses import replace

from drives import braking_points
import numpy as np

from squeal_core import BrakeModel
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.view.engine_plot import ErrorsOverDistance, plot_errors

DISTANCES = np.geomspace(2e-3, 0.6, 13)
PARAMETERS = {'rotor_speed': 'rotor speed', 'contact_pressure': 'pressure',
              'friction': 'friction', 'contact_stiffness': 'contact stiffness'}


def errors(model: BrakeModel, anchor: SpectralExpansion,
           point: OperatingPoint) -> tuple[float, float]:
    """Return the largest true and estimated error [1/s] of the modes below 16 kHz."""
    roots, estimates = anchor.eigenvalues(np.array(point.coefficients())[:, None])
    truth = eigenvalues(model, point)
    audible = (roots[:, 0].imag > 1.0) & (roots[:, 0].imag < 2.0 * np.pi * 16e3)
    away = np.abs(roots[audible, 0][:, None] - truth).min(axis=1)
    return float(away.max()), float(estimates[audible, 0].max())


def moved(point: OperatingPoint, parameter: str, factor: float) -> OperatingPoint:
    changed = {parameter: factor * getattr(point, parameter)}
    if parameter == 'friction':
        changed['friction_slope'] = factor * point.friction_slope
    return replace(point, **changed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('-o', '--output', default='docs/images/online_error.png')
    parser.add_argument('--anchors', type=int, default=24)
    arguments = parser.parse_args()
    model = BrakeModel.load('kang2009')
    points = braking_points(model, 'us06')
    points = points[::len(points) // arguments.anchors][:arguments.anchors]
    anchors = [expand_spectrum(model, point) for point in points]
    found = []
    for parameter, name in PARAMETERS.items():
        pairs = np.array([[
            errors(model, anchor, moved(anchor.point, parameter, (1.0 + d) ** sign))
            for anchor in anchors for sign in (-1, 1)] for d in DISTANCES])
        found.append(ErrorsOverDistance(name, DISTANCES, pairs[..., 0], pairs[..., 1]))
        inside = pairs[pairs[..., 1] <= 0.1]
        print(f'{name:18} estimate within 0.1 1/s: {len(inside)} of {pairs[..., 0].size}, largest '
              f'true error there {inside[:, 0].max():.3g} 1/s')
    plot_errors(found, arguments.output)


if __name__ == '__main__':
    main()
