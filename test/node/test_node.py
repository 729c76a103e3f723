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

"""
The node on real DDS: inputs published, outputs heard. No launch, no mock, no sleep.

Time is simulated, and goes on when the node has spoken; see `vehicle.py`.
"""

import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from squeal_core import BrakeModel  # noqa: E402
from squeal_core.common.errors import SquealError  # noqa: E402
from squeal_core.stability.eigensolution import complex_modes  # noqa: E402
from std_msgs.msg import Float64MultiArray  # noqa: E402
from support.node_outputs import LATCHED  # noqa: E402, I100
from support.node_runs import PATIENT, vehicle  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))


def steady(car: Vehicle) -> None:
    car.until(lambda: car.risk > 0.99 and car.status.level == WARN, 'risk near one')


def test_braking_gives_the_modes_of_the_full_solution(kang: BrakeModel) -> None:
    with vehicle() as car:
        steady(car)
        point = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
        expected = [m.frequency_hz for m in complex_modes(kang, point).unstable
                    if m.kind == 'flutter']
        assert car.unstable == pytest.approx(expected, rel=1e-9)
        worst = complex_modes(kang, point).flutter_in(1250.0, 16000.0)[0]
        assert car.said['growth_rate'].data == pytest.approx(worst.growth_rate, abs=1e-4)
        assert math.isnan(car.said['friction_margin'].data)  # without a table
        layout = car.said['unstable'].layout
        assert (layout.dim[0].label, layout.dim[0].size) == ('frequency_hz', len(expected))
        values = {item.key: item.value for item in car.status.values}
        assert float(values['growth_rate_1_s']) == pytest.approx(worst.growth_rate, abs=1e-4)
        assert values['state'] == 'steady'
        assert car.said['diagnostics'].header.stamp.sec > 0


def test_released_is_risk_zero_and_an_empty_list() -> None:
    with vehicle() as car:
        car.pressure = 0.0
        car.step()
        assert car.risk == 0.0
        assert car.status.level == OK
        assert car.unstable == []


def test_standing_still_is_not_known() -> None:
    with vehicle() as car:
        car.rotor_speed = 0.0
        car.step()
        assert 'not sliding' in car.status.message
        assert math.isnan(car.risk)
        assert len(car.unstable) == 1
        assert math.isnan(car.unstable[0])


BAD = [('rotor_speed', math.nan), ('rotor_speed', math.inf), ('pressure', math.nan),
       ('pressure', -5e5), ('pressure', 1e12), ('friction', math.nan), ('friction', -0.4)]


def test_invalid_input_gives_no_number_and_recovers() -> None:
    with vehicle() as car:
        for signal, value in BAD:
            steady(car)
            good = getattr(car, signal)
            setattr(car, signal, value)
            car.step()
            assert math.isnan(car.risk)
            assert car.status.level == ERROR
            assert signal in car.status.message
            setattr(car, signal, good)
        steady(car)


def test_silent_input_goes_stale_and_recovers() -> None:
    signals = ('rotor_speed', 'pressure', 'friction')
    with vehicle(**{f'fl__{signal}__max_age': 0.2 for signal in signals}) as car:
        for signal in signals:
            steady(car)
            car.silent = {signal}
            car.advance(0.15)
            assert car.risk > 0.99
            car.advance(0.05)
            assert car.status.level == STALE
            assert car.status.message.startswith(f'{signal} is 0.25 s old')
            assert math.isnan(car.risk)
            assert math.isnan(car.unstable[0])
            car.silent = set()
        steady(car)


def test_nothing_received_is_stale_from_the_first_tick() -> None:
    with vehicle() as car:
        car.silent |= {'rotor_speed', 'pressure', 'friction'}
        car.step()
        assert car.status.level == STALE
        assert 'never received' in car.status.message
        assert math.isnan(car.risk)


def test_turning_backwards_is_assessed_too() -> None:
    with vehicle() as car:
        car.rotor_speed = -20.0
        steady(car)


