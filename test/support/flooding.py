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

"""
A process that floods topics: `flooding.py '[["topic", "kind", 20.0, 500.0], ...]'`.

Each topic gets messages at its first rate [Hz], and at each of its other rates in turn. A line on
stdin begins each flood and another ends it, the last one ends the process; what was sent so far is
printed as JSON at every change.
"""

from collections.abc import Callable
import json
import select
import sys
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.serialization import serialize_message
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

_VARIANTS = 64  # messages that differ: nothing is stuck
# without stamps: the node takes the time of receipt
MESSAGES: dict[str, tuple[Any, Callable[[float], Any]]] = {
    'rotor_speed': (JointState, lambda noise: JointState(
        name=['wheel'], velocity=[20.0 + 0.05 * noise])),
    'pressure': (FluidPressure, lambda noise: FluidPressure(fluid_pressure=7.84e5 + 2e3 * noise)),
    'friction': (Float64, lambda noise: Float64(data=0.42 + 1e-3 * noise))}


class Tap:
    """One topic and how often it is published."""

    def __init__(self, node: Node, topic: str, kind: str, *rates: float) -> None:
        message_type, make = MESSAGES[kind]
        self._publisher = node.create_publisher(message_type, topic, 10)
        noise = np.random.default_rng(1).standard_normal(_VARIANTS)
        self._data = [serialize_message(make(value)) for value in noise]
        self.topic, self.rates = topic, rates
        self.sent, self.next = 0, 0.0

    def publish(self, now: float, period: float) -> None:
        """Publish once if it is time to; what the process is late by is not made up for."""
        if now < self.next:
            return
        self.next = max(self.next + period, now - period)
        self._publisher.publish(self._data[self.sent % _VARIANTS])
        self.sent += 1


def pour(taps: list[Tap], stage: int, until: Callable[[], bool]) -> None:
    """Publish on all topics at their rates of a stage until a condition holds, and say so."""
    periods = [1.0 / tap.rates[stage] for tap in taps]
    start = time.monotonic()
    while not until():
        now = time.monotonic()
        for tap, period in zip(taps, periods, strict=True):
            tap.next = min(tap.next, now + period)  # of a slower stage before
            tap.publish(now, period)
        wait = min(tap.next for tap in taps) - time.monotonic()
        if wait > 0.0:
            time.sleep(wait)
    print(json.dumps({'sent': {tap.topic: tap.sent for tap in taps},
                      'seconds': time.monotonic() - start}), flush=True)


def told() -> bool:
    """Tell whether a line came on stdin, and take it."""
    return bool(select.select([sys.stdin], [], [], 0.0)[0] and sys.stdin.readline())


def main(topics: list[Any]) -> None:
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node('flood', context=context)
    taps = [Tap(node, *topic) for topic in topics]
    for stage in range(1, len(taps[0].rates)):
        pour(taps, 0, told)
        pour(taps, stage, told)
    pour(taps, 0, told)
    context.try_shutdown()


if __name__ == '__main__':
    main(json.loads(sys.argv[1]))
