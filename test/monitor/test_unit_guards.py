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

"""Guards of units: bar given as Pa, rpm given as rad/s, and leaps of a speed."""

import math

import numpy as np
import pytest
from squeal_core.monitor.inputs.plausibility import BarGuard, RPM
from support.brake_monitors import feed, GOOD, monitor, SECOND, TICK
from support.guards import BAR, judged, LEAPS, speeds, TO_RPM


@pytest.mark.parametrize('rate', [10.0, 100.0, 1000.0])
@pytest.mark.parametrize('bar', [0.5, 5.0, 80.0, 200.0, 499.0])
def test_bar_is_told_within_half_a_second_or_ten_samples(bar: float, rate: float) -> None:
    said = judged(BarGuard(500.0), [0.0] * 20 + [bar] * 600, rate)[20:]
    first = said.index(BAR)
    assert first == max(9, round(0.5 * rate))
    assert set(said[first:]) == {BAR}


def test_bar_is_remembered_over_a_release_and_forgotten_at_the_first_pascal() -> None:
    guard = BarGuard(500.0)
    assert judged(guard, [20.0] * 60)[-1] == BAR
    assert judged(guard, [0.0, 0.3, 20.0, 0.0, 2.0], start=1.0) == ['', '', BAR, '', BAR]
    assert judged(guard, [2e6, 20.0, -2e6], start=2.0) == [''] * 3


