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
Drives ticks on ROS time from a steady timer, so that no step of a clock can stall them.

A timer on ROS time waits for the system clock to come back after a backward step (rclpy#1490), and
for ever on a /clock that stopped. Here a timer on steady time leads to each tick; simulated time
is heard of by a jump callback, and the steady timer looks whether it still moves.

To rclpy's executor each callback means two waits, and each of them a look at every service and
event there is. Where no one else needs its thread, the ticker keeps it for some ticks and sleeps.
"""

from collections.abc import Callable
import time
from typing import Any

from rclpy.clock import Clock, JumpThreshold
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from squeal_ros.node.tick_grid import StandstillWatch, Tick, TickGrid

_LOOKS = 4  # at a simulated clock within its timeout
_LONGEST = 10_000_000  # ns between two wake-ups: in so short a time no queue of messages fills
_KEPT = 50_000_000  # ns for which services wait at most


class Ticker:
    """
    Calls `on_tick` with each tick that is due, and `on_stop` while ROS time stands still.

    It wakes up at every tick, and in between where ticks are rare.

    Parameters
    ----------
    node : rclpy.node.Node
    gather : callable
        Takes the messages that came: called at every wake-up before all else, and before simulated
        time changes, so that each finds the time at which it came.
    on_tick : callable
        Given a `Tick`.
    on_stop : callable
        Given what the clock does, in words; called again and again until it goes on.
    alone : bool
        Whether the executor serves nothing but this node.

    """

    def __init__(self, node: Node, gather: Callable[[], None], on_tick: Callable[[Tick], None],
                 on_stop: Callable[[str], None], *, alone: bool = False) -> None:
        self._node, self._gather, self._alone = node, gather, alone
        self._on_tick, self._on_stop = on_tick, on_stop
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer: Any = None
        self._guard: Any = None
        self._jumps: Any = None

    def start(self, period: int, clock_timeout: int) -> None:
        """Begin; both times in ns."""
        self.stop()
        self._timeout, self._begun = clock_timeout, False
        self._grid = TickGrid(period, self._now(), time.monotonic_ns())
        self._watch = StandstillWatch(time.monotonic_ns())
        self._guard = self._node.create_guard_condition(self._wake)
        self._timer = self._node.create_timer(1.0, self._wake, clock=self._steady)
        self._jumps = self._node.get_clock().create_jump_callback(
            JumpThreshold(min_forward=Duration(nanoseconds=1),
                          min_backward=Duration(nanoseconds=-1)),
            pre_callback=self._gather, post_callback=self._moved)
        self._arm()

    def retime(self, period: int, clock_timeout: int) -> None:
        """Take other times from the next tick on."""
        if self._timer is None:
            return
        self._timeout = clock_timeout
        if period != self._grid.period:
            self._grid = TickGrid(period, self._now(), time.monotonic_ns())
        self._arm()

    def stop(self) -> None:
        """Stop the ticks."""
        if self._jumps is not None:
            self._jumps.unregister()
            self._node.destroy_timer(self._timer)
            self._node.destroy_guard_condition(self._guard)
        self._timer = self._guard = self._jumps = None

    def _moved(self, jump: Any) -> None:
        """Handle a new simulated time."""
        if self._guard is not None:
            self._go_on()

    def _go_on(self) -> None:
        """Trigger a due tick in simulated time, once the executor comes to it."""
        if self._grid.due(self._now()):
            self._guard.trigger()

    def _wake(self) -> None:
        if self._timer is None:
            return
        end = time.monotonic_ns() + _KEPT
        if not self._begun and not self._simulated:
            self._begun = True  # work between the start and the first wake-up costs no tick
            self._grid = TickGrid(self._grid.period, self._now(), time.monotonic_ns())
        try:
            self._look()
            while self._sleeps(end):
                self._look()
        finally:
            if self._timer is not None:
                self._arm()

    def _sleeps(self, end: int) -> bool:
        """Sleep until the next wake-up and keep the thread, or return at once and leave it."""
        if not (self._alone and self._timer is not None and self._node.context.ok()):
            return False
        if self._simulated:  # of which only the executor hears
            return False
        wait = self._grid.wait(self._now(), _LONGEST)
        if time.monotonic_ns() + wait > end:
            return False
        time.sleep(1e-9 * wait)
        return True

    def _look(self) -> None:
        self._gather()
        now, steady, simulated = self._now(), time.monotonic_ns(), self._simulated
        if simulated:
            standstill = self._watch.standstill(now, steady)
            if standstill > self._timeout:
                self._on_stop(_in_words(now, standstill))
        else:
            self._watch = StandstillWatch(steady)
        tick = self._grid.next_tick(now, steady, simulated=simulated)
        if tick is not None:
            self._on_tick(tick)

    def _arm(self) -> None:
        """Wait for the next wake-up; with simulated time, for the next look at it."""
        if self._simulated:
            self._timer.timer_period_ns = min(self._timeout // _LOOKS, _LONGEST)
            self._go_on()
        else:
            self._timer.timer_period_ns = max(self._grid.wait(self._now(), _LONGEST), 1)
        self._timer.reset()

    @property
    def _simulated(self) -> bool:
        return bool(self._node.get_clock().ros_time_is_active)

    def _now(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)


def _in_words(now: int, standstill: int) -> str:
    seconds = standstill * 1e-9
    if now == 0:
        return f'clock: use_sim_time is set and nothing came on /clock for {seconds:.1f} s'
    return f'clock: /clock stands still at {now * 1e-9:.3f} s since {seconds:.1f} s'
