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
Act on squeal alarms: which brakes squeal, and whether the monitor knows.

Run: python examples/act_on_alarms.py, beside the node; docs/howto/alarms.md explains it.
"""

from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL)  # and reliable


class AlarmListener(Node):
    """Keeps which brakes squeal, by frequency, and which are not known."""

    def __init__(self, **options: Any) -> None:
        super().__init__('alarm_listener', **options)
        self.squealing: dict[str, float] = {}
        self.unknown: set[str] = set()
        self.create_subscription(DiagnosticArray, 'squeal_monitor/events', self.hear, LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self.watch, 10)

    def hear(self, message: DiagnosticArray) -> None:
        """Take starts and ends of alarms; this is where to act."""
        for event in message.status:
            values = {item.key: item.value for item in event.values}
            if values['event'] == 'start':
                self.squealing[values['brake']] = float(values['frequency_hz'])
            else:
                self.squealing.pop(values['brake'], None)
            print(f'{values["brake"]}: {event.message}', flush=True)

    def watch(self, message: DiagnosticArray) -> None:
        """Take what is not known: without it no alarm would read as no squeal."""
        for status in message.status:
            if status.name.startswith('squeal_monitor: '):
                if status.level > DiagnosticStatus.WARN:  # ERROR or STALE; levels are bytes
                    self.unknown.add(status.name)
                else:
                    self.unknown.discard(status.name)


def main() -> None:
    with rclpy.init():
        rclpy.spin(AlarmListener())


if __name__ == '__main__':
    main()
