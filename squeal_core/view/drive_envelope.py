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

"""A drive of any length in a fixed number of intervals of time, for a plot: extremes of each."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
import math

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.results.history import AssessmentRecord

_FREQUENCY_STEP = 10.0  # Hz; modes of an interval closer than this are one mark


@dataclass(frozen=True, eq=False)
class BrakeEnvelope:
    """
    Extremes of one brake in each interval; NaN where nothing is known.

    Parameters
    ----------
    rotor_speed, pressure : arrays (n, 2)
        Smallest and largest [rad/s], [Pa].
    risk : array (n,)
        Largest squeal risk [-].

    """

    rotor_speed: FloatArray
    pressure: FloatArray
    risk: FloatArray

    @classmethod
    def empty(cls, count: int) -> 'BrakeEnvelope':
        return cls(np.full((count, 2), np.nan), np.full((count, 2), np.nan),
                   np.full(count, np.nan))

    def add(self, at: int, row: AssessmentRecord) -> None:
        for extremes, value in ((self.rotor_speed, row.rotor_speed_rad_s),
                                (self.pressure, row.pressure_pa)):
            extremes[at, 0] = np.fmin(extremes[at, 0], value)
            extremes[at, 1] = np.fmax(extremes[at, 1], value)
        self.risk[at] = np.fmax(self.risk[at], row.squeal_risk)


@dataclass(eq=False)
class DriveEnvelope:
    """
    Extremes of all brakes over a drive, in intervals of equal length.

    Parameters
    ----------
    edges : array (n + 1,)
        Ends of the intervals [s].
    brakes : dict
        `BrakeEnvelope` of each brake, in order of appearance.
    modes : dict
        Largest growth rate [1/s] of the unstable modes at (interval, step of frequency).

    """

    edges: FloatArray
    brakes: dict[str, BrakeEnvelope] = field(default_factory=dict)
    modes: dict[tuple[int, int], float] = field(default_factory=dict)

    @property
    def times(self) -> FloatArray:
        """Middles of the intervals [s], array (n,)."""
        return 0.5 * (self.edges[:-1] + self.edges[1:])

    def add(self, row: AssessmentRecord) -> None:
        count = self.edges.size - 1
        width = self.edges[1] - self.edges[0]
        at = min(max(math.floor((row.time_s - self.edges[0]) / width), 0), count - 1)
        if row.brake not in self.brakes:
            self.brakes[row.brake] = BrakeEnvelope.empty(count)
        self.brakes[row.brake].add(at, row)
        for frequency, growth in zip(row.unstable_frequencies_hz, row.unstable_growth_rates_1_s,
                                     strict=True):
            key = at, round(frequency / _FREQUENCY_STEP)
            self.modes[key] = max(self.modes.get(key, -math.inf), growth)

    @property
    def marks(self) -> FloatArray:
        """Time [s], frequency [Hz] and growth rate [1/s] of the unstable modes, array (k, 3)."""
        times = self.times
        return np.array([(times[at], step * _FREQUENCY_STEP, growth)
                         for (at, step), growth in self.modes.items()]).reshape(-1, 3)


def drive_envelope(rows: Callable[[], Iterable[AssessmentRecord]], *,
                   most: int = 1500) -> DriveEnvelope:
    """
    Return the envelope of a drive, in two passes over its rows.

    Parameters
    ----------
    rows : callable
        Gives the rows anew at each call, in order of time.
    most : int
        Intervals; fewer where there are fewer ticks, so that each tick then has its own.

    """
    first, last, step = math.inf, -math.inf, math.inf
    for row in rows():
        if row.time_s > last > -math.inf:
            step = min(step, row.time_s - last)
        first, last = min(first, row.time_s), max(last, row.time_s)
    if not math.isfinite(first):
        return DriveEnvelope(np.array([0.0, 1.0]))
    step = step if math.isfinite(step) else 1.0
    count = min(round((last - first) / step) + 1, most)
    width = max(step, (last - first) / count)
    edges: FloatArray = first - 0.5 * step + width * np.arange(count + 1, dtype=np.float64)
    envelope = DriveEnvelope(edges)
    for row in rows():
        envelope.add(row)
    return envelope


def outline(envelope: DriveEnvelope, extremes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times and values of a line through both extremes of each interval."""
    return np.repeat(envelope.times, 2), extremes.ravel()
