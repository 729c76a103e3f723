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

"""Field paths: what they are, what they read of a message, and what they refuse."""

import re
from types import SimpleNamespace as Message
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.common.errors import ConfigurationError
from squeal_ros.node.field_paths import FieldError, FieldPath

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
