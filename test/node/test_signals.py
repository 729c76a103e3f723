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

"""Field paths, stamps, and the way of a message to the brakes it feeds."""

import re
from types import SimpleNamespace as Message
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import MissingValue, Sample
from squeal_ros.node.field_paths import FieldError, FieldPath, Router, stamp_of

SECOND = 1_000_000_000
JOINTS = Message(name=['left', 'right', 'spare wheel', 'a=b'], velocity=[1.0, -2.0, 3.0, 4.0])
NESTED = Message(a=Message(b=[Message(c=5), Message(c=-6.5)]), data=7, flat=[8.0, 9.0],
                 wheels=[JOINTS, Message(name=['left'], velocity=[10.0])], empty=[], text='fast',
                 nothing=None, fields={'x': 1.0})


@pytest.mark.parametrize(('text', 'steps'), [
    ('data', [('attribute', 'data', '')]),
    ('a.b', [('attribute', 'a', ''), ('attribute', 'b', '')]),
    ('a[2]', [('attribute', 'a', ''), ('index', 2, '')]),
    ('a[0][12]', [('attribute', 'a', ''), ('index', 0, ''), ('index', 12, '')]),
    ('velocity[name=x]', [('attribute', 'velocity', ''), ('lookup', 'name', 'x')]),
    ('v[name=rear wheel.joint/2]', [('attribute', 'v', ''), ('lookup', 'name',
                                                             'rear wheel.joint/2')]),
    ('a.b[2].c', [('attribute', 'a', ''), ('attribute', 'b', ''), ('index', 2, ''),
                  ('attribute', 'c', '')])])
def test_parse(text: str, steps: list[Any]) -> None:
    path = FieldPath.parse(text)
    assert (path.text, list(path.steps)) == (text, steps)


@pytest.mark.parametrize('text', [
    '', '.a', 'a..b', 'a.', '.', 'a[', 'a[]', 'a[2', 'a]', 'a b', ' a', 'a ', '[2]', '[name=x]',
    'a[-1]', 'a[1.5]', 'a.[2]', 'a[2]b', 'a[name=]', 'a[=x]', 'a[name=x', '2a', 'a.2', 'a-b',
    'a/b', 'a()', 'a\n', 'a[name]', 'ä', 'a[' + '9' * 5000 + ']'])
