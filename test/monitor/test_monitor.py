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

"""The monitor: what it says in each state, when it recovers, and that nothing else sways it."""

import math
from typing import Any

import numpy as np
import pytest
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.errors import ConfigurationError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import BrakeMonitor, Sample, VehicleMonitor
from support.brake_monitors import (
    ANY_LEAP,
    assess,
    check_unknown,
    feed,
    GOOD,
    invalid,
    LIMITS,
    MODEL,
    monitor,
    NAN,
    SECOND,
    small_model,
    TABLE_ONLY,
    TICK,
    WITH_TABLE,
)


def test_steady_and_squealing() -> None:
    found = assess(GOOD)
    assert (found.state, found.is_valid, found.brake, found.time) == ('steady', True, 'a', TICK)
    assert (found.friction, found.friction_source) == (0.5, 'measured')
    assert [round(m.frequency_hz, -2) for m in found.flutter] == [2000.0]
    assert found.flutter[0].growth_rate == found.growth_rate > 0.0
    assert found.instability_probability > 0.99
    assert math.isnan(found.risk)
    assert found.reason.startswith('squeal risk not known: no growth emulator')


def test_steady_and_quiet() -> None:
    found = assess({**GOOD, 'friction': 0.1})
    assert (found.state, found.modes) == ('steady', ())
    assert found.growth_rate < 0.0 <= found.instability_probability < 0.01


@pytest.mark.parametrize('missing', GOOD)
def test_never_received(missing: str) -> None:
    others = {signal: value for signal, value in GOOD.items() if signal != missing}
    check_unknown(assess(others), 'stale', f'{missing} never received')


@pytest.mark.parametrize('old', GOOD)
@pytest.mark.parametrize('max_age', [0.5, 0.1, 2.0])
def test_stale_just_over_max_age(old: str, max_age: float) -> None:
    others = {signal: value for signal, value in GOOD.items() if signal != old}
    watch = feed(monitor(**{f'a.{old}.max_age': max_age}), **others)
    feed(watch, TICK - round(max_age * SECOND), **{old: GOOD[old]})
    assert watch.assess(TICK).state == 'steady'
    shown = {'rotor_speed': '10 rad/s', 'pressure': '2e+06 Pa', 'friction': '0.5'}[old]
    check_unknown(watch.assess(TICK + 1), 'stale', f'{old} is {max_age:.2f} s old: {shown}')


@pytest.mark.parametrize(('signal', 'value'), [
    *((signal, value) for signal in GOOD for value in (NAN, math.inf, -math.inf)),
    *((signal, math.nextafter(limit, sign * math.inf)) for signal, limits in LIMITS.items()
      for limit, sign in zip(limits, (-1, 1), strict=True)),
    ('friction', 0.0), ('friction', -0.42), ('pressure', -1e6)])
def test_invalid(signal: str, value: float) -> None:
    cases = [{**GOOD, signal: value}]
    if signal != 'friction':  # of which a released brake has no need
        cases.append({**GOOD, 'pressure': 0.0, signal: value})
    for values in cases:
        check_unknown(assess(values, **ANY_LEAP), 'invalid', invalid(signal, value))


@pytest.mark.parametrize('signal', GOOD)
def test_the_limits_themselves_are_believed(signal: str) -> None:
    wide = {'validated_rotor_speed_high': 400.0, 'validated_preload_high': 3e7 * 2.5e-3,
            'validated_friction_low': 0.01, 'validated_friction_high': 1.5}
    for limit in LIMITS[signal]:
        assert assess({**GOOD, signal: limit}, **wide).is_valid


@pytest.mark.parametrize('pressure', [0.0, 4.9999e4, -4e4])
@pytest.mark.parametrize('speed', [10.0, -10.0, 0.0])
def test_released(pressure: float, speed: float) -> None:
    found = assess({**GOOD, 'pressure': pressure, 'rotor_speed': speed})
    assert (found.state, found.risk, found.is_valid, found.modes) == ('released', 0.0, True, ())


@pytest.mark.parametrize('pressure', [-9e4, -101325.0, -1.05e5])
def test_a_gauge_may_undershoot_to_minus_an_atmosphere(pressure: float) -> None:
    assert assess({**GOOD, 'pressure': pressure}).state == 'released'
    below = math.nextafter(-1.05e5, -math.inf)
    check_unknown(assess({**GOOD, 'pressure': below}), 'invalid', invalid('pressure', below))


WITHOUT_FRICTION: dict[str, dict[str, float]] = {
    'NaN': {'friction': NAN}, 'zero': {'friction': 0.0}, 'negative': {'friction': -0.3},
    'beyond the model': {'friction': 1.2}, 'missing': {}, 'both bad': {
        'friction': NAN, 'temperature': NAN}, 'a cold disc': {'temperature': 250.0}}


