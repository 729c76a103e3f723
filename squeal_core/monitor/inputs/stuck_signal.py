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

"""Detection of a value that no longer moves, against one within the step of its sensor."""

import math

_SECOND = 1_000_000_000
_FIT = 0.05  # of a step, by which a change may miss a multiple of it (rounding of float32 fields)
_MISSES = 2.0  # changes off the grid that are tolerated: a clipped value, a dead band
_RECOVERY = 0.25  # of a miss, by each change on the grid
_LEAST_STEP = 1e-9  # of a change; a smaller step is none
_AGAIN = 64  # changes after which a step that is smaller than all of them is learned anew


class SignalStep:
    """
    The resolution of a signal: the largest step of which its changes are multiples.

    Changes of a fine and noisy signal have no common divisor, so that its step falls towards zero.
    """

    def __init__(self) -> None:
        self.value = 0.0
        self._misses = 0.0
        self._count, self._least = 0, math.inf

    def add(self, change: float) -> None:
        """Take a change of the signal, other than zero."""
        change = abs(change)
        if not math.isfinite(change):
            return
        self._count, self._least = self._count + 1, min(self._least, change)
        if self._count == _AGAIN:
            if self._least > 2.0 * self.value:
                self.value, self._misses = self._least, 0.0
            self._count, self._least = 0, math.inf
        if not self.value:
            self.value = change
        if self.value < _LEAST_STEP * change:
            return
        rest = abs(math.remainder(change, self.value))
        if rest <= _FIT * self.value:
            self._misses = max(self._misses - _RECOVERY, 0.0)
            return
        self._misses += 1.0
        if self._misses > _MISSES:
            self.value, self._misses = rest, 0.0


class StuckCheck:
    """
    Detects a value that stays exactly the same while the disc slides under load.

    A fine sensor flickers in its last digits, a coarse one stays at a step for as long as the
    signal does. So the time that a value may rest grows with the step of the signal, as far as
    that exceeds the least movement of a live signal. A constant is no evidence by itself (a test
    bench, a friction that nobody estimates), so it counts only for an input that was seen to
    change, and while the other inputs of the brake go on changing.

    Parameters
    ----------
    after : float
        For how long, in sum over stretches of sliding [s]; 0: never.
    changes : int
        Changes that make an input a lively one.
    longest_gap : float
        Between samples that count as one stretch [s].
    movement : float
        By which a live signal moves at least within `after`; in the unit of the signal.

    """

    def __init__(self, after: float, changes: int, longest_gap: float, movement: float) -> None:
        self._after, self._least_changes = round(after * _SECOND), changes
        self._longest_gap, self._movement = round(longest_gap * _SECOND), movement
        self.changes = 0
        self._step = SignalStep()
        self._value = math.nan
        self._stamp = 0
        self._held = 0
        self._others_before = 0

    @property
    def limit(self) -> float:
        """For how long the value may rest [ns]."""
        return self._after * max(1.0, self._step.value / self._movement)

    def check(self, stamp: int, value: float, *, sliding: bool, others: int) -> str:
        """Check a sample; `others` counts the changes of the brake's other inputs up to now."""
        if value != self._value:
            if self.changes:
                self._step.add(value - self._value)
            self.changes += 1
            self._value, self._held, self._others_before = value, 0, others
        elif sliding and 0 < stamp - self._stamp <= self._longest_gap:
            self._held += stamp - self._stamp
        self._stamp = stamp
        if not self._held:
            return ''
        lively = min(self.changes - 1, others - self._others_before) >= self._least_changes
        if not self._after or self._held <= self.limit or not lively:
            return ''
        return f'has been stuck there for {self._held / _SECOND:.1f} s of sliding, until it moves'
