"""The node on clocks that stop, start late, jump or are set: never a number from a stopped clock.

Simulated time is /clock as a simulator publishes it; the system clock that is set is the node's
own clock object, set ahead or back as the system's would be.
"""

from itertools import pairwise
import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from builtin_interfaces.msg import Time as TimeMessage  # noqa: E402
from harness import Vehicle, vehicle  # noqa: E402
from lifecycle_msgs.msg import Transition  # noqa: E402
from lifecycle_msgs.srv import ChangeState  # noqa: E402
from rclpy.duration import Duration  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))
START = 1_000_000_000_000


def simulated(**values: Any) -> Any:
    return vehicle(use_sim_time=True, clock_timeout=0.3, **values)


def go_on(car: Vehicle) -> None:
    """Let simulated time go on until the node is heard to see squeal."""
    for _ in range(100):
        car.advance(0.2)
        if car.risk > 0.99 and car.status is not None and car.status.level == WARN:
            return
    pytest.fail(f'no risk; said {car.said}')


def in_time(car: Vehicle) -> None:
    """Let the node hear of the present time; on a busy machine it may be some messages behind."""
    car.until(lambda: car.monitor.get_clock().now().nanoseconds == car.simulated)


def test_ticks_follow_simulated_time() -> None:
    with simulated() as car:
        car.simulated = START
        go_on(car)
        stamps = []
        in_time(car)
        done = car.monitor.health.ticks_done
        begin = car.simulated
        for _ in range(20):
            car.advance(0.05)
            stamp = car.said['diagnostics'].header.stamp
            stamps.append(stamp.sec * 10**9 + stamp.nanosec)
        assert all(stamp % 50_000_000 == 0 for stamp in stamps)
        assert stamps == sorted(stamps)
        in_time(car)
        passed = car.monitor.health.ticks_done + car.monitor.health.ticks_lost - done
        assert abs(passed - (car.simulated - begin) // 50_000_000) <= 1
        assert car.monitor.health.clock_jumps == 0


def test_a_clock_with_long_steps_costs_no_ticks() -> None:
    """As when a bag is played with a /clock that is slower than the monitor."""
    with simulated(rate=100.0, diagnostics_rate=100.0) as car:
        car.simulated = START
        go_on(car)

        def caught_up() -> bool:
            stamp = car.said['diagnostics'].header.stamp
            return bool(stamp.sec * 10**9 + stamp.nanosec == car.simulated)

        car.until(caught_up)
        health = car.monitor.health
        done, lost = health.ticks_done, health.ticks_lost
        for _ in range(20):
            car.advance(0.1, step=0.1)
            car.until(caught_up)
        assert (health.ticks_done - done, health.ticks_lost - lost) == (200, 0)
        assert car.risk > 0.99


def test_a_clock_that_never_starts_is_named() -> None:
    with simulated() as car:
        car.until(lambda: car.status is not None and car.status.level == STALE)
        assert 'nothing came on /clock' in car.status.message
        assert math.isnan(car.risk)
        assert car.node_status.level == STALE
        assert 'clock' in car.node_status.message
        car.simulated = START
        go_on(car)
        assert car.node_status.level in (OK, WARN)


def test_a_clock_that_stops_is_named_and_may_go_on() -> None:
    with simulated() as car:
        car.simulated = START
        go_on(car)
        for count in (1, 2):
            car.until(lambda: math.isnan(car.risk) and car.status.level == STALE)
            assert 'stands still at 10' in car.status.message
            assert math.isnan(car.unstable[0])
            assert car.monitor.health.clock_stops == count
            go_on(car)
        assert int(car.figures['clock_stops']) == 2


def test_a_jump_back_is_named_and_forgets_the_future() -> None:
    """As when a bag begins again."""
    with simulated() as car:
        car.simulated = START
        go_on(car)
        car.simulated, car.silent = START // 2, {'rotor_speed', 'pressure', 'friction'}
        car.advance(0.2)
        assert math.isnan(car.risk)
        assert car.monitor.health.clock_jumps == 1
        # samples of the old time may have been under way; they are told of for one max_age
        while 'time went backwards' not in car.status.message:
            assert 'stamped ahead' in car.status.message
            assert car.simulated < START // 2 + 2 * 10**9
            car.advance(0.1)
            assert math.isnan(car.risk)
        car.silent = set()
        go_on(car)


def test_a_jump_forward_makes_samples_old_not_ticks_lost() -> None:
    with simulated() as car:
        car.simulated = START
        go_on(car)
        lost = car.monitor.health.ticks_lost
        car.simulated, car.silent = START + 3600 * 10**9, {'rotor_speed', 'pressure', 'friction'}
        car.advance(0.1)
        assert math.isnan(car.risk)
        assert car.monitor.health.clock_jumps == 1
        assert car.monitor.health.ticks_lost - lost < 100
        car.silent = set()
        go_on(car)


@pytest.mark.parametrize('alone', [False, True])
def test_from_system_to_simulated_time_and_back(alone: bool) -> None:
    with vehicle(alone=alone, clock_timeout=0.3) as car:
        car.until(lambda: car.risk > 0.99)
        car.monitor.set_parameters([Parameter('use_sim_time', value=True)])
        car.until(lambda: math.isnan(car.risk) and 'clock' in car.status.message)
        car.simulated = START
        go_on(car)
        car.simulated = None
        car.monitor.set_parameters([Parameter('use_sim_time', value=False)])
        car.until(lambda: car.risk > 0.99 and car.status.level == WARN)


def test_a_time_that_is_none_ends_nothing() -> None:
    """rclpy refuses a negative time by an exception in its own callback."""
    with simulated() as car:
        car.simulated = START
        go_on(car)
        publisher = car.node.create_publisher(Clock, '/clock', 10)
        errors, car.simulated = car.monitor.health.errors, None
        car.silent = {'rotor_speed', 'pressure', 'friction'}

        def refused() -> bool:
            publisher.publish(Clock(clock=TimeMessage(sec=-5)))
            return car.monitor.health.errors > errors

        car.until(refused)
        car.silent, car.simulated = set(), START + 10**11
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


@pytest.mark.parametrize('step', [-3600, -2, -0.06, 0.06, 2, 3600])
def test_the_system_clock_is_set(step: float) -> None:
    """A timer on ROS time would stall for as long as the clock goes back (rclpy#1490)."""
    with vehicle(bring_up=False) as car:
        clock = SetClock(car.monitor.get_clock())
        car.monitor.get_clock = lambda: clock
        car.node.get_clock = lambda: clock  # stamps come from the same machine
        car.monitor.bring_up()
        car.until(lambda: car.risk > 0.99)
        clock.offset = round(step * 1e9)
        done = car.monitor.health.ticks_done
        car.until(lambda: car.monitor.health.ticks_done > done + 4)
        car.said.clear()
        car.until(lambda: car.risk > 0.99)
        assert car.monitor.health.clock_jumps == (abs(step) >= 2)


@pytest.mark.parametrize('rate', [2.0, 20.0, 500.0])
def test_a_node_that_keeps_its_thread_serves_all_the_same(rate: float) -> None:
    """It sleeps between ticks itself, for 50 ms; and again, where the executor serves it first."""
    with vehicle(alone=True, rate=rate) as car:
        car.until(lambda: car.risk > 0.99)
        served: list[int] = []
        timer = car.node.create_timer(1e-3, lambda: served.append(car.monitor.health.ticks_done))
        while len(served) < 20:
            car.publish()
            car.executor.spin_once(timeout_sec=1.0)
        ticks = [after - before for before, after in pairwise(served)]
        assert max(ticks) <= 2 * (0.05 * rate + 1)
        assert max(ticks) > 2 or rate < 100.0
        car.node.destroy_timer(timer)
        answer = car.ask(ChangeState, 'change_state', ChangeState.Request(
            transition=Transition(id=Transition.TRANSITION_DEACTIVATE)))
        assert answer.success
        car.until(lambda: math.isnan(car.risk))
