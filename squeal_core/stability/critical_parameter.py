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
How far it is to the edge: where along a ray a mode starts to grow, and where two modes merge.

Both are found by solves and bracketed or verified by solves, never extrapolated.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
import math
from typing import TypeAlias

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import OperatingPointError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, Mode, Tolerances
from squeal_core.stability.mode_tracking import between, follow, identify, moved, Tracked

SQUEAL_BAND = (1250.0, 16000.0)  # Hz, SAE J2521
Ray: TypeAlias = Callable[[float], OperatingPoint]


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """
    Where a growth rate passes through zero, or that it does not.

    Parameters
    ----------
    value : float
        Of the parameter, the middle of the bracket; NaN where there is no crossing.
    bracket : (2,) floats
        On either side of it, first the one nearer to the start; without a crossing, the start
        and the end of the search.
    growth_rates : (2,) floats
        By a solve at each [1/s]; -inf where no mode is in the band.
    frequency_hz : float
        Of the mode that grows at one end of the bracket; NaN without a crossing.
    converged : bool
        Whether the bracket is as narrow as asked for and the growth rate goes through zero in it.
    reason : str
        The result in words.
    solves : int

    """

    value: float
    bracket: tuple[float, float]
    growth_rates: tuple[float, float]
    frequency_hz: float
    converged: bool
    reason: str
    solves: int


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
        """Return the nearer one; where there is none, the one above."""
        found = [c for c in (self.above, self.below) if not math.isnan(c.value)]
        return min(found, key=lambda c: abs(c.value - self.start), default=self.above)


def critical_value(model: BrakeModel, point: OperatingPoint, parameter: str,
                   bounds: tuple[float, float], *, numbers: Collection[int] = (),
                   ray: Ray | None = None, band_hz: tuple[float, float] = SQUEAL_BAND,
                   samples: int = 40, tolerance: float = 1e-6,
                   tolerances: Tolerances | None = None) -> CriticalValue:
    """
    Return where along a ray through a point a mode starts or ceases to grow.

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
        Width of the bracket, as a part of the bounds' distance.
    tolerances : Tolerances, optional
        Of them, `growth` is what counts as growing.

    """
    low, high = bounds
    moved(model, point, parameter, high)  # says what the parameters are
    start = float(getattr(point, parameter))
    if not low <= start <= high or not low < high:
        raise OperatingPointError(f'bounds are {low:g} and {high:g}, {parameter} is {start:g}; '
                                  'give bounds on either side of it')
    if not set(numbers) <= set(range(1, model.size + 1)):
        raise OperatingPointError(f'numbers are {sorted(numbers)}; give numbers of modes, 1 to '
                                  f'{model.size}')
    limits = tolerances or Tolerances.of(model, point)
    at = ray or (lambda value: moved(model, point, parameter, value))
    search = _Search(_Growth(model, at, start, high - low, frozenset(numbers), band_hz, limits),
                     limits.growth, (high - low) / samples, tolerance * (high - low))
    return CriticalValue(parameter, start, search.growth(start).growth_rate,
                         below=search.towards(start, low), above=search.towards(start, high))


class _Growth:
    """The least stable of the modes that are meant, at a value of the parameter; counts solves."""

    def __init__(self, model: BrakeModel, at: Ray, start: float, span: float,
                 numbers: frozenset[int], band_hz: tuple[float, float],
                 limits: Tolerances) -> None:
        self._model, self._at, self._span, self._limits = model, at, span, limits
        self._numbers, self._band = numbers, band_hz
        self._known: dict[float, Tracked] = {}
        if numbers:
            self._known[start] = identify(model, at(start), tolerances=limits)
        self.solves = 0

    def __call__(self, value: float) -> Mode:
        self.solves += 1
        if self._numbers:
            found = self._tracked(value).of(self._numbers)
        else:
            found = tuple(
                mode for mode in complex_modes(self._model, self._at(value),
                                               tolerances=self._limits).modes
                if mode.kind in ('flutter', 'stable')
                and self._band[0] <= mode.frequency_hz <= self._band[1])
        return max(found, key=lambda mode: mode.growth_rate, default=_NONE)

    def _tracked(self, value: float) -> Tracked:
        nearest = min(self._known, key=lambda known: abs(known - value))
        if nearest != value:
            way = between(self._model, self._at(nearest), self._at(value))
            self._known[value] = follow(self._model, way, self._known[nearest],
                                        parts=self._span / abs(value - nearest),
                                        tolerances=self._limits)
        return self._known[value]


_NONE = Mode(0, complex(-math.inf, math.nan), 'stable')


@dataclass(frozen=True)
class _Search:
    """Steps away from a start until the sign changes, then halves the bracket."""

    growth: _Growth
    level: float
    step: float
    width: float

    def towards(self, start: float, end: float) -> Crossing:
        solved, near = self.growth.solves, (start, self.growth(start))
        grows = near[1].growth_rate > self.level
        count = max(math.ceil(abs(end - start) / self.step - 1e-9), 0)
        for i in range(1, count + 1):
            value = end if i == count else start + math.copysign(i * self.step, end - start)
            far = (value, self.growth(value))
            if (far[1].growth_rate > self.level) != grows:
                return self._halved(near, far, solved)
            near = far
        word = 'grows' if grows else 'is stable'
        return self._crossing(
            (start, self.growth(start)), near, math.nan, False, solved,
            f'{word} from {start:g} to {end:g}, by {count} steps of {self.step:g} at most')

    def _halved(self, near: tuple[float, Mode], far: tuple[float, Mode], solved: int) -> Crossing:
        grows, wide = near[1].growth_rate > self.level, _gap(near, far)
        while abs(far[0] - near[0]) > self.width:
            value = 0.5 * (near[0] + far[0])
            if value in (near[0], far[0]):
                break
            middle = (value, self.growth(value))
            if (middle[1].growth_rate > self.level) == grows:
                near = middle
            else:
                far = middle
            wide = wide if math.isfinite(wide) else _gap(near, far)
        # a growth rate that passes through zero differs little over a small bracket
        gap = _gap(near, far)
        through = math.isfinite(gap) and gap <= max(0.1 * wide, self.level)
        verb = 'ceases' if grows else 'starts'
        reason = f'{verb} to grow; bracket {abs(far[0] - near[0]):.3g} wide' if through else (
            f'{verb} to grow by a jump: the mode that grows does not pass through zero here, but '
            'leaves or enters the band or the group')
        return self._crossing(near, far, 0.5 * (near[0] + far[0]), through, solved, reason)

    def _crossing(self, near: tuple[float, Mode], far: tuple[float, Mode], value: float,
                  converged: bool, solved: int, reason: str) -> Crossing:
        growing = max(near[1], far[1], key=lambda mode: mode.growth_rate)
        return Crossing(
            value=value, bracket=(near[0], far[0]),
            growth_rates=(near[1].growth_rate, far[1].growth_rate), converged=converged,
            frequency_hz=math.nan if math.isnan(value) else growing.frequency_hz,
            reason=reason, solves=self.growth.solves - solved)


def _gap(near: tuple[float, Mode], far: tuple[float, Mode]) -> float:
    """Difference of growth rates [1/s]; infinite where there is no mode on one side."""
    gap = abs(far[1].growth_rate - near[1].growth_rate)
    return math.inf if math.isnan(gap) else gap
