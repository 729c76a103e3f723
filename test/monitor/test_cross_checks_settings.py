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

"""Checks across brakes: axles and their shares, and checks that are turned off."""

import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.axles import axle_partners, axle_shares
from squeal_core.monitor.inputs.cross_checks import CrossChecks
from squeal_core.monitor.settings import read_settings
from support.checked_cars import alternating, lie, SENSORS, told
from support.vehicle_streams import Fault, FL, FR, NAMES, RL, RR, settings, stop, stream


def test_axles_by_name_and_by_setting() -> None:
    for names, axles in (
            (('fl', 'fr', 'rl', 'rr'), {'fl': 'fr', 'rl': 'rr'}),
            (('LF', 'RF', 'LR', 'RR'), {'LF': 'RF', 'LR': 'RR'}),
            (('wheel_1_left', 'wheel_1_right', 'x'), {'wheel_1_left': 'wheel_1_right'}),
            (('FrontLeft', 'FrontRight'), {'FrontLeft': 'FrontRight'}),
            (('front', 'rear'), {}), (('a', 'b', 'c', 'd'), {})):
        found = axle_partners(names, ['auto'])
        assert found == {**axles, **{right: left for left, right in axles.items()}}
    assert axle_partners('abcd', ['a+c', 'b+d']) == {'a': 'c', 'c': 'a', 'b': 'd', 'd': 'b'}
    for wrong in (['a'], ['a+'], ['a+a'], ['a+e'], ['a+b', 'b+c'], ['auto', 'none']):
        with pytest.raises(ConfigurationError, match=r'axles: has .*each brake once'):
            read_settings({'brakes': ['a', 'b', 'c', 'd'], 'axles': wrong})
    with pytest.raises(ConfigurationError, match=r"axles: is \[\]; give \['none'\]"):
        read_settings({'axles': []})


def test_a_given_share_of_the_rear_axle_tells_which_brake_of_an_axle_is_wrong() -> None:
    """Before it could be learned; the one that reads too high is believed."""
    samples = stream(stop(60.0, 9.0, front=15.0), SENSORS, [
        Fault('twice', 'pressure', (FR,), lie(lambda p: 2.0 * p), 0.0)])
    assert set(told(samples)) == {(FL, 'pressure')}
    assert told(samples, rear_pressure_share=0.43) == {}
    assert set(told(samples, rear_pressure_share=0.2)) == {(FL, 'pressure')}


def test_shares_of_axles() -> None:
    """The first brake that has a partner is one of the front axle."""
    pairs = axle_partners(NAMES, ['auto'])
    assert axle_shares(NAMES, pairs, 0.4) == pytest.approx(
        dict(zip(NAMES, (2.5, 2.5, 0.4, 0.4), strict=True)))
    three = ('a', 'b', 'c', 'd', 'e', 'f')  # 1, 0.5 and 0.5
    shares = axle_shares(three, axle_partners(three, ['a+b', 'c+d', 'e+f']), 0.5)
    assert shares == pytest.approx({'a': 2.0, 'b': 2.0} | dict.fromkeys('cdef', 0.5 / 0.75))
    assert axle_shares(NAMES, pairs, 0.0) == axle_shares(NAMES[:2], pairs, 0.4) == {}


def test_one_brake_has_nothing_to_be_checked_against_and_says_so() -> None:
    checks = CrossChecks(read_settings({'brakes': ['a']}))
    assert checks.summary == 'one brake: it cannot be checked against others'
    assert CrossChecks(settings()).summary == (
        'axles: front_left+front_right, rear_left+rear_right')


@pytest.mark.parametrize(('off', 'fault'), [
    ({'contradicting_pressure': 0.0}, Fault('', 'pressure', (FL,), lie(lambda p: 0.0), 0.0)),
    ({'axle_pressure_ratio': 0.0}, Fault('', 'pressure', (FL,), lie(lambda p: 0.5 * p), 0.0)),
    ({'pressure_slew': 0.0, 'contradicting_pressure': 0.0},
     Fault('', 'pressure', (FL,), alternating(0.04), 0.0)),
    ({'unbraked_deceleration': 0.0},
     Fault('', 'pressure', (FL, FR, RL, RR), lie(lambda p: 0.0), 0.0)),
    ({'wheel_speed_tolerance': 0.0}, Fault('', 'rotor_speed', (FL,), lie(lambda w: 0.0), 0.0)),
    ({'friction_ratio': 0.0}, Fault('', 'friction', (FL,), lie(lambda mu: 0.4 * mu), 0.0))])
def test_each_check_can_be_turned_off(off: dict[str, float], fault: Fault) -> None:
    samples = stream(stop(70.0, 16.0, front=15.0), SENSORS, [fault])
    assert told(samples)
    assert told(samples, **off) == {}
