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

"""Checks across brakes: what they tell, how soon, and when a doubt ends."""

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core.monitor.vehicle_monitor import VehicleMonitor
from support.brake_monitors import CERTAIN, MODEL
from support.checked_cars import alternating, Car, lie, PRESSURE_LIES, SENSORS, SPEED_LIES, told
from support.vehicle_streams import (
    Drive,
    Fault,
    FL,
    FR,
    FRONT,
    play,
    RL,
    RR,
    settings,
    stop,
    stream,
)


@pytest.mark.parametrize('rate', [1.0, 10.0, 100.0])
@pytest.mark.parametrize('name', ['dead', 'hPa', 'half'])
def test_a_pressure_that_lies_is_told_at_any_rate_of_ticks(name: str, rate: float) -> None:
    change, within = PRESSURE_LIES[name]
    braking = stop(60.0, 12.0, front=15.0)
    found = told(stream(braking, SENSORS, [Fault(name, 'pressure', (FL,), change, 1.0)]), rate)
    assert set(found) == {(FL, 'pressure')}
    # seen from 3.1 s on, when the other brake has 1.5 bar
    assert 3.4 <= found[FL, 'pressure'][0][0] <= 3.1 + within + 1.0 / rate
    assert 'though front_right pressure is ' in found[FL, 'pressure'][0][1]


def test_the_reason_names_both_inputs_and_values() -> None:
    vehicle = VehicleMonitor(settings(**CERTAIN), MODEL)
    samples = stream(stop(60.0, 12.0, front=15.0), SENSORS, [
        Fault('kPa', 'pressure', (FL,), PRESSURE_LIES['kPa'][0], 0.0)])
    seconds, found = next(x for x in play(samples, vehicle) if x[0] >= 5.0)
    assert (found[FL].state, found[FL].is_valid, str(found[FL].risk)) == ('invalid', False, 'nan')
    assert found[FL].reason == (
        'pressure is 1500 Pa, though front_right pressure is 1.5e+06 Pa, as kPa given as Pa would '
        'be, until it brakes with 100000 Pa or more as the others do (0.00 s old)')
    assert [one.state for one in found[1:]] == ['steady'] * 3


def test_a_doubt_is_held_until_the_brake_agrees_and_says_so() -> None:
    """The fault ends at 6 s, while the brake is released; the next braking clears it."""
    first = stop(60.0, 9.0, front=15.0, before=2.0, after=4.0, hold=3.0)
    again = stop(30.0, 6.0, front=15.0, before=0.0, after=2.0, hold=3.0)
    both = Drive(np.concatenate([first.time, again.time + first.time[-1] + 0.01]), *(
        np.concatenate([getattr(first, s), getattr(again, s)]) for s in (
            'rotor_speed', 'pressure', 'friction')))
    found = told(stream(both, SENSORS, [
        Fault('dead', 'pressure', (FL,), lie(lambda p: 0.0), 0.0, 6.0)]))
    times = [seconds for seconds, _ in found[FL, 'pressure']]
    assert times == pytest.approx(np.arange(times[0], times[-1] + 0.05, 0.1))
    assert first.time[-1] < times[-1] < first.time[-1] + 0.8
    held = next(text for seconds, text in found[FL, 'pressure'] if seconds > 7.0)
    assert 'though front_right pressure was ' in held
    assert ', until it brakes with 100000 Pa or more as the others do' in held


STANDS = stop(60.0, 12.0, front=15.0, hold=10.0)  # from 8 s on, and is held
DEAD = Fault('dead', 'pressure', (FL,), lie(lambda p: 0.0), 0.0, 5.0)
LASTS = Fault('dead', 'pressure', (FL,), lie(lambda p: 0.0), 0.0)
PARTNER_OFF = Fault('off', 'pressure', (FR,), lie(lambda p: math.nan), 4.0)
ROLLING = stop(75.0, 1.0, front=0.0, hold=10.0)
SLOW_WHEEL = Fault('0.7', 'rotor_speed', (RL,), lie(lambda w: 0.7 * w), 1.0, 6.0)
AXLE = Fault('0.5', 'rotor_speed', FRONT, lie(lambda w: 0.5 * w), 1.0, 9.0)
FRICTION = Fault('half', 'friction', (FR,), lie(lambda mu: 0.5 * mu), 0.0, 6.0)


@pytest.mark.parametrize(('drive', 'faults', 'end', 'until'), [
    pytest.param(STANDS, [DEAD], 5.0, 'brakes with 100000 Pa or more', id='braking'),
    pytest.param(STANDS, [replace(DEAD, end=9.0)], 9.0, 'brakes with 100000 Pa', id='at rest'),
    pytest.param(STANDS, [DEAD, PARTNER_OFF], 5.0, 'brakes with 100000 Pa', id='partner off'),
    pytest.param(stop(70.0, 18.0, front=8.0), [replace(DEAD, wheels=(FL, FR, RL, RR))], 5.0,
                 'reads 100000 Pa or more while a brake reads 500000 Pa', id='deceleration'),
    pytest.param(ROLLING, [SLOW_WHEEL], 6.0, 'turns as the others do', id='wheel'),
    pytest.param(ROLLING, [AXLE], 9.0, 'turns as the others do', id='axle'),
    pytest.param(STANDS, [FRICTION], 6.0, 'is like the others while they brake', id='friction')])
