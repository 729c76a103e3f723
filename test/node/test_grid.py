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

"""When ticks are due, and the node's own figures: pure functions of times handed in."""

import math

from hypothesis import given
from hypothesis import strategies as st
import pytest
from squeal_ros.node.node_statistics import Growth, Health, LostTicks, Rate, RECENT, Series
from squeal_ros.node.tick_grid import StandstillWatch, Tick, TickGrid

MS = 1_000_000
SECOND = 1000 * MS
PERIOD = 100 * MS


def grid(now: int = 1000 * SECOND) -> TickGrid:
    return TickGrid(PERIOD, now, 0)


@given(st.integers(1, 10**10), st.integers(0, 2**62))
def test_the_wait_leads_to_a_multiple_of_the_period(period: int, now: int) -> None:
    wait = TickGrid(period).wait(now)
    assert 0 < wait <= period
    assert (now + wait) % period == 0


@given(st.integers(1, 10**10), st.integers(0, 2**62), st.integers(10**4, 10**8))
def test_a_long_wait_is_cut_into_as_few_parts_as_will_do(
        period: int, now: int, longest: int) -> None:
    found = TickGrid(period)
    assert 0 < found.wait(now, longest) <= min(longest, found.wait(now))
    parts = math.ceil(period / longest)
    if parts < 100:
        start = now - now % period
        passed = [0]
        while passed[-1] < period:
            passed.append(passed[-1] + found.wait(start + passed[-1], longest))
        assert len(passed) == parts + 1
        assert passed[-1] == period


def test_the_first_tick_is_the_one_that_comes_next() -> None:
    found = grid(1000 * SECOND + 1)
    assert found.next_tick(1000 * SECOND + PERIOD - 1, 0, simulated=False) is None
    assert found.next_tick(1000 * SECOND + PERIOD + 3 * MS, 0, simulated=False) == Tick(
        1000 * SECOND + PERIOD, 3 * MS, 0)
    assert not found.due(1000 * SECOND + PERIOD + 4 * MS)


@pytest.mark.parametrize('found', [TickGrid(PERIOD), grid()])
def test_a_time_of_zero_has_no_tick(found: TickGrid) -> None:
    assert not found.due(0)
    assert found.next_tick(0, 0, simulated=True) is None
    assert found.next_tick(1001 * SECOND, 0, simulated=True) is not None


def test_without_a_time_the_first_tick_is_due_at_once() -> None:
    assert TickGrid(PERIOD).next_tick(SECOND + 5, 0, simulated=True) == Tick(
        SECOND, 5, 0, simulated=True)


def test_a_tick_that_came_during_the_last_one_is_late_and_not_lost() -> None:
    """Work that takes longer than a period now and then costs no tick."""
    found, start = grid(), 1000 * SECOND
    assert found.next_tick(start + PERIOD, PERIOD, simulated=False) == Tick(start + PERIOD, 0, 0)
    assert found.wait(start + 2 * PERIOD - 1) == 1
    over = start + 2 * PERIOD + 20 * MS
    assert found.wait(over, MS) == 0
    assert found.next_tick(over, 2 * PERIOD + 20 * MS, simulated=False) == Tick(
        start + 2 * PERIOD, 20 * MS, 0)
    assert found.wait(over + 5 * MS) == 75 * MS


@pytest.mark.parametrize('simulated', [False, True])
def test_ticks_that_came_meanwhile_are_made_up(simulated: bool) -> None:
    """Of a node that is kept by one of them, or of a clock with steps of many periods."""
    period, start = 10 * MS, 1000 * SECOND
    found = TickGrid(period, start, 0)
    assert found.next_tick(start + period, period, simulated=simulated)
    made = []
    for now in range(start + 100 * MS, start + 120 * MS, 2 * MS):
        while (tick := found.next_tick(now, now - start, simulated=simulated)) is not None:
            made.append(tick)
    assert [tick.time - start for tick in made] == [n * period for n in range(2, 12)]
    assert [tick.late for tick in made] == [n * period for n in range(8, -1, -1)] + [0]
    assert {tick.lost for tick in made} == {0}
    assert found.next_tick(start + 119 * MS, 119 * MS, simulated=simulated) is None


def test_ticks_that_came_too_long_ago_are_passed_over() -> None:
    period, start = 10 * MS, 1000 * SECOND
    found = TickGrid(period, start, 0)
    assert found.next_tick(start + period, period, simulated=False)
    now = start + 123 * MS  # the next tick would be 103 ms late
    assert found.next_tick(now, 123 * MS, simulated=False) == Tick(start + 12 * period, 3 * MS, 10)
    assert not found.due(now)


def test_ticks_passed_over_are_counted() -> None:
    found, start = grid(), 1000 * SECOND
    assert found.next_tick(start + 4 * PERIOD, 4 * PERIOD, simulated=False) == Tick(
        start + 4 * PERIOD, 0, 3)


