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
Search for stability boundaries along a parameter: walk away from a start, narrow the bracket.

The same search runs offline, by full solutions one at a time, and online, by the table of local
expansions for all brakes and several values at once. Both ends of a bracket are evaluated, never
extrapolated.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.stability.boundaries import Boundaries, Crossing

Evaluate: TypeAlias = Callable[[IndexArray, FloatArray], ComplexArray]
"""
Eigenvalues [1/s] of the least stable mode, given which of the searches ask (R,) and for which
values (R, n): `NO_MODE` where no mode is in the band, NaN where it is not known.
"""

_RUNG = 4.0  # ratio of distances from the chord's zero, from one pair of trials to the next
_ASIDE = 0.1  # of the first bracket: about the error of its first chord
_EDGE = 1e-3  # of the bracket, from its ends to the nearest trial
_DOUBT = 1e-3  # of the width asked for, down to which what looks like a jump is narrowed
# A bracket w of the first one leaves this power of w of the change of growth over it, at most:
# 1 where growth is smooth, 1/2 at the square root of two modes that merge, 0 at a jump.
_SMOOTH = 0.25
_ROUNDING = 1e-14


@dataclass(frozen=True, kw_only=True)
class BoundarySearch:
    """
    Walks away from starts until the verdict changes, then narrows the brackets.

    Parameters
    ----------
    parameter : str
        For the words of the results.
    level : float
        Growth rate above which a mode is unstable [1/s].
    width : float
        Of a bracket at the end, in units of the parameter.
    trials : int
        Values at once that narrow a bracket: 1, or an even number.

    Notes
    -----
    Brackets are narrowed by regula falsi: trials lie close to either side of the chord's zero
    (a single one towards the middle, so that both ends come near); of four or more, half divide
    the bracket evenly. Trials that do not halve the bracket are followed by an even division of
    it, so that a search by single trials takes at most twice as many as bisection; where growth
    is smooth it takes a third.

    """

    parameter: str
    level: float
    width: float
    trials: int = 1

    def __call__(self, start: FloatArray, eigenvalues: ComplexArray,
                 trials: Iterable[FloatArray], evaluate: Evaluate) -> Boundaries:
        """
        Return the nearest boundary of each of B searches.

        Parameters
        ----------
        start : (B,) array
            Where each search begins.
        eigenvalues : (B,) array
            Of the least stable mode there [1/s].
        trials : iterable of (B, n) arrays
            Values to walk along, in order from the start, each array evaluated at once; two
            boundaries between two values pass unseen.
        evaluate : callable
            See `Evaluate`.

        """
        result = Boundaries.begun(self.parameter, self.level, start, eigenvalues)
        rows = np.arange(start.size)
        for values in trials:
            some = values[rows]
            rows = rows[~result.take(rows, some, evaluate(rows, some), past_unknown=False)]
            if not rows.size:
                break
        result.status[rows] = 'none'
        result.status[np.isnan(result.eigenvalues.real[:, 1])] = 'unknown'
        with np.errstate(invalid='ignore', divide='ignore'):  # where there is no mode
            self._narrow(result, evaluate)
        return result

    def both_sides(self, start: float, eigenvalue: complex, bounds: tuple[float, float],
                   step: float, at: Callable[[float], complex]) -> tuple[Crossing, Crossing]:
        """
        Return the nearest crossings below and above a start, by one solution at a time.

        Parameters
        ----------
        start : float
            Where both searches begin.
        eigenvalue : complex
            Of the least stable mode there [1/s].
        bounds : (2,) floats
            Where they end.
        step : float
            Of the walks.
        at : callable
            Eigenvalue of the least stable mode at a value; see `Evaluate`.

        """
        below, above = (self(np.array([start]), np.array([eigenvalue]), linear_walk(
            start, end, step).T[..., None], one_by_one(at)).crossings()[0] for end in bounds)
        return below, above

    def _narrow(self, result: Boundaries, evaluate: Evaluate) -> None:
        widths, searching, even = result.widths, result.status == 'found', np.zeros(
            result.start.size, bool)
        first, reference, change = widths, widths, result.changes
        while True:
            through = self._through(result.changes, change, widths / reference)
            least = np.maximum(np.where(through, 1.0, _DOUBT) * self.width,
                               _ROUNDING * np.abs(result.ends[:, 0]))
            rows = (searching & (widths > least)).nonzero()[0]
            if not rows.size:
                break
            trials = self._trials(result, rows, first, even)
            result.take(rows, trials, evaluate(rows, trials), past_unknown=True)
            narrowed = result.widths
            even[rows] = narrowed[rows] > 0.5 * widths[rows]
            stuck = rows[narrowed[rows] == widths[rows]]
            result.status[stuck], searching[stuck] = 'unknown', False
            widths, lacking = narrowed, ~np.isfinite(change)
            reference = np.where(lacking, widths, reference)
            change = np.where(lacking, result.changes, change)
        result.status[searching & ~through] = 'jump'
        fraction = np.where(through, result.zeros, 0.5)
        values = result.ends[:, 0] + fraction * (result.ends[:, 1] - result.ends[:, 0])
        result.values[searching] = values[searching]

    def _trials(self, result: Boundaries, rows: IndexArray, first: FloatArray,
                even: Any) -> FloatArray:
        """Return values (R, n) strictly between both ends, from the near one to the far one."""
        spans = (result.ends[:, 1] - result.ends[:, 0])[rows]
        zeros = result.zeros[rows, None]
        aside = np.maximum(_ASIDE * np.abs(spans) / first[rows],
                           np.minimum(0.4 * self.width / np.abs(spans), _ASIDE))[:, None]
        if self.trials == 1:
            parts = zeros + np.copysign(np.minimum(aside, np.abs(0.5 - zeros)), 0.5 - zeros)
        else:
            pairs = -(-self.trials // 4)
            about = aside * _RUNG ** -np.arange(float(pairs))
            rest = self.trials - 2 * pairs
            parts = np.concatenate([zeros - about, zeros + about, np.broadcast_to(
                np.arange(1, rest + 1) / (rest + 1), (rows.size, rest))], axis=1)
            parts.sort(axis=1)
        division = np.arange(1, self.trials + 1) / (self.trials + 1)
        evenly = even[rows] | ~np.isfinite(result.changes[rows])
        parts = np.where(evenly[:, None], division, np.clip(parts, _EDGE, 1.0 - _EDGE))
        return np.asarray(result.ends[rows, :1] + spans[:, None] * parts)

    def _through(self, changes: FloatArray, change: FloatArray, narrower: FloatArray) -> Any:
        """Return whether the growth rate crosses zero, by its change over the bracket."""
        return np.isfinite(changes) & (
            changes <= np.maximum(change * narrower ** _SMOOTH, self.level))


def one_by_one(at: Callable[[float], complex]) -> Evaluate:
    """Return an evaluation of one search by one solution at a time."""
    return lambda _, values: np.array([[at(value) for value in row] for row in values.tolist()])


def linear_walk(start: float, end: float, step: float) -> FloatArray:
    """Return the values (1, n) after a start to an end, in equal steps but for the last one."""
    count = max(math.ceil(abs(end - start) / step - 1e-9), 0)
    values = start + math.copysign(step, end - start) * np.arange(
        1.0, count + 1.0, dtype=np.float64)
    values[-1:] = end
    return values[None]
