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
Executor of the node: exceptions end as a log line and an answer, and little wakes it.

rclpy lets an exception of any callback end `spin`, of a service callback also the wait of its
caller; one that a message raises while it is taken blocks the callback group for ever. And its
executor looks at all it serves whenever it wakes, so what may wait is better kept from it.
"""

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from squeal_core.common.errors import in_one_line

Report = Callable[[Exception], None]


class ResilientExecutor(SingleThreadedExecutor):  # type: ignore[misc]
    """Spins on after an exception, which it reports, until its context ends."""

    def __init__(self, *, context: Context, report: Report) -> None:
        super().__init__(context=context)
        self._report = report

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Execute one callback; raise only exceptions after the context has ended."""
        try:
            super().spin_once(timeout_sec)
        except Exception as error:
            if isinstance(error, ExternalShutdownException) or not self.context.ok():
                raise
            self._report(error)

    def _make_handler(self, entity: Any, node: Any, take_from_wait_list: Any) -> Any:
        def take(entity: Any) -> Any:
            try:
                return take_from_wait_list(entity)
            except Exception as error:
                self._report(error)
                return None  # to rclpy: there is nothing to do

        return super()._make_handler(entity, node, take)


class DeferredCallbackGroup(MutuallyExclusiveCallbackGroup):  # type: ignore[misc]
    """
    Entities that an executor neither waits for nor serves, unless `open` is set.

    What comes meanwhile is kept: messages in their queues, events in the middleware.
    """

    open = False  # noqa: A003

    def can_execute(self, entity: Any) -> bool:
        """Return whether an entity may be executed: only while the group is open."""
        return self.open and bool(super().can_execute(entity))


def report_exceptions(callback: Callable[..., None], report: Report) -> Callable[..., None]:
    """Return a callback that reports exceptions of the given one."""
    def call(*arguments: Any) -> None:
        try:
            callback(*arguments)
        except Exception as error:
            report(error)
    return call


def guard_services(node: Node, report: Report) -> None:
    """Make every service of a node answer, if only by refusal (rclpy#1209 and others)."""
    for service in node.services:
        service.callback = _answering(service.callback, report)


def _answering(callback: Callable[..., Any], report: Report) -> Callable[..., Any]:
    def call(request: Any, response: Any) -> Any:
        try:
            return callback(request, response)
        except Exception as error:
            report(error)
            return _refusal(request, response, in_one_line(error))
    return call


def _refusal(request: Any, response: Any, reason: str) -> Any:
    """Return a response that refuses in its own fields; earlier results stay in it."""
    refused = SetParametersResult(successful=False, reason=reason)
    fields = response.get_fields_and_field_types()
    if 'success' in fields:
        response.success = False
    elif 'result' in fields and isinstance(response.result, SetParametersResult):
        response.result = refused
    elif 'results' in fields:
        missing = len(request.parameters) - len(response.results)
        response.results = [*response.results, *[refused] * missing]
    return response
