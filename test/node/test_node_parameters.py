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

"""Parameters of a running node: what takes effect, what waits, what is refused and why."""

import math
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from rcl_interfaces.msg import Parameter as ParameterMessage  # noqa: E402
from rcl_interfaces.msg import ParameterType, ParameterValue  # noqa: E402
from rcl_interfaces.srv import SetParameters, SetParametersAtomically  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from squeal_core.monitor.settings import settings_keys  # noqa: E402
from std_msgs.msg import Float64MultiArray  # noqa: E402
from support.node_outputs import LATCHED  # noqa: E402, I100
from support.node_runs import vehicle  # noqa: E402
from support.processes import short_and_long  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))


def put(car: Vehicle, name: str, value: Any) -> Any:
    return car.monitor.set_parameters([Parameter(name, value=value)])[0]


def test_every_setting_is_described() -> None:
    with vehicle(autostart=False) as car:
        for key in settings_keys(('fl',)):
            found = car.monitor.describe_parameter(key.name)
            assert found.description == f'{key.meaning} [{key.unit}]'
            assert found.additional_constraints
            assert found.read_only == (key.name in ('brakes', 'autostart'))
            if isinstance(key.default, float) and math.isfinite(key.minimum):
                (span,) = found.floating_point_range
                assert (span.from_value, span.to_value) == (key.minimum, key.maximum)


def test_thresholds_take_effect_and_samples_stay() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        car.silent |= {'rotor_speed', 'pressure', 'friction'}  # what was received must do
        for name in ('rotor_speed', 'pressure', 'friction'):
            assert put(car, f'fl.{name}.max_age', 60.0).successful
        assert put(car, 'release_pressure', 9e5).successful
        car.until(lambda: car.risk == 0.0, 'released')
        assert put(car, 'release_pressure', 5e4).successful
        car.until(lambda: car.risk > 0.99, 'braking by the old samples')
        assert put(car, 'minimum_rotor_speed', 21.0).successful
        car.until(lambda: math.isnan(car.risk) and 'not sliding' in car.status.message)


def test_a_band_moves_in_one_step_or_not_at_all() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        low, high = 'squeal_band_low_hz', 'squeal_band_high_hz'
        assert not put(car, low, 17000.0).successful  # the high end is 16 kHz
        result = car.monitor.set_parameters_atomically(
            [Parameter(low, value=17000.0), Parameter(high, value=19000.0)])
        assert result.successful, result.reason
        car.until(lambda: math.isnan(car.risk), 'no mode in the band, so nothing is known')
        result = car.monitor.set_parameters_atomically(
            [Parameter(low, value=1250.0), Parameter(high, value=1000.0)])
        assert not result.successful
        assert 'squeal_band_high_hz: is 1000.0' in result.reason
        assert car.monitor.get_parameter(low).value == 17000.0


def test_the_rate_changes_without_a_step_back() -> None:
    with vehicle(rate=50.0) as car:
        car.until(lambda: car.risk > 0.99)
        for rate in (2.0, 100.0, 7.3):
            assert put(car, 'rate', rate).successful
            done = car.monitor.health.ticks_done
            car.until(lambda done=done: car.monitor.health.ticks_done > done + 1)  # type: ignore
            assert car.risk > 0.99
            assert car.monitor.health.clock_jumps == 0


def test_scale_and_limits_of_an_input() -> None:
    with vehicle() as car:
        car.pressure = 7.84
        car.until(lambda: car.risk == 0.0 or math.isnan(car.risk))
        assert put(car, 'fl.pressure.scale', 1e5).successful
        car.until(lambda: car.risk > 0.99)
        assert put(car, 'fl.pressure.maximum', 5e5).successful
        car.until(lambda: math.isnan(car.risk) and car.status.level == ERROR)


def test_whole_numbers_stand_for_real_ones() -> None:
    with vehicle() as car:
        assert put(car, 'rate', 40).successful
        assert car.monitor.get_parameter('rate').value == 40.0
        assert car.monitor.settings.rate == 40.0


@pytest.mark.parametrize(('name', 'value', 'words'), [
    ('rate', 0.0, 'rate'), ('rate', math.nan, 'rate'), ('rate', 'fast', 'rate'),
    ('fl.pressure.offset', math.nan, 'fl.pressure.offset'),
    ('fl.pressure.scale', math.inf, 'fl.pressure.scale'), ('fl.pressure.scale', 0.0, 'is 0'),
    ('fl.pressure.minimum', 1e9, 'maximum'), ('risk_warning', 1.5, 'risk_warning'),
    ('brakes', ['rl'], 'read-only'), ('autostart', False, 'read-only'),
    ('model', 'nobody', 'clean it up'), ('fl.pressure.topic', 'x', 'clean it up'),
    ('fl.pressure.type', 'x', 'clean it up'), ('fl.pressure.field', 'x', 'clean it up'),
    ('fl.pressure.stamp', 'receipt', 'clean it up'), ('mode_shapes', True, 'clean it up'),
    ('qos_overrides./fl/friction.subscription.depth', 3, 'read-only')])
def test_refusals_give_a_reason(running: Vehicle, name: str, value: Any, words: str) -> None:
    before = running.monitor.get_parameter(name).value
    result = put(running, name, value)
    assert not result.successful
    assert words in result.reason or 'Wrong parameter type' in result.reason
    assert running.monitor.get_parameter(name).value == before


