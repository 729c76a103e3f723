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

"""The buffer of an input: stamps ahead, missing or set back, and messages without a value."""

from collections.abc import Sequence
from typing import Any

import pytest
from squeal_core.monitor.vehicle_monitor import BrakeMonitor, MissingValue, Sample
from support.brake_monitors import feed, GOOD, monitor, NAN, SECOND, TICK


def flooded(stamps: Sequence[int], **parameters: Any) -> BrakeMonitor:
    watch = feed(monitor(**parameters), **GOOD)
    assert watch.assess(TICK).state == 'steady'
    for stamp in stamps:
        watch.receive('friction', Sample(stamp, 0.1))
    return watch


@pytest.mark.parametrize('ahead', [2 * SECOND, 3600 * SECOND])
def test_samples_far_ahead_displace_nothing_and_are_counted(ahead: int) -> None:
    watch = flooded(range(TICK + ahead, TICK + ahead + 10_000))
    feed(watch, TICK + SECOND // 10, **GOOD)
    found = watch.assess(TICK + SECOND // 10)
    assert (found.state, found.friction) == ('steady', 0.5)
    assert watch.refused == {'friction stamped ahead': 10_000}
    watch.assess(TICK + ahead)
    assert watch.assess(TICK + ahead + 10_000).friction != 0.1


def test_only_samples_ahead() -> None:
    watch = flooded([])
    for tenths in range(1, 21):
        time = TICK + tenths * SECOND // 10
        feed(watch, time, rotor_speed=10.0, pressure=2e6)
        watch.receive('friction', Sample(time + 5 * SECOND, 0.4))
        found = watch.assess(time)
        assert found.is_valid == (tenths <= 5)
    assert found.reason == 'friction is 0.4, stamped ahead of time by 5.00 s'
    assert (found.state, found.inputs['friction'].status) == ('invalid', 'invalid')
    feed(watch, time + 1, friction=0.5)
    assert watch.assess(time + 1).state == 'steady'
    feed(watch, time + SECOND, rotor_speed=10.0, pressure=2e6)
    assert watch.assess(time + SECOND).reason == 'friction is 1.00 s old: 0.5'


@pytest.mark.parametrize(('tolerance', 'known'), [(0.5, True), (0.05, False)])
def test_how_far_ahead_is_a_setting(tolerance: float, known: bool) -> None:
    """A sensor clock 0.2 s ahead of ticks at 10 Hz: samples wait their time, or are refused."""
    watch = monitor(stamp_tolerance=tolerance)
    for tenths in range(10):
        feed(watch, TICK + (tenths + 2) * SECOND // 10, **GOOD)
        found = watch.assess(TICK + tenths * SECOND // 10)
    assert found.is_valid is known
    assert watch.refused.total() == (0 if known else 30)


def test_samples_without_a_stamp_are_refused_and_named() -> None:
    watch = feed(flooded([]), 0, friction=0.4)
    feed(watch, TICK + SECOND, rotor_speed=10.0, pressure=2e6)
    found = watch.assess(TICK + SECOND)
    assert (found.state, found.reason) == ('invalid', 'friction is 0.4, without a stamp (zero)')
    assert watch.refused == {'friction without a stamp': 1}
    found = feed(feed(monitor(), rotor_speed=10.0, pressure=2e6), 0, friction=NAN).assess(TICK)
    assert found.reason == 'friction without a stamp (zero)'
    assert feed(watch, TICK + SECOND, friction=0.4).assess(TICK + SECOND).state == 'steady'
    found = feed(feed(monitor(), rotor_speed=10.0, pressure=2e6), -5 * SECOND, friction=0.4)
    assert found.assess(TICK).reason == (
        'friction is 0.4, with a stamp before all time (-5.00 s)')


def test_messages_without_the_value_are_named_until_one_has_it() -> None:
    watch = feed(monitor(), rotor_speed=10.0, pressure=2e6)
    watch.receive('friction', MissingValue('data[2]: the list is too short'))
    found = watch.assess(TICK)
    assert (found.state, found.inputs['friction'].status) == ('stale', 'never received')
    why = 'messages come without it (data[2]: the list is too short)'
    assert found.reason == f'friction never received, {why}'
    assert feed(watch, friction=0.4).assess(TICK).state == 'steady'
    later = TICK + SECOND
    feed(watch, later, rotor_speed=10.0, pressure=2e6)
    assert watch.assess(later).reason == 'friction is 1.00 s old: 0.4'
    watch.receive('friction', MissingValue('data[2]: the list is too short'))
    assert watch.assess(later).reason == f'friction is 1.00 s old: 0.4, {why}'
    assert watch.refused == {'friction unreadable': 2}
    watch.reset()
    assert watch.assess(later).reason.endswith('friction never received')


def test_a_clock_set_back_a_little_forgets_only_what_is_ahead() -> None:
    watch = feed(monitor(), **GOOD)
    watch.assess(TICK)
    feed(watch, TICK + SECOND // 5, friction=0.1)
    assert watch.assess(TICK + SECOND // 5).friction == 0.1
    found = watch.assess(TICK + SECOND // 10)
    assert (found.state, found.inputs['rotor_speed'].status) == ('stale', 'good')
    assert found.reason == 'friction not received since time went backwards'


def test_other_settings_while_running() -> None:
    watch = feed(monitor(), **GOOD)
    limits = {'a.friction.maximum': 0.4, 'a.rotor_speed.max_age': 9}
    other, late = monitor(**limits), monitor(release_pressure=3e6, **limits)
    assert watch.assess(TICK).state == 'steady'
    watch.update_settings(other.brake, other._settings)
    assert watch.assess(TICK).reason == (
        'friction is 0.5, outside its range 0.01 to 0.4 (0.00 s old)')
    watch.update_settings(late.brake, late._settings)
    feed(watch, TICK + SECOND, pressure=2e6)
    assert watch.assess(TICK + SECOND).state == 'released'
