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

"""One input: its guards, its buffer, the ranges of the model; and the alarm over the risk."""

from collections.abc import Sequence
from itertools import pairwise
import math
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.brake.friction import FrictionTable
from squeal_core.common.resources import config_folder
from squeal_core.monitor.alarm import Alarm
from squeal_core.monitor.plausibility import (
    AbsoluteGuard,
    BarGuard,
    GaugeGuard,
    PlausibilityCheck,
    RPM,
    RpmGuard,
)
from squeal_core.monitor.stuck_signal import SignalStep, StuckCheck
from squeal_core.monitor.vehicle_monitor import BrakeMonitor, MissingValue, Sample
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle
from support.brake_monitors import (
    assess,
    feed,
    GOOD,
    monitor,
    NAN,
    SECOND,
    small_model,
    TABLE_ONLY,
    TICK,
)

BAR, TO_RPM, LEAPS = 'bar', 'rpm', 'leaps'  # in what they say
CYCLES = ('us06', 'wltc_3b', 'chicago_trip')


def speeds(**changes: float) -> RpmGuard:
    return RpmGuard(**{'maximum': 400.0, 'leap': 500.0, 'ramp': 40.0, 'memory': 0.5, **changes})


def judged(guard: PlausibilityCheck, values: Sequence[float], rate: float = 100.0,
           start: float = 0.0) -> list[str]:
    said = [guard.check(round((start + i / rate) * SECOND), float(value))
            for i, value in enumerate(values)]
    return [next((word for word in (BAR, TO_RPM) if f'like {word} given' in text), text)
            for text in said]


# -- bar given as Pa

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


# -- rpm given as rad/s

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


# -- the reference of a pressure

ABSOLUTE, GAUGE = 'looks like an absolute pressure', 'looks like a gauge pressure'


def braked(*, rest: float = 0.0, noise: float = 0.0, rate: float = 50.0,
           brakings: int = 4) -> Sequence[float]:
    """Rests of 6 s and brakings of 2 s to 20 bar."""
    one = np.concatenate([np.zeros(round(6 * rate)),
                          20e5 * np.sin(np.linspace(0.0, np.pi, round(2 * rate)))])
    values = rest + np.tile(one, brakings)
    values += noise * np.random.default_rng(0).standard_normal(values.size)
    return list(values)


@pytest.mark.parametrize('air', [6.6e4, 9e4, 101325.0, 1.06e5])
@pytest.mark.parametrize('noise', [0.0, 5e3])
def test_an_absolute_pressure_given_as_gauge_is_told_in_five_seconds(air: float,
                                                                     noise: float) -> None:
    said = judged(GaugeGuard(), [*braked(rest=air, noise=noise, brakings=1)] * 2, rate=50.0)
    assert said[249] == ''
    assert all(text.startswith(ABSOLUTE) for text in said[600:])
    assert 'until it falls below 0.4 bar' in said[-1]


def test_an_absolute_pressure_after_a_gauge_is_told_with_its_third_return() -> None:
    guard = GaugeGuard()
    assert set(judged(guard, braked())) == {''}
    said = judged(guard, braked(rest=1e5), rate=50.0, start=100.0)
    assert said.index(next(filter(None, said))) == pytest.approx((8 * 3 + 5) * 50, abs=15)
    assert judged(guard, [0.0, 1e5], start=200.0) == ['', '']


@pytest.mark.parametrize('values', [
    braked(), braked(noise=2e4), [0.0, *[1e5] * 3000], [*[2e5] * 300, *[0.0] * 10, *[1e5] * 900],
    list(np.tile([1e5, 2.5e5, 0.9e5], 2000)), list(1e5 + 6e4 * np.sin(np.arange(3000)))],
    ids=['brakings', 'noise', 'held at 1 bar', 'held later', 'pulses', 'waves'])
def test_what_is_no_absolute_pressure(values: Sequence[float]) -> None:
    assert set(judged(GaugeGuard(), values, rate=50.0)) == {''}


