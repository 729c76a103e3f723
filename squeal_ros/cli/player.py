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

"""Playback of brake signals as a vehicle would publish them, and the monitor's answers."""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

from collections.abc import Callable, Iterator  # noqa: I100
from contextlib import contextmanager
from dataclasses import dataclass
import math
import os
import time
from types import TracebackType
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState, Temperature
from std_msgs.msg import Float64, Header

from squeal_core.monitor.inputs.reading import BELIEVED  # noqa: I100
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.settings import NODE_NAME
from squeal_core.vehicle.vehicle_model import BrakeSignals
from squeal_ros.cli.drive_signals import ORIGIN

ZERO_CELSIUS = 273.15
_LONGEST_WAIT = 5.0  # s, for an answer of the monitor
# columns of the table that a brake's diagnostics have by the same names
NUMBERS = ('squeal_risk', 'instability_probability', 'build_up_nepers', 'time_to_squeal_s',
           'growth_rate_1_s', 'damping_ratio', 'worst_frequency_hz', 'friction_margin')
Record = Callable[[str, str, int, bytes], None]


@dataclass(frozen=True)
class Progress:
    """Latest state of the monitor: one row a brake, and its ticks done and lost."""

    rows: tuple[AssessmentRecord, ...]
    ticks_done: int
    ticks_lost: int


class BrakePlayer:
    """
    Publishes the signals of four wheels and collects the diagnostics of a monitor.

    A context manager, with a ROS context of its own.

    Parameters
    ----------
    signals : BrakeSignals
    namespace : str
        Of the topics, and of the monitor that is heard; others are not.
    domain : int, optional
        ROS domain, in which only this machine is then heard; by default the one that
        ROS_DOMAIN_ID gives.

    """

    def __init__(self, signals: BrakeSignals, *, namespace: str = '',
                 domain: int | None = None) -> None:
        self._signals = signals
        self._heard_names = f'{namespace.strip("/")}/{NODE_NAME}: '.lstrip('/')
        self._context = Context()
        with _discovery(None if domain is None else 'LOCALHOST'):
            rclpy.init(context=self._context, domain_id=domain)
        self._node: Node = rclpy.create_node(
            'brake_player', context=self._context, namespace=namespace)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._publishers: dict[str, Any] = {}
        self._heard: list[Progress] = []
        self._rows: dict[str, AssessmentRecord] = {}  # the newest of each brake
        self._answered: int | None = None  # time of the monitor's last answer [ns]
        self._add('joint_states', JointState)
        for brake in signals.brakes:
            self._add(f'{brake}/brake_pressure', FluidPressure)
            self._add(f'{brake}/friction', Float64)
            self._add(f'{brake}/rotor_temperature', Temperature)
        self._clock = self._node.create_publisher(Clock, '/clock', 10)
        self._node.create_subscription(DiagnosticArray, '/diagnostics', self._hear, 100)

    def __enter__(self) -> 'BrakePlayer':
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def wait_for_listener(self, seconds: float, *,
                          still_alive: Callable[[], bool] = lambda: True) -> bool:
        """Return whether somebody subscribed to rotor speeds and to all pressures in time."""
        needed = [p for name, p in self._publishers.items()
                  if name == 'joint_states' or name.endswith('brake_pressure')]
        end = time.monotonic() + seconds
        while not all(p.get_subscription_count() for p in needed):
            if time.monotonic() > end or not still_alive():
                return False
            self._executor.spin_once(timeout_sec=0.05)
        return True

    def play(self, *, speed_up: float = 1.0, simulated: bool = True, lag: float = math.inf,
             record: Record = lambda *_: None) -> Iterator[list[Progress]]:
        """
        Publish all signals in step with time; yield after each the monitor's answers since.

        What the player is late by, be it kept by the machine or by its caller, it does not make
        up for: a burst of times would be a jump of the clock to the monitor.

        Parameters
        ----------
        speed_up : float
            Seconds of the drive in one second.
        simulated : bool
            Publish /clock and stamp with the drive's time; otherwise stamp with the system's.
        lag : float
            Time waits for a monitor whose last answer is older than this [s], for some seconds at
            most: a slow or busy machine then loses no tick.
        record : callable
            Given topic, type, time [ns] and CDR bytes of each message.

        """
        step_time = self._signals.time[1] - self._signals.time[0]
        start, now = time.monotonic() + step_time / speed_up, 0
        for step, seconds in enumerate(self._signals.time):
            # half a step ahead of the clock, so that they are there when it reaches their stamps
            yield self._until(start + (seconds - 0.5 * step_time) / speed_up)
            if step:  # what an answer depends on is out, and nothing that is later
                self._await_answer(now - lag * 1e9)
            now = ORIGIN + round(seconds * 1e9) if simulated else time.time_ns()
            for topic, message in self._messages(step, now):
                self._publishers[topic].publish(message)
                record(f'/{topic}', _type_name(message), now, serialize_message(message))
            if simulated:
                yield self._until(start + seconds / speed_up)
                self._clock.publish(Clock(clock=_time(now)))
            start = max(start, time.monotonic() - (seconds + 0.5 * step_time) / speed_up)
        yield self._until(time.monotonic() + 0.5)

    def _await_answer(self, since: float) -> None:
        """Wait for an answer of the monitor at or after a time [ns], once it has answered."""
        end = time.monotonic() + _LONGEST_WAIT
        while self._answered is not None and self._answered < since:
            if time.monotonic() > end:
                return
            self._executor.spin_once(timeout_sec=0.05)

    def _until(self, deadline: float) -> list[Progress]:
        rest = 1.0
        while rest > 0.0:
            rest = deadline - time.monotonic()
            self._executor.spin_once(timeout_sec=max(0.0, rest))
        heard, self._heard = self._heard, []
        return heard

    def _messages(self, step: int, now: int) -> Iterator[tuple[str, Any]]:
        s = self._signals
        header = Header(stamp=_time(now))
        yield 'joint_states', JointState(
            header=header, name=[f'{brake}_wheel_joint' for brake in s.brakes],
            velocity=s.rotor_speed[step].tolist())
        for i, brake in enumerate(s.brakes):
            yield f'{brake}/brake_pressure', FluidPressure(
                header=header, fluid_pressure=float(s.pressure[step, i]))
            yield f'{brake}/friction', Float64(data=float(s.friction[step, i]))
            yield f'{brake}/rotor_temperature', Temperature(
                header=header, temperature=float(s.temperature[step, i]) - ZERO_CELSIUS)

    def _add(self, topic: str, kind: Any) -> None:
        self._publishers[topic] = self._node.create_publisher(kind, topic, 10)

    def _hear(self, message: Any) -> None:
        seconds = (message.header.stamp.sec * 10**9 + message.header.stamp.nanosec) * 1e-9
        node: dict[str, str] = {}
        for status in message.status:
            if not status.name.startswith(self._heard_names):
                continue  # another monitor's
            values = {item.key: item.value for item in status.values}
            if 'ticks_done' in values:
                node = values
            elif 'squeal_risk' in values:
                self._rows[status.hardware_id] = _row(
                    seconds, status.hardware_id, status.message, values)
        if node:
            self._answered = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            rows, self._rows = tuple(self._rows.values()), {}  # brakes may come in other messages
            self._heard.append(Progress(
                rows, int(node['ticks_done']), int(node['ticks_lost'])))