@pytest.mark.parametrize('step', [1, PERIOD // 2, PERIOD])
def test_a_small_step_back_ticks_no_time_twice(step: int) -> None:
    """The system clock is slewed and stepped by some ms every day."""
    found, start = grid(), 1000 * SECOND
    assert found.next_tick(start + 5 * PERIOD, 5 * PERIOD, simulated=False)
    back = start + 6 * PERIOD - 1 - step
    assert found.next_tick(back, 6 * PERIOD, simulated=False) is None
    assert found.next_tick(start + 6 * PERIOD, 7 * PERIOD, simulated=False) == Tick(
        start + 6 * PERIOD, 0, 0)


def test_a_step_back_goes_on_from_there() -> None:
    found = grid()
    assert found.next_tick(1000 * SECOND + PERIOD, PERIOD, simulated=False)
    assert found.next_tick(10 * SECOND, 2 * PERIOD, simulated=False) == Tick(
        10 * SECOND, 0, 0, 'back')
    assert found.next_tick(10 * SECOND + PERIOD, 3 * PERIOD, simulated=False) == Tick(
        10 * SECOND + PERIOD, 0, 0)


@pytest.mark.parametrize(('simulated', 'steady', 'tick'), [
    (False, SECOND, ('forward', 0)), (True, SECOND, ('forward', 0)),
    (False, 3600 * SECOND, ('', 36000 - 1))])
def test_a_step_forward_is_no_lost_hour_but_a_blocked_node_is(
        simulated: bool, steady: int, tick: tuple[str, int]) -> None:
    found = grid().next_tick(4600 * SECOND, steady, simulated=simulated)
    assert found is not None
    assert (found.jump, found.lost) == tick


@given(st.lists(st.integers(-3 * SECOND, 3 * SECOND) | st.integers(0, SECOND // 4), max_size=60),
       st.booleans(), st.sampled_from([MS, 10 * MS, PERIOD, SECOND]))
def test_ticks_go_forward_unless_they_say_so(
        steps: list[int], simulated: bool, period: int) -> None:
    """And between two of them all are counted as lost."""
    now, last, found = 1000 * SECOND, 1000 * SECOND, TickGrid(period, 1000 * SECOND, 0)
    for steady, step in enumerate(steps):
        now += step
        tick = found.next_tick(now, steady, simulated=simulated)
        if tick:
            assert tick.time % period == 0
            assert 0 <= tick.late == now - tick.time <= max(period, SECOND // 10)
            assert (tick.time > last) != (tick.jump == 'back')
            assert tick.jump or tick.time - last == (tick.lost + 1) * period
            last = tick.time


def test_standstill_is_measured_from_the_last_movement() -> None:
    watch = StandstillWatch(5)
    assert watch.standstill(0, 10) == 5  # never started: zero is no time
    assert watch.standstill(0, 20) == 15
    assert watch.standstill(7, 30) == 0
    assert watch.standstill(7, 40) == 10
    assert watch.standstill(6, 50) == 0


def test_percentiles_of_the_last_thousand() -> None:
    series = Series()
    assert all(math.isnan(float(str(v))) for v in series.values('x').values())
    for number in range(5000, 0, -1):  # the last thousand are 1000 to 1
        series.add(number * SECOND)
    assert series.values('x') == {'x_s': 1.0, 'x_max_s': 1000.0, 'x_p99_s': 990.0}


def test_a_deadline_is_missed_by_work_or_by_delay() -> None:
    health = Health()
    for lost, work in ((0, PERIOD), (0, PERIOD + 1), (2, 5), (2, PERIOD + 1)):
        health.begin(Tick(SECOND, MS, lost), PERIOD)
        health.end(work, PERIOD)
    values = health.values()
    assert (values['ticks_done'], values['ticks_lost'], values['deadline_misses']) == (4, 4, 4)
    assert values['tick_lateness_max_s'] == pytest.approx(1e-3 + 2e-9 * PERIOD)
    assert values['tick_lateness_s'] == values['tick_lateness_max_s']


def test_steps_of_a_simulated_clock_are_no_missed_deadline() -> None:
    health = Health()
    for simulated in (True, False):
        health.begin(Tick(SECOND, 2 * PERIOD, 0, simulated=simulated), PERIOD)
        assert health.deadline_misses == (0 if simulated else 1)
    health.begin(Tick(SECOND, 2 * PERIOD, 1, simulated=True), PERIOD)
    assert (health.deadline_misses, health.ticks_lost) == (2, 1)


def test_rate_over_a_second_or_more() -> None:
    rate = Rate()
    assert math.isnan(rate.update(0, 0))
    assert math.isnan(rate.update(40, SECOND // 2))
    assert rate.update(100, 2 * SECOND) == 50.0
    assert rate.update(101, 2 * SECOND + 1) == 50.0
    assert rate.update(100, 3 * SECOND) == 0.0


def test_growth_is_forgotten_after_a_while() -> None:
    growth = Growth()
    assert not growth.recent(0, 5)
    assert growth.recent(3, 10)
    assert growth.recent(3, 9 + RECENT)
    assert not growth.recent(3, 10 + RECENT)


def test_lost_ticks_are_logged_at_the_first_and_once_a_minute_where_more_come() -> None:
    lost = LostTicks()
    assert not lost.due(0, 5)
    assert lost.due(3, SECOND)
    assert not lost.due(4, 60 * SECOND)
    assert lost.due(5, 61 * SECOND)
    assert not lost.due(5, 300 * SECOND)