def test_parse_refuses(text: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        FieldPath.parse(text)
    assert len(str(caught.value).splitlines()) == 1
    assert f'{text!r} is no field path' in str(caught.value)
    assert str(caught.value).endswith(('write a.b, a[2] or a[name=text]', 'name a field first'))


@given(st.text(alphabet='ab.[]=0 n', max_size=12))
def test_parse_takes_all_of_a_text_or_refuses_it(text: str) -> None:
    try:
        steps = FieldPath.parse(text).steps
    except ConfigurationError:
        return
    written = ''.join({'attribute': f'.{name}', 'index': f'[{name}]',
                       'lookup': f'[{name}={key}]'}[kind] for kind, name, key in steps)
    assert written == '.' + re.sub(r'\[0+0', '[0', text)


@pytest.mark.parametrize(('text', 'expected'), [
    ('data', 7.0), ('a.b[0].c', 5.0), ('a.b[1].c', -6.5), ('flat[1]', 9.0),
    ('wheels[1].velocity[0]', 10.0), ('wheels[1].velocity[name=left]', 10.0),
    ('wheels[0].velocity[name=left]', 1.0)])
def test_read(text: str, expected: float) -> None:
    value = FieldPath.parse(text).read(NESTED)
    assert value == expected
    assert type(value) is float


@pytest.mark.parametrize(('joint', 'expected'), [
    ('left', 1.0), ('right', -2.0), ('spare wheel', 3.0), ('a=b', 4.0)])
def test_read_by_name(joint: str, expected: float) -> None:
    path = FieldPath.parse(f'velocity[name={joint}]')
    assert path.read(JOINTS) == expected
    assert path.read(Message(name=JOINTS.name, velocity=np.array(JOINTS.velocity))) == expected
    turned = Message(name=JOINTS.name[::-1], velocity=JOINTS.velocity[::-1])
    assert path.read(turned) == expected


@pytest.mark.parametrize(('text', 'reason'), [
    ('speed', "no field 'speed'"), ('a.c', "no field 'c'"), ('data.x', "no field 'x'"),
    ('flat[2]', 'too short'), ('empty[0]', 'too short'), ('data[0]', 'is no list'),
    ('nothing[0]', 'is no list'), ('fields[0]', 'is no list'),
    ('flat[999999999]', 'too short'), ('flat', 'is no number but list'),
    ('nothing', 'is no number but NoneType'), ('a', 'is no number but SimpleNamespace'),
    ('text', 'is no number but str'), ('flat[name=left]', "no field 'name'"),
    ('wheels[1].velocity[name=right]', "no 'right' in the list 'name'"),
    ('wheels[1].velocity[name=le]', "no 'le' in the list 'name'")])
def test_read_refuses(text: str, reason: str) -> None:
    with pytest.raises(FieldError) as caught:
        FieldPath.parse(text).read(NESTED)
    assert str(caught.value).startswith(f'{text}: ')
    assert reason in str(caught.value)


@pytest.mark.parametrize('message', [
    Message(name=['left'], velocity=[]), Message(name=[], velocity=[]),
    Message(name=[], velocity=[1.0]), Message(name=None, velocity=[1.0]), Message(name=['left']),
    Message(velocity=[1.0]), Message(name=['left'], velocity=None), Message(),
    Message(name=['left'], velocity=['fast'])])
def test_joint_states_that_say_nothing(message: Any) -> None:
    with pytest.raises(FieldError):
        FieldPath.parse('velocity[name=left]').read(message)


@pytest.mark.parametrize('value', [
    'fast', '3.5', None, [1.0], np.array([1.0]), np.array([]), object(), 1j,
    b'5',  # rclpy's form of a ROS byte 53
    np.complex128(1j), np.str_('3.5'), np.array('3.5'), np.array(None)])
def test_what_is_no_number(value: Any) -> None:
    with pytest.raises(FieldError, match='data: is no number but'):
        FieldPath.parse('data').read(Message(data=value))


@pytest.mark.parametrize('value', [3, 3.0, np.float32(3), np.int16(3), np.array(3.0)])
def test_what_is_a_number(value: Any) -> None:
    assert FieldPath.parse('data').read(Message(data=value)) == 3.0


@pytest.mark.parametrize('value', [True, np.True_, np.array(True)])
def test_a_switch_is_a_number(value: Any) -> None:
    assert FieldPath.parse('data').read(Message(data=value)) == 1.0


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


WHEELS = ['left', 'right', 'rear', 'spare']
PATHS = [*(f'velocity[name={name}]' for name in WHEELS), *(f'velocity[{i}]' for i in range(3))]


@pytest.mark.parametrize('path', PATHS)
@pytest.mark.parametrize('velocity', [[1.0, 2.0, 3.0], [1.0, 2.0, 3.0, 4.0, 5.0], [1.0]])
def test_names_and_velocities_of_unequal_length_are_unreadable(path: str,
                                                               velocity: list[float]) -> None:
    """Which wheel has which speed is not known: not even that of an index that is there."""
    for values in (velocity, np.array(velocity)):
        with pytest.raises(FieldError, match=(
                rf"^{re.escape(path)}: {len(velocity)} values for 4 in the list 'name'$")):
            FieldPath.parse(path).read(Message(name=WHEELS, velocity=values))


def test_lists_of_any_names_are_of_one_length() -> None:
    arms = Message(joint_names=['a', 'b'], twist=[Message(x=1.0)], name=['?'])
    with pytest.raises(FieldError, match=r"1 values for 2 in the list 'joint_names'"):
        FieldPath.parse('twist[joint_names=a].x').read(arms)
    assert FieldPath.parse('twist[0].x').read(arms) == 1.0
    # a list that is not given, and one that does not belong to the names
    assert FieldPath.parse('velocity[1]').read(Message(name=[], velocity=[1.0, 2.0])) == 2.0
    assert FieldPath.parse('data[1]').read(Message(name=['a'], data=[1.0, 2.0])) == 2.0
    assert FieldPath.parse('velocity[0].x[2]').read(Message(
        name=['a'], velocity=[Message(x=[1.0, 2.0, 3.0])])) == 3.0


def test_a_name_that_is_there_twice_is_unreadable() -> None:
    twice = Message(name=['left', 'right', 'left'], velocity=[1.0, 2.0, 3.0])
    with pytest.raises(FieldError, match="'left' is 2 times in the list 'name'"):
        FieldPath.parse('velocity[name=left]').read(twice)
    assert FieldPath.parse('velocity[name=right]').read(twice) == 2.0


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
