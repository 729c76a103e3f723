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

"""Critical values of a parameter, at which the brake crosses the stability boundary."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
import math
from typing import TypeAlias

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import OperatingPointError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.boundaries import Crossing, NO_MODE
from squeal_core.stability.boundary_search import BoundarySearch
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.stability.mode_tracking import follow, identify, Tracked
from squeal_core.stability.parameter_paths import between, moved

Ray: TypeAlias = Callable[[float], OperatingPoint]


@dataclass(frozen=True)
class CriticalValue:
    """The crossings nearest to a start, `below` and `above` it, and the growth rate there."""

    parameter: str
    start: float
    growth_rate: float
    below: Crossing
    above: Crossing

    @property
    def nearest(self) -> Crossing:
        """Return the nearer crossing; `above` where there is none."""
        result = [c for c in (self.above, self.below) if not math.isnan(c.value)]
        return min(result, key=lambda c: abs(c.value - self.start), default=self.above)


def critical_value(model: BrakeModel, point: OperatingPoint, parameter: str,
                   bounds: tuple[float, float], *, numbers: Collection[int] = (),
                   ray: Ray | None = None, band_hz: tuple[float, float] = SQUEAL_BAND,
                   samples: int = 40, tolerance: float = 1e-6,
                   tolerances: Tolerances | None = None) -> CriticalValue:
    """
    Return the stability boundaries along a ray through a point, by full solutions.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Where the search starts, in both directions.
    parameter : str
        What changes: 'friction' (its slope in proportion), 'rotor_speed', 'contact_pressure',
        'contact_stiffness' or 'friction_slope'.
    bounds : (2,) floats
        Of the parameter; the point lies between them.
    numbers : collection of int
        Identities (`tracking.identify`) of the modes that are meant; none: any mode that
        oscillates in the band.
    ray : callable, optional
        Operating point at a value of the parameter, where more than the parameter changes, as
        friction by a law of speed.
    band_hz : (2,) floats
        Low and high end [Hz].
    samples : int
        Steps of the search over the bounds. Two crossings within a step pass unseen.
    tolerance : float
        Width of the bracket, relative to the distance of the bounds.
    tolerances : Tolerances, optional
        Of them, `growth` is what counts as unstable.

    Returns
    -------
    CriticalValue
        The nearest boundary on either side of the point.

    Raises
    ------
    OperatingPointError
        For a parameter that does not exist, bounds that leave the point out, or numbers that are
        no mode's.

    Examples
    --------
    >>> from squeal_core import BrakeModel, critical_value, OperatingPoint
    >>> model = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=0.002,
    ...                    friction_couple=[[0.0, 1e-3], [-1e-3, 0.0]])
    >>> point = OperatingPoint(rotor_speed=7.0, friction=0.1, contact_pressure=5e5,
    ...                        contact_stiffness=1e10)
    >>> print(critical_value(model, point, 'friction', (0.0, 1.0)).above.reason)
    stability boundary mu = 0.2061 (1607 Hz), stable below

    """
    low, high = bounds
    moved(model, point, parameter, high)  # says which parameters there are
    start = float(getattr(point, parameter))
    if not low <= start <= high or not low < high:
        raise OperatingPointError(f'bounds are {low:g} and {high:g}, {parameter} is {start:g}; '
                                  'give bounds on either side of it')
    if not set(numbers) <= set(range(1, model.size + 1)):
        raise OperatingPointError(f'numbers are {sorted(numbers)}; give numbers of modes, 1 to '
                                  f'{model.size}')
    limits = tolerances or Tolerances.of(model, point)
    solver = _FullSolver(
        model, ray or (lambda value: moved(model, point, parameter, value)), start, high - low,
        frozenset(numbers), band_hz, limits)
    search = BoundarySearch(parameter=parameter, level=limits.growth,
                            width=tolerance * (high - low))
    here = solver(start)
    below, above = search.both_sides(start, here, bounds, (high - low) / samples, solver)
    return CriticalValue(parameter, start, here.real, below=below, above=above)


class _FullSolver:
    """The least stable of the modes that are meant, by full solutions along a ray."""

    def __init__(self, model: BrakeModel, at: Ray, start: float, span: float,
                 numbers: frozenset[int], band_hz: tuple[float, float],
                 limits: Tolerances) -> None:
        self._model, self._at, self._span, self._limits = model, at, span, limits
        self._numbers, self._band = numbers, band_hz
        self._known: dict[float, Tracked] = {}
        if numbers:
            self._known[start] = identify(model, at(start), tolerances=limits)

    def __call__(self, value: float) -> complex:
        if self._numbers:
            result = self._tracked(value).of(self._numbers)
        else:
            result = complex_modes(self._model, self._at(value),
                                   tolerances=self._limits).least_stable(*self._band)
        return result[0].eigenvalue if result else NO_MODE

    def _tracked(self, value: float) -> Tracked:
        nearest = min(self._known, key=lambda known: abs(known - value))
        if nearest != value:
            way = between(self._model, self._at(nearest), self._at(value))
            self._known[value] = follow(self._model, way, self._known[nearest],
                                        parts=self._span / abs(value - nearest),
                                        tolerances=self._limits)
        return self._known[value]