def test_what_is_told_is_remembered_over_a_change_of_other_settings() -> None:
    watch, other, off = monitor(), monitor(risk_warning=0.9), monitor(bar_suspected_below=0)
    for tenths in range(20):
        feed(watch, TICK + tenths * SECOND // 10, **{**GOOD, 'pressure': 20.0})
    last = TICK + 2 * SECOND
    for settings, told in ((other, True), (off, False)):
        watch.update_settings(settings.brake, settings._settings)
        feed(watch, last, **{**GOOD, 'pressure': 20.0})
        assert ('bar given as Pa' in watch.assess(last).reason) is told
        last += SECOND // 10


def test_what_is_no_bar() -> None:
    ramp = np.linspace(0.0, 5e4, 200)  # 0.5 bar over 2 s: below 500 Pa for 20 ms
    noise = np.random.default_rng(1).normal(0.0, 100.0, 5000)
    for values in (ramp, ramp[::-1], noise, [0.0] * 500, [0.49] * 500, [500.0] * 500):
        assert set(judged(BarGuard(500.0), list(values))) == {''}


@pytest.mark.parametrize(('speed', 'rate'), [
    (5.0, 100.0), (5.0, 1000.0),  # 43 rad/s more in 50 ms would be no more than a wheel does
    *((speed, rate) for speed in (20.0, -20.0, 41.0, 60.0, 150.0)
      for rate in (20.0, 100.0, 1000.0))])
def test_a_change_of_unit_is_told_at_once_for_as_long_as_it_lasts(speed: float,
                                                                  rate: float) -> None:
    slowing = speed * np.linspace(1.0, 0.7, 400)
    guard = speeds()
    assert set(judged(guard, list(slowing[:100]), rate)) == {''}
    said = judged(guard, list(slowing[100:300] / RPM), rate, 100 / rate)
    seen = np.abs(slowing[100:300] / RPM) <= 400.0 / RPM  # beyond that the range says it
    assert {text for text, s in zip(said, seen, strict=True) if s} == {TO_RPM}
    assert set(judged(guard, list(slowing[300:]), rate, 300 / rate)) == {''}


def test_a_unit_that_changed_is_remembered_over_a_hard_braking() -> None:
    guard = speeds()
    judged(guard, [30.0] * 10)
    braking = np.linspace(30.0, 5.0, 200) / RPM  # 12.5 rad/s^2, more in rpm than any vehicle's
    assert set(judged(guard, list(braking), start=0.1)) == {TO_RPM}
    assert set(judged(guard, [5.0 / RPM] * 1400, 20.0, start=2.1)) == {TO_RPM}


@pytest.mark.parametrize(('before', 'after'), [(20.0, 120.0), (10.0, 100.0), (100.0, 1.0)])
def test_another_leap_is_not_believed_until_a_wheel_could_be_there(before: float,
                                                                   after: float) -> None:
    said = judged(speeds(), [before] * 10 + [after] * 60)[9:]
    wait = math.ceil(abs(after - before) / 500.0 * 100.0 - 1e-9)
    assert [text[:5] for text in said] == [''] + [LEAPS] * (wait - 1) + [''] * (61 - wait)
    assert said[1] == (f'leaps there from {before:g} rad/s within 0.01 s, until a wheel could be '
                       'there')


def test_after_half_a_second_any_leap_is_believed() -> None:
    said = judged(speeds(leap=1.0), [20.0] * 10 + [60.0] * 60)[10:]
    assert [bool(text) for text in said] == [True] * 50 + [False] * 10
    assert judged(speeds(), [20.0]) + judged(speeds(), [120.0], start=0.6) == ['', '']


def test_a_single_wild_value_costs_one_sample() -> None:
    for wild in (191.0, 120.0, -60.0, 1e9, 4000.0):
        said = judged(speeds(), [20.0] * 10 + [wild] + [20.0] * 10)
        beyond = abs(wild) * RPM > 400.0  # which the range says
        assert [i for i, text in enumerate(said) if text] == ([] if beyond else [10])


def test_what_wheels_do_is_no_leap() -> None:
    time = np.arange(0.0, 4.0, 0.01)
    slip = 40.0 - 8.0 * time - 15.0 * np.maximum(np.sin(2.0 * np.pi * 4.0 * time), 0.0)  # ABS
    noise = np.random.default_rng(2).normal(0.0, 0.4, time.size)
    crawl = np.abs(np.cumsum(np.random.default_rng(3).normal(0.0, 0.1, time.size)))
    through = np.linspace(20.0, -20.0, time.size)
    for values in (slip, 40.0 + noise, crawl, through):
        assert set(judged(speeds(), list(values))) == {''}
    assert judged(speeds(), [20.0, 20.5, 19.5], rate=1e9) == [''] * 3  # all but the same stamp


@pytest.mark.parametrize('rate', [5.0, 100.0])
def test_rpm_from_the_start_is_told_by_its_ramp_and_remembered_for_a_minute(rate: float) -> None:
    braking = np.linspace(20.0, 12.5, round(1.5 * rate)) / RPM  # 5 rad/s^2, 1.7 m/s^2
    guard = speeds()
    said = judged(guard, list(braking), rate)
    first = said.index(TO_RPM)
    assert 1.0 <= first / rate <= 1.2
    hold = judged(guard, [12.5 / RPM] * round(70.0 * rate), rate, 1.5 + 1 / rate)
    assert said[first:] == [TO_RPM] * len(said[first:])
    assert 58.0 < hold.count(TO_RPM) / rate < 62.0
    assert hold[-1] == ''


def test_a_speed_beyond_the_maximum_is_remembered() -> None:
    rising = np.linspace(380.0, 420.0, 100)
    said = judged(speeds(), [*rising, *rising[::-1]])
    assert [bool(text) for text in said] == [v > 400.0 for v in rising] + [True] * 100
    assert judged(speeds(), [450.0, 445.0, 440.0]) == [TO_RPM] * 3


@pytest.mark.parametrize('rate', [5.0, 20.0, 100.0])
def test_what_is_over_at_once_is_no_ramp(rate: float) -> None:
    """A silence with another sign after it, a wheel that locks or spins, one wild stretch."""
    before = [27.0] * 10
    for value in (-27.0, 0.0, 90.0):
        values = [*before, *[value] * 200]
        guard = speeds()
        stamps = np.arange(len(values)) / rate + np.where(np.arange(len(values)) < 10, 0.0, 0.3)
        said = [guard.check(round(t * SECOND), v) for t, v in zip(stamps, values, strict=True)]
        late = [text for t, text in zip(stamps, said, strict=True) if t > stamps[10] + 0.5]
        assert set(late) == {''}
    locking = [*np.linspace(60.0, 0.0, round(0.3 * rate)), *[0.0] * round(3 * rate)]
    assert not any('rpm' in text for text in judged(speeds(), locking, rate))


def test_spikes_beyond_the_maximum_are_no_rpm() -> None:
    guard = speeds()
    assert guard.check(0, 20.0) == ''
    assert guard.check(SECOND, 500.0)  # after a silence of a second
    assert set(judged(guard, [20.0] * 100, start=1.6)) == {''}
