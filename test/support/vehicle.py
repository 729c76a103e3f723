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

"""A vehicle for node tests: real publishers and subscribers around a real node, no launch."""

import os

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')

from collections.abc import Callable  # noqa: E402, I100
import math  # noqa: E402
from time import monotonic  # noqa: E402
from typing import Any  # noqa: E402

import pytest  # noqa: E402

pytest.importorskip('rclpy', reason='needs rclpy')

import rclpy  # noqa: E402, I100
from rclpy.context import Context  # noqa: E402
from rclpy.duration import Duration  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.time import Time  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState, Temperature  # noqa: E402
from squeal_ros.node.executor import ResilientExecutor  # noqa: E402
from std_msgs.msg import Float64  # noqa: E402
from support.node_outputs import NodeOutputs, SECOND  # noqa: E402

TIMEOUT = 200.0  # s of the machine's time: only what hangs takes so long
BEGIN = 1000 * SECOND  # where simulated time begins
STEP = SECOND // 20  # longest step of it
# of simulated time, by when a condition must hold; on a slow machine things outside it may last
LONGEST, LEAST = 100 * SECOND, 150.0
_GREETING = 0.5  # s
_SPIN = 0.002  # s; always the same: another one makes rclpy begin again with its first entity


class Vehicle(NodeOutputs):
    """
    One brake's signals, the node under test, and what the node last said.

    Simulated time goes on only when the node has taken what was published and has spoken at each
    tick, so no test depends on the machine's speed. Without a `monitor` the node under test is
    another process, which takes what it is sent on the system's clock (`simulated` is None) or,
    once `simulated` is set, with diagnostics at each tick.
    """

    def __init__(self, context: Context, monitor: Any, brake: str, namespace: str = '', *,
                 simulated: bool = False, rate: float = 20.0) -> None:
        self.context, self.monitor = context, monitor
        self._namespace, self._rate = namespace, rate
        node = rclpy.create_node('vehicle', context=context, namespace=namespace,
                                 parameter_overrides=parameters(use_sim_time=simulated))
        self.executor = ResilientExecutor(
            context=context, report=monitor.report if monitor else self._fail)
        if monitor:
            self.executor.add_node(monitor)
        self.executor.add_node(node)
        self.rotor_speed, self.pressure, self.friction = 20.0, 7.84e5, 0.42
        self.temperature = math.nan
        self.silent: set[str] = set()
        # time of /clock and of all stamps [ns]
        self.simulated: int | None = BEGIN if simulated else None
        self.behind = 0  # of stamps [ns]
        self._begun = False
        self._heard = False  # all that a node in another process says at a tick
        self._clock = node.create_publisher(Clock, '/clock', 10)
        self._clients: dict[str, Any] = {}
        self._publishers = {
            'rotor_speed': node.create_publisher(JointState, 'joint_states', 10),
            'pressure': node.create_publisher(
                FluidPressure, f'{brake}/brake_pressure', 10),
            'friction': node.create_publisher(Float64, f'{brake}/friction', 10),
            'temperature': node.create_publisher(
                Temperature, f'{brake}/rotor_temperature', 10)}
        super().__init__(node, brake, namespace)

    @staticmethod
    def _fail(error: Exception) -> None:
        raise error

    @property
    def now(self) -> Any:
        """Return the present time, for a stamp."""
        if self.simulated is None:
            return self.node.get_clock().now().to_msg()
        return Time(nanoseconds=self.simulated).to_msg()

    def publish(self) -> None:
        """Publish all signals that are not silent, stamped now."""
        joints, pressure, heat = JointState(), FluidPressure(), Temperature()
        for message in (joints, pressure, heat):
            message.header.stamp = (Time.from_msg(self.now)
                                    - Duration(nanoseconds=self.behind)).to_msg()
        joints.name = ['spare', f'{self.brake}_wheel_joint']
        joints.velocity = [math.nan, self.rotor_speed]
        pressure.fluid_pressure, heat.temperature = self.pressure, self.temperature
        messages = {'rotor_speed': joints, 'pressure': pressure,
                    'friction': Float64(data=self.friction), 'temperature': heat}
        for name, message in messages.items():
            if name not in self.silent:
                self._publishers[name].publish(message)

    # -- time

    def set_time(self, time: int) -> None:
        """Let simulated time be another [ns]; return when the node has spoken at every tick."""
        before, self.simulated = self.simulated or 0, time
        self._begun = True
        self._fresh.clear()
        begin = again = monotonic()
        while not (self._told() and self._answered(before)):
            if not (self.monitor or self._heard) and monotonic() > begin + _GREETING:
                return  # a node in another process may not know of the listeners yet
            assert monotonic() < begin + TIMEOUT, f'no answer at {time} ns; said: {self.said}'
            if monotonic() >= again:  # best effort: what gets lost under way is sent again
                self._clock.publish(Clock(clock=self.now))
                again = monotonic() + 1.0
            self.executor.spin_once(timeout_sec=_SPIN)
        self.hear()

    def _told(self) -> bool:
        """Whether the vehicle's own node knows the present time."""
        clock = self.node.get_clock()
        return not clock.ros_time_is_active or clock.now().nanoseconds == self.simulated

    def _answered(self, before: int) -> bool:
        """Whether the node was told of the present time, and has spoken at each tick up to it."""
        assert self.simulated is not None
        if self.monitor:
            ticker = self.monitor._ticker
            return (self.monitor.get_clock().now().nanoseconds == self.simulated
                    and (ticker._timer is None or not ticker._grid.due(self.simulated)))
        tick = int(self.simulated * self._rate / SECOND)
        if tick == int(before * self._rate / SECOND):
            return True
        whole = len(self._fresh) == len(self._listeners)
        self._heard = self._heard or whole
        return whole and self.stamp * self._rate >= tick * SECOND

    def meet(self) -> None:
        """
        Wait until the node's topics and this vehicle's are connected, and begin to tell time.

        What was published before would be lost.
        """
        inputs = {p.topic_name: p for p in (*self._publishers.values(), self._clock)}
        if self.monitor:
            taken = {topic.topic_name for topic in self.monitor.subscriptions}
            outputs = {topic.topic_name: topic for topic in self.monitor.publishers}
        else:
            taken = set(inputs) - {self._publishers['temperature'].topic_name}
            outputs = {}
        for topic in taken & set(inputs):
            if self.monitor:
                self.connected(inputs[topic])
            else:
                self.wait(inputs[topic].get_subscription_count, f'subscriber of {topic}')
        for topic, listener in self._listeners.items():
            if not self.monitor or topic in outputs:
                self.wait(listener.get_publisher_count, f'publisher of {topic}')
            if topic in outputs:
                self.wait(outputs[topic].get_subscription_count, f'subscriber of {topic}')
        if self.simulated is not None and not self._begun:
            self.set_time(self.simulated)

    def connected(self, publisher: Any, count: int = 0) -> None:
        """Wait until a publisher and the node know of each other; of so many (0: of any)."""
        topic = publisher.topic_name
        self.wait(publisher.get_subscription_count, f'subscriber of {topic}')
        # what is published before the node's side knows of it is lost
        self.wait(lambda: all(count in (known := s.get_publisher_count(), 0) and known
                              for s in self.monitor.subscriptions if s.topic_name == topic),
                  f'publisher of {topic}')

    def step(self, longest: int = STEP) -> None:
        """Publish all signals and let time go on, to the node's next tick at most."""
        self.meet()
        self.publish()
        assert self.simulated is not None
        period = self.monitor.settings.period if self.monitor else round(SECOND / self._rate)
        self.set_time(min((self.simulated // period + 1) * period, self.simulated + longest))

    def advance(self, seconds: float, step: float = STEP / SECOND) -> None:
        """Let simulated time go on by so much, with all signals in equal steps."""
        for _ in range(round(seconds / step)):
            self.meet()
            self.publish()
            assert self.simulated is not None
            self.set_time(self.simulated + round(step * SECOND))

    def until(self, condition: Callable[[], Any], what: str = 'condition') -> None:
        """Publish and let time go on until a condition holds."""
        if self.simulated is None:
            self._until_on_the_systems_clock(condition, what)
            return
        end, last = monotonic() + LEAST, self.simulated + LONGEST
        while not condition():
            assert self.simulated < last or monotonic() < end, (
                f'{what} did not come true; said: {self.said}')
            self.step()

    def _until_on_the_systems_clock(self, condition: Callable[[], Any], what: str) -> None:
        end = monotonic() + TIMEOUT
        while not condition():
            assert monotonic() < end, f'{what} did not come true; said: {self.said}'
            self.publish()
            self.spin(0.02)
        self.spin(0.02)  # what else the node said at that tick

    def wait(self, condition: Callable[[], Any], what: str = 'condition') -> None:
        """Wait for something that needs no signals; simulated time stands still."""
        end = monotonic() + TIMEOUT
        while not condition():
            assert monotonic() < end, f'{what} did not come true; said: {self.said}'
            self.executor.spin_once(timeout_sec=_SPIN)

    def spin(self, seconds: float) -> None:
        """Serve the node for some of the machine's time: only to leave others time, too."""
        end = monotonic() + seconds
        while monotonic() < end:
            self.executor.spin_once(timeout_sec=_SPIN)

    # -- services

    def ask(self, kind: Any, name: str, request: Any) -> Any:
        """
        Call a service of the monitor, and return its response.

        Of a node in another process only what may be asked twice: a first response can be lost.
        """
        if name not in self._clients:
            self._clients[name] = client = self.node.create_client(
                kind, f'{self._namespace}/squeal_monitor/{name}')
            self.wait(client.service_is_ready, f'service {name}')
            if self.monitor:  # ready is known of the request's way only
                self.wait(lambda: self.monitor.count_clients(client.service_name),
                          f'client of {name}')
        end = monotonic() + TIMEOUT
        while monotonic() < end:
            future = self._clients[name].call_async(request)
            again = end if self.monitor else monotonic() + 5.0
            while not future.done() and monotonic() < again:
                self.executor.spin_once(timeout_sec=_SPIN)
            if future.done():
                return future.result()
        raise AssertionError(f'no answer of {name} to {request}')


def parameters(**values: Any) -> list[Parameter]:
    """Return parameters; dots in names are written as two underscores."""
    return [Parameter(name.replace('__', '.'), value=value) for name, value in values.items()]
