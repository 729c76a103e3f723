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

"""The node as `ros2 param` and `ros2 lifecycle` see it: their requests, over its services."""

from collections.abc import Iterator
import math
from pathlib import Path
from typing import Any

import pytest
import yaml

pytest.importorskip('rclpy', reason='needs rclpy')

from lifecycle_msgs.msg import Transition  # noqa: E402, I100
from lifecycle_msgs.srv import (  # noqa: E402
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from rcl_interfaces.srv import (  # noqa: E402
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter, parameter_value_to_python  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from support import processes  # noqa: E402
from support.domains import free_domain  # noqa: E402, I100
from support.node_runs import outside, vehicle  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

TYPES = Parameter.Type
# a value of each type that a parameter may have
EACH = {TYPES.BOOL: False, TYPES.INTEGER: 7, TYPES.DOUBLE: 7.0, TYPES.STRING: 'seven',
        TYPES.BYTE_ARRAY: [b'\x07'], TYPES.BOOL_ARRAY: [True], TYPES.INTEGER_ARRAY: [7],
        TYPES.DOUBLE_ARRAY: [math.nan], TYPES.STRING_ARRAY: ['seven'], TYPES.NOT_SET: None}


@pytest.fixture(scope='module')
def car() -> Iterator[Vehicle]:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        yield car


def names(car: Vehicle, **request: Any) -> list[str]:
    answer = car.ask(ListParameters, 'list_parameters', ListParameters.Request(**request))
    return list(answer.result.names)


def values(car: Vehicle, *wanted: str) -> list[Any]:
    answer = car.ask(GetParameters, 'get_parameters', GetParameters.Request(names=wanted))
    return [parameter_value_to_python(value) for value in answer.values]


def put(car: Vehicle, *parameters: Parameter, together: bool = False) -> list[Any]:
    """Set one by one, or together; return the results."""
    messages = [parameter.to_parameter_msg() for parameter in parameters]
    if together:
        return [car.ask(SetParametersAtomically, 'set_parameters_atomically',
                        SetParametersAtomically.Request(parameters=messages)).result]
    return list(car.ask(SetParameters, 'set_parameters',
                        SetParameters.Request(parameters=messages)).results)


def lives(car: Vehicle) -> None:
    car.said.clear()
    car.until(lambda: car.risk > 0.99, 'risk near one')


# -- ros2 param

def test_parameters_are_listed_described_and_read(car: Vehicle) -> None:
    found = names(car)
    assert {'rate', 'fl.pressure.topic'} <= set(found)
    assert all(name.startswith('fl.pressure.') for name in names(car, prefixes=['fl.pressure']))
    assert all('.' not in name for name in names(car, depth=1))
    assert names(car, prefixes=['nobody']) == []
    described = car.ask(DescribeParameters, 'describe_parameters',
                        DescribeParameters.Request(names=found)).descriptors
    types = car.ask(GetParameterTypes, 'get_parameter_types',
                    GetParameterTypes.Request(names=found)).types
    assert [d.name for d in described] == found
    assert [d.type for d in described] == list(types)
    assert len(values(car, *found)) == len(found)


@pytest.mark.parametrize('wanted', [['nobody'], ['rate', 'nobody'], [''], []])
def test_what_is_no_parameter_is_asked_for(car: Vehicle, wanted: list[str]) -> None:
    for kind, name in ((DescribeParameters, 'describe_parameters'),
                       (GetParameters, 'get_parameters'),
                       (GetParameterTypes, 'get_parameter_types')):
        car.ask(kind, name, kind.Request(names=wanted))  # an answer is all there is to it
    lives(car)


@pytest.mark.parametrize('name', [
    'rate', 'fl.pressure.scale', 'model', 'mode_shapes', 'brakes', 'mode_shape_frame',
    'use_sim_time', 'start_type_description_service',
    'qos_overrides./fl/friction.subscription.depth'])
def test_values_of_every_other_type(car: Vehicle, name: str) -> None:
    before, = values(car, name)
    own = car.monitor.get_parameter(name).type_
    fair = {own, TYPES.INTEGER} if own == TYPES.DOUBLE else {own}
    wrong = [Parameter(name, kind, value) for kind, value in EACH.items() if kind not in fair]
    for result in put(car, *wrong):
        assert not result.successful
        assert result.reason
    assert values(car, name) == [before]
    lives(car)


def test_what_is_no_parameter_is_refused_by_name(car: Vehicle) -> None:
    rate = Parameter('rate', value=30.0)
    before = values(car, 'rate')
    for name in ('nobody', 'fl.nobody', 'é'):
        results = put(car, Parameter(name, value=1.0))
        results += put(car, rate, Parameter(name, value=1.0), together=True)
        for result in results:
            assert not result.successful
            assert repr(name) in result.reason
    assert values(car, 'rate') == before


def test_together_is_all_or_nothing(car: Vehicle) -> None:
    before = values(car, 'rate', 'risk_warning')
    rate = Parameter('rate', value=30.0)
    for bad in (Parameter('risk_warning', value=math.nan), Parameter('risk_warning', value='x'),
                Parameter('fl.pressure.scale', value=math.nan),
                Parameter('model', value='another'), Parameter('brakes', value=['fr'])):
        (result,) = put(car, rate, bad, together=True)
        assert not result.successful
        assert result.reason
        assert values(car, 'rate', 'risk_warning') == before
    (result,) = put(car, rate, Parameter('risk_warning', value=0.25), together=True)
    assert result.successful
    assert values(car, 'rate', 'risk_warning') == [30.0, 0.25]
    put(car, *(Parameter(n, value=v) for n, v in zip(('rate', 'risk_warning'), before,
                                                     strict=True)))
    lives(car)


def test_a_dump_starts_the_same_node(car: Vehicle, tmp_path: Path) -> None:
    """`ros2 param dump` to a file, and a node started with it."""
    found = names(car)
    before = dict(zip(found, values(car, *found), strict=True))
    tree: dict[str, Any] = {}
    for name, value in before.items():
        *path, last = name.split('.')
        at = tree
        for part in path:
            at = at.setdefault(part, {})
        at[last] = value
    dump = tmp_path / 'dump.yaml'
    dump.write_text(yaml.safe_dump({'/squeal_monitor': {'ros__parameters': tree}}))
    with free_domain() as domain:
        command = ['-m', 'squeal_ros.node', '--ros-args', '--params-file', str(dump)]
        with processes.process(command, processes.environment(domain)), outside(
                domain, simulated=True) as other:
            other.until(lambda: other.risk > 0.99)
            assert dict(zip(found, values(other, *found), strict=True)) == before


# -- ros2 lifecycle

def test_transitions_offered_are_those_that_work() -> None:
    offered = {'unconfigured': {'configure', 'shutdown'},
               'inactive': {'cleanup', 'activate', 'shutdown'},
               'active': {'deactivate', 'shutdown'}}
    with vehicle(autostart=False) as car:
        for label, leads in (('configure', 'inactive'), ('activate', 'active'),
                             ('deactivate', 'inactive'), ('cleanup', 'unconfigured')):
            now = car.ask(GetState, 'get_state', GetState.Request()).current_state.label
            answer = car.ask(GetAvailableTransitions, 'get_available_transitions',
                             GetAvailableTransitions.Request())
            found = {t.transition.label: t.transition for t in answer.available_transitions}
            assert set(found) == offered[now]
            request = ChangeState.Request(transition=found[label])  # with number and label
            assert car.ask(ChangeState, 'change_state', request).success
            assert car.ask(GetState, 'get_state', GetState.Request()).current_state.label == leads


@pytest.mark.parametrize(('number', 'label'), [
    (0, ''), (0, 'nobody'), (77, ''), (255, ''), (1, ''), (3, 'nobody'), (255, 'configure'),
    (0, 'é\n'), (0, 'x' * 70_000)])
def test_what_is_no_transition_is_refused(car: Vehicle, number: int, label: str) -> None:
    request = ChangeState.Request(transition=Transition(id=number, label=label))
    assert not car.ask(ChangeState, 'change_state', request).success
    assert car.ask(GetState, 'get_state', GetState.Request()).current_state.label == 'active'
    graph = car.ask(GetAvailableTransitions, 'get_transition_graph',
                    GetAvailableTransitions.Request())
    states = car.ask(GetAvailableStates, 'get_available_states', GetAvailableStates.Request())
    assert len(graph.available_transitions) > len(states.available_states) > 4
    lives(car)


# -- ros2 topic pub

JOINT = 'velocity[name=fl_wheel_joint]'


@pytest.mark.parametrize(('message', 'cause'), [
    (JointState(), f"{JOINT}: no 'fl_wheel_joint' in the list 'name'"),
    (JointState(velocity=[20.0]), f"{JOINT}: no 'fl_wheel_joint' in the list 'name'"),
    (JointState(name=['fr_wheel_joint'], velocity=[20.0]),
     f"{JOINT}: no 'fl_wheel_joint' in the list 'name'"),
    (JointState(name=['fl_wheel_joint']), f'{JOINT}: the list is empty'),
    (JointState(name=['a', 'fl_wheel_joint'], velocity=[20.0]),
     f"{JOINT}: 1 values for 2 in the list 'name'"),
    (JointState(name=['fl_wheel_joint'], velocity=[math.nan]), 'nan rad/s, outside its range')],
    ids=['empty', 'no names', 'another joint', 'no values', 'too few', 'NaN'])
def test_joint_states_without_the_speed(car: Vehicle, message: Any, cause: str) -> None:
    lives(car)
    car.silent = {'rotor_speed'}

    def named() -> bool:
        message.header.stamp = car.now
        car._publishers['rotor_speed'].publish(message)
        return math.isnan(car.risk) and cause in car.status.message

    try:
        car.until(named, cause)
        assert car.status.message.startswith('rotor_speed is ')
    finally:
        car.silent = set()
    lives(car)


def test_joints_in_another_order_each_time(car: Vehicle) -> None:
    order = ['fl_wheel_joint', 'fr_wheel_joint', 'é', '']
    speeds = {'fl_wheel_joint': 20.0, 'fr_wheel_joint': math.nan, 'é': math.inf, '': -1e300}
    car.silent = {'rotor_speed'}
    try:
        for turn in range(20):
            joints = order[turn % 4:] + order[:turn % 4]
            message = JointState(name=joints, velocity=[speeds[joint] for joint in joints])
            message.header.stamp = car.now
            car._publishers['rotor_speed'].publish(message)
            car.step()
            assert car.risk > 0.99
    finally:
        car.silent = set()
