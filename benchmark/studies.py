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
What studies cost: a million operating points, rebuilds of a brake with the cache and without.

Run: python benchmark/studies.py [--boxes N] [--design]. Times are processor time; the million is
that of a random sample of its boxes, unless --boxes 0 asks for all. Boxes cost different times,
and evenly taken ones would all be at high speeds.
"""

import argparse
from dataclasses import replace
import time

import numpy as np
from squeal_core import BrakeModel
from squeal_core.common.resources import config_folder
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.studies.design import BrakeDesign, DesignModels
from squeal_core.studies.point_options import PointOptions
from squeal_core.studies.study import run_study
from squeal_core.studies.study_spec import StudySpec
from squeal_core.studies.study_tasks import MapTask
from squeal_core.surrogate.grid_columns import EXPANSION

MILLION = {'friction': np.linspace(0.2, 0.6, 50), 'rotor_speed': np.linspace(2.0, 40.0, 25),
           'preload': np.linspace(500.0, 6000.0, 20),
           'contact_stiffness': np.linspace(2e10, 5e10, 40)}


def million(boxes: int, name: str) -> None:
    """Print the cost of a point by local expansions, and that of a full solution."""
    model = BrakeModel.load(name)
    spec = StudySpec(source=model, axes=MILLION, task=MapTask(),
                     options=PointOptions(rotor_speed=5.0, friction=0.4))
    chosen: list[int] = []

    def run(function, jobs):
        keys = list(jobs)
        count = min(boxes, len(keys)) or len(keys)
        chosen.extend(np.random.default_rng(1).choice(keys, count, replace=False).tolist())
        for key in chosen:
            yield key, function(*jobs[key])

    begun = time.process_time()
    found = run_study(spec, run)
    seconds = time.process_time() - begun
    done, counts = int(found.done.sum()), found.about['counts']
    point = replace(spec.options, rotor_speed=10.0).at(model)
    begun = time.process_time()
    for _ in range(20):
        eigenvalues(model, point)
    full = (time.process_time() - begun) / 20
    print(f'{name}: {done} of {found.size} points in {len(chosen)} boxes: {seconds:.1f} s of '
          f'processor time, {1e6 * seconds / done:.0f} us a point; a million on two cores '
          f'{found.size / done * seconds / 120.0:.1f} min; full solutions would take '
          f'{found.size * full / 120.0:.0f} min ({1e3 * full:.1f} ms each)')
    print(f'by expansion {found.count(EXPANSION) / done:.2%}; {counts["expansions"]:.0f} '
          f'expansions, {counts["full"]:.0f} full solutions; off by at most '
          f'{counts["largest_error"]:.3f} 1/s at {counts["checks"]:.0f} points checked')


def design() -> None:
    """Print the cost of 5 x 5 rebuilds of the shipped brake, with the cache and without."""
    content = BrakeDesign.read(config_folder() / 'brakes' / 'kang2009.yaml')
    values = [{'disc.rotor_thickness_mm': h, 'pads.young_modulus_gpa': e}
              for h in np.linspace(14.0, 18.0, 5) for e in np.linspace(150.0, 230.0, 5)]
    models = DesignModels(content)
    begun = time.process_time()
    for place in values:
        models.model(place)
    cached = time.process_time() - begun
    begun = time.process_time()
    for place in values[::6]:  # five that share nothing
        DesignModels(content).model(place)
    plain = 5.0 * (time.process_time() - begun)
    print(f'25 rebuilds: {cached:.1f} s with the cache, {plain:.1f} s without (of five)')


def main() -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--model', default='kang2009')
    parser.add_argument('--boxes', type=int, default=8, help='of the million; 0: all')
    parser.add_argument('--design', action='store_true', help='rebuilds alone')
    options = parser.parse_args()
    if not options.design:
        million(options.boxes, options.model)
    else:
        design()


if __name__ == '__main__':
    main()
