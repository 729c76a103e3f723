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

"""Stability boundaries along a parameter: of one search in words, of several as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray

NO_MODE = complex(-math.inf, math.nan)  # 1/s
_UNITS = {'friction': '', 'rotor_speed': ' rad/s', 'pressure': ' Pa', 'contact_pressure': ' Pa',
          'contact_stiffness': ' N/m^3', 'friction_slope': ' s/m'}


class Crossing(NamedTuple):
    """
    A stability boundary along a parameter, or that there is none.

    Parameters
    ----------
    value : float
        Critical value of the parameter; NaN without a boundary.
    bracket : (2,) floats
        On either side of it, first the one nearer to the start; without a boundary, the start
        and the end of the search.
    growth_rates : (2,) floats
        Evaluated at both ends of the bracket [1/s]; -inf where no mode is in the band.
    frequency_hz : float
        Of the mode that is unstable at one end of the bracket; NaN without a boundary.
    converged : bool
        Whether the bracket is as narrow as asked for and the growth rate goes through zero in it.
    reason : str
        The result in words.
    solves : int
        Values evaluated.

    """

    value: float
    bracket: tuple[float, float]
    growth_rates: tuple[float, float]
    frequency_hz: float
    converged: bool
    reason: str
    solves: int


@dataclass(frozen=True, eq=False)
class Boundaries:
    """
    Results of B searches, and their brackets meanwhile.

    Parameters
    ----------
    parameter : str
    level : float
        Growth rate above which a mode is unstable [1/s].
    start : (B,) array
        Where each search began.
    ends : (B, 2) array
        The bracket, first the end nearer to the start; without a boundary that one is the last
        value of the start's verdict.
    eigenvalues : (B, 2) array
        At both ends [1/s].
    values : (B,) array
        Critical values; NaN without a boundary.
    status : (B,) array of str
        'none': the verdict did not change; 'found'; 'jump': the growth rate does not go through
        zero in the bracket; 'unknown': the table does not answer.
    solves : (B,) array
        Values evaluated.

    """

    parameter: str
    level: float
    start: FloatArray
    ends: FloatArray
    eigenvalues: ComplexArray
    values: FloatArray
    status: Any
    solves: IndexArray

    @classmethod
    def begun(cls, parameter: str, level: float, start: FloatArray,
              eigenvalues: ComplexArray) -> 'Boundaries':
        count = start.size
        return cls(parameter, level, start, np.repeat(start, 2).reshape(count, 2),
                   np.repeat(eigenvalues, 2).reshape(count, 2), np.full(count, np.nan),
                   np.full(count, 'found', dtype='U7'), np.zeros(count, np.intp))

    @property
    def widths(self) -> FloatArray:
        """Return the widths of the brackets."""
        return np.abs(self.ends[:, 1] - self.ends[:, 0])

    @property
    def changes(self) -> FloatArray:
        """Return the change of the growth rate over each [1/s]; not finite where no mode is."""
        return np.abs(self.eigenvalues.real[:, 1] - self.eigenvalues.real[:, 0])

    @property
    def unstable(self) -> Any:
        """Return whether the brake is unstable at the start, (B,)."""
        return self.eigenvalues.real[:, 0] > self.level

    @property
    def zeros(self) -> FloatArray:
        """Return the crossings of the level by the chords, as fractions of the bracket."""
        growth = self.eigenvalues.real
        return np.asarray((growth[:, 0] - self.level) / (growth[:, 0] - growth[:, 1]))

    def take(self, rows: IndexArray, trials: FloatArray, eigenvalues: ComplexArray, *,
             past_unknown: bool) -> Any:
        """
        Move the ends of brackets to trials (R, n), in order from the start; return which changed.

        The far end goes to the first trial of the other verdict, the near end to the last one
        before it. Unless they are passed over, trials that are not known end a search.
        """
        growth, places = eigenvalues.real, np.arange(trials.shape[1] + 1)
        missing, other = np.isnan(growth), (growth > self.level) != self.unstable[rows, None]
        ends = other & ~missing if past_unknown else other | missing
        far = np.where(ends.any(axis=1), ends.argmax(axis=1) + 1, places.size)
        near = (places[1:] * (~missing & (places[1:] < far[:, None]))).max(axis=1, initial=0)
        changed = far < places.size
        for known, tried in ((self.ends, trials), (self.eigenvalues, eigenvalues)):
            values = np.concatenate([known[rows, :1], tried], axis=1)
            known[rows, 0] = values[np.arange(rows.size), near]
            known[rows[changed], 1] = values[changed, far[changed]]
        self.solves[rows] += trials.shape[1]
        return changed

    def crossings(self) -> list[Crossing]:
        """Return the result of each search, in words, too."""
        columns = (self.start, self.ends, self.eigenvalues.real, self.eigenvalues.imag,
                   self.unstable, self.values, self.status, self.solves)
        return [*map(self._crossing, *(column.tolist() for column in columns))]

    def _crossing(self, start: float, ends: Sequence[float], rates: Sequence[float],
                  frequencies: Sequence[float], unstable: bool, value: float, status: str,
                  solves: int) -> Crossing:
        near, far = ends
        if status in ('none', 'unknown'):
            remark = '; outside the table beyond it' if status == 'unknown' else ''
            return Crossing(
                value=math.nan, bracket=(start, near), growth_rates=(rates[0], rates[0]),
                frequency_hz=math.nan, converged=False, solves=solves,
                reason=f'no stability boundary from {self._quoted(start)} to {near:.4g}, '
                       f'{"unstable" if unstable else "stable"}{remark}')
        hertz = abs(frequencies[0 if unstable else 1]) / (2.0 * math.pi)
        side = 'above' if unstable == (far > near) else 'below'
        reason = f'stability boundary {self._quoted(value)} ({hertz:.0f} Hz), stable {side}'
        if status == 'jump':
            reason += ', by a jump: a mode leaves or enters the band or the group'
        return Crossing(value, (near, far), (rates[0], rates[1]), hertz, status == 'found',
                        reason, solves)

    def _quoted(self, value: float) -> str:
        name = 'mu' if self.parameter == 'friction' else self.parameter.replace('_', ' ')
        return f'{name} = {value:.4g}{_UNITS.get(self.parameter, "")}'
