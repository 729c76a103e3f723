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

"""Stamps, and the way of a message to the brakes it feeds."""

from types import SimpleNamespace as Message
from typing import Any

import numpy as np
import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import MissingValue, Sample
from squeal_ros.node.field_paths import Router, stamp_of

SECOND = 1_000_000_000


def stamped(seconds: int, nanoseconds: int, **fields: Any) -> Message:
    return Message(header=Message(stamp=Message(sec=seconds, nanosec=nanoseconds)), **fields)


@pytest.mark.parametrize(('message', 'expected'), [
    (stamped(12, 345), 12_000_000_345), (stamped(0, 1), 1), (stamped(1, 0), 1_000_000_000),
    (stamped(2_000_000_000, 999_999_999), 2_000_000_000_999_999_999),
    (stamped(0, 0), 77), (Message(), 77), (Message(header=Message()), 77),
    (Message(header=None), 77), (stamped(np.int32(2_000_000_000), np.uint32(5)),
                                 2_000_000_000_000_000_005)])
def test_stamps(message: Any, expected: int) -> None:
    stamp = stamp_of(message, 77)
    assert stamp == expected
    assert type(stamp) is int


def router(**changes: Any) -> Router:
    return Router.of(read_settings({'brakes': ['a', 'b'], **changes}))


def test_one_message_feeds_several_brakes() -> None:
    message = stamped(3, 0, name=['b_wheel_joint', 'a_wheel_joint'], velocity=[2.0, 1.0])
    assert list(router().samples('joint_states', message, 99)) == [
        ('a', 'rotor_speed', Sample(3_000_000_000, 1.0)),
        ('b', 'rotor_speed', Sample(3_000_000_000, 2.0))]


def test_a_topic_of_one_brake() -> None:
    found = router()
    assert list(found.samples('b/friction', Message(data=0.4), 99)) == [
        ('b', 'friction', Sample(99, 0.4))]
    assert list(found.samples('c/friction', Message(data=0.4), 99)) == []
    assert found.types == {
        'joint_states': 'sensor_msgs/msg/JointState',
        **{f'{brake}/{name}': type_name for brake in 'ab' for name, type_name in (
            ('brake_pressure', 'sensor_msgs/msg/FluidPressure'),
            ('friction', 'std_msgs/msg/Float64'))}}


def test_one_message_feeds_several_inputs() -> None:
    found = router(**{'a.pressure.topic': 'x', 'a.pressure.field': 'data[0]',
                      'a.pressure.type': 'T', 'a.friction.topic': 'x', 'a.friction.type': 'T',
                      'a.friction.field': 'data[1]'})
    assert list(found.samples('x', Message(data=[1e5, 0.4]), 99)) == [
        ('a', 'pressure', Sample(99, 1e5)), ('a', 'friction', Sample(99, 0.4))]


def test_scale_and_offset() -> None:
    found = router(**{'a.pressure.scale': 1e5, 'a.pressure.offset': -101325.0,
                      'a.temperature.topic': 't', 'b.pressure.scale': -1})
    for topic, field, value, expected in (
            ('a/brake_pressure', 'fluid_pressure', 20, 1898675.0),
            ('b/brake_pressure', 'fluid_pressure', 20.0, -20.0), ('t', 'temperature', 20, 293.15)):
        (_, _, sample), = found.samples(topic, Message(**{field: value}), 99)
        assert sample.value == pytest.approx(expected)


def test_nan_passes_for_the_monitor_to_judge() -> None:
    (_, _, sample), = router().samples('a/friction', Message(data=float('nan')), 99)
    assert np.isnan(sample.value)


def test_a_topic_of_two_types_is_refused() -> None:
    with pytest.raises(ConfigurationError, match=(
            r'^b\.friction\.type: x is std_msgs/msg/Float64 elsewhere and std_msgs/msg/Float32 '
            r'here; give a topic one type$')):
        router(**{'a.friction.topic': 'x', 'b.friction.topic': 'x',
                  'b.friction.type': 'std_msgs/msg/Float32'})


@pytest.mark.parametrize('field', ['', 'a; b', 'a..b', 'a\n'])
def test_a_bad_path_names_its_key_and_value(field: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        router(**{'b.pressure.field': field})
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert text.startswith('b.pressure')
    assert f'{field!r} is no field path' in text


def test_problems_are_counted_and_stop_nothing() -> None:
    found = router()
    message = Message(name=['b_wheel_joint'], velocity=[2.0])
    for at in (0, 5, 6, 7, 8):  # the first half a second says nothing yet
        assert list(found.samples('joint_states', message, at * SECOND // 10)) == [
            ('a', 'rotor_speed', MissingValue(
                "velocity[name=a_wheel_joint]: no 'a_wheel_joint' in the list 'name'", True)),
            ('b', 'rotor_speed', Sample(at * SECOND // 10, 2.0))]
    assert list(found.samples('a/friction', Message(value=1), 99)) == [
        ('a', 'friction', MissingValue("data: the message has no field 'data'"))]
    assert found.problems.total() == 4
    (first, count), (second, once) = found.problems.most_common()
    assert (count, once) == (3, 1)
    assert first.startswith("joint_states: velocity[name=a_wheel_joint]: no 'a_wheel_joint'")
    assert second == "a/friction: data: the message has no field 'data'"


@pytest.mark.parametrize('other', [
    Message(name=['arm'], velocity=[9.0]), Message(name=['a_wheel_joint'], velocity=[])],
    ids=['other joints', 'positions only'])
def test_a_second_publisher_of_something_else_is_no_problem(other: Any) -> None:
    found, wheels = router(), Message(name=['a_wheel_joint', 'b_wheel_joint'],
                                      velocity=[1.0, 2.0])
    for at in range(0, 3 * SECOND, SECOND // 10):  # it comes first
        list(found.samples('joint_states', other, at))
        list(found.samples('joint_states', wheels, at + 1))
    assert found.problems.total() == 0
    for late in (at + SECOND // 2, at + SECOND):
        list(found.samples('joint_states', other, late))
    assert found.problems.total() == 2  # of both brakes, once their values are too old
    list(found.samples('joint_states', other, 0))  # the clock was set back
    assert found.problems.total() == 2


def test_an_absolute_pressure_has_the_air_taken_off() -> None:
    found = router(**{'a.pressure.reference': 'absolute', 'a.pressure.scale': 100.0,
                      'b.pressure.reference': 'absolute', 'ambient_pressure': 9e4})
    (_, _, sample), = found.samples('a/brake_pressure', Message(fluid_pressure=1000.0), 99)
    assert sample.value == 1e4
    (_, _, sample), = found.samples('b/brake_pressure', Message(fluid_pressure=1.59e6), 99)
    assert sample.value == 1.5e6
    with pytest.raises(ConfigurationError, match=r'a\.pressure\.reference.*gauge, absolute'):
        router(**{'a.pressure.reference': 'sealed'})


def test_the_number_of_a_message_goes_with_its_sample() -> None:
    (_, _, sample), = router().samples('a/friction', Message(data=0.4), 99, 7, 3)
    assert sample == Sample(99, 0.4, number=7, connection=3)


def test_nothing_is_counted_while_all_is_well() -> None:
    found = router()
    list(found.samples('a/friction', Message(data=0.4), 99))
    assert found.problems.total() == 0