def test_every_doubt_names_its_end_and_ends(drive: Drive, faults: Sequence[Fault], end: float,
                                            until: str) -> None:
    found = told(stream(drive, SENSORS, faults))
    assert set(found) == {(wheel, faults[0].signal) for wheel in faults[0].wheels}
    for each in found.values():
        assert all(f', until it {until}' in text for _, text in each)
        assert end <= each[-1][0] <= end + 1.0  # which is 0.3 s beyond the means


def test_a_doubt_outlives_the_partner() -> None:
    found = told(stream(STANDS, SENSORS, [LASTS, PARTNER_OFF]))[FL, 'pressure']
    assert [seconds for seconds, _ in found] == pytest.approx(
        np.arange(found[0][0], found[-1][0] + 0.05, 0.1))
    assert found[-1][0] > STANDS.time[-1] - 0.2


def test_an_alternation_ends_when_the_pressure_is_steady() -> None:
    """At rest too, and of a brake without others."""
    samples = stream(STANDS, faults=[Fault('0', 'pressure', (FL,), alternating(0.01), 4.0, 9.0)])
    alone = replace(samples, samples=[one for one in samples.samples if one[1] == FL])
    for given, changes in ((samples, {}), (alone, {'brakes': ['front_left']})):
        found = told(given, **changes)
        assert set(found) == {(FL, 'pressure')}
        times, texts = zip(*found[FL, 'pressure'], strict=True)
        assert times[0] <= 4.6
        assert 9.3 <= times[-1] <= 9.65
        assert all(', until it has been steady for 0.5 s' in text for text in texts)


def test_a_check_that_is_turned_off_ends_what_it_told() -> None:
    for fault, off in ((LASTS, 'contradicting_pressure'),
                       (replace(SLOW_WHEEL, end=99.0), 'wheel_speed_tolerance'),
                       (replace(FRICTION, end=99.0), 'friction_ratio')):
        car = Car()
        drive = ROLLING if fault.signal == 'rotor_speed' else STANDS
        for seconds, readings in car.run(stream(drive, SENSORS, [fault])):
            status = readings[fault.wheels[0]][fault.signal].status
            if seconds == 7.0:
                assert status == 'implausible'
                car.monitor.update_settings(settings(**{off: 0.0}))
            elif seconds > 7.0:
                assert status == 'good'


def test_a_second_publisher_of_zero_is_told_at_once() -> None:
    for period, within in ((0.02, 0.6), (0.01, 0.6), (0.1, 3.3)):
        found = told(stream(stop(60.0, 9.0, front=15.0), faults=[
            Fault('0', 'pressure', (FL,), alternating(period), 4.0)]))
        assert set(found) == {(FL, 'pressure')}
        assert found[FL, 'pressure'][0][0] <= 4.0 + within, period
        assert 'alternates' in found[FL, 'pressure'][0][1]


def test_all_pressures_dead_is_told_by_the_deceleration() -> None:
    for change, slowing, front in ((0.0, 18.0, 20.0), (0.01, 25.0, 60.0)):
        found = told(stream(stop(70.0, slowing, front=front), SENSORS, [
            Fault('dead', 'pressure', (FL, FR, RL, RR), lie(lambda p, by=change: by * p), 0.0)]))
        assert set(found) == {(wheel, 'pressure') for wheel in range(4)}
        seconds, text = found[RR, 'pressure'][0]
        assert seconds <= 3.0 + 1.5
        assert f'falls by {slowing:.0f}' in text
        assert 'though rotor_speed of the wheels' in text


@pytest.mark.parametrize('name', SPEED_LIES)
def test_a_wheel_speed_unlike_the_others_is_told(name: str) -> None:
    change, within = SPEED_LIES[name]
    rolling = stop(75.0, 1.0, front=0.0, hold=10.0)
    found = told(stream(rolling, SENSORS, [Fault(name, 'rotor_speed', (RL,), change, 2.0)]))
    assert set(found) == {(RL, 'rotor_speed')}
    # a sudden step is no good value for up to max_age either
    assert found[RL, 'rotor_speed'][0][0] <= 2.0 + 0.5 + within
    assert 'rotor_speed is ' in found[RL, 'rotor_speed'][0][1]


def test_both_wheels_of_an_axle_are_told_by_the_other_axle() -> None:
    found = told(stream(stop(60.0, 1.0, front=0.0, hold=10.0), SENSORS, [
        Fault('rev/s', 'rotor_speed', FRONT, SPEED_LIES['rev/s'][0], 2.0)]))
    assert set(found) == {(FL, 'rotor_speed'), (FR, 'rotor_speed')}
    assert found[FL, 'rotor_speed'][0][0] <= 8.0


def test_a_friction_far_below_the_neighbours_is_told() -> None:
    braking = stop(60.0, 9.0, front=15.0)
    found = told(stream(braking, SENSORS, [
        Fault('half', 'friction', (FR,), lie(lambda mu: 0.5 * mu), 0.0)]))
    assert set(found) == {(FR, 'friction')}
    assert found[FR, 'friction'][0][0] <= 3.1 + 1.4
    assert 'though front_left friction is 0.42' in found[FR, 'friction'][0][1]


def test_brakes_without_known_axles_are_compared_with_most_others() -> None:
    found = told(stream(stop(60.0, 9.0, front=15.0), SENSORS, [
        Fault('dead', 'pressure', (FL,), lie(lambda p: 0.0), 0.0)]), axles=['none'])
    assert set(found) == {(FL, 'pressure')}
