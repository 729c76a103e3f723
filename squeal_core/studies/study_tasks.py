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

"""Tasks of a study at the points of one model: the map, loci, critical values."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.boundaries import Crossing, NO_MODE
from squeal_core.stability.boundary_search import BoundarySearch
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.stability.mode_tracking import identify, track, Tracked
from squeal_core.stability.parameter_paths import Law, moved
from squeal_core.surrogate.grid_columns import COLUMNS, FULL, IMPOSSIBLE
from squeal_core.surrogate.grid_stability import GridStability
from squeal_core.surrogate.table_cell import TableTolerances

Columns: TypeAlias = dict[str, FloatArray]
Rebuilt: TypeAlias = Callable[[int, float], tuple[BrakeModel | None, OperatingPoint | None]]
_DESIGN_STEPS = 8  # of the search along a dimension: each is a model to build
_DESIGN_WIDTH = 1e-3  # of its bracket, in parts of the bounds


@dataclass(frozen=True, eq=False, kw_only=True)
class StudyPlace:
    """
    A box of points of one model.

    Parameters
    ----------
    model : BrakeModel
    points : sequence of OperatingPoint
        The last axis runs fastest; None is an impossible point.
    shape : ints
        Of the box.
    rebuilt : callable, optional
        Model and point of place i at a value of the dimension that is searched along, or None
        and None.
    start : float
        Of that dimension.

    """

    model: BrakeModel
    points: Sequence[OperatingPoint | None]
    shape: Sequence[int]
    rebuilt: Rebuilt | None = None
    start: float = math.nan


@dataclass(frozen=True, kw_only=True)
class MapTask:
    """
    The least stable mode in a band, and how many modes are unstable.

    Parameters
    ----------
    band : (2,) floats
        [Hz]
    exact : bool
        Solve every point in full.
    growth_error : float, optional
        Of growth rates from expansions [1/s]; None: relative to the model's spectrum.

    """

    band: tuple[float, float] = SQUEAL_BAND
    exact: bool = False
    growth_error: float | None = None

    @property
    def columns(self) -> tuple[str, ...]:
        return COLUMNS

    @property
    def points_of_a_job(self) -> int:
        return 1024 if self.exact else 16384  # many points share an expansion

    def solve(self, place: StudyPlace) -> tuple[Columns, dict[str, float]]:
        tolerances = None if self.exact else TableTolerances.of(
            place.model, growth=self.growth_error)
        solver = GridStability(place.model, self.band, tolerances)
        return solver.solve(place.points), asdict(solver.counts)


@dataclass(frozen=True, kw_only=True)
class LocusTask:
    """
    Eigenvalues of modes by their numbers at mu = 0.

    Parameters
    ----------
    numbers : tuple of int
    along : bool
        Modes are followed along the last axis; else each point is numbered anew, from mu = 0.

    """

    numbers: tuple[int, ...]
    along: bool = True
    points_of_a_job = 64

    @property
    def columns(self) -> tuple[str, ...]:
        return (*(f'{what}_{number}' for number in self.numbers for what in (
            'growth_rate', 'frequency_hz', 'merged_with')), 'source')

    def solve(self, place: StudyPlace) -> tuple[Columns, dict[str, float]]:
        model, points, shape = place.model, place.points, place.shape
        if max(self.numbers) > model.size:
            raise SquealError(f'--modes: {max(self.numbers)} is no number of a mode; the model '
                              f'has {model.size}')
        columns = _empty(self.columns, len(points))
        line = shape[-1] if self.along else 1
        for start in range(0, len(points), line):
            row = [(i, point) for i, point in enumerate(points[start:start + line], start)
                   if point is not None]
            result = (track(model, [point for _, point in row]) if self.along
                      else (identify(model, point) for _, point in row))
            for (i, _), here in zip(row, result, strict=True):
                self._take(columns, i, here)
        return columns, {}

    def _take(self, columns: Columns, place: int, here: Tracked) -> None:
        columns['source'][place] = FULL
        for number in self.numbers:
            mode = here.mode(number)
            if mode is None:
                continue
            columns[f'growth_rate_{number}'][place] = mode.growth_rate
            columns[f'frequency_hz_{number}'][place] = mode.frequency_hz
            columns[f'merged_with_{number}'][place] = next(
                (other for other in here.identity(mode).numbers if other != number), math.nan)


@dataclass(frozen=True, kw_only=True)
class CriticalTask:
    """
    Stability boundaries along a parameter, nearest to each point.

    Parameters
    ----------
    parameter : str
        Of the operation, or a path of the brake description.
    bounds : (2,) floats, optional
        None: friction 0 to 1, else up to twice what it is; of a path they are given.
    numbers : tuple of int
        Modes that are meant; none: any in the band.
    band : (2,) floats
        [Hz]
    law : bool or 'slope'
        What follows the friction law along the parameter.

    """

    parameter: str
    bounds: tuple[float, float] | None = None
    numbers: tuple[int, ...] = ()
    band: tuple[float, float] = SQUEAL_BAND
    law: Law = False
    points_of_a_job = 8

    @property
    def columns(self) -> tuple[str, ...]:
        return ('start', 'growth_rate', 'below', 'below_hz', 'above', 'above_hz', 'source')

    def solve(self, place: StudyPlace) -> tuple[Columns, dict[str, float]]:
        columns = _empty(self.columns, len(place.points))
        if place.rebuilt is not None:
            self._along_design(place, place.rebuilt, columns)
            return columns, {}
        model, parameter = place.model, self.parameter
        for i, point in enumerate(place.points):
            if point is None:
                continue
            result = critical_value(
                model, point, parameter, self.bounds or default_bounds(point, parameter),
                numbers=self.numbers, band_hz=self.band,
                ray=partial(moved, model, point, parameter, friction_law=self.law))
            _take_crossings(columns, i, result.start, result.growth_rate, result.below,
                            result.above)
        return columns, {}

    def _along_design(self, place: StudyPlace, rebuilt: Rebuilt, columns: Columns) -> None:
        """Search along a dimension; models are built as the search asks for them."""
        assert self.bounds is not None
        low, high = self.bounds
        for i in range(len(place.points)):
            start, model = place.start, place.model
            level = Tolerances.of(model, place.points[i]).growth

            def least_stable(value: float, i: int = i) -> complex:
                return self._least_stable(*rebuilt(i, value))

            here = least_stable(start)
            search = BoundarySearch(parameter=self.parameter, level=level,
                                    width=_DESIGN_WIDTH * (high - low))
            _take_crossings(columns, i, start, here.real, *search.both_sides(
                start, here, self.bounds, (high - low) / _DESIGN_STEPS, least_stable))

    def _least_stable(self, model: BrakeModel | None, point: OperatingPoint | None) -> complex:
        if model is None or point is None:
            return complex(math.nan, math.nan)  # no such brake
        result = complex_modes(model, point).least_stable(*self.band)
        return result[0].eigenvalue if result else NO_MODE


def _empty(names: Sequence[str], count: int) -> Columns:
    columns = {name: np.full(count, np.nan) for name in names}
    columns['source'][:] = IMPOSSIBLE
    return columns


def _take_crossings(columns: Columns, place: int, start: float, growth: float, below: Crossing,
                    above: Crossing) -> None:
    result: dict[str, Any] = {
        'start': start, 'growth_rate': growth, 'below': below.value,
        'below_hz': below.frequency_hz, 'above': above.value, 'above_hz': above.frequency_hz,
        'source': FULL}
    for name, value in result.items():
        columns[name][place] = value


def default_bounds(point: OperatingPoint, parameter: str) -> tuple[float, float]:
    """Return default bounds of a search: friction 0 to 1, all else up to twice its value."""
    if parameter == 'friction':
        return (0.0, 1.0) if point.friction >= 0.0 else (-1.0, 0.0)
    start = float(getattr(point, parameter))
    # a speed of zero is no sliding
    least = 0.05 * start if parameter == 'rotor_speed' else 0.0
    low, high = sorted((least, 2.0 * start))
    return low, high
