"""A vehicle for node tests: real publishers and subscribers around a real node, no launch."""

import os

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')

from collections.abc import Callable, Iterator  # noqa: E402
from contextlib import contextmanager  # noqa: E402
import gc  # noqa: E402
import math  # noqa: E402
import time  # noqa: E402
from typing import Any  # noqa: E402

import pytest  # noqa: E402

pytest.importorskip('rclpy', reason='needs rclpy')

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402
from domains import free_domain  # noqa: E402
import rclpy  # noqa: E402
from rclpy.context import Context  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from rclpy.time import Time  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState, Temperature  # noqa: E402
from std_msgs.msg import Float64, Float64MultiArray  # noqa: E402

from squeal_ros.guards import SturdyExecutor  # noqa: E402
from squeal_ros.node import SquealMonitor  # noqa: E402

TIMEOUT = 60.0  # s: of a test that fails; a machine that others use took twenty
# settings for a test of something else than age: a busy machine may pause for half a second
PATIENT = {f'fl__{name}__max_age': 60.0 for name in ('rotor_speed', 'pressure', 'friction')}
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Vehicle:
    """One brake's signals, the node under test, and what the node last said.

    Without a `monitor` the node under test is another process.
    """

    def __init__(self, context: Context, monitor: Any, brake: str, namespace: str = '') -> None:
        self.context, self.monitor, self.brake = context, monitor, brake
        self._namespace = namespace
        self.node = rclpy.create_node('vehicle', context=context, namespace=namespace)
        self.executor = SturdyExecutor(
            context=context, report=monitor.report if monitor else self._fail)
        if monitor:
            self.executor.add_node(monitor)
        self.executor.add_node(self.node)
        self.rotor_speed, self.pressure, self.friction = 20.0, 7.84e5, 0.42
        self.temperature = math.nan
        self.silent: set[str] = set()
        self.simulated: int | None = None  # time of /clock and of all stamps [ns]
        self._clock = self.node.create_publisher(Clock, '/clock', 10)
        self.said: dict[str, Any] = {}
        self.count = 0
        self._clients: dict[str, Any] = {}
        self._publishers = {
            'rotor_speed': self.node.create_publisher(JointState, 'joint_states', 10),
            'pressure': self.node.create_publisher(
                FluidPressure, f'{brake}/brake_pressure', 10),
            'friction': self.node.create_publisher(Float64, f'{brake}/friction', 10),
            'temperature': self.node.create_publisher(
                Temperature, f'{brake}/rotor_temperature', 10)}
        outputs = f'{namespace}/squeal_monitor/{brake}'
        for name in ('squeal_risk', 'growth_rate', 'friction_margin'):
            self._listen(Float64, f'{outputs}/{name}', name)
        self._listen(Float64MultiArray, f'{outputs}/unstable_frequencies', 'unstable', LATCHED)
        self._listen(DiagnosticArray, '/diagnostics', 'diagnostics')

    def _listen(self, kind: Any, topic: str, name: str, qos: Any = 10) -> None:
        def hear(message: Any) -> None:
            self.said[name] = message
            self.count += 1

        self.node.create_subscription(kind, topic, hear, qos)

    @staticmethod
    def _fail(error: Exception) -> None:
        raise error

    def publish(self) -> None:
        """Publish all signals that are not silent, stamped now."""
        joints, pressure, heat = JointState(), FluidPressure(), Temperature()
        now = self.node.get_clock().now()
        if self.simulated is not None:
            now = Time(nanoseconds=self.simulated)
            self._clock.publish(Clock(clock=now.to_msg()))
        for message in (joints, pressure, heat):
            message.header.stamp = now.to_msg()
        joints.name = ['spare', f'{self.brake}_wheel_joint']
        joints.velocity = [math.nan, self.rotor_speed]
        pressure.fluid_pressure, heat.temperature = self.pressure, self.temperature
        messages = {'rotor_speed': joints, 'pressure': pressure,
                    'friction': Float64(data=self.friction), 'temperature': heat}
        for name, message in messages.items():
            if name not in self.silent:
                self._publishers[name].publish(message)

    def until(self, condition: Callable[[], bool], what: str = 'condition') -> None:
        """Publish and spin until a condition holds; fail after TIMEOUT."""
        end = time.monotonic() + TIMEOUT
        while not condition():
            assert time.monotonic() < end, f'{what} did not come true; said: {self.said}'
            self.publish()
            self.spin(0.02)
        self.spin(0.02)  # what else the node said at that tick

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            # always the same timeout: another one makes rclpy begin again with its first entity
            self.executor.spin_once(timeout_sec=0.002)

    def advance(self, seconds: float, step: float = 0.02) -> None:
        """Let simulated time go on, with all signals."""
        for _ in range(round(seconds / step)):
            assert self.simulated is not None
            self.simulated += round(step * 1e9)
            self.publish()
            self.spin(0.002)

    def ask(self, kind: Any, name: str, request: Any) -> Any:
        """Call a service of the monitor, and return its response."""
        if name not in self._clients:
            self._clients[name] = client = self.node.create_client(
                kind, f'{self._namespace}/squeal_monitor/{name}')
            self.until(client.service_is_ready, f'service {name}')
            self.spin(0.3)  # ready is known of the request's way only; a response could be lost
        future = self._clients[name].call_async(request)
        end = time.monotonic() + TIMEOUT
        while not future.done():
            assert time.monotonic() < end, f'no answer of {name} to {request}'
            self.executor.spin_once(timeout_sec=1.0)
        return future.result()

    @property
    def risk(self) -> float:
        """The risk last heard; minus one before the first."""
        return float(self.said['squeal_risk'].data) if 'squeal_risk' in self.said else -1.0

    @property
    def unstable(self) -> list[float]:
        return list(self.said['unstable'].data) if 'unstable' in self.said else [-1.0]

    @property
    def status(self) -> Any:
        """This brake's diagnostic status, or None."""
        found = [s for s in getattr(self.said.get('diagnostics'), 'status', ())
                 if s.hardware_id == self.brake]
        return found[0] if found else None

    @property
    def node_status(self) -> Any:
        """The node's own diagnostic status, or None."""
        statuses = getattr(self.said.get('diagnostics'), 'status', ())
        return statuses[-1] if statuses else None

    @property
    def figures(self) -> dict[str, str]:
        """The values of the node's own status."""
        return {item.key: item.value for item in getattr(self.node_status, 'values', ())}


