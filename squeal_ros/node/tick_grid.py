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

"""Ticks on multiples of the period, whatever the clock does: pure, of times handed in [ns]."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

Jump: TypeAlias = Literal['', 'back', 'forward']

_JUMP_PERIODS = 10
_JUMP_TIME = 1_000_000_000
_LATEST = 100_000_000  # ns: a tick that comes later is of no use to anyone, so it is passed over


@dataclass(frozen=True)
class Tick:
    """
    A tick that is due: its time, how late it is and how many before it were passed over.

    Lateness in simulated time is that of the clock's steps, too.
    """

    time: int
    late: int
    lost: int
    jump: Jump = ''
    simulated: bool = False


class TickGrid:
    """
    Determines when a tick is due; a replay of the same samples then ticks at the same times.

    Ticks that came while others were worked on are made up one after the other, and so are those
    that a simulated clock with long steps leaps over. Where the oldest of them would come too
    late all but the newest are passed over.

    Parameters
    ----------
    period : int
    now, steady : int
        Present times: the first tick is the one that comes next. A ROS time of zero is none.

    """

    def __init__(self, period: int, now: int = 0, steady: int = 0) -> None:
        self.period = period
        self._last = now // period if now else None
        self._last_steady = steady

    def wait(self, now: int, longest: int | None = None) -> int:
        """
        Return the time to the next tick, or to the next of the equal parts of a period.

        Zero, where the next tick is there already. A period has as few parts as make none of them
        longer than `longest`.
        """
        if self._last is not None and now // self.period > self._last:
            return 0
        parts = 1 if longest is None else _ceil(self.period, longest)
        passed = now % self.period
        return _ceil((passed * parts // self.period + 1) * self.period, parts) - passed

    def due(self, now: int) -> bool:
        """Return whether `next_tick` would return a tick; never at a time of zero: unset."""
        if now == 0:
            return False
        tick = now // self.period
        # a clock that was set back by less than a period does not tick twice, and forgets nothing
        return self._last is None or tick > self._last or tick < self._last - 1

    def next_tick(self, now: int, steady: int, *, simulated: bool) -> Tick | None:
        """
        Return the tick that is due now, if one is.

        Parameters
        ----------
        now : int
            ROS time.
        steady : int
            Of a clock that nobody sets.
        simulated : bool
            ROS time comes from /clock, so it may run at any speed.

        """
        if not self.due(now):
            return None
        tick = now // self.period
        jump, lost = self._step(tick, 0 if simulated else steady - self._last_steady)
        if lost and now - (tick - lost) * self.period <= _LATEST:
            tick, lost = tick - lost, 0
        self._last, self._last_steady = tick, steady
        return Tick(tick * self.period, now - tick * self.period, lost, jump, simulated)

    def _step(self, tick: int, steady: int) -> tuple[Jump, int]:
        """Return the jump of time, and the number of ticks between the last one and this."""
        if self._last is None:
            return '', 0
        if tick < self._last:
            return 'back', 0
        passed = tick - self._last
        if passed * self.period - steady > max(_JUMP_TIME, _JUMP_PERIODS * self.period):
            return 'forward', 0
        return '', passed - 1


def _ceil(numerator: int, denominator: int) -> int:
    return -(-numerator // denominator)


class StandstillWatch:
    """Measures for how long a clock has not moved, on the steady clock [ns]."""

    def __init__(self, steady: int) -> None:
        self._seen: int | None = None
        self._moved = steady

    def standstill(self, now: int, steady: int) -> int:
        """Return for how long a clock has stood still [ns], by a steady clock."""
        if now != self._seen:
            # a first look at a simulated clock that has not started is no movement
            if self._seen is not None or now != 0:
                self._moved = steady
            self._seen = now
        return steady - self._moved
