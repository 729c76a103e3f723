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

"""Recent history of one input in equal steps of time, at any rate of samples and of ticks."""

from bisect import bisect_right
from collections import deque
import math
from operator import itemgetter

STEP = 50_000_000  # ns; ABS at 15 Hz has a dip in each
_SECOND = 1_000_000_000
_KEPT = 4096  # samples that wait for a tick
_SMOOTHING = 1.0 - math.exp(-STEP / (0.5 * _SECOND))  # over 0.5 s
_HISTORY = 20  # steps: 1 s
_LEAST_STEP = 1_000_000  # ns; two samples may have the same stamp

_by_stamp = itemgetter(0)


class SignalWindow:
    """
    The samples of the last step, their mean and extremes, and a second of means before.

    Values are NaN while the input has no sample that is fresh, so comparisons with them are false.

    Parameters
    ----------
    max_age : float
        Older than this the newest sample is no value [s].
    minimum, maximum : float
        Samples outside are dropped.

    """

    def __init__(self, max_age: float, minimum: float, maximum: float) -> None:
        self._waiting: list[tuple[int, float]] = []
        self._in_order = True
        self.update_settings(max_age, minimum, maximum)
        self.forget()

    def update_settings(self, max_age: float, minimum: float, maximum: float) -> None:
        self._max_age = round(max_age * _SECOND)
        self._minimum, self._maximum = minimum, maximum

    def forget(self, after: int | None = None) -> None:
        """Discard all samples; those up to a time [ns] that no step has seen stay, if given."""
        self._waiting = [] if after is None else [
            sample for sample in self._waiting if sample[0] <= after]
        self._newest = 0
        self._last = math.nan
        self.begin_anew()

    def begin_anew(self) -> None:
        """Discard the history; the newest sample stays."""
        self.mean = self.high = self.smooth = math.nan
        self.means: deque[float] = deque(maxlen=_HISTORY)
        self.swings = PressureSwings()

    def receive(self, stamp: int, value: float) -> None:
        """Take a sample, to be looked at when its time has come."""
        if stamp <= 0 or not self._minimum <= value <= self._maximum:
            return
        self._in_order = self._in_order and (
            not self._waiting or stamp >= self._waiting[-1][0])
        self._waiting.append((stamp, value))
        if len(self._waiting) > _KEPT:
            del self._waiting[0]

    def advance(self, end: int, *, swings: bool = False) -> None:
        """Process the samples stamped up to the end of a step [ns]."""
        new = self._due(end)
        if new:
            self._newest, self._last = new[-1]
            if len(new) == 1:
                self.mean, self.high = 0.0 + self._last, self._last
            else:
                values = [value for _, value in new]
                self.mean, self.high = sum(values) / len(values), max(values)
            if swings:
                for stamp, value in new:
                    self.swings.add(stamp, value)
        elif end - self._newest <= self._max_age:
            self.mean = self.high = self._last
        if end - self._newest > self._max_age:
            self.mean = self.high = math.nan
        mean, smooth = self.mean, self.smooth
        known = mean == mean and smooth == smooth  # neither is NaN
        self.smooth = smooth + _SMOOTHING * (mean - smooth) if known else mean
        self.means.append(self.mean)

    def _due(self, end: int) -> list[tuple[int, float]]:
        """Take the samples up to the end of a step that are no older than the newest before."""
        waiting = self._waiting
        if not waiting or self._in_order and waiting[0][0] > end:
            return []
        if not self._in_order:
            waiting.sort(key=_by_stamp)
            self._in_order = True
        if waiting[-1][0] <= end:
            due, self._waiting = waiting, []
        else:
            count = bisect_right(waiting, end, key=_by_stamp)
            due, self._waiting = waiting[:count], waiting[count:]
        return due if not due or due[0][0] >= self._newest else [
            sample for sample in due if sample[0] >= self._newest]

    def fall(self, steps: int) -> float:
        """Return the rate of fall of the magnitude over the last steps [1/s]; 0 if not known."""
        if len(self.means) <= steps:
            return 0.0
        fall = (abs(self.means[-1 - steps]) - abs(self.means[-1])) * _SECOND / (steps * STEP)
        return 0.0 if math.isnan(fall) else fall


class PressureSwings:
    """Counts reversals of a pressure, and leaps away and back."""

    least = 1.5e5  # Pa; smaller is the noise and the resolution of a sensor
    _share = 0.15  # of the pressure, likewise

    def __init__(self) -> None:
        self._turns: deque[tuple[int, float]] = deque(maxlen=256)  # stamp, share of the pressure
        self._leaps: deque[tuple[int, float]] = deque(maxlen=16)  # stamp, slope [Pa/s]
        self._extreme = 0.0
        self._rising = True
        self._before: tuple[tuple[int, float], tuple[int, float]] = ((0, 0.0), (0, 0.0))

    def add(self, stamp: int, value: float) -> None:
        """Take a sample by stamp."""
        (first, a), (second, b) = self._before
        self._before = (second, b), (stamp, value)
        self._turn(stamp, value)
        change = min(abs(b - a), abs(b - value))
        if ((b - a) * (value - b) < 0.0 and change >= max(2.0 * self.least, 0.5 * max(a, b, value))
                and stamp - first <= 25_000_000):
            slope = change * _SECOND / max(stamp - second, second - first, _LEAST_STEP)
            self._leaps.append((stamp, slope))

    def _turn(self, stamp: int, value: float) -> None:
        away = self._extreme - value if self._rising else value - self._extreme
        if away <= 0.0:
            self._extreme = value
            return
        larger = max(self._extreme, value)
        if away >= max(self.least, self._share * larger):
            self._turns.append((stamp, away / max(larger, away)))
            self._extreme, self._rising = value, not self._rising

    def is_calm(self, end: int) -> bool:
        """Return whether there was no turn within a second, and no leap."""
        return not self._leaps and not (
            self._turns and end - self._turns[-1][0] <= _SECOND)

    def turns(self, end: int, within: int, share: float = 0.0) -> int:
        """Return the number of turns of at least a share of the pressure within a time [ns]."""
        if not self._turns or end - self._turns[-1][0] > within:
            return 0
        count = 0
        for stamp, size in reversed(self._turns):
            if end - stamp > within:  # as are those before it
                break
            count += size >= share
        return count

    def leaps(self, end: int, within: int, slew: float) -> int:
        """Return the number of leaps away and back within a time [ns], above a slew [Pa/s]."""
        return sum(end - stamp <= within and slope > slew for stamp, slope in self._leaps)
