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
A growth emulator against full solutions: its error at new points, and its cost.

Run: python benchmark/emulator.py [--model kang2009_damped] [--points 400] [--seed 7] [--json]

The points are spread over the emulator's whole domain and differ from those it was built and
measured with. The costs are those of the growth rates of 64 members of four brakes at once, and
of the whole risk, in processor time, beside a full solution of the same moment. Exits with 1 where
the error is more than twice the file's or the risk costs more than a half.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Callable  # noqa: I100
from functools import partial
import json
import sys
import time

from checking import check_options, said
import numpy as np

from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.emulator_audit import growth_differences
from squeal_core.risk.emulator_builder import scattered_inputs
from squeal_core.risk.emulator_file import find_emulator
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.growth_emulator import GrowthEmulator, points_at
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import eigenvalues


def processor_time(task: Callable[[], object]) -> float:
    """Return the processor time of a task [ms]."""
    start = time.process_time()
    task()
    return 1e3 * (time.process_time() - start)


def costs(model: BrakeModel, emulator: GrowthEmulator) -> dict[str, float]:
    """Return the medians of growth rates and risk of four brakes and a full solution in turns."""
    risk = SquealRisk(emulator, prior_ensemble(EnsemblePrior()))
    conditions = [20.0, 20.1, 19.8, 20.0], 1500.0 / model.contact_area, [0.42, 0.42, 0.4, 0.4]
    inputs = risk.ensemble.inputs(*conditions)
    applications = [ApplicationRisk(risk) for _ in conditions[0]]

    def evaluate(time_ns: int) -> None:
        growth = risk.growth(*conditions, model.contact_stiffness_at(conditions[1]))
        states = [one.advance(time_ns, growth.at(i)) for i, one in enumerate(applications)]
        risk.assess([state for state in states if state is not None])

    found = [[processor_time(partial(emulator.evaluate, inputs)),
              processor_time(partial(evaluate, turn * 50_000_000)),
              processor_time(partial(eigenvalues, model, points_at(model, inputs[0, :1])[0]))]
             for turn in range(51)]
    growth, whole, full = np.median(found, axis=0).tolist()
    return {'growth_of_four_ms': growth, 'risk_of_four_ms': whole, 'full_solution_ms': full,
            'growth_fraction': growth / full, 'risk_fraction': whole / full}


def figures(emulator: GrowthEmulator, off: FloatArray) -> dict[str, float]:
    """Return what the comparison comes to."""
    magnitudes = np.abs(off)
    return {'modes_compared': off.size, 'rms': float(np.sqrt(np.mean(off**2))),
            'median': float(np.median(magnitudes)), 'largest': float(magnitudes.max()),
            'rms_of_the_file': emulator.error.rms, 'largest_of_the_file': emulator.error.largest,
            **costs(emulator.model, emulator)}


def main() -> int:
    parser = check_options(__doc__.strip().splitlines()[0], points=400)
    parser.set_defaults(model='kang2009_damped', seed=7)
    options = parser.parse_args()
    model = BrakeModel.load(options.model)
    shipped = find_emulator(model)
    if shipped is None:
        parser.error(f'{options.model} has no growth emulator; run squeal tabulate --growth-only')
    emulator, off = shipped[1], []
    for i, row in enumerate(scattered_inputs(emulator.domain, options.points, options.seed)):
        off.append(growth_differences(emulator, row))
        said(f'{i + 1} of {options.points} full solutions')
    found = figures(emulator, np.concatenate(off))
    if options.json:
        print(json.dumps({**found, 'model': options.model, 'seed': options.seed}))
    else:
        print('\n'.join(f'{name:20} {value:.4g}' for name, value in found.items()))
    return int(found['rms'] > 2.0 * found['rms_of_the_file'] or found['risk_fraction'] > 0.5)


if __name__ == '__main__':
    sys.exit(main())
