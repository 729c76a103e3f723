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

"""A stretch of a drive in a bounded number of points: extremes of intervals, unstable modes."""

from dataclasses import dataclass, field
import math
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.view.report.tick_stream import BoolArray, Ticks

CURVES = ('rotor_speed_rad_s', 'pressure_pa', 'friction', 'temperature_k', 'squeal_risk')
MOST_POINTS = 8_000  # of a curve
_MOST_MARKS = 4_000  # of unstable modes
_FREQUENCY_STEP = 20.0  # Hz; modes of an interval closer than this are one mark


class Curve(NamedTuple):
    """Values at equal intervals, NaN in gaps; times from the start of the recording [s]."""

    start: float
    step: float
    value: FloatArray


@dataclass(eq=False)
class _Extremes:
    """Smallest and largest value of each interval of one brake, and unknown intervals."""

    low: dict[str, FloatArray]
    high: dict[str, FloatArray]
    sliding: BoolArray
    unknown: BoolArray

    @classmethod
    def empty(cls, count: int) -> '_Extremes':
        low, high = ({name: np.full(count, np.nan) for name in CURVES} for _ in range(2))
        return cls(low, high, np.zeros(count, bool), np.zeros(count, bool))


@dataclass(eq=False)
class StretchEnvelope:
    """
    Envelope of a stretch; an accumulator of ticks.

    A stretch of few ticks has a point for each of them, another one two for each interval: the
    smallest and the largest value.

    Parameters
    ----------
    start, end : float
        [s], on the clock of the recording.
    rate : float
        Ticks a second of a brake.
    origin : float
        From which times count [s].

    """

    start: float
    end: float
    rate: float
    origin: float
    brakes: dict[str, _Extremes] = field(default_factory=dict)
    _marks: dict[tuple[int, int], float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        ticks = math.floor((self.end - self.start) * self.rate + 1e-6) + 1
        self.single = ticks <= MOST_POINTS
        self.count = ticks if self.single else MOST_POINTS // 2
        self.width = (1.0 / self.rate) if self.single else (
            (self.end - self.start + 1.0 / self.rate) / self.count)

    @property
    def times(self) -> FloatArray:
        """Return the times of the intervals from the start of the recording [s], array (n,)."""
        middle = 0.0 if self.single else 0.5 * (self.width - 1.0 / self.rate)
        return self.start - self.origin + middle + self.width * np.arange(self.count, dtype=float)

    def add(self, ticks: Ticks) -> None:
        """Take further ticks of a brake."""
        time = ticks.numbers['time_s']
        inside = np.flatnonzero((time >= self.start - 1e-6) & (time <= self.end + 1e-6))
        if not inside.size:
            return
        own = self.brakes.setdefault(ticks.brake, _Extremes.empty(self.count))
        at = np.clip(np.floor((time[inside] - self.start) / self.width + 0.5 * self.single),
                     0, self.count - 1).astype(int)
        for name in CURVES:
            values = ticks.numbers[name][inside]
            np.fmin.at(own.low[name], at, values)
            np.fmax.at(own.high[name], at, values)
        own.sliding[at[ticks.sliding[inside]]] = True
        own.unknown[at[ticks.unknown[inside]]] = True
        for place, tick in zip(at.tolist(), inside.tolist(), strict=True):
            if ticks.frequencies_hz[tick]:
                self._mark(place, ticks.frequencies_hz[tick], ticks.growth_rates[tick])

    def _mark(self, place: int, frequencies: str, growth_rates: str) -> None:
        for frequency, growth in zip(map(float, frequencies.split()),
                                     map(float, growth_rates.split()), strict=False):
            key = place, round(frequency / _FREQUENCY_STEP)
            self._marks[key] = max(self._marks.get(key, -math.inf), growth)

    def curve(self, brake: str, name: str) -> Curve:
        """Return the points of a curve of a brake."""
        own, first = self.brakes[brake], float(self.times[0])
        if self.single:
            return Curve(first, self.width, own.high[name])
        return Curve(first - 0.25 * self.width, 0.5 * self.width,
                     np.column_stack([own.low[name], own.high[name]]).ravel())

    def stretches(self, flags: BoolArray) -> FloatArray:
        """Return the starts and ends of the intervals of which something is so, array (k, 2)."""
        steps = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
        first = self.times[0] - 0.5 * self.width
        ends = np.column_stack([np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)])
        result: FloatArray = first + self.width * ends
        return result

    def modes(self) -> FloatArray:
        """
        Return time [s], frequency [Hz] and growth rate [1/s] of the unstable modes, array (k, 3).

        Where they are too many, neighbouring intervals are one and keep the largest growth rate.
        """
        marks, merged = self._marks, 1
        while len(marks) > _MOST_MARKS:
            merged *= 2
            fewer: dict[tuple[int, int], float] = {}
            for (place, step), growth in marks.items():
                key = place // 2, step
                fewer[key] = max(fewer.get(key, -math.inf), growth)
            marks = fewer
        times = self.times
        return np.array([(times[min(merged * place + merged // 2, self.count - 1)],
                          step * _FREQUENCY_STEP, growth)
                         for (place, step), growth in marks.items()]).reshape(-1, 3)