@pytest.fixture(scope='module')
def running() -> Any:
    """Return a node that is only asked, never told anything it takes."""
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        yield car


def test_the_same_value_again_is_no_change(running: Vehicle) -> None:
    for name in ('model', 'fl.pressure.topic', 'rate'):
        assert put(running, name, running.monitor.get_parameter(name).value).successful


NAMES = [key.name for key in settings_keys(('fl',))] + ['nobody', 'use_sim_time', '', 'a' * 300]
VALUES = st.one_of(
    st.builds(ParameterValue, type=st.just(ParameterType.PARAMETER_DOUBLE),
              double_value=st.floats(width=64)),
    st.builds(ParameterValue, type=st.just(ParameterType.PARAMETER_INTEGER),
              integer_value=st.integers(-2**63, 2**63 - 1)),
    st.builds(ParameterValue, type=st.just(ParameterType.PARAMETER_STRING),
              string_value=st.text(max_size=30)),
    st.builds(ParameterValue, type=st.just(ParameterType.PARAMETER_STRING_ARRAY),
              string_array_value=st.lists(st.text(max_size=5), max_size=3)),
    st.builds(ParameterValue, type=st.sampled_from([0, 1, 5, 6, 7, 8, 10, 99, 255])))
STORM = st.lists(st.builds(ParameterMessage, name=st.sampled_from(NAMES), value=VALUES),
                 max_size=4)


@short_and_long('count', 60, 2000)
def test_any_request_is_answered_and_leaves_settings_that_hold(
        stormy: Vehicle, count: int) -> None:
    settings(max_examples=count)(given(STORM, st.booleans())(
        lambda storm, atomic: request(stormy, storm, atomic)))()
    stormy.said.clear()
    stormy.until(lambda: stormy.status is not None, 'diagnostics after the storm')


def request(stormy: Vehicle, storm: list[Any], atomic: bool) -> None:
    storm = [p for p in storm if p.name != 'use_sim_time' or p.value.type != 1]
    if atomic:
        answer = stormy.ask(SetParametersAtomically, 'set_parameters_atomically',
                            SetParametersAtomically.Request(parameters=storm))
        assert answer.result.successful or answer.result.reason
    else:
        answer = stormy.ask(SetParameters, 'set_parameters',
                            SetParameters.Request(parameters=storm))
        assert len(answer.results) == len(storm)
        assert all(r.successful or r.reason for r in answer.results)
    held = stormy.monitor.settings
    assert held.squeal_band_low_hz < held.squeal_band_high_hz
    assert math.isfinite(held.rate)
    assert stormy.monitor.get_parameter('rate').value == held.rate


@pytest.fixture(scope='module')
def stormy() -> Any:
    with vehicle(rate=5.0) as car:
        car.until(lambda: car.risk > 0.99)
        yield car


def test_quality_of_service_by_parameter(tmp_path: Path) -> None:
    """Overrides come as a parameter file gives them, and reach the middleware."""
    with vehicle(**{'qos_overrides./fl/friction.subscription.reliability': 'reliable',
                    'qos_overrides./fl/friction.subscription.depth': 3,
                    'qos_overrides./squeal_monitor/fl/squeal_risk.publisher.durability':
                    'transient_local'}) as car:
        (info,) = car.monitor.get_subscriptions_info_by_topic('/fl/friction')
        assert info.qos_profile.reliability.name == 'RELIABLE'
        (other,) = car.monitor.get_subscriptions_info_by_topic('/fl/brake_pressure')
        assert other.qos_profile.reliability.name == 'BEST_EFFORT'
        assert car.monitor.get_parameter(
            'qos_overrides./fl/friction.subscription.depth').value == 3
        (risk,) = car.monitor.get_publishers_info_by_topic('/squeal_monitor/fl/squeal_risk')
        assert risk.qos_profile.durability.name == 'TRANSIENT_LOCAL'
        car.until(lambda: car.risk > 0.99)


def test_outputs_are_reliable_and_the_list_is_latched(running: Vehicle) -> None:
    for topic in ('squeal_risk', 'growth_rate', 'friction_margin', 'unstable_frequencies'):
        (info,) = running.monitor.get_publishers_info_by_topic(f'/squeal_monitor/fl/{topic}')
        assert info.qos_profile.reliability.name == 'RELIABLE'
        latched = info.qos_profile.durability.name == 'TRANSIENT_LOCAL'
        assert latched == (topic == 'unstable_frequencies')
    heard: list[Any] = []
    running.node.create_subscription(
        Float64MultiArray, '/squeal_monitor/fl/unstable_frequencies', heard.append, LATCHED)
    running.until(lambda: len(heard) > 0)


@pytest.mark.parametrize(('policy', 'value'), [('reliability', 'sometimes'), ('depth', -1),
                                               ('depth', 'deep'), ('history', 7)])
def test_a_quality_of_service_that_is_none(policy: str, value: Any) -> None:
    name = f'qos_overrides./fl/friction.subscription.{policy}'
    with pytest.raises(Exception, match='qos_overrides of fl/friction'), \
            vehicle(**{name: value}):
        pytest.fail('the node started')
