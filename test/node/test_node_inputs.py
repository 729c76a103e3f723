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

"""Inputs on real DDS: any publisher, any type, any bytes; what cannot be used is named."""

import math
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from geometry_msgs.msg import TwistStamped  # noqa: E402, I100
from rclpy.qos import (  # noqa: E402
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.serialization import serialize_message  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from squeal_ros.node import subscriptions as input_topics  # noqa: E402
from squeal_ros.node.executor import DeferredCallbackGroup  # noqa: E402
from squeal_ros.node.message_types import RosMessages  # noqa: E402
from squeal_ros.node.subscriptions import InputTopics  # noqa: E402
from std_msgs.msg import Float32, Float64, Float64MultiArray, String  # noqa: E402
from support.node_runs import stranger, vehicle  # noqa: E402

OK, WARN, ERROR, STALE = (bytes([n]) for n in range(4))


# of three settings of two values each, every pair of values
PUBLISHERS = [(ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE, 1),
              (ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL, 0),
              (ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE, 0),
              (ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.TRANSIENT_LOCAL, 1)]


def test_any_publisher_is_heard() -> None:
    with vehicle() as car:
        car.silent = {'friction'}
        for reliability, durability, depth in PUBLISHERS:
            publisher = car.node.create_publisher(Float64, 'fl/friction', QoSProfile(
                depth=depth, reliability=reliability, durability=durability,
                history=HistoryPolicy.KEEP_LAST if depth else HistoryPolicy.KEEP_ALL))

            def known(friction: Any = publisher) -> bool:
                friction.publish(Float64(data=0.42))
                return car.risk > 0.99

            car.until(known)
            car.node.destroy_publisher(publisher)
            car.advance(0.7)
            assert math.isnan(car.risk)


def test_one_message_of_a_foreign_type_feeds_all_inputs_of_two_brakes() -> None:
    fields: dict[str, Any] = {}
    for i, brake in enumerate(('fl', 'fr')):
        for j, signal in enumerate(('rotor_speed', 'pressure', 'friction')):
            fields.update({f'{brake}__{signal}__topic': '/vehicle/brakes',
                           f'{brake}__{signal}__type': 'std_msgs/Float64MultiArray',
                           f'{brake}__{signal}__field': f'data[{3 * i + j}]'})
    with vehicle(brakes=['fl', 'fr'], **fields) as car:
        publisher = car.node.create_publisher(Float64MultiArray, '/vehicle/brakes', 10)

        def state(words: str, data: list[float]) -> bool:
            publisher.publish(Float64MultiArray(data=data))
            status = getattr(car.said.get('diagnostics'), 'status', ())[:-1]
            return words in ' '.join(s.message for s in status)

        car.until(lambda: state('released', [20.0, 7.84e5, 0.42, 20.0, 0.0, 0.42])
                  and car.risk > 0.99)
        car.until(lambda: state('never received', [20.0]) or math.isnan(car.risk))
        assert int(car.figures['unreadable_messages']) > 0
        car.until(lambda: state('released', [20.0, 7.84e5, 0.42, 20.0, 0.0, 0.42])
                  and car.risk > 0.99)


def test_nested_fields_and_units() -> None:
    with vehicle(fl__rotor_speed__topic='twist', fl__rotor_speed__scale=1.0 / 0.3,
                 fl__rotor_speed__type='geometry_msgs/msg/TwistStamped',
                 fl__rotor_speed__field='twist.linear.x') as car:
        publisher = car.node.create_publisher(TwistStamped, 'twist', 10)
        message = TwistStamped()
        message.twist.linear.x = 6.0

        def known() -> bool:
            message.header.stamp = car.now
            publisher.publish(message)
            return car.risk > 0.99 and car.status is not None

        car.until(known)
        values = {item.key: item.value for item in car.status.values}
        assert float(values['rotor_speed_input']) == pytest.approx(20.0)


def test_the_time_of_receipt_for_stamps_that_cannot_be_trusted() -> None:
    receipt = {'fl__rotor_speed__stamp': 'receipt', 'fl__pressure__stamp': 'receipt'}
    for settings in (receipt, {}):
        with vehicle(**settings) as car:  # type: ignore[arg-type]
            car.behind = 600 * 10**9  # all stamps from a machine whose clock is ten minutes behind
            if settings:
                car.until(lambda: car.risk > 0.99)
            else:
                car.step()
                assert '600.' in car.status.message
                assert car.status.level == STALE
                assert math.isnan(car.risk)


def test_a_publisher_of_another_type_is_named() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        with stranger(car) as other:
            wrong = other.create_publisher(Float32, 'fl/friction', 10)

            def said() -> bool:
                wrong.publish(Float32(data=0.9))
                # a busy machine adds deadline misses
                return str(car.node_status.message).startswith(
                    'fl/friction: /stranger publishes std_msgs/msg/Float32, and '
                    'std_msgs/msg/Float64 is wanted')

            del car.said['squeal_risk']  # nothing was published while the stranger began
            car.until(lambda: car.risk > 0.99)
            car.until(said)
            assert car.node_status.level == WARN
            assert car.figures['wrong_publishers'] == '1'
            assert car.risk > 0.99  # the right one is heard
            assert car.status.level == WARN
            car.silent = {'friction'}
            car.until(lambda: math.isnan(car.risk) and 'friction is' in car.status.message)
            other.destroy_publisher(wrong)
            car.silent = set()
            car.until(lambda: car.risk > 0.99 and car.figures['wrong_publishers'] == '0')


NO_MESSAGES = [
    b'', b'\x00', b'\x00\x01\x00\x00', b'\xff' * 200,
    serialize_message(JointState(name=['fl_wheel_joint'], velocity=[20.0]))[:-20],
    serialize_message(String(data='x' * 5000))]


def test_bytes_that_are_no_message_are_counted() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        for data in NO_MESSAGES:
            before = int(car.figures['unreadable_messages'])
            for _ in range(3):
                car._publishers['rotor_speed'].publish(data)
            car.step()
            assert int(car.figures['unreadable_messages']) == before + 3
            assert 'unreadable messages' in car.node_status.message
            assert car.node_status.level == WARN
            assert car.risk > 0.99


def test_what_comes_and_what_is_dropped() -> None:
    with vehicle() as car:
        car.until(lambda: car.risk > 0.99)
        car.until(lambda: float(car.figures['fl/friction rate_hz']) > 0.0)
        before = {name: int(car.figures[f'fl/friction {name}'])
                  for name in ('received', 'dropped')}
        for _ in range(200):  # while the node does not spin: its queue holds ten
            car._publishers['friction'].publish(Float64(data=0.42))
        car.until(lambda: int(car.figures['fl/friction dropped']) > before['dropped'])
        figures = car.figures
        heard = sum(int(figures[f'fl/friction {name}']) - before[name] for name in before)
        assert heard >= 200
        assert int(figures['dropped_messages']) >= int(figures['fl/friction dropped']) > 0


def test_messages_wait_with_their_time_of_receipt_and_come_in_order() -> None:
    heard: list[tuple[str, float, int]] = []
    aside, topics = DeferredCallbackGroup(), ('one', 'other')
    with vehicle(autostart=False, use_sim_time=False) as car:
        def now() -> int:
            return int(car.node.get_clock().now().nanoseconds)

        inputs = InputTopics(
            car.node, RosMessages(), dict.fromkeys(topics, 'std_msgs/msg/Float64'), aside,
            lambda topic, message, stamp, _: heard.append((topic, message.data, stamp)),
            pytest.fail)
        publishers = [car.node.create_publisher(Float64, topic, 10) for topic in topics]
        car.wait(lambda: all(p.get_subscription_count() for p in publishers)
                 and all(s.get_publisher_count() for s in car.node.subscriptions
                         if s.topic_name in {p.topic_name for p in publishers}))
        start = now()
        for i in range(6):
            publishers[i % 2].publish(Float64(data=float(i)))
            car.spin(0.02)
        assert heard == []  # the executor leaves them alone
        inputs.take()
        assert [(topic, value) for topic, value, _ in heard] == [
            (topics[i % 2], i) for i in range(6)]
        times = [start, *(stamp for _, _, stamp in heard), now()]
        assert times == sorted(times)
        assert times[-2] - times[1] > 5e7  # not when they were taken
        publishers[0].publish(Float64(data=6.0))
        inputs.begin()  # as if it had never come
        aside.open = True
        publishers[0].publish(Float64(data=7.0))
        car.wait(lambda: len(heard) > 6)
        assert heard[6][1] == 7.0
        inputs.destroy()


@pytest.mark.parametrize(('noted', 'age'), [
    (1000 - 3, 3), (1000 - 30, 10), (1000 + 30, 0), (0, 10)])
def test_no_message_is_older_than_the_time_since_the_last_were_taken(noted: int, age: int) -> None:
    """The system's clock was set meanwhile, or the middleware gives no time."""
    moment = input_topics._Moment(now=5000, system=1000, passed=10)
    assert moment.received({'received_timestamp': noted}) == 5000 - age


def test_what_came_before_activation_does_not_count() -> None:
    with vehicle(autostart=False) as car:
        car.monitor.trigger_configure()
        car.advance(0.5)
        car.silent = set(car._publishers)
        car.monitor.trigger_activate()
        car.step()
        assert 'pressure never received' in car.status.message
        assert car.figures['dropped_messages'] == '0'


def test_a_subscriber_that_can_hear_nothing_is_named_in_the_log(
        capfd: pytest.CaptureFixture[str]) -> None:
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    said = ''
    with vehicle() as car:
        car.node.create_subscription(
            Float64, '/squeal_monitor/fl/growth_rate', lambda _: None, qos)

        def named() -> bool:
            nonlocal said
            said += capfd.readouterr().err
            return any('[squeal_monitor]' in line and 'incompatible QoS' in line
                       for line in said.splitlines())

        car.until(named)


def test_the_model_and_its_audit_are_in_the_figures() -> None:
    with vehicle() as car:
        car.step()
        assert car.figures['model'] == 'kang2009'
        assert car.figures['model_modes'] == '92'
        assert int(car.figures['audit_checks']) > 5
        for name in ('tick_time_s', 'tick_time_max_s', 'tick_time_p99_s', 'tick_lateness_p99_s'):
            assert float(car.figures[name]) >= 0.0 or math.isnan(float(car.figures[name]))
        assert car.node_status.name == 'squeal_monitor: node'


def test_two_namespaces_are_told_apart_in_diagnostics() -> None:
    with vehicle(namespace='/left') as car:
        car.step()
        assert car.status.name == 'left/squeal_monitor: fl'