@pytest.mark.parametrize('friction', WITHOUT_FRICTION.values(), ids=WITHOUT_FRICTION)
@pytest.mark.parametrize('idle', [{'pressure': 0.0}, {'rotor_speed': 0.1}])
def test_friction_is_judged_when_it_is_needed(friction: dict[str, float],
                                              idle: dict[str, float]) -> None:
    values = {'rotor_speed': 10.0, 'pressure': 2e6, **friction}
    parameters = WITH_TABLE if 'temperature' in friction else {}
    assert not assess(values, **parameters).is_valid
    found = assess({**values, **idle}, **parameters)
    assert found.state == ('released' if 'pressure' in idle else 'not sliding')
    assert 'friction' not in found.reason
    assert (str(found.friction), found.friction_source) == ('nan', '')
    bad = assess({**values, **idle, 'rotor_speed': NAN, 'pressure': NAN}, **parameters)
    assert bad.state in ('invalid', 'stale')
    assert [part.split()[0] for part in bad.reason.split('; ')][:2] == ['rotor_speed', 'pressure']


def test_a_friction_that_only_comes_while_braking() -> None:
    watch = feed(monitor(), **GOOD)
    later = TICK + 10 * SECOND
    feed(watch, later, rotor_speed=10.0, pressure=0.0)
    assert watch.assess(later).state == 'released'
    feed(watch, later + 1, pressure=2e6)
    assert watch.assess(later + 1).reason == 'friction is 10.00 s old: 0.5'
    assert feed(watch, later + 2, friction=0.4).assess(later + 2).state == 'steady'


@pytest.mark.parametrize('speed', [0.0, 0.4999, -0.4999, -0.0])
def test_not_sliding(speed: float) -> None:
    check_unknown(assess({**GOOD, 'rotor_speed': speed}), 'not sliding',
                  f'rotor speed {speed:.2f} rad/s: not sliding')
    assert assess({**GOOD, 'rotor_speed': 0.5, 'pressure': 5e4}).state == 'steady'


@pytest.mark.parametrize('bad', [
    {}, *({**GOOD, signal: value} for signal in GOOD for value in (NAN, math.inf, -1e9)),
    {**GOOD, 'pressure': 0.0}, {**GOOD, 'rotor_speed': 0.0}])