def test_a_gauge_pressure_given_as_absolute() -> None:
    guard = AbsoluteGuard()
    said = judged(guard, braked(rest=-101325.0), rate=50.0)
    assert said[149] == ''
    assert all(text.startswith(GAUGE) for text in said[155:])
    assert set(judged(guard, [0.0] * 3100, rate=50.0, start=100.0)[3001:]) == {''}
    undershoot = [*braked(brakings=1), *[-9e4] * 100]
    assert set(judged(AbsoluteGuard(), undershoot, rate=50.0)) == {''}


def test_the_reference_is_looked_for_in_the_monitor() -> None:
    for parameters, rest, words in (({}, 101325.0, ABSOLUTE), (
            {'a.pressure.reference': 'absolute'}, -101325.0, GAUGE)):
        for check in (True, False):
            watch = monitor(reference_check=check, **parameters)
            for tenths in range(60):
                feed(watch, TICK + tenths * SECOND // 10, **{**GOOD, 'pressure': rest})
            found = watch.assess(TICK + 6 * SECOND)
            assert (words in found.reason) is check
            assert (found.state == 'invalid') is check


# -- publishers that contradict each other

def heard(*publishers: tuple[int, float, Sequence[float]], signal: Any = 'pressure',
          rate: float = 50.0, **parameters: Any) -> list[str]:
    """Return what is said of publishers that take turns: first number, delay, values."""
    watch = monitor(**parameters)
    events = sorted((round((i / rate + delay) * SECOND) + TICK, number + i, value)
                    for number, delay, values in publishers for i, value in enumerate(values))
    said = []
    for stamp, number, value in events:
        feed(watch, stamp, **{name: GOOD[name] for name in GOOD if name != signal})
        watch.receive(signal, Sample(stamp, value, number=number))
        found = watch.assess(stamp)
        said.append(found.reason if found.inputs[signal].status == 'contradicted' else '')
    return said


@pytest.mark.parametrize(('first', 'second'), [(1, 1), (1, 500), (900, 3), (7, 8)])
@pytest.mark.parametrize(('signal', 'one', 'other', 'words'), [
    ('pressure', 15e5, 0.0, '0'), ('rotor_speed', 45.0, 0.0, '0'), ('friction', 0.4, 0.6, '0.6'),
    ('friction', 0.4, NAN, 'no number'), ('pressure', 15e5, 1500.0, '1500')])
def test_publishers_that_contradict_each_other_are_told_of_every_sample(
        signal: Any, one: float, other: float, words: str, first: int, second: int) -> None:
    """As soon as both go on for 0.8 max_age, whichever comes first, whatever their numbers."""
    said = heard((first, 0.0, [one] * 50), (second, 0.004, [other] * 50), signal=signal)
    assert not any(said[:40])
    assert all(said[44:])
    assert f'another publisher of the topic, which says {words}, until' in said[-2]


def test_publishers_that_count_alike_and_take_turns_as_they_like() -> None:
    random = np.random.default_rng(6)
    watch, said = monitor(), []
    for count in range(60):
        pair = [(15e5, 1), (0.0, 2)]
        for value, offset in (pair if random.random() < 0.5 else pair[::-1]):
            stamp = TICK + count * SECOND // 50 + offset
            watch.receive('pressure', Sample(stamp, value, number=count + 1))
            said.append(watch._inputs['pressure'].read(stamp).status)
    assert set(said[44:]) == {'contradicted'}


def test_a_contradiction_begins_and_ends_with_the_values() -> None:
    apart = [0.0] * 50 + [15e5] * 100 + [0.0] * 50
    said = heard((1, 0.0, apart), (400, 0.004, [0.0] * 200))
    told = [i / 100.0 for i, text in enumerate(said) if text]
    assert 1.4 <= told[0] <= 1.44  # 0.8 max_age after they part
    assert 2.98 <= told[-1] <= 3.02
    # one of them is silent: over within one max_age
    said = heard((1, 0.0, [15e5] * 100), (400, 0.004, [0.0] * 50))
    told = [i for i, text in enumerate(said) if text]
    assert told[-1] <= 100 + 20
    assert not any(heard((1, 0.0, apart), (400, 0.004, [0.0] * 200), publisher_tolerance=0.0))


def test_publishers_that_agree_are_no_contradiction() -> None:
    time = np.arange(0.0, 2.4, 0.02)
    random = np.random.default_rng(1)
    pulsing = 40e5 + 30e5 * np.sin(2 * np.pi * 15.0 * time)  # ABS
    for values in (pulsing, np.minimum(20e5 * time, 40e5), random.normal(1e4, 2e4, time.size)):
        noise = random.normal(0.0, 5e3, time.size)
        for delay in (0.001, 0.1, 0.3):
            assert not any(heard((1, 0.0, values), (77, delay, values + noise)))
    # one hands over to another, which begins anew
    handed = heard((800, 0.0, [15e5] * 50), (1, 1.0, [0.0] * 50))
    assert not any(handed)


def test_connections_of_a_recording_are_publishers() -> None:
    watch = monitor()
    for count in range(40):
        for connection, value in ((1, 15e5), (2, 0.0)):
            stamp = TICK + count * SECOND // 50 + connection
            watch.receive('pressure', Sample(stamp, value, connection=connection))
    assert watch._inputs['pressure'].read(stamp).status == 'contradicted'


# -- a value that no longer moves

def held(values: Sequence[float], others: Sequence[int], *, sliding: bool = True,
         rate: float = 10.0, **changes: Any) -> list[bool]:
    guard = StuckCheck(**{
        'after': 2.0, 'changes': 5, 'longest_gap': 0.5, 'movement': 1.0, **changes})
    return [bool(guard.check(round(i / rate * SECOND), value, sliding=sliding, others=other))
            for i, (value, other) in enumerate(zip(values, others, strict=True))]


LIVELY = [float(i) for i in range(10)]


def test_a_frozen_value_is_told_while_the_others_move() -> None:
    values = LIVELY + [9.0] * 30 + [9.1]
    said = held(values, range(41))
    assert said.index(True) == 9 + 21  # more than 2 s after it froze
    assert all(said[30:40])
    assert not said[40]


@pytest.mark.parametrize(('values', 'others', 'changes'), [
    ([9.0] * 40, range(40), {}),  # never moved: a bench
    (LIVELY + [9.0] * 30, [10] * 40, {}),  # nothing moves
    (LIVELY + [9.0] * 30, range(40), {'after': 0.0}),
    (LIVELY + [9.0] * 30, range(40), {'sliding': False}),
    (LIVELY + [9.0] * 30, range(40), {'rate': 1.0}),  # gaps longer than 0.5 s are no evidence
    (LIVELY + [9.0, 9.0 + 1e-12] * 15, range(40), {})])
def test_what_is_not_stuck(values: list[float], others: Sequence[int],
                           changes: dict[str, Any]) -> None:
    assert not any(held(values, others, **changes))


def quantised(values: Any, step: float) -> list[float]:
    return list(np.round(np.asarray(values) / step) * step)


@pytest.mark.parametrize(('step', 'level', 'movement', 'after'), [
    (1e5, 12e5, 1e3, 5.0), (1e4, 12e5, 1e3, 5.0), (0.5, 25.0, 0.004, 2.0), (0.1, 25.0, 0.004, 2.0),
    (0.05, 0.42, 1e-3, 10.0), (0.01, 0.42, 1e-3, 10.0), (1.0, 400.0, 0.05, 10.0)])
@pytest.mark.parametrize('rate', [10.0, 100.0])
@pytest.mark.parametrize('kind', [float, np.float32])
def test_a_coarse_signal_is_not_stuck_while_it_stays_within_its_step(
        step: float, level: float, movement: float, after: float, rate: float, kind: Any) -> None:
    random = np.random.default_rng(3)
    ramps = np.abs(np.sin(np.arange(0.0, 12.0, 1.0 / rate))) * 20.0 * step
    held_at = level + 0.2 * step * random.uniform(-1.0, 1.0, round(30 * rate))
    values = [float(kind(v)) for v in quantised([*ramps, *held_at], step)]
    if len(set(np.diff(values))) > 3:
        said = held(values, range(len(values)), rate=rate, movement=movement, after=after)
        assert not any(said)
    frozen = [values[-1]] * round((after * step / movement + 1.0) * rate)
    values += frozen[:round(600 * rate)]
    limit = after * step / movement
    assert any(held(values, range(len(values)), rate=rate, movement=movement, after=after)) == (
        limit < 590)


@pytest.mark.parametrize('noise', [2e3, 1e4])
def test_a_fine_and_noisy_signal_is_stuck_in_its_time(noise: float) -> None:
    """Few changes tell that it has no step; so does one that is clipped at zero."""
    random = np.random.default_rng(5)
    for low in (-1e9, 11.9e5):
        values = np.maximum(12e5 + random.normal(0.0, noise, 60), low)
        said = held([*values, *[13e5] * 80], range(140), movement=1e3, after=5.0)
        assert 60 + 50 <= said.index(True) <= 60 + 53


def test_a_step_is_learned_in_spite_of_a_dead_band() -> None:
    step = SignalStep()
    values = [0.0, 0.37, 0.47, 0.67, 0.97, 1.07, 1.37, 1.27, 0.97, 0.67, 0.47, 0.37, 0.0, 0.0] * 9
    for one, other in pairwise(values):
        if one != other:
            step.add(other - one)
    assert step.value == pytest.approx(0.1)


def test_without_changes_asked_for_a_constant_is_stuck() -> None:
    assert held([9.0] * 40, [0] * 40, changes=0).index(True) == 21


# -- drives

TABLE = FrictionTable((293.15, 373.15, 473.15, 873.15), (0.38, 0.42, 0.45, 0.3))


def drive(name: str, rate: float) -> BrakeSignals:
    return brake_signals(read_drive_cycle(config_folder() / 'drive_cycles' / f'{name}.csv'),
                         read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml'), TABLE,
                         rate=rate)


def watched(signals: BrakeSignals, brake: int, read: Any, **parameters: Any) -> None:
    """Feed a drive to a brake; `read` sees every input after each step."""
    watch = monitor(small_model(friction_table=TABLE), **parameters)
    columns = {name: getattr(signals, name)[:, brake].tolist() for name in watch._inputs}
    for step, seconds in enumerate(signals.time.tolist()):
        stamp = TICK + round(seconds * SECOND)
        for name, values in columns.items():
            watch.receive(name, Sample(stamp, values[step]))
        read(stamp, {name: one.read(stamp) for name, one in watch._inputs.items()})


@pytest.mark.parametrize('name', CYCLES)
def test_no_false_alarm_on_a_drive(name: str) -> None:
    def read(stamp: int, readings: Any) -> None:
        assert {r.status for r in readings.values()} == {'good'}, readings

    signals = drive(name, 20.0)
    for brake in (0, 2) if name == 'us06' else (0,):  # the rear one where it brakes hardest
        watched(signals, brake, read, **{'a.temperature.topic': '/t'})


def test_no_false_alarm_on_a_drive_as_coarse_sensors_see_it() -> None:
    """Noise, and steps of 0.1 bar, 0.05 rad/s and 0.01: the drive with the hardest braking."""
    def read(stamp: int, readings: Any) -> None:
        assert {r.status for r in readings.values()} == {'good'}, readings

    exact, random = drive('us06', 50.0), np.random.default_rng(4)

    def seen(values: Any, noise: float, step: float) -> Any:
        noisy = values + noise * random.standard_normal(values.shape)
        return np.where(values == 0.0, 0.0, step * np.round(noisy / step))

    coarse = BrakeSignals(
        exact.time, exact.vehicle_speed, exact.brakes, temperature=exact.temperature,
        rotor_speed=seen(exact.rotor_speed, 0.05, 0.05),
        pressure=seen(exact.pressure, 3e3, 1e4), friction=seen(exact.friction, 0.0, 0.01))
    watched(coarse, 0, read)


@pytest.mark.parametrize('name', CYCLES)
def test_a_drive_in_wrong_units_is_told(name: str) -> None:
    """Told for most of what would have been a number; within the first hard manoeuvres."""
    signals = drive(name, 10.0)
    numbers: dict[str, int] = {'bar': 0, 'rpm': 0}
    braked = (signals.pressure[:, 0] > 0.5e5).tolist()
    turning = (signals.rotor_speed[:, 0] > 0.5).tolist()
    for kind, guard, values in (
            ('bar', BarGuard(500.0), signals.pressure[:, 0] * 1e-5),
            ('rpm', speeds(), signals.rotor_speed[:, 0] / RPM)):
        wanted = braked if kind == 'bar' else turning
        limit = 400.0 if kind == 'rpm' else math.inf
        said = judged(guard, values.tolist(), 10.0)
        numbers[kind] = sum(not text and w and v <= limit
                            for text, w, v in zip(said, wanted, values, strict=True))
        numbers[f'{kind} of'] = sum(wanted)
    assert numbers['bar'] <= 10  # one second: the first ten samples
    assert numbers['rpm'] < 0.25 * numbers['rpm of']


# -- the buffer

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


# -- ranges of the model

@pytest.mark.parametrize(('signal', 'value', 'shown'), [
    ('rotor_speed', 200.1, 'rotor_speed is 200.1 rad/s, {} 0.5 to 200'),
    ('rotor_speed', -250.0, 'rotor_speed is -250 rad/s, {} 0.5 to 200'),
    ('pressure', 1.61e7, 'pressure is 1.61e+07 Pa, {} 20000 to 1.6e+07'),
    ('friction', 0.901, 'friction is 0.901, {} 0.05 to 0.9'),
    ('friction', 0.049, 'friction is 0.049, {} 0.05 to 0.9')])
def test_outside_the_validated_range(signal: str, value: float, shown: str) -> None:
    if signal == 'rotor_speed':  # of a released brake, too
        assert assess({**GOOD, 'pressure': 0.0, signal: value}).reason.startswith(signal)
    found = assess({**GOOD, signal: value})
    assert (found.state, found.is_valid) == ('outside validated range', False)
    assert found.reason == shown.format("outside the model's validated range") + ' (0.00 s old)'
    assert np.isnan(found.risk)
    assert found.inputs[signal].status == 'outside validated range'


def test_the_low_ends_of_speed_and_preload_count_under_load_only() -> None:
    low = {'release_pressure': 1e4, 'minimum_rotor_speed': 0.1}
    assert assess({**GOOD, 'pressure': 19e3}, **low).reason == (
        "pressure is 19000 Pa, outside the model's validated range 20000 to 1.6e+07 (0.00 s old)")
    assert assess({**GOOD, 'rotor_speed': -0.4}, **low).state == 'outside validated range'
    assert assess({**GOOD, 'pressure': 21e3, 'rotor_speed': 0.6}, **low).state == 'steady'
    assert assess({**GOOD, 'pressure': 9e3, 'rotor_speed': 0.4}, **low).state == 'released'
    assert assess({**GOOD, 'rotor_speed': 0.05}, **low).state == 'not sliding'


def test_unbelievable_comes_before_unvalidated() -> None:
    found = assess({**GOOD, 'rotor_speed': 250.0, 'friction': NAN})
    assert found.state == 'invalid'
    assert [part.split()[0] for part in found.reason.split('; ')] == ['rotor_speed', 'friction']


@pytest.mark.parametrize(('kelvin', 'friction'), [
    (299.5, 0.5), (300.0, 0.5), (400.0, 0.3), (500.0, 0.1), (500.9, 0.1)])
def test_a_table_is_not_extrapolated(kelvin: float, friction: float) -> None:
    """A sensor may err by 1 K at the ends, where the table is flat."""
    found = assess({**GOOD, 'temperature': kelvin}, **TABLE_ONLY)
    assert (found.state, found.friction) == ('steady', pytest.approx(friction))


@pytest.mark.parametrize('kelvin', [298.9, 250.0, 501.1, 900.0])
@pytest.mark.parametrize('others', [{}, {'a.friction.topic': ''}])
def test_a_temperature_outside_the_table(kelvin: float, others: dict[str, str]) -> None:
    values = {'rotor_speed': 10.0, 'pressure': 2e6, 'temperature': kelvin}
    found = assess(values, **{'a.temperature.topic': '/t', **others})
    assert not found.is_valid
    assert found.reason.endswith(f"temperature is {kelvin:g} K, outside the model's validated "
                                 'range 300 to 500 (0.00 s old)')
    if others:
        assert found.state == 'outside validated range'
    else:
        assert (found.state, found.reason.split(';')[0]) == ('stale', 'friction never received')


def test_a_table_that_gives_more_friction_than_the_model_was_validated_for() -> None:
    hot = small_model(friction_table=FrictionTable((300.0, 500.0), (0.5, 1.3)))
    found = assess({**GOOD, 'temperature': 450.0}, hot, **TABLE_ONLY)
    assert found.state == 'outside validated range'
    assert found.reason.startswith('temperature is 450 K, which gives friction 1.1, outside the')


# -- the alarm

def raised(risks: Sequence[float], *, rate: float = 10.0, hold: float = 0.5) -> list[bool]:
    alarm = Alarm(0.5, 0.1, hold)
    return [alarm.update(TICK + round(i / rate * SECOND), risk) for i, risk in enumerate(risks)]


def test_an_alarm_ends_below_the_hysteresis_and_after_the_hold() -> None:
    assert raised([0.49, 0.5, 0.45, 0.41, 0.4] + [0.45] * 20) == [False] + [True] * 24
    assert raised([0.9] + [0.39] * 8) == [True] * 5 + [False] * 4
    assert raised([0.9, 0.3, 0.3, 0.3, 0.42] + [0.39] * 5) == [True] * 9 + [False]
    assert raised([0.9, 0.3, 0.3], hold=0.0) == [True, False, False]
    assert raised([0.9] + [0.0] * 5 + [0.45, 0.49, 0.5]) == [True] * 5 + [False] * 3 + [True]


def test_an_unknown_risk_neither_raises_nor_keeps_an_alarm() -> None:
    assert raised([NAN] * 3) == [False] * 3
    assert raised([0.9] + [NAN] * 6) == [True] * 5 + [False] * 2


def test_an_alarm_and_a_clock_set_back() -> None:
    alarm = Alarm(0.5, 0.1, 3600.0)
    assert alarm.update(TICK, 0.9)
    assert not alarm.update(TICK - 1, 0.1)
    assert alarm.update(TICK - 1, 0.6)


def test_an_alarm_can_always_end() -> None:
    alarm = Alarm(0.3, 0.9, 0.0)
    assert [alarm.update(i, risk) for i, risk in enumerate((0.3, 0.01, 0.0))] == [
        True, True, False]
    alarm.update_settings(0.0, 0.0, 0.0)
    assert alarm.update(9, 0.0)


@given(st.lists(st.floats(0.0, 1.0) | st.just(NAN), max_size=60))
def test_an_alarm_does_not_chatter(risks: list[float]) -> None:
    """Up for the hold at least; up and down only where the risk crossed its levels."""
    said = raised(risks)
    assert said == raised(risks)
    ends = [i for i, (a, b) in enumerate(pairwise(said), start=1) if a and not b]
    for end in ends:
        assert all(not risk >= 0.4 for risk in risks[end - 4:end + 1])
    for i, (risk, up) in enumerate(zip(risks, said, strict=True)):
        assert up or not risk >= 0.5
        assert not up or i == 0 or said[i - 1] or risk >= 0.5