def test_temperature_stands_in_for_friction() -> None:
    with vehicle(fl__friction__topic='', fl__temperature__topic='fl/rotor_temperature') as car:
        car.temperature = 100.0
        steady(car)
        values = {item.key: item.value for item in car.status.values}
        assert values['friction_source'] == 'temperature'
        assert float(values['friction']) == pytest.approx(0.42)  # the table's own point


def test_scale_turns_bar_into_pascal() -> None:
    with vehicle(fl__pressure__scale=1e5) as car:
        car.pressure = 7.84
        steady(car)


def test_late_subscriber_gets_the_last_unstable_list() -> None:
    with vehicle() as car:
        steady(car)
        topic, heard = '/squeal_monitor/fl/unstable_frequencies', list[Any]()
        car.node.create_subscription(Float64MultiArray, topic, heard.append, LATCHED)
        car.wait(lambda: len(heard) > 0)  # time stands still: no other is published
        assert len(heard[0].data) > 1


def test_last_word_of_a_node_that_stops_is_not_known() -> None:
    with vehicle() as car:
        steady(car)
        car.monitor.trigger_deactivate()
        car.hear()
        assert math.isnan(car.risk)
        assert car.status.level == STALE
        assert 'not active' in car.status.message
        heard = list[Any]()
        car.node.create_subscription(
            Float64MultiArray, '/squeal_monitor/fl/unstable_frequencies', heard.append, LATCHED)
        car.wait(lambda: len(heard) > 0)
        assert math.isnan(heard[0].data[0])


def test_namespace_moves_inputs_and_outputs() -> None:
    with vehicle(namespace='/car') as car:
        steady(car)


def test_unreadable_messages_are_counted_and_never_a_number() -> None:
    with vehicle(fl__rotor_speed__field='velocity[name=nobody]') as car:
        car.step()
        assert car.status.level == STALE
        assert math.isnan(car.risk)
        # counted once no publisher has given the value for one max_age
        car.until(lambda: int(car.figures['unreadable_messages']) > 0, 'a message counted')
        assert car.status.message == (
            'rotor_speed never received, messages come without it '
            "(velocity[name=nobody]: no 'nobody' in the list 'name')")


def test_inactive_node_is_silent() -> None:
    with vehicle() as car:
        steady(car)
        car.monitor.trigger_deactivate()
        car.hear()  # the last word
        car.said.clear()
        car.advance(1.0)  # twenty ticks of an active node
        assert car.said == {}


BAD_SETTINGS: list[tuple[dict[str, Any], str]] = [
    ({'rate': -1.0}, 'rate'), ({'rate': math.nan}, 'rate'), ({'brakse': 'x'}, 'brakse'),
    ({'model': 'nobody'}, 'nobody'), ({'fl__rotor_speed__field': 'a..b'}, 'a..b'),
    ({'fl__pressure__type': 'no_msgs/msg/None'}, 'no_msgs'),
    ({'fl__pressure__topic': 'not a topic'}, 'not a topic'),
    ({'squeal_band_low_hz': 2e4}, 'squeal_band')]


def test_bad_settings_end_the_start_with_their_name() -> None:
    for values, words in BAD_SETTINGS:
        with pytest.raises(SquealError, match=words), vehicle(**values):
            pytest.fail('the node started')


def test_one_message_feeds_several_brakes() -> None:
    with vehicle(brakes=['fl', 'fr']) as car:
        steady(car)
        statuses = car.said['diagnostics'].status
        assert [s.hardware_id for s in statuses] == ['fl', 'fr', 'squeal_monitor']
        assert 'never received' in statuses[1].message


def test_on_the_systems_clock() -> None:
    with vehicle(use_sim_time=False, **PATIENT) as car:
        steady(car)
        car.pressure = 0.0
        car.until(lambda: car.risk == 0.0 and car.status.level == OK)
