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
Quiet intervals: ranges of a positive parameter, such as pressure, without an unstable mode.

A scan in equal ratios finds the verdicts, and looks closer at extrema of the growth rate that may
reach the other verdict between two of its values. Where verdicts differ, the boundary search
narrows the bracket. The end of an interval is the bracket's stable end: evaluated, not between.
"""

from collections.abc import Callable, Iterator
import math
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.boundaries import NO_MODE
from squeal_core.stability.boundary_search import BoundarySearch
from squeal_core.stability.eigensolution import complex_modes, Tolerances

LeastStable: TypeAlias = Callable[[FloatArray], ComplexArray]
"""Eigenvalues [1/s] (n,) of the least stable mode at values (n,), as of `boundary_search`."""
EndKind: TypeAlias = Literal['boundary', 'limit', 'unknown']

_RATIO = 1.2  # from one value of the scan to the next
_ROUNDS = 3  # of closer looks; each divides the two steps about an extremum by four
_WIDTH = 1e-3  # of a bracket, relative
_TRIALS = 8  # that narrow a bracket where values together cost little more than one


class IntervalEnd(NamedTuple):
    """
    An end of a quiet interval: the last quiet value that was evaluated.

    Attributes
    ----------
    value : float
        Of the parameter.
    kind : str
        'boundary': a mode is unstable beyond it; 'limit': the scan ends there; 'unknown': it is
        not known what is beyond it.
    growth_rate : float
        Of the least stable mode at the value [1/s].
    frequency_hz : float
        Of the mode that is unstable beyond it; NaN without a boundary.

    """

    value: float
    kind: EndKind
    growth_rate: float
    frequency_hz: float = math.nan


class QuietInterval(NamedTuple):
    """Values from `low` to `high` at which no mode is unstable."""

    low: IntervalEnd
    high: IntervalEnd


def quiet_intervals(parameter: str, bounds: tuple[float, float], least_stable: LeastStable, *,
                    level: float, together: bool) -> tuple[QuietInterval, ...]:
    """
    Return the quiet intervals of a parameter, in rising order.

    Parameters
    ----------
    parameter : str
        Its name, for the result.
    bounds : (2,) floats
        Of the scan, positive.
    least_stable : callable
        See `LeastStable`.
    level : float
        Growth rate above which a mode is unstable [1/s].
    together : bool
        Whether several values at once cost little more than one, as by a table.

    """
    low, high = bounds
    count = max(math.ceil(math.log(high / low) / math.log(_RATIO)), 1) + 1
    x = np.linspace(math.log(low), math.log(high), count)

    def evaluate(_: IndexArray, places: FloatArray) -> ComplexArray:
        values = np.clip(np.exp(places), low, high)  # exp(log(x)) may be beyond x
        return least_stable(values.ravel()).reshape(places.shape)

    def scan(places: FloatArray) -> ComplexArray:
        return evaluate(np.arange(places.size), places)

    x, result = _scanned(x, scan, level)
    stable = result.real <= level  # what is not known is not
    known = ~np.isnan(result.real)
    near = np.flatnonzero(known[:-1] & known[1:] & (stable[:-1] != stable[1:]))
    near, far = near + ~stable[near], near + stable[near]  # the stable end, and the other one
    trials = _TRIALS if together else 1
    search = BoundarySearch(parameter=parameter, level=level, width=_WIDTH, trials=trials)
    boundaries = search(x[near], result[near], [x[far, None]], evaluate)
    at = {(place, place > beyond): IntervalEnd(
        math.exp(end), 'unknown' if status == 'unknown' else 'boundary', here.real,
        abs(there.imag) / math.tau) for place, beyond, end, (here, there), status in zip(
            near.tolist(), far.tolist(), boundaries.ends[:, 0].tolist(),
            boundaries.eigenvalues.tolist(), boundaries.status.tolist(), strict=True)}
    at |= {(0, True): IntervalEnd(low, 'limit', float(result.real[0])),
           (x.size - 1, False): IntervalEnd(high, 'limit', float(result.real[-1]))}
    return tuple(QuietInterval(*(
        at.get(end) or IntervalEnd(math.exp(x[end[0]]), 'unknown', float(result.real[end[0]]))
        for end in ((first, True), (last, False)))) for first, last in _runs(stable))


def full_solutions(model: BrakeModel, at: SlidingConditions, pressures: FloatArray,
                   band_hz: tuple[float, float], tolerances: Tolerances) -> ComplexArray:
    """Return the least stable mode in a band at pressures (n,) [Pa], as a `LeastStable`."""
    def solve(pressure: float) -> complex:
        point = model.operating_point(**{**vars(at), 'pressure': pressure})
        try:
            worst = complex_modes(model, point, tolerances=tolerances).worst_in(*band_hz)
        except np.linalg.LinAlgError:
            return complex(math.nan, math.nan)
        return worst.eigenvalue if worst else NO_MODE

    return np.array([solve(pressure) for pressure in pressures.tolist()], dtype=complex)


def nearest_quiet(intervals: tuple[QuietInterval, ...], present: float) -> tuple[float, float]:
    """Return the largest quiet value up to a present one and the smallest from it on; or NaN."""
    below = [min(one.high.value, present) for one in intervals if one.low.value <= present]
    above = [max(one.low.value, present) for one in intervals if one.high.value >= present]
    return max(below, default=math.nan), min(above, default=math.nan)


def _scanned(x: FloatArray, evaluate: LeastStable, level: float
             ) -> tuple[FloatArray, ComplexArray]:
    """Return places and eigenvalues there, closer where the verdict may change unseen."""
    result = evaluate(x)
    for _ in range(_ROUNDS):
        growth = result.real - level
        away = np.abs(growth)
        near, left, right = away[1:-1], away[:-2], away[2:]
        with np.errstate(invalid='ignore'):  # no mode, on both sides
            closer = (near <= left) & (near <= right) & (near < np.maximum(left, right) - near)
        same = (growth[1:-1] > 0.0) == (growth[:-2] > 0.0)
        same &= (growth[1:-1] > 0.0) == (growth[2:] > 0.0)
        places = np.flatnonzero(closer & same) + 1
        if not places.size:
            break
        steps = np.array([0.25, 0.5, 0.75])
        pairs = np.unique(np.concatenate([places - 1, places]))
        more = (x[pairs, None] + steps * (x[pairs + 1] - x[pairs])[:, None]).ravel()
        x, result = np.concatenate([x, more]), np.concatenate([result, evaluate(more)])
        order = np.argsort(x)
        x, result = x[order], result[order]
    return x, result


def _runs(stable: Any) -> Iterator[tuple[int, int]]:
    """Yield the first and the last place of each run of what is true."""
    steps = np.diff(np.concatenate([[False], stable, [False]]).astype(int))
    yield from zip(np.flatnonzero(steps == 1).tolist(),
                   (np.flatnonzero(steps == -1) - 1).tolist(), strict=True)
