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
Measure how mode frequencies, arrays and growth rates converge with mesh and quadrature.

Run: python examples/convergence.py [--quick]; prints the tables of
docs/explanation/convergence.md.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import sys  # noqa: I100

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.assembly.build import build_model
from squeal_core.brake.brake_yaml import read_brake
from squeal_core.common import resources
from squeal_core.stability.eigensolution import complex_modes

LADDER = (
    # disc order, pad elements, contact points a pad element in each direction
    (3, (4, 8, 1), 2),
    (3, (6, 12, 2), 3),
    (4, (9, 18, 3), 4),  # the default, and the shipped model
    (6, (12, 24, 3), 5))
POINTS = tuple(OperatingPoint(
    rotor_speed=speed, friction=0.42, contact_stiffness=0.35e11,
    contact_pressure=2000.0 / BrakeModel.load('kang2009').contact_area) for speed in (5.0, 20.0))


def main(arguments: list[str]) -> None:
    brake = read_brake(resources.config_folder() / 'brakes' / 'kang2009.yaml')
    ladder = LADDER[:2] if '--quick' in arguments else LADDER
    models = [build_model(brake, disc_order=order, pad_elements=pads, contact_points=points)
              for order, pads, points in ladder]
    best = models[-1]
    print('| disc order | pad elements | points an element | disc Hz | pad Hz | growth rate 1/s |')
    print('|---|---|---|---|---|---|')
    for settings, model in zip(ladder[:-1], models[:-1], strict=True):
        disc, pad = (_frequency_error(model, best, part) for part in ('disc', 'pad 1 flexible'))
        growth = max(_growth_error(model, best, point) for point in POINTS)
        order, elements, points = settings
        print(f'| {order} | {elements} | {points} | {disc:.1e} | {pad:.1e} | {growth:.2f} |')
    print(f'\nlargest differences from order {ladder[-1][0]}, {ladder[-1][1]} elements, '
          f'{ladder[-1][2]} points; frequencies relative')


def _frequency_error(model: BrakeModel, best: BrakeModel, part: str) -> float:
    """Largest relative difference among the component modes both models keep."""
    known = dict(zip(best.names, best.angular_frequencies, strict=True))
    return max(abs(w / known[name] - 1.0) for name, w in zip(
        model.names, model.angular_frequencies, strict=True)
        if name.startswith(part) and name in known)


def _growth_error(model: BrakeModel, best: BrakeModel, point: OperatingPoint) -> float:
    """Largest difference of a growth rate among the unstable modes."""
    modes, reference = (complex_modes(m, point) for m in (model, best))
    return max(min(abs(mode.growth_rate - other.growth_rate) for other in modes.modes
                   if abs(other.frequency_hz / mode.frequency_hz - 1.0) < 5e-3)
               for mode in reference.unstable)


if __name__ == '__main__':
    main(sys.argv[1:])