def test_recovery(bad: dict[str, float]) -> None:
    watch = feed(monitor(), TICK - SECOND // 10, **bad)
    assert watch.assess(TICK - SECOND // 10).state != 'steady'
    assert repr(feed(watch, **GOOD).assess(TICK)) == repr(assess(GOOD))
    assert watch.assess(TICK + SECOND).state == 'stale'
    assert feed(watch, TICK + SECOND, **GOOD).assess(TICK + SECOND).state == 'steady'


def test_samples_of_the_future_wait() -> None:
    watch = feed(monitor(), **GOOD)
    for number in range(1, 1001):
        feed(watch, TICK + number, friction=number * 5e-4)
    assert repr(watch.assess(TICK)) == repr(assess(GOOD))
    assert [watch.assess(TICK + n).friction for n in (200, 500, 1000)] == [0.1, 0.25, 0.5]


def test_a_late_sample_does_not_replace_a_newer_one() -> None:
    watch = feed(monitor(), **GOOD)
    feed(watch, TICK - SECOND, friction=0.1)
    assert repr(watch.assess(TICK)) == repr(assess(GOOD))


def test_one_sample_of_the_future_does_not_block_an_input() -> None:
    watch = feed(feed(monitor(), TICK - SECOND, **GOOD), TICK + 1000 * SECOND, friction=0.1)
    assert repr(feed(watch, **GOOD).assess(TICK)) == repr(assess(GOOD))


def test_jump_back_of_the_clock() -> None:
    watch = feed(monitor(), **GOOD)
    assert (watch.assess(TICK).state, watch.assess(TICK - 1).state) == ('steady', 'stale')
    watch.reset()
    check_unknown(watch.assess(TICK), 'stale', '; '.join(f'{s} never received' for s in GOOD))
    assert feed(watch, TICK - SECOND, **GOOD).assess(TICK - SECOND).state == 'steady'


def test_friction_of_the_temperature_alone() -> None:
    found = assess({**GOOD, 'temperature': 350.0}, **TABLE_ONLY)
    assert (found.friction, found.friction_source) == (pytest.approx(0.4), 'temperature')
    assert found.growth_rate == assess({**GOOD, 'friction': found.friction}).growth_rate
    for value in (NAN, 199.0, 1501.0):
        check_unknown(assess({**GOOD, 'temperature': value}, **TABLE_ONLY), 'invalid',
                      invalid('temperature', value))


@pytest.mark.parametrize('friction', [{}, {'friction': NAN}, {'friction': -0.1}])
def test_the_temperature_stands_in_for_friction(friction: dict[str, float]) -> None:
    watch = feed(monitor(**WITH_TABLE), **friction, temperature=300.0)
    found = feed(watch, rotor_speed=10.0, pressure=2e6).assess(TICK)
    assert (found.state, found.friction, found.friction_source) == ('steady', 0.5, 'temperature')
    assert found.growth_rate == assess(GOOD).growth_rate
    found = feed(watch, TICK + 1, friction=0.45).assess(TICK + 1)
    assert (found.friction, found.friction_source) == (0.45, 'measured')


def test_a_constant_friction_and_another_one_later() -> None:
    def given(mu: float) -> dict[str, Any]:
        return {'brakes': ['a'], 'a.friction.topic': '', 'a.friction.constant': mu}

    watch = feed(BrakeMonitor(read_settings(given(0.5)).brakes[0], read_settings(given(0.5)),
                              small_model(friction_table=None)), **GOOD)
    found = watch.assess(TICK)
    assert (found.state, found.friction, found.friction_source) == ('steady', 0.5, 'constant')
    assert found.growth_rate == assess(GOOD).growth_rate
    watch.update_settings(read_settings(given(0.4)).brakes[0], read_settings(given(0.4)))
    assert feed(watch, TICK + 1, **GOOD).assess(TICK + 1).friction == 0.4


def test_stale_friction_and_temperature() -> None:
    watch = feed(monitor(**WITH_TABLE), TICK - SECOND, friction=0.5, temperature=NAN)
    feed(watch, rotor_speed=10.0, pressure=2e6)
    check_unknown(watch.assess(TICK), 'stale', 'friction is 1.00 s old: 0.5; '
                  'temperature is 1.00 s old: nan K')
    assert feed(watch, temperature=300.0).assess(TICK).friction_source == 'temperature'
    assert feed(watch, friction=0.3, temperature=NAN).assess(TICK).friction == 0.3


@pytest.mark.parametrize(('low', 'high', 'frequency'), [
    (1250.0, 16000.0, 2000.0), (1250.0, 1800.0, 1500.0), (500.0, 1000.0, 900.0)])
def test_squeal_band(low: float, high: float, frequency: float) -> None:
    found = assess(GOOD, squeal_band_low_hz=low, squeal_band_high_hz=high)
    assert round(found.worst_frequency_hz, -2) == frequency
    assert (found.instability_probability > 0.99) == (found.growth_rate > 0.0) == (
        frequency == 2000.0)
    assert [round(m.frequency_hz, -2) for m in found.modes] == [2000.0]
    none = assess(GOOD, squeal_band_low_hz=5000.0)
    assert (none.state, none.instability_probability, none.modes) == (
        'steady', 0.0, found.modes)


@pytest.mark.parametrize('speed', [2.0, 10.0, 40.0])
def test_backwards_as_forwards(kang: BrakeModel, speed: float) -> None:
    forwards, backwards = (assess({**GOOD, 'rotor_speed': sign * speed}, kang)
                           for sign in (1, -1))
    for name in ('instability_probability', 'growth_rate', 'worst_frequency_hz'):
        assert getattr(backwards, name) == pytest.approx(
            getattr(forwards, name), rel=1e-6, nan_ok=True)
    assert len(backwards.modes) == len(forwards.modes) > 0


@pytest.mark.parametrize(('changes', 'parameters', 'text'), [
    ({'caliper': None}, {}, 'model: has no caliper, so a pressure says nothing to it; give'),
    ({'friction_table': None}, TABLE_ONLY, 'a.temperature: is all there is, and the model has'),
    ({}, {'a.friction.minimum': 0.0}, 'a.friction.minimum: is 0.0 ')])
def test_refused_at_once(changes: Any, parameters: Any, text: str) -> None:
    with pytest.raises(ConfigurationError, match=f'^{text}'):
        monitor(model := small_model(**changes), **parameters)
    with pytest.raises(ConfigurationError, match=f'^{text}'):
        VehicleMonitor(read_settings({'brakes': ['a'], **parameters}), model)


def test_a_temperature_without_a_table_is_passed_over() -> None:
    model, warm = small_model(friction_table=None), {**GOOD, 'temperature': 300.0}
    assert assess(warm, model, **WITH_TABLE).friction_source == 'measured'
    check_unknown(assess({**warm, 'friction': NAN}, model, **WITH_TABLE), 'invalid',
                  invalid('friction', NAN))


def test_a_growing_mode_is_probably_unstable() -> None:
    model = BrakeModel(
        angular_frequencies=np.array([4e3 * np.pi]), damping_ratios=0.0, caliper=Caliper(2.5e-3),
        negative_slope=np.array([[1e-4]]), friction_law=FrictionLaw())
    for speed in np.linspace(1.0, 40.0, 12):
        found = assess({**GOOD, 'rotor_speed': speed}, model)
        assert found.instability_probability > 0.5


def test_brakes_of_a_vehicle_do_not_sway_each_other() -> None:
    vehicle = VehicleMonitor(read_settings({'brakes': ['b', 'a']}), MODEL)
    for signal, value in GOOD.items():
        vehicle.receive('a', signal, Sample(TICK, value))
        vehicle.receive('b', signal, Sample(TICK - SECOND, NAN))
    first, second = vehicle.assess(TICK)
    assert (first.brake, first.state) == ('b', 'stale')
    assert repr(second) == repr(assess(GOOD))
    vehicle.reset()
    assert [found.state for found in vehicle.assess(TICK)] == ['stale', 'stale']
