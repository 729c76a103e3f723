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
Stability at many operating points, by local expansions of the spectrum that full solutions check.

Points are grouped by the coefficients that multiply the model's arrays, not by their places on a
grid: friction times pressure over speed is one coefficient. A group is expanded around its middle.
What the last degree of the power series changes estimates the error; full solutions check it at
the points where that is largest, mode by mode. A group that is too far off is halved along the
coefficient that matters most. Few points are solved in full, and so are those whose verdict or
mode number hangs on the error. Some more points are solved in full to measure the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import moving_eigenvalues, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.grid_columns import COLUMNS, columns_of, EXPANSION, FULL, IMPOSSIBLE
from squeal_core.surrogate.group_expansion import GroupExpansion, LastTerms
from squeal_core.surrogate.spectral_deviation import Accuracy, Deviation
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_cell import TableTolerances

_FEW = 12  # points that full solutions take no longer for than an expansion and its checks
_DEGREE = 4  # of the series: higher ones reach further but cost more than that saves
_FAR = 16  # points that an expansion is tried at before all: most that fail, fail there
_REACH = 2.0  # tolerances that the last degree may change: the error is some times less
_CHECKS, _MARGIN = 4, 0.5  # full solutions that check a group; tolerances it may be off there
_CHECK_EVERY = 499  # points from one check within groups to the next


@dataclass
class SolverCounts:
    """Counts of solutions; the largest error is that of the points checked within groups [1/s]."""

    full: int = 0
    expansions: int = 0
    checks: int = 0
    largest_error: float = 0.0


@dataclass(eq=False)
class GridStability:
    """
    Solves operating points of one model.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    band : (2,) floats
        In which the least stable mode is wanted [Hz].
    tolerances : TableTolerances, optional
        Errors that expansions keep to; None: every point is solved in full.
    limits : Tolerances, optional
        What counts as oscillation and growth; None: `Tolerances.of(model)`.

    """

    model: BrakeModel
    band: tuple[float, float]
    tolerances: TableTolerances | None = None
    limits: Tolerances | None = None
    counts: SolverCounts = field(default_factory=SolverCounts)

    def solve(self, points: Sequence[OperatingPoint | None]) -> dict[str, FloatArray]:
        """Return `COLUMNS` (P,) at points; None is an impossible one."""
        solution = _Solution(self, points, self.limits or Tolerances.of(self.model))
        scales = np.array([np.nan if p is None else p.damping_scale for p in points])
        for scale in np.unique(scales[~np.isnan(scales)]).tolist():
            places = np.flatnonzero(scales == scale)
            if self.tolerances is None:
                solution.solve_in_full(places)
            else:  # an expansion is of one damping scale
                _Groups(solution, self.tolerances).fill(places)
        return solution.columns


class _Solution:
    """The columns of points as they are filled, and full solutions by place."""

    def __init__(self, solver: GridStability, points: Sequence[OperatingPoint | None],
                 limits: Tolerances) -> None:
        self.model, self.band, self.limits = solver.model, solver.band, limits
        self.counts, self.points = solver.counts, points
        self.columns = {name: np.full(len(points), np.nan) for name in COLUMNS}
        self.columns['source'][:] = IMPOSSIBLE
        self._solved: dict[int, ComplexArray] = {}

    def solve_in_full(self, places: IndexArray) -> None:
        for place in places.tolist():
            self.keep(np.array([place]), self.eigenvalues(place)[None], 0.0, FULL)

    def eigenvalues(self, place: int) -> ComplexArray:
        """Return those at a point from a full solution, known zeros left out."""
        if place not in self._solved:
            point = self.points[place]
            assert point is not None
            self._solved[place] = moving_eigenvalues(self.model, point)
            self.counts.full += 1
        return self._solved[place]

    def keep(self, places: IndexArray, eigenvalues: ComplexArray, error: float,
             source: float) -> None:
        """Fill the columns at places (P,) from eigenvalues (P, n)."""
        result = {**columns_of(eigenvalues, self.model.size, self.limits, self.band),
                  'error': error, 'source': source}
        for name, values in result.items():
            self.columns[name][places] = values


