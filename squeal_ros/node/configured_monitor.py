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

"""Parts of a node while it is configured: model, monitor, topics, reports."""

from collections.abc import Sequence
from contextlib import ExitStack
import time
from typing import Any

from squeal_core.common.errors import in_one_line
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.alarm_events import AlarmEvent, AlarmEvents
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_advice import VehicleAdvice
from squeal_core.monitor.vehicle_monitor import Assessment, Reading, VehicleMonitor
from squeal_ros.node import messages
from squeal_ros.node.advice_reports import AdviceReports
from squeal_ros.node.diagnostics import Reporter
from squeal_ros.node.executor import DeferredCallbackGroup, Report, report_exceptions
from squeal_ros.node.field_check import check_fields
from squeal_ros.node.field_hints import hint
from squeal_ros.node.field_paths import Router
from squeal_ros.node.markers import ModeShapes
from squeal_ros.node.message_types import RosMessages
from squeal_ros.node.node_statistics import Health
from squeal_ros.node.publishers import OutputTopics
from squeal_ros.node.subscriptions import InputTopics
from squeal_ros.node.tick_grid import Tick

_LONGEST_HINT = 500  # characters, of names that a message may have any number of


class ConfiguredMonitor:
    """
    Model, monitor and topics of a node, from configure to cleanup.

    Parameters
    ----------
    node : LifecycleNode
    settings : MonitorSettings
    health : Health
    report : callable
        Given the exceptions of callbacks.

    Raises
    ------
    SquealError
        For a model, a table or a topic that cannot be used.

    """

    def __init__(self, node: Any, settings: MonitorSettings, health: Health,
                 report: Report) -> None:
        self._node, self._library = node, RosMessages()
        library = self._library
        model = BrakeModel.load(settings.model)
        self.router = Router.of(settings)
        check_fields(settings, library.fields, node.get_logger().warning)
        self.monitor = VehicleMonitor(settings, model)
        self.monitor.evaluator.warm_up(list(self.monitor.brakes))
        self.alarms = AlarmEvents(settings)
        self._said: set[str] = set()
        self._warn()
        aside = DeferredCallbackGroup()
        with ExitStack() as undo:
            self.inputs = InputTopics(node, library, self.router.types, aside,
                                      report_exceptions(self._receive, report), self._complain)
            undo.callback(self.inputs.destroy)
            self.outputs = OutputTopics(
                node, library, self.monitor.brakes, settings.mode_shapes, aside)
            undo.callback(self.outputs.destroy)
            self._set_up_reports(library, model, settings, health)
            undo.pop_all()

    def _set_up_reports(self, library: RosMessages, model: BrakeModel, settings: MonitorSettings,
                        health: Health) -> None:
        self.advice = AdviceReports(settings, self._advice(settings), self.outputs.publish_number)
        self.reporter = Reporter(
            self._node.get_fully_qualified_name().lstrip('/'), settings, library, health, model,
            self.inputs, self.outputs, lambda: self.router.problems.total(),
            lambda: self.monitor.evaluator.figures(),
            lambda: self.monitor.cross_checks.summary, self.alarms,
            lambda: self.monitor.evaluator.risk.unknown, self.advice)
        self.mode_shapes: ModeShapes | None = None
        if settings.mode_shapes:
            self.mode_shapes = ModeShapes(library, model, settings, self.outputs.publish_markers)
            self.reporter.mode_shapes = self.mode_shapes.status

    def _advice(self, settings: MonitorSettings) -> VehicleAdvice:
        evaluator = self.monitor.evaluator
        return VehicleAdvice(evaluator.stability.model, settings, evaluator.stability,
                             evaluator.risk.squeal_risk)

    def begin(self) -> None:
        """Discard earlier samples, also messages queued while nobody took them."""
        self.inputs.begin()
        self.monitor.reset()

    def destroy(self) -> None:
        """Destroy publishers and subscriptions."""
        self.inputs.destroy()
        self.outputs.destroy()

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings of the same brakes and topics from the next tick on."""
        self.router = Router.of(settings, self.router.problems)
        self.monitor.update_settings(settings)
        self._warn()
        self.alarms.update_settings(settings)
        self.advice.update_settings(settings, self._advice(settings))
        self.reporter.update_settings(settings)
        if self.mode_shapes:
            self.mode_shapes.update_settings(settings)

    def assess(self, tick: Tick) -> None:
        """Assess all brakes at a tick and publish the results."""
        assessments = self.monitor.assess(tick.time)
        self.outputs.publish(assessments)
        self._tell(tick.time, self.alarms.update(assessments))
        self.advice.take(assessments)
        self.reporter.report(assessments)
        if self.mode_shapes:
            self.mode_shapes.update(assessments, time.monotonic_ns())

    def say_unknown(self, reason: str) -> None:
        """Publish that nothing is known of any brake, with the reason."""
        now = self._node.get_clock().now().nanoseconds
        assessments = tuple(
            Assessment(brake=name, time=now, state='stale', reason=reason,
                       inputs={signal: Reading('stale') for signal in brake.brake.inputs})
            for name, brake in self.monitor.brakes.items())
        self.outputs.publish(assessments)
        self._tell(now, self.alarms.end(assessments))
        self.advice.forget(tuple(self.monitor.brakes))
        self.reporter.report_unknown(assessments, reason)
        if self.mode_shapes:
            self.mode_shapes.wipe()

    def _receive(self, topic: str, message: Any, received: int, number: int) -> None:
        problems, known = self.router.problems, len(self.router.problems)
        for source, (brake, name, sample) in zip(
                self.router.sources(topic),
                self.router.samples(topic, message, received, number), strict=True):
            self.monitor.receive(brake, name, sample)
            if len(problems) > known:  # logged once, counted after
                known = len(problems)
                self._complain(f'cannot read {next(reversed(problems))}; '
                               f'{in_one_line(hint(source.path, message), _LONGEST_HINT)}')

    def _tell(self, time: int, events: Sequence[AlarmEvent]) -> None:
        """Publish and log the alarms that began or ended at a tick."""
        if not events:
            return
        logger, name = self._node.get_logger(), self.reporter.name
        for event in events:
            text = f'{event.brake}: {event.in_words}'
            if event.kind == 'start':  # rclpy wants one severity of each line that logs
                logger.warning(text)
            else:
                logger.info(text)
        self.outputs.publish_events(messages.diagnostics(
            self._library, time, [messages.event_status(name, event) for event in events]))

    def _warn(self) -> None:
        """Log the reason for an unknown squeal risk, and settings that do not suit it."""
        risk = self.monitor.evaluator.risk
        for text in risk.warnings:
            self._complain(text)
        if risk.unknown:
            self._complain(f'squeal risk not known: {risk.unknown}')

    def _complain(self, text: str) -> None:
        if text not in self._said:
            self._said.add(text)
            self._node.get_logger().warning(text)
