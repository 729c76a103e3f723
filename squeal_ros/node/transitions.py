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

"""Requests for a transition that the state does not offer: refused in words; rclpy raises."""

from collections.abc import Callable
from typing import Any

from lifecycle_msgs.srv import ChangeState
from rclpy.lifecycle import LifecycleNode
from squeal_core.common.errors import short_repr


def refuse_in_words(node: LifecycleNode) -> None:
    """Make the service `change_state` log a refused transition, and those it offers instead."""
    for service in node.services:
        if service.srv_type is ChangeState:
            service.callback = _checked(node, service.callback)


def _checked(node: LifecycleNode, callback: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    def call(request: Any, response: Any) -> Any:
        machine, wanted = node._state_machine, request.transition
        offered = {number: label for number, label, *_ in machine.available_transitions}
        if wanted.label in offered.values() or (not wanted.label and wanted.id in offered):
            return callback(request, response)
        name = short_repr(wanted.label) if wanted.label else f'number {wanted.id}'
        node.get_logger().warning(
            f'refused transition {name}: the node is {machine.current_state[1]}; possible now: '
            f'{", ".join(offered.values()) or "none"}', throttle_duration_sec=1.0)
        response.success = False
        return response
    return call
