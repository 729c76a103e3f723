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
The node on clocks that stop, start late, jump or are set: never a number from a stopped clock.

Simulated time is /clock as a simulator publishes it; the system clock that is set is the node's
own clock object, set ahead or back as the system's would be.
"""

from itertools import pairwise
import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from builtin_interfaces.msg import Time as TimeMessage  # noqa: E402, I100
from lifecycle_msgs.msg import Transition  # noqa: E402
from lifecycle_msgs.srv import ChangeState  # noqa: E402
from rclpy.duration import Duration  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from support.node_runs import PATIENT, vehicle  # noqa: E402
from support.vehicle import BEGIN, Vehicle  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))
START = BEGIN


def simulated(**values: Any) -> Any:
    """Return a node that calls a clock stopped soon."""
    return vehicle(clock_timeout=0.3, **values)


def go_on(car: Vehicle) -> None:
    """
    Let simulated time go on until the node is heard to see squeal.

    Where the machine is slow, it may have called the clock stopped in between.
    """
    car.until(lambda: car.risk > 0.99 and car.status.level == WARN)


def stopped(car: Vehicle) -> None:
    """Let simulated time stand still until the node says so."""
    car.wait(lambda: 'clock' in getattr(car.status, 'message', ''))
    car.hear()
    assert math.isnan(car.risk)


def test_ticks_follow_simulated_time() -> None:
    with vehicle() as car:
        go_on(car)
        health = car.monitor.health
        done, stamps = health.ticks_done, [car.stamp]
        assert car.stamp == car.simulated
        for step in (0.05, 0.05, 0.02, 0.02, 0.02, 0.05, 0.01, 0.05):
            car.advance(step, step)
            stamps.append(car.stamp)
        assert stamps[-1] == START + (car.simulated - START) // 50_000_000 * 50_000_000
        assert [b - a for a, b in pairwise(stamps) if a != b] == [50_000_000] * 5
        assert health.ticks_done - done == 5
        assert (health.ticks_lost, health.clock_jumps) == (0, 0)


def test_a_clock_with_long_steps_costs_no_ticks() -> None:
    """As when a bag is played with a /clock that is slower than the monitor."""
    with vehicle(rate=100.0, diagnostics_rate=100.0) as car:
        go_on(car)
        health = car.monitor.health
        car.advance(0.1 - car.simulated % 100_000_000 / 1e9)
        done, lost = health.ticks_done, health.ticks_lost
        for _ in range(8):
            car.advance(0.1, step=0.1)
            assert car.stamp == car.simulated
        assert (health.ticks_done - done, health.ticks_lost - lost) == (80, 0)
        assert car.risk > 0.99


def test_lost_ticks_are_logged_once_with_a_remedy(capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle(rate=100.0, diagnostics_rate=100.0) as car:
        go_on(car)
        lost = car.monitor.health.ticks_lost
        assert 'ticks lost' not in capfd.readouterr().err
        for _ in range(2):
            car.advance(0.5, step=0.5)
        assert car.monitor.health.ticks_lost > lost + 50
        (line,) = (line for line in capfd.readouterr().err.splitlines() if 'ticks lost' in line)
        assert 'WARN' in line
        assert 'lower `rate`' in line
        assert 'more slowly' in line


def test_a_clock_that_never_starts_is_named() -> None:
    with simulated() as car:
        stopped(car)
        assert car.status.level == STALE
        assert 'nothing came on /clock' in car.status.message
        assert math.isnan(car.risk)
        assert car.node_status.level == STALE
        assert 'clock' in car.node_status.message
        go_on(car)
        assert car.node_status.level in (OK, WARN)


def test_a_clock_that_stops_is_named_and_may_go_on() -> None:
    with simulated() as car:
        go_on(car)
        for _ in range(2):
            stops = car.monitor.health.clock_stops
            stopped(car)
            assert car.status.level == STALE
            assert 'stands still at 10' in car.status.message
            assert math.isnan(car.unstable[0])
            # once a standstill, of which a slow machine makes more
            assert car.monitor.health.clock_stops > stops
            go_on(car)
        assert int(car.figures['clock_stops']) >= 2


def test_a_jump_back_is_named_and_forgets_the_future() -> None:
    """As when a bag begins again."""
    with vehicle() as car:
        go_on(car)
        car.silent = {'rotor_speed', 'pressure', 'friction'}
        car.set_time(START // 2)
        assert math.isnan(car.risk)
        assert car.monitor.health.clock_jumps == 1
        assert car.status.message.count('time went backwards') == 3
        car.advance(0.2)
        assert math.isnan(car.risk)
        assert car.status.message.count('time went backwards') == 3
        car.silent = set()
        go_on(car)


def test_samples_of_the_future_are_told_of_for_one_max_age() -> None:
    """They were under way when a bag began again."""
    with vehicle() as car:
        go_on(car)
        car.publish()
        car.publish()
        car.silent, future = {'rotor_speed', 'pressure', 'friction'}, car.simulated
        car.set_time(START // 2)
        car.simulated = future
        car.silent = {'friction'}
        car.publish()
        car.silent, car.simulated = {'rotor_speed', 'pressure', 'friction'}, START // 2
        car.advance(0.1)
        assert math.isnan(car.risk)
        assert car.status.message.count('stamped ahead') == 2
        car.advance(0.6)
        assert math.isnan(car.risk)
        assert car.status.message.count('time went backwards') == 3


def test_a_jump_forward_makes_samples_old_not_ticks_lost() -> None:
    with vehicle() as car:
        go_on(car)
        lost = car.monitor.health.ticks_lost
        car.silent = {'rotor_speed', 'pressure', 'friction'}
        car.set_time(car.simulated + 3600 * 10**9)
        assert math.isnan(car.risk)
        assert car.monitor.health.clock_jumps == 1
        assert car.monitor.health.ticks_lost - lost < 100
        car.silent = set()
        go_on(car)


@pytest.mark.parametrize('alone', [False, True])
def test_from_system_to_simulated_time_and_back(alone: bool) -> None:
    with vehicle(alone=alone, use_sim_time=False, clock_timeout=0.3, **PATIENT) as car:
        car.until(lambda: car.risk > 0.99)
        car.monitor.set_parameters([Parameter('use_sim_time', value=True)])
        stopped(car)
        car.simulated = START
        go_on(car)
        car.simulated = None
        car.monitor.set_parameters([Parameter('use_sim_time', value=False)])
        car.until(lambda: car.risk > 0.99 and car.status.level == WARN)


def test_a_time_that_is_none_ends_nothing() -> None:
    """Send a negative time, which rclpy refuses by an exception in its own callback."""
    with vehicle() as car:
        go_on(car)
        publisher = car.node.create_publisher(Clock, '/clock', 10)
        car.connected(publisher, 2)
        errors = car.monitor.health.errors
        publisher.publish(Clock(clock=TimeMessage(sec=-5)))
        car.wait(lambda: car.monitor.health.errors > errors)
        car.set_time(START + 10**11)
        go_on(car)


class SetClock:
    """The node's clock, as someone sets the system's: an offset that changes at once."""

    ros_time_is_active = False

    def __init__(self, clock: Any) -> None:
        self._clock, self.offset = clock, 0

    def now(self) -> Any:
        return self._clock.now() + Duration(nanoseconds=self.offset)

    def create_jump_callback(self, *arguments: Any, **names: Any) -> Any:
        return self._clock.create_jump_callback(*arguments, **names)


def test_the_system_clock_is_set() -> None:
    """A timer on ROS time would stall for as long as the clock goes back (rclpy#1490)."""
    with vehicle(bring_up=False, use_sim_time=False, **PATIENT) as car:
        clock = SetClock(car.monitor.get_clock())
        car.monitor.get_clock = lambda: clock
        car.node.get_clock = lambda: clock  # stamps come from the same machine
        car.monitor.bring_up()
        car.until(lambda: car.risk > 0.99)
        health = car.monitor.health
        for step in (-3600, -2, -0.04, 0.04, 2, 3600):
            clock.offset += round(step * 1e9)
            done, jumps = health.ticks_done, health.clock_jumps
            car.until(lambda: health.ticks_done > done + 4)  # noqa: B023
            car.said.clear()
            car.until(lambda: car.risk > 0.99)
            assert health.clock_jumps - jumps == (abs(step) >= 2), step


@pytest.mark.parametrize('rate', [2.0, 200.0])
def test_a_node_that_keeps_its_thread_serves_all_the_same(rate: float) -> None:
    """It sleeps between ticks itself, for 50 ms; and again, where the executor serves it first."""
    with vehicle(alone=True, use_sim_time=False, rate=rate, **PATIENT) as car:
        car.until(lambda: car.risk > 0.99)
        car.pressure = 0.0  # of which a tick takes next to no time, so that it can sleep
        car.until(lambda: car.risk == 0.0)
        served = [car.monitor.health.ticks_done]
        timer = car.node.create_timer(1e-3, lambda: served.append(car.monitor.health.ticks_done))

        def longest() -> int:
            return max(after - before for before, after in pairwise(served))

        while len(served) < 8 or (rate > 100.0 and longest() < 3):
            car.publish()
            car.executor.spin_once(timeout_sec=1.0)
        # ticks of 0.1 s may be made up
        assert longest() <= 2 * (0.15 * rate + 1)
        car.node.destroy_timer(timer)
        answer = car.ask(ChangeState, 'change_state', ChangeState.Request(
            transition=Transition(id=Transition.TRANSITION_DEACTIVATE)))
        assert answer.success
        car.hear()
        assert math.isnan(car.risk)