def parameters(**values: Any) -> list[Parameter]:
    """Return parameters; dots in names are written as two underscores."""
    return [Parameter(name.replace('__', '.'), value=value) for name, value in values.items()]


@contextmanager
def vehicle(*, brake: str = 'fl', namespace: str = '', bring_up: bool = True,
            alone: bool = False, **values: Any) -> Iterator[Vehicle]:
    """Run a node for one brake in a domain of its own, with settings that suit a test."""
    chosen = {'brakes': [brake], 'rate': 20.0, 'diagnostics_rate': 20.0, **values}
    with free_domain() as domain:
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        try:
            monitor = SquealMonitor(alone=alone, context=context, namespace=namespace,
                                    parameter_overrides=parameters(**chosen))
            car = Vehicle(context, monitor, brake, namespace)
            if bring_up:
                monitor.bring_up()
            yield car
            car.executor.shutdown()
            monitor.destroy_node()
            car.node.destroy_node()
        finally:
            context.try_shutdown()
            gc.collect()  # what the garbage holds of a node stays in the graph


@contextmanager
def outside(domain: int, *, brake: str = 'fl', namespace: str = '') -> Iterator[Vehicle]:
    """Give signals to a node of another process in a domain, and hear what it says."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    try:
        car = Vehicle(context, None, brake, namespace)
        yield car
        car.executor.shutdown()
        car.node.destroy_node()
    finally:
        context.try_shutdown()
        gc.collect()
