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

"""More than one publisher of an input on real DDS: named where they contradict each other."""

import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from rclpy.time import Time  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Sample  # noqa: E402
from std_msgs.msg import Header  # noqa: E402
from support.node_runs import stranger, vehicle  # noqa: E402
from support.stages import drive, Stage, stage  # noqa: E402

OK, WARN, ERROR = (bytes([level]) for level in range(3))


def header(acted: Stage) -> Header:
    return Header(stamp=Time(nanoseconds=acted.now).to_msg())


@pytest.mark.usefixtures('often')
def test_publishers_that_contradict_each_other_are_named() -> None:
    """One of another process says 0 Pa: no number while it does, and both are named."""
    with stage() as (acted, car), stranger(car) as other:
        drive(acted, 0.6)
        assert acted.risk >= 0.0
        liar, honest = other.create_publisher(FluidPressure, 'fl/brake_pressure', 10), (
            acted.publishers['pressure'])
        acted.connected(liar, 2)
        for _ in range(12):
            drive(acted, 0.1)  # 0.05 s
            acted.publishers['pressure'] = liar
            acted.send('pressure', Sample(acted.now, 0.0))
            acted.publishers['pressure'] = honest
        drive(acted, 0.1)
        assert math.isnan(acted.risk)
        assert car.status.level == ERROR
        assert 'contradicted by another publisher of the topic, which says' in car.status.message
        assert car.figures['contradicted_topics'] == '1'
        assert car.node_status.level == WARN
        assert car.node_status.message.startswith('fl/brake_pressure: 2 publishers (/stranger, '
                                                  '/vehicle) contradict each other')
        drive(acted, 0.7)  # it is silent: over within one max_age
        assert car.figures['contradicted_topics'] == '0'
        assert 'another publisher' not in car.status.message
        drive(acted, 1.5)  # nor were there leaps of late
        assert acted.risk >= 0.0, car.status.message


@pytest.mark.usefixtures('often')
@pytest.mark.parametrize('message', [
    JointState(name=['arm', 'hand'], velocity=[0.1, 0.2]), JointState(name=['fl_wheel_joint'])],
    ids=['other joints', 'positions only'])
def test_a_second_publisher_of_other_joints_is_no_fault(message: Any) -> None:
    with stage() as (acted, car), stranger(car) as other:
        arms = other.create_publisher(JointState, 'joint_states', 10)
        acted.connected(arms, 2)
        before = acted._taken('rotor_speed')
        for count in range(12):
            message.header = header(acted)
            arms.publish(message)
            acted.wait(lambda n=count: acted._taken('rotor_speed') > before + 3 * n, 'it')
            drive(acted, 0.1)  # 0.05 s
        drive(acted, 0.2)
        assert acted.risk >= 0.0
        assert car.status.level in (OK, WARN)
        for word in ('joint_states', 'unreadable', 'contradict'):  # but deadline misses, perhaps
            assert word not in car.node_status.message
        assert car.figures['unreadable_messages'] == '0'


def test_the_reference_of_the_pressures_is_said_at_start(
        capfd: pytest.CaptureFixture[str]) -> None:
    with vehicle():
        assert 'pressures are taken as gauge' in capfd.readouterr().err
    with vehicle(fl__pressure__reference='absolute') as car:
        assert 'pressures are taken as absolute' in capfd.readouterr().err
        car.pressure = 7.84e5 + 101325.0
        car.until(lambda: car.risk >= 0.0 and car.status is not None)
        values = {item.key: float(item.value) for item in car.status.values
                  if item.key == 'pressure_input'}
        assert values['pressure_input'] == pytest.approx(7.84e5)
