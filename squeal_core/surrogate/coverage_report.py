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

"""Coverage of an envelope or a drive by a table, and its errors: measured, not assumed."""

from dataclasses import asdict, dataclass, replace

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.tabulated_solver import deviation

POINTS = 20_000  # random points, at which answers are counted
SOLVED = 300  # of them compared with full solutions


@dataclass(frozen=True)
class CoverageReport:
    """
    Coverage of random points by a table, and its errors.

    Parameters
    ----------
    points : int
    answered : float
        Fraction of the points that the table answers.
    gaps : float
        Fraction of the envelope's volume without a cell.
    overlap : float
        Fraction of the volume in more than one cell.
    solved : int
        Answers compared with full solutions.
    worst_error : float
        Largest distance of an eigenvalue that matters from the full solution, in tolerances.
    wrong_verdicts : int
        Points at which table and full solution differ in the modes that are unstable.

    """

    points: int
    answered: float
    gaps: float
    overlap: float
    solved: int
    worst_error: float
    wrong_verdicts: int


def measure_coverage(table: ExpansionTable, model: BrakeModel, *, x: FloatArray | None = None,
                     points: int = POINTS, solved: int = SOLVED, seed: int = 0) -> CoverageReport:
    """
    Return the coverage at random points of the envelope.

    Parameters
    ----------
    table : ExpansionTable
        What is measured.
    model : BrakeModel
        Its model.
    x : (P, 3) array, optional
        Places in the domain's coordinates instead of random ones, as of a drive.
    points, solved : int
        Points in all, and how many of the answers are compared with full solutions.
    seed : int
        Of the random numbers.

    """
    generator = np.random.default_rng(seed)
    if x is None:
        x = table.domain.low + table.domain.width * generator.random((points, 3))
        x = x[table.domain.covers(x)]
    limits = Tolerances.of(model)
    result = table.evaluate(x, limits)
    chosen = generator.permutation(np.flatnonzero(result.answered))[:solved]
    places, worst, wrong = table.domain.points(model, x[chosen]), 0.0, 0
    listed = result.listed()
    for i, place in enumerate(chosen.tolist()):
        ours, truth = listed[place], complex_modes(model, places[i], tolerances=limits)
        worst = max(worst, deviation(ours, truth, table.tolerances))
        wrong += len(ours.unstable) != len(truth.unstable)
    filled = float((table.grid >= 0).mean())
    volume = float((2.0 * table.halves).prod(axis=1).sum() / table.domain.width.prod())
    return CoverageReport(
        points=len(x), answered=float(result.answered.mean()) if len(x) else 0.0,
        gaps=_gaps(table), overlap=max(0.0, round(volume - filled, 9)), solved=len(chosen),
        worst_error=worst, wrong_verdicts=wrong)


def _gaps(table: ExpansionTable) -> float:
    """Return the fraction without a cell of the boxes whose centre is in the envelope."""
    steps = [(np.arange(count) + 0.5) / count for count in table.grid.shape]
    shares = np.stack(np.meshgrid(*steps, indexing='ij'), axis=-1).reshape(-1, 3)
    inside = table.domain.covers(table.domain.low + table.domain.width * shares)
    return float((table.grid.ravel()[inside] < 0).mean()) if inside.any() else 1.0


def with_coverage(table: ExpansionTable, report: CoverageReport) -> ExpansionTable:
    """Return the table with its measured coverage in `about`."""
    return replace(table, about={**table.about, 'coverage': asdict(report)})
