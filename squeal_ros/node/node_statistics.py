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

"""Statistics of the node itself: ticks, lateness, inputs. Pure; times are handed in."""

from collections import deque
from dataclasses import dataclass, field
import math

from squeal_ros.node.tick_grid import Tick

_KEPT = 1000  # ticks that percentiles are taken of
RECENT = 10_000_000_000  # ns; for so long a fault of the node's own shows in its level
_AGAIN = 60_000_000_000  # ns until lost ticks are logged again


class Series:
    """The last figures of one kind, in s."""

    def __init__(self) -> None:
        self._last: deque[int] = deque(maxlen=_KEPT)

    def add(self, nanoseconds: int) -> None:
        """Add a duration [ns]."""
        self._last.append(nanoseconds)

    def values(self, name: str) -> dict[str, object]:
        """Return last, largest and 99th percentile; NaN before the first."""
        if not self._last:
            return dict.fromkeys((f'{name}_s', f'{name}_max_s', f'{name}_p99_s'), math.nan)
        ordered = sorted(self._last)
        rank = math.ceil(0.99 * len(ordered)) - 1
        return {f'{name}_s': self._last[-1] / 1e9, f'{name}_max_s': ordered[-1] / 1e9,
                f'{name}_p99_s': ordered[rank] / 1e9}


@dataclass
class Health:
    """Counts of a node's life, and its last ticks."""

    ticks_done: int = 0
    ticks_lost: int = 0
    deadline_misses: int = 0
    clock_jumps: int = 0
    clock_stops: int = 0
    errors: int = 0
    work: Series = field(default_factory=Series)
    lateness: Series = field(default_factory=Series)

    def begin(self, tick: Tick, period: int) -> None:
        """
        Count a tick; one that comes more than a period late missed its deadline.

        Its lateness counts from the first of those that were passed over for it [ns]. One that is
        late by the steps of a simulated clock missed nothing.
        """
        late = tick.late + tick.lost * period
        self.ticks_done += 1
        self.ticks_lost += tick.lost
        self.deadline_misses += tick.lost > 0 or (late > period and not tick.simulated)
        self.clock_jumps += tick.jump != ''
        self.lateness.add(late)

    def end(self, work: int, period: int) -> None:
        """Record the duration of a tick [ns]; one longer than a period missed its deadline."""
        self.deadline_misses += work > period
        self.work.add(work)

    def values(self) -> dict[str, object]:
        """Return the figures for the diagnostics by name."""
        return {'ticks_done': self.ticks_done, 'ticks_lost': self.ticks_lost,
                'deadline_misses': self.deadline_misses, 'clock_jumps': self.clock_jumps,
                'clock_stops': self.clock_stops, 'errors': self.errors,
                **self.work.values('tick_time'), **self.lateness.values('tick_lateness')}


class LostTicks:
    """Schedule of log messages on lost ticks: at the first, then once a minute at most."""

    def __init__(self) -> None:
        self._logged, self._next = 0, 0

    def due(self, lost: int, steady: int) -> bool:
        """Take the number of ticks lost so far, and steady time [ns]."""
        if lost == self._logged or (self._logged and steady < self._next):
            return False
        self._logged, self._next = lost, steady + _AGAIN
        return True


class Rate:
    """Events a second, over stretches of a second or more."""

    def __init__(self) -> None:
        self._since: tuple[int, int] | None = None
        self.per_second = math.nan

    def update(self, count: int, steady: int) -> float:
        """Return the rate [Hz] from a count at a steady time [ns]; NaN in the first second."""
        if self._since is None:
            self._since = count, steady
        elif steady - self._since[1] >= 1_000_000_000:
            self.per_second = (count - self._since[0]) / ((steady - self._since[1]) * 1e-9)
            self._since = count, steady
        return self.per_second


class Growth:
    """Detects whether a count grew of late."""

    def __init__(self) -> None:
        self._count = 0
        self._at: int | None = None

    def recent(self, count: int, steady: int) -> bool:
        """Return whether a count grew recently, at a steady time [ns]."""
        if count != self._count:
            self._count, self._at = count, steady
        return self._at is not None and steady - self._at < RECENT


class Turns:
    """
    Schedule of several reports: each is due once a period, one after the other.

    Parameters
    ----------
    count : int

    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._last: list[tuple[int, int]] = []  # ROS time and steady time of each [ns]

    def due(self, now: int, steady: int, period: int, tick: int) -> set[int]:
        """
        Return the places of those that are due at a tick; periods in ns.

        Simulated time may run faster or slower, or stand still, so steady time counts, too.
        """
        if not self._last:
            step = period // self._count if period > tick else 0
            ahead = [place * step - period for place in range(self._count)]
            self._last = [(now + wait, steady + wait) for wait in ahead]
        result = {place for place, (last, steadily) in enumerate(self._last)
                  if abs(now - last) >= period or steady - steadily >= period}
        for place in result:
            self._last[place] = now, steady
        return result
