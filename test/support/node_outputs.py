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

"""What a node says to whoever listens: numbers, and its diagnostics by status."""

from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from diagnostic_msgs.msg import DiagnosticArray  # noqa: E402, I100
from rclpy.qos import DurabilityPolicy, QoSProfile  # noqa: E402
from squeal_ros.node.messages import NUMBERS  # noqa: E402
from std_msgs.msg import Float64, Float64MultiArray  # noqa: E402

SECOND = 1_000_000_000  # ns
EVENTS = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class NodeOutputs:
    """What the node under test last said of one brake, and of itself."""

    def __init__(self, node: Any, brake: str, namespace: str = '') -> None:
        self.node, self.brake = node, brake
        self.said: dict[str, Any] = {}
        self.statuses: dict[str, Any] = {}  # by name, the last heard behind
        self._fresh: set[str] = set()  # heard of since time went on
        self.count = 0
        outputs = f'{namespace}/squeal_monitor/{brake}'
        for name in NUMBERS:
            self._listen(Float64, f'{outputs}/{name}', name)
        self._listen(Float64MultiArray, f'{outputs}/unstable_frequencies', 'unstable', LATCHED)
        self._listen(DiagnosticArray, '/diagnostics', 'diagnostics')
        self._listeners = {s.topic_name: s for s in self.node.subscriptions}
        self.events: list[Any] = []  # alarms that began or ended: not heard at every tick
        self.node.create_subscription(
            DiagnosticArray, f'{namespace}/squeal_monitor/events', self.events.append, EVENTS)

    def _listen(self, kind: Any, topic: str, name: str, qos: Any = 10) -> None:
        def hear(message: Any) -> None:
            self.said[name] = message
            self._fresh.add(name)
            self.count += 1
            for status in getattr(message, 'status', ()):  # of a brake, or the node's
                self.statuses.pop(status.name, None)
                self.statuses[status.name] = status

        self.node.create_subscription(kind, topic, hear, qos)

    def hear(self) -> None:
        """Take all that came on this vehicle's subscriptions."""
        for subscription in list(self.node.subscriptions):
            if not subscription.raw:
                with subscription.handle:
                    while (taken := subscription.handle.take_message(
                            subscription.msg_type, subscription.raw)) is not None:
                        subscription.callback(taken[0])

    @property
    def stamp(self) -> int:
        """Time of the last diagnostics [ns]; zero before the first."""
        if 'diagnostics' not in self.said:
            return 0
        stamp = self.said['diagnostics'].header.stamp
        return int(stamp.sec) * SECOND + int(stamp.nanosec)

    @property
    def risk(self) -> float:
        """Return the risk last heard; minus one before the first."""
        return float(self.said['squeal_risk'].data) if 'squeal_risk' in self.said else -1.0

    @property
    def unstable(self) -> list[float]:
        return list(self.said['unstable'].data) if 'unstable' in self.said else [-1.0]

    @property
    def status(self) -> Any:
        """Return this brake's diagnostic status, or None."""
        found = [s for s in self.statuses.values() if s.hardware_id == self.brake]
        return found[-1] if found else None

    @property
    def node_status(self) -> Any:
        """Return the node's own diagnostic status, or None."""
        found = [s for s in self.statuses.values() if s.name.endswith(': node')]
        return found[-1] if found else None

    @property
    def figures(self) -> dict[str, str]:
        """Return the values of the node's own status."""
        return {item.key: item.value for item in getattr(self.node_status, 'values', ())}