@contextmanager
def _discovery(reach: str | None) -> Iterator[None]:
    """Set how far participants look for each other; it is read as a context begins."""
    name, before = 'ROS_AUTOMATIC_DISCOVERY_RANGE', os.environ.copy()
    if reach is not None:
        os.environ[name] = reach
    try:
        yield
    finally:
        os.environ.pop(name, None)
        os.environ.update({name: before[name]} if name in before else {})


def _row(seconds: float, brake: str, reason: str, values: dict[str, str]) -> AssessmentRecord:
    return AssessmentRecord(
        time_s=seconds, brake=brake, state=values['state'],
        rotor_speed_rad_s=float(values['rotor_speed_input']),
        pressure_pa=float(values['pressure_input']), friction=float(values['friction']),
        **{name: float(values[name]) for name in NUMBERS},
        unstable_frequencies_hz=tuple(map(float, values['unstable_frequencies_hz'].split())),
        unstable_growth_rates_1_s=tuple(map(float, values['unstable_growth_rates_1_s'].split())),
        reason=reason, risk_error=float(values.get('risk_error', 'nan')),
        temperature_k=float(values['temperature_input']) if values.get(
            'temperature_status') in BELIEVED else math.nan,
        incomplete=values.get('risk_incomplete') == 'True',
        worst_mode_number=int(values.get('worst_mode_number', 0)),
        mode_numbers=tuple(map(int, values.get('unstable_mode_numbers', '').split())))


def _time(nanoseconds: int) -> Time:
    return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)


def _type_name(message: Any) -> str:
    package = type(message).__module__.partition('.')[0]
    return f'{package}/msg/{type(message).__name__}'
