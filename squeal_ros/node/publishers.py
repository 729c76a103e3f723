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

"""Publishers of the node: reliable, lists and events latched, silent unless it is active."""

from collections.abc import Iterable
from contextlib import suppress
import time
from typing import Any

from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.serialization import deserialize_message
from squeal_core.common.errors import ConfigurationError, in_one_line
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages, state_message
from squeal_ros.node.executor import DeferredCallbackGroup
from squeal_ros.node.message_types import RosMessages
from squeal_ros.node.subscriptions import naming, POLICIES

_DIAGNOSTICS = '/diagnostics'
_LONGEST_WAIT = 1_000_000_000  # ns, for subscribers; `ros2 launch` allows a node 5 s to end


class OutputTopics:
    """
    The topics of some brakes, and /diagnostics.

    Parameters
    ----------
    node : rclpy.lifecycle.LifecycleNode
    library : RosMessages
    brakes : iterable of str
    mode_shapes : bool
        Whether there are markers, too.
    aside : DeferredCallbackGroup
        For the events of the publishers.

    Raises
    ------
    ConfigurationError
        For a quality of service that is none.

    """

    def __init__(self, node: LifecycleNode, library: RosMessages, brakes: Iterable[str],
                 mode_shapes: bool, aside: DeferredCallbackGroup) -> None:
        self._node, self._library, self._aside = node, library, aside
        self._publishers: dict[tuple[str, str], Any] = {}
        types = {**messages.TYPES, **messages.ADVICE}
        if mode_shapes:
            types['mode_shape'] = messages.MARKERS_TYPE
        self.why_no_state = why_no_state(library)
        if not self.why_no_state:
            types[state_message.NAME] = state_message.TYPE
        try:
            for brake in brakes:
                for name, type_name in types.items():
                    self._publishers[brake, name] = self._create(
                        f'~/{brake}/{name}', type_name)
            self._publishers['', _DIAGNOSTICS] = self._create(
                _DIAGNOSTICS, messages.DIAGNOSTICS_TYPE)
            self._publishers['', messages.FRONT_SHARE] = self._create(
                f'~/{messages.FRONT_SHARE}', 'std_msgs/msg/Float64')
            self._publishers['', messages.EVENTS] = self._create(
                f'~/{messages.EVENTS}', messages.DIAGNOSTICS_TYPE)
        except Exception:
            self.destroy()
            raise

    def _create(self, topic: str, type_name: str) -> Any:
        qos = QoSProfile(depth=10)
        if latched := messages.LATCHED.get(topic.rpartition('/')[2]):
            qos = QoSProfile(depth=latched, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        with naming(topic):
            return self._node.create_lifecycle_publisher(
                self._library.type(type_name), topic, qos, callback_group=self._aside,
                qos_overriding_options=QoSOverridingOptions(POLICIES))

    def publish(self, assessments: Iterable[Assessment]) -> None:
        """Publish the assessments of all brakes at a tick."""
        for assessment in assessments:
            for name, message in messages.brake_messages(self._library, assessment):
                self._publishers[assessment.brake, name].publish(message)
            if not self.why_no_state:
                self._publishers[assessment.brake, state_message.NAME].publish(
                    state_message.serialised_state(assessment))

    def publish_number(self, brake: str, name: str, value: float) -> None:
        """Publish a Float64 of a brake, or of the vehicle where the brake is ''."""
        message = self._library.type('std_msgs/msg/Float64')(data=value)
        self._publishers[brake, name].publish(message)

    def publish_markers(self, brake: str, markers: Any) -> None:
        """Publish the markers of a brake's mode shape."""
        self._publishers[brake, 'mode_shape'].publish(markers)

    def publish_diagnostics(self, message: Any) -> None:
        """Publish on /diagnostics."""
        self._publishers['', _DIAGNOSTICS].publish(message)

    def publish_events(self, message: Any) -> None:
        """Publish the events of alarms."""
        self._publishers['', messages.EVENTS].publish(message)

    def destroy(self) -> None:
        """Remove the topics once all subscribers have what was published, or do not take it."""
        end = time.monotonic_ns() + _LONGEST_WAIT
        for publisher in self._publishers.values():
            with suppress(Exception):  # a middleware that ended, or has no such thing
                publisher.wait_for_all_acked(
                    Duration(nanoseconds=max(end - time.monotonic_ns(), 0)))
        for publisher in self._publishers.values():
            self._node.destroy_lifecycle_publisher(publisher)
        self._publishers.clear()


def why_no_state(library: RosMessages) -> str:
    """Return the reason why `squeal_msgs/BrakeSqueal` cannot be published; empty if it can."""
    unknown = Assessment(brake='', time=0, state='stale', reason='')
    try:
        fields = library.fields(state_message.TYPE)
        if list(fields.items()) != list(state_message.FIELDS.items()):
            return 'squeal_msgs is of another version; build that of this checkout'
        deserialize_message(state_message.serialised_state(unknown),
                            library.type(state_message.TYPE))
    except ConfigurationError:
        return 'squeal_msgs is not installed here; build it (docs/install.md)'
    except Exception as error:  # on PYTHONPATH, but its libraries are not found
        return f'squeal_msgs cannot be used ({in_one_line(error, 200)}); source its workspace'
    return ''
