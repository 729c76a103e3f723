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
The engine's error estimate where it is as large as an answer may have it.

Run: python benchmark/online_limit.py [--points 1200] [--model kang2009] [--seed 0] [--json]

From expansions at braking points of US06 and at random points of the whole range in turn, random
directions are followed to the last point that is accepted: its estimate is what is tolerated, and
it is compared with a full solve. Counted are oscillating modes with errors above 1e-6 1/s.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import json  # noqa: I100
import sys
from typing import Any

from checking import check_options, said
from drives import braking_points
import numpy as np
from online_accuracy import LIMIT, random_point
from scipy.optimize import linear_sum_assignment

from squeal_core import BrakeModel, OperatingPoint
from squeal_core.stability.eigensolution import eigenvalues, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

DIRECTIONS = 10  # from each expansion
FARTHEST = 0.6
COUNTED = 1e-6  # 1/s
HALVINGS = 14


def moved(start: OperatingPoint, shares: Any, step: float) -> OperatingPoint:
    values = {name: value * float(1.0 + step * share) for (name, value), share in zip(
        vars(start).items(), shares, strict=True)}
    return OperatingPoint(**{**values, 'friction_slope': start.friction_slope
                             + 0.1 * step * float(shares[2])})


def tolerated(roots: Any) -> Any:
    return np.maximum(LIMIT, -0.02 * roots.real)


def at_limit(anchor: SpectralExpansion, shares: Any) -> OperatingPoint | None:
    """Return the last accepted point of a direction; None where a series diverges before it."""
    def worst(step: float) -> float:
        roots, errors = anchor.eigenvalues_at(np.array(moved(anchor.point, shares,
                                                             step).coefficients()))
        return float((errors / tolerated(roots)).max())

    low, high = 1e-3, FARTHEST
    for _ in range(HALVINGS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if worst(middle) <= 1.0 else (low, middle)
    return moved(anchor.point, shares, low) if 0.5 < worst(low) <= 1.0 else None


def beaten(model: BrakeModel, anchor: SpectralExpansion, at: OperatingPoint) -> tuple[Any, Any]:
    """Return errors over estimates and over what is tolerated, of modes off by more than both."""
    roots, estimates = anchor.eigenvalues_at(np.array(at.coefficients()))
    truth = eigenvalues(model, at)
    every = np.concatenate([roots, roots[anchor.mirrored].conj()])
    ours, theirs = linear_sum_assignment(np.abs(every[:, None] - truth))
    away = np.abs(every[ours] - truth[theirs])[:roots.size]
    counted = (away > estimates) & (away > COUNTED) & (
        roots.imag > Tolerances.of(model).oscillation)
    return (away / estimates)[counted], (away / tolerated(roots))[counted]


def main() -> int:
    options = check_options(__doc__.strip().splitlines()[0], points=1200).parse_args()
    model, generator = BrakeModel.load(options.model), np.random.default_rng(options.seed)
    driven = braking_points(model, 'us06')
    points, times, parts = 0, [], []
    while points < options.points:
        for start in (driven[int(generator.integers(len(driven)))],
                      random_point(model, generator)):
            anchor = expand_spectrum(model, start)
            for shares in generator.uniform(-1.0, 1.0, (DIRECTIONS, 5)):
                if (at := at_limit(anchor, shares)) is not None:
                    over, part = beaten(model, anchor, at)
                    times.append(over.max(initial=0.0))
                    parts.append(part.max(initial=0.0))
                    points += 1
        said(f'{points} points')
    figures = {'points': points, 'beaten': int(np.count_nonzero(times)),
               'worst_of_estimate': float(np.max(times)),
               'worst_of_tolerated': float(np.max(parts)), 'seed': options.seed}
    print(json.dumps(figures) if options.json else
          '\n'.join(f'{name:20} {value}' for name, value in figures.items()))
    return int(figures['worst_of_tolerated'] > 1.0)


if __name__ == '__main__':
    sys.exit(main())