class _Groups:
    """Fills the columns of points by expansions."""

    def __init__(self, solution: _Solution, tolerances: TableTolerances) -> None:
        self._solution = solution
        self._accuracy = Accuracy(tolerances, solution.limits, solution.band)
        self._coefficients = np.array([[np.nan] * 9 if point is None else point.coefficients()
                                       for point in solution.points])

    def fill(self, places: IndexArray, last: LastTerms | None = None) -> None:
        """
        Fill the columns at places, by halves where one expansion does not do.

        Parameters
        ----------
        places : (P,) index array
            Of points with one damping scale.
        last : LastTerms, optional
            Those of an expansion of a larger group, which predict how far one of this is off.

        """
        here = self._coefficients[places]
        if places.size <= _FEW:
            self._solution.solve_in_full(places)
            return
        try:
            last = last or self._first_terms(places)
            if last.predicted(here).max() <= _REACH:
                last = self._expanded(places)
                if last is None:
                    return
        except np.linalg.LinAlgError:
            pass
        far = last.far_half(here) if last else _widest_half(here)
        if not far.any():  # one point many times over
            self._solution.solve_in_full(places)
            return
        for part in (places[~far], places[far]):
            self.fill(part, last)

    def _first_terms(self, places: IndexArray) -> LastTerms:
        """Return the last terms of a series for usual steps from the middle of a group."""
        middle = places[_middle(self._coefficients[places])]
        expansion = self._expansion(middle)
        centre = expansion.eigenvalues(self._coefficients[[middle]])
        return LastTerms.of(expansion, self._accuracy.matters(centre)[0],
                            1.0 / self._accuracy.tolerances.growth)

    def _expansion(self, place: int, around: FloatArray | None = None) -> SpectralExpansion:
        point = self._solution.points[place]
        assert point is not None
        self._solution.counts.expansions += 1
        return expand_spectrum(self._solution.model, point, degree=_DEGREE, around=around)

    def _expanded(self, places: IndexArray) -> LastTerms | None:
        """Fill the columns by one expansion and return None, or its last terms if it is off."""
        here = self._coefficients[places]
        expansion = self._expansion(places[_middle(here)], here)
        far = np.argsort(-np.abs(expansion.steps(here)).sum(axis=1), kind='stable')[:_FAR]
        for some in (far, slice(None)):
            group = GroupExpansion.at(expansion, here[some], self._accuracy)
            off = float(group.off.max(initial=0.0))
            if off > _REACH:
                return group.last_terms().worth(here, off)
        checks: dict[int, Deviation] = {}
        for i, most in self._checks(group, places).items():
            checks[i] = self._accuracy.deviation(
                group.eigenvalues[i], self._solution.eigenvalues(int(places[i])))
            if checks[i].off > most:
                return group.last_terms().worth(here, _REACH * max(2.0, checks[i].off / most))
        self._keep(group, places, checks)
        return None

    def _checks(self, group: GroupExpansion, places: IndexArray) -> dict[int, float]:
        """Return the points of a group to solve in full, and how far each may be off."""
        inside = np.flatnonzero(_measures_error(places)).tolist()
        return {**dict.fromkeys(inside, 1.0), **dict.fromkeys(
            group.most_changed()[:_CHECKS], _MARGIN)}

    def _keep(self, group: GroupExpansion, places: IndexArray,
              checks: dict[int, Deviation]) -> None:
        solution, error = self._solution, max(each.growth for each in checks.values())
        undecided = group.undecided(checks, self._accuracy, solution.model.size)
        solution.keep(places, group.eigenvalues, error, EXPANSION)
        solution.solve_in_full(places[undecided])
        for i, each in checks.items():
            if _measures_error(places[i]):
                solution.counts.checks += 1
                solution.counts.largest_error = max(solution.counts.largest_error, each.growth)


def _measures_error(places: Any) -> Any:
    """Return whether each point is solved in full to measure the error, whatever it is."""
    return places % _CHECK_EVERY == _CHECK_EVERY // 2


def _middle(coefficients: FloatArray) -> int:
    """Return the place of the point closest to the middle of all, by the widest coefficient."""
    low, high = coefficients.min(axis=0), coefficients.max(axis=0)
    away = np.abs(coefficients - 0.5 * (low + high)) / np.where(high > low, high - low, 1.0)
    return int(away.max(axis=1).argmin())


def _widest_half(coefficients: FloatArray) -> Any:
    """Return whether points lie above the middle of the coefficient that varies most."""
    low, high = coefficients.min(axis=0), coefficients.max(axis=0)
    axis = int(np.argmax((high - low) / (np.maximum(np.abs(low), np.abs(high)) + 1e-300)))
    return coefficients[:, axis] > 0.5 * (low + high)[axis]
