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

"""The risk through brake applications: when it is evaluated, held, begun anew, marked."""

from collections.abc import Iterator
from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor import vehicle_risk
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.risk.build_up import FLOOR
from support.brake_monitors import ANY_LEAP, EAGER, GOOD, MODEL, SECOND
from support.linear_growth import EmulatedGrowth, LinearGrowth

BEGIN = 100 * SECOND
GAIN, DECAY = 150.0, 20.0  # 1/s: 10 1/s at friction 0.5
GROWTH = GAIN * 0.2 - DECAY


@pytest.fixture(autouse=True)
def _linear(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the model's emulator be one whose growth is known: a family of two modes."""
    emulator = LinearGrowth([2000.0], [DECAY], [GAIN])
    monkeypatch.setattr(vehicle_risk, 'named_emulator', lambda path, model: emulator)


def car(rate: float = 100.0, **changes: Any) -> VehicleMonitor:
    return VehicleMonitor(read_settings({
        'brakes': ['a'], 'rate': rate, 'table': 'none', **EAGER, 'audible_build_up': 3.0,
        **{f'a.{signal}.max_age': 60.0 for signal in GOOD}, 'stuck_changes': 1e6, **ANY_LEAP,
        **changes}), MODEL)


def drive(monitor: VehicleMonitor, *stretches: tuple[float, dict[str, float]],
          begin: int = BEGIN) -> Iterator[Assessment]:
    """Yield the assessments of stretches of a drive: for how long [s], inputs (else GOOD)."""
    period, tick = monitor.settings.period, begin
    for duration, values in stretches:
        for _ in range(round(duration * 1e9 / period)):
            for signal, value in {**GOOD, **values}.items():
                monitor.receive('a', signal, Sample(tick, value))  # type: ignore[arg-type]
            [found] = monitor.assess(tick)
            yield found
            tick += period


RELEASED = {'pressure': 0.0}
AT_REST = {'rotor_speed': 0.0}
UNKNOWN = {'friction': 5.0}  # invalid


def test_build_up_over_an_application_in_closed_form() -> None:
    """From the floor: ln sqrt of e^(2 s t) + d / s (e^(2 s t) - 1), in the middle of a tick."""
    found = [*drive(car(risk_rate=100.0), (0.1, RELEASED), (0.6, {}), (0.05, RELEASED))]
    sliding = [one for one in found if one.state == 'steady']
    time = 0.005 + 0.01 * np.arange(len(sliding))
    energy = np.exp(2.0 * GROWTH * time) * (1.0 + DECAY / GROWTH) - DECAY / GROWTH
    assert [one.build_up for one in sliding] == pytest.approx(0.5 * np.log(energy), abs=2e-3)
    assert [one.risk for one in sliding] == [float(one.build_up > 3.0) for one in sliding]
    assert (sliding[0].risk, sliding[-1].risk) == (0.0, 1.0)
    missing = 3.0 - sliding[10].build_up
    assert sliding[10].time_to_squeal == pytest.approx(missing / GROWTH)
    assert [one.risk_result.result.incomplete for one in sliding if one.risk_result] == (
        [False] * len(sliding))
    released = found[-5:]
    assert released[0].build_up > sliding[-1].build_up  # half a tick more
    assert [(one.risk, one.build_up) for one in released[1:]] == [(0.0, 0.0)] * 4


def test_saturation_is_where_the_contact_opens() -> None:
    *_, last = drive(car(), (0.1, RELEASED), (3.0, {}))
    point = last.point
    assert point is not None
    amplitude = 2.0 * point.contact_pressure / point.contact_stiffness
    assert last.build_up == pytest.approx(math.log(amplitude / FLOOR))


@pytest.mark.parametrize('rate', [10.0, 20.0, 50.0])
def test_rates_agree(rate: float) -> None:
    """A touch of 0.2 s and an application in which friction rises."""
    rising = [(0.1, {'friction': 0.40 + 0.02 * step}) for step in range(6)]
    for stretches in ([(0.2, {})], rising):
        def most(monitor: VehicleMonitor) -> float:
            return max(one.build_up for one in drive(
                monitor, (0.1, RELEASED), *stretches, (0.2, RELEASED)))  # noqa: B023
        assert most(car(rate)) == pytest.approx(most(car(risk_rate=100.0)), abs=0.3)


def test_between_evaluations_the_risk_is_held() -> None:
    """At 20 Hz of absolute time; growth rate and margins are of each tick."""
    found = [*drive(car(), (0.02, RELEASED), *(
        (0.01, {'friction': 0.5 + 1e-3 * tick}) for tick in range(20)))][2:]
    changed = [tick for tick in range(1, 20) if found[tick].build_up != found[tick - 1].build_up]
    assert [found[tick].time % (SECOND // 20) for tick in changed] == [0] * 4
    assert len({one.growth_rate for one in found}) == 20


def test_all_brakes_are_evaluated_at_the_same_ticks() -> None:
    """So that four brakes cost little more than two, and alike ones have alike numbers."""
    names = ['a', 'b', 'c']
    monitor = car(brakes=names, **{
        f'{name}.{signal}.max_age': 60.0 for name in names for signal in GOOD})
    for tick in range(BEGIN, BEGIN + SECOND // 5, monitor.settings.period):
        for name in names:
            for signal, value in GOOD.items():
                monitor.receive(name, signal, Sample(tick, value))  # type: ignore[arg-type]
        found = monitor.assess(tick)
        assert len({one.build_up for one in found}) == 1
    assert found[0].build_up > 0.5


def test_a_release_begins_anew_and_a_rest_does_not() -> None:
    found = [*drive(car(), (0.1, RELEASED), (0.5, {}), (0.1, AT_REST), (0.1, {}),
                    (0.1, RELEASED), (0.1, {}))]
    first, rested, new = found[59].build_up, found[79].build_up, found[99].build_up
    assert new < rested < first  # the modes decay at rest, with 20 1/s
    assert all(one.risk_result is None or not one.risk_result.result.incomplete for one in found)


def test_what_is_not_known_adds_nothing_and_is_marked() -> None:
    found = [*drive(car(), (0.1, RELEASED), (0.3, {}), (0.5, UNKNOWN), (0.1, {}),
                    (0.1, RELEASED), (0.1, {}))]
    before, after, new = found[39], found[90], found[-1]
    assert after.build_up == pytest.approx(before.build_up, abs=0.05 * GROWTH)
    marks = [one.risk_result.result.incomplete for one in (before, after, new) if one.risk_result]
    assert marks == [False, True, False]
    assert 'a part of this brake application is not known' in after.reason
    assert 'not known' not in new.reason


def test_what_a_monitor_sees_first_is_marked_until_the_release() -> None:
    found = [*drive(car(), (0.3, {}), (0.1, RELEASED), (0.3, {}))]
    marks = [one.risk_result.result.incomplete for one in found if one.risk_result]
    assert marks == [True] * 30 + [False] * 30


def test_a_clock_set_back_and_a_reset_begin_anew() -> None:
    monitor = car()
    *_, before = drive(monitor, (0.1, RELEASED), (0.5, {}))
    *_, back = drive(monitor, (0.05, {}), begin=BEGIN - SECOND)
    monitor.reset()
    *_, anew = drive(monitor, (0.05, {}))
    assert back.build_up == anew.build_up < before.build_up
    assert [one.risk_result.result.incomplete for one in (back, anew) if one.risk_result] == [
        True, True]


def test_ticks_that_are_left_out_are_not_known() -> None:
    monitor = car()
    *_, before = drive(monitor, (0.1, RELEASED), (0.3, {}))
    after = next(drive(monitor, (0.1, {}), begin=before.time + SECOND))
    assert after.build_up == pytest.approx(before.build_up, abs=1e-9)
    assert after.risk_result is not None
    assert after.risk_result.result.incomplete


def test_outside_of_the_emulator_the_risk_is_not_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LinearGrowth, 'evaluate', lambda self, inputs: _nowhere(inputs))
    *_, found = drive(car(), (0.1, RELEASED), (0.1, {}))
    assert (found.state, math.isnan(found.risk)) == ('steady', True)
    assert found.reason.startswith(
        'squeal risk not known: outside the range of the growth emulator')


def _nowhere(inputs: Any) -> Any:
    return EmulatedGrowth(*(np.full((*inputs.shape[:-1], 1), np.nan) for _ in range(4)))


def test_without_an_emulator_the_remedy_is_named_and_the_instability_is_known() -> None:
    monitor = car(growth_emulator='none')
    *_, found = drive(monitor, (0.1, RELEASED), (0.1, {}))
    assert math.isnan(found.risk)
    assert math.isnan(found.build_up)
    assert found.instability_probability == 1.0
    assert 'squeal tabulate MODEL --growth' in monitor.evaluator.risk.unknown
    assert monitor.evaluator.risk.note == ''


def test_a_band_without_a_family_of_the_emulator_has_no_risk() -> None:
    """Not zero: unstable modes are there. And another band has one again."""
    monitor = car(squeal_band_low_hz=2020.0)
    *_, found = drive(monitor, (0.1, RELEASED), (0.1, {}))
    assert (found.state, math.isnan(found.risk)) == ('steady', True)
    assert 'no mode of the growth emulator is in the squeal band' in found.reason
    assert monitor.evaluator.risk.squeal_risk is None
    monitor.update_settings(replace(monitor.settings, squeal_band_low_hz=1000.0))
    *_, found = drive(monitor, (0.1, {}), begin=found.time + SECOND // 10)
    assert not math.isnan(found.risk)
    assert monitor.evaluator.risk.unknown == ''


def test_other_settings_leave_the_application_unless_the_band_changes() -> None:
    monitor = car()
    *_, before = drive(monitor, (0.1, RELEASED), (0.4, {}))
    for later, changes, build_up in (
            (20_000_000, {'rate': 50.0, 'instability_damping_ratio': 0.005}, before.build_up),
            (40_000_000, {'squeal_band_low_hz': 1500.0}, 0.0)):
        monitor.update_settings(replace(monitor.settings, **changes))
        after = next(drive(monitor, (0.1, {}), begin=before.time + later))
        assert after.build_up == pytest.approx(build_up, abs=0.07 * GROWTH)  # of 50 ms + a tick
    assert after.instability_probability == 0.0  # zeta is -0.0008


def test_many_ticks_at_once_are_each_of_them() -> None:
    """Whatever the sizes of the blocks, to the last bit."""
    stretches = ((0.1, RELEASED), (0.4, {}), (0.1, UNKNOWN), (0.2, {}), (0.1, RELEASED), (0.2, {}))
    single = [*drive(car(ensemble_size=16.0, friction_scatter=0.02), *stretches)]
    monitor = car(ensemble_size=16.0, friction_scatter=0.02)
    prepared = []
    monitor.assess = lambda time: prepared.append(monitor.prepare(time)) or [None]  # type: ignore
    assert len([*drive(monitor, *stretches)]) == len(single)
    found = [tick[0] for start, end in ((0, 7), (7, 60), (60, 110))
             for tick in monitor.complete(prepared[start:end])]
    assert repr(found) == repr(single)
