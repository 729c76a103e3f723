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

"""Nodes that run for one test, each in a domain of its own, with a vehicle around it."""

import os

os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
os.environ.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')

from collections.abc import Iterator  # noqa: E402, I100
from contextlib import contextmanager  # noqa: E402
import gc  # noqa: E402
from typing import Any  # noqa: E402

import pytest  # noqa: E402

pytest.importorskip('rclpy', reason='needs rclpy')

import rclpy  # noqa: E402, I100
from rclpy.context import Context  # noqa: E402
from squeal_ros.node.lifecycle_node import SquealMonitor  # noqa: E402
from squeal_ros.node.message_types import RosMessages  # noqa: E402
from squeal_ros.node.publishers import why_no_state  # noqa: E402
from support.brake_monitors import EAGER  # noqa: E402
from support.domains import free_domain  # noqa: E402
from support.vehicle import parameters, Vehicle  # noqa: E402

# settings for a test that runs on the system's clock: a busy machine may pause for long
PATIENT = {f'fl__{name}__max_age': 600.0 for name in ('rotor_speed', 'pressure', 'friction')}
NO_STATE = why_no_state(RosMessages())  # why there is no topic `state` here, if so
needs_squeal_msgs = pytest.mark.skipif(bool(NO_STATE), reason=NO_STATE)


@contextmanager
def vehicle(*, brake: str = 'fl', namespace: str = '', bring_up: bool = True,
            alone: bool = False, **values: Any) -> Iterator[Vehicle]:
    """
    Run a node for one brake in a domain of its own, with settings that suit a test.

    Time is simulated and stands still while the node is waited for: no clock has stopped. With
    `use_sim_time=False` it is the system's, and `PATIENT` what keeps samples of a busy machine.
    """
    chosen = {**EAGER, 'brakes': [brake], 'rate': 20.0, 'diagnostics_rate': 20.0,
              'use_sim_time': True, 'clock_timeout': 600.0, **values}
    with free_domain() as domain:
        context = Context()
        rclpy.init(context=context, domain_id=domain)
        try:
            monitor = SquealMonitor(alone=alone, context=context, namespace=namespace,
                                    parameter_overrides=parameters(**chosen))
            car = Vehicle(context, monitor, brake, namespace,
                          simulated=bool(chosen['use_sim_time']))
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
def outside(domain: int, *, brake: str = 'fl', namespace: str = '', simulated: bool = False,
            rate: float = 20.0) -> Iterator[Vehicle]:
    """Give signals to a node of another process in a domain, and hear what it says."""
    context = Context()
    rclpy.init(context=context, domain_id=domain)
    try:
        car = Vehicle(context, None, brake, namespace, simulated=simulated, rate=rate)
        yield car
        car.executor.shutdown()
        car.node.destroy_node()
    finally:
        context.try_shutdown()
        gc.collect()


@contextmanager
def stranger(car: Vehicle) -> Iterator[Any]:
    """Yield a node of another process, as far as the middleware can tell."""
    context = Context()
    rclpy.init(context=context, domain_id=car.context.get_domain_id())
    node = rclpy.create_node('stranger', context=context)
    try:
        yield node
        node.destroy_node()
    finally:
        context.try_shutdown()
