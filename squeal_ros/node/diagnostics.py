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

"""What the node says about itself and its brakes, and when: diagnostics, and the markers."""

from collections.abc import Callable, Mapping, Sequence
import time
from typing import Any

from squeal_core.common.errors import printable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages
from squeal_ros.node.node_statistics import Growth, Health
from squeal_ros.node.publishers import OutputTopics
from squeal_ros.node.subscriptions import InputTopics


class Reporter:
    """
    Publishes diagnostics at their rate and on a change of level.

    Parameters
    ----------
    name : str
        Of the node, for the statuses.
    settings : MonitorSettings
    library : MessageLibrary
    health : Health
    model : BrakeModel
    inputs : InputTopics
    outputs : OutputTopics
    unreadable : callable
        Count of messages without the field that was looked for.
    engine : callable
        Figures of the engine, and which brakes are compared, by name.

    """

    def __init__(self, name: str, settings: MonitorSettings, library: messages.MessageLibrary,
                 health: Health, model: BrakeModel, inputs: InputTopics, outputs: OutputTopics,
                 unreadable: Callable[[], int],
                 engine: Callable[[], Mapping[str, object]]) -> None:
        self._name, self._settings = name, settings
        self._library, self._health = library, health
        self._inputs, self._outputs, self._unreadable = inputs, outputs, unreadable
        self._model, self._engine = _model_values(model), engine
        self._topics = {(brake.name, signal): source.topic for brake in settings.brakes
                        for signal, source in brake.inputs.items()}
        self.mode_shapes = 'off'
        self._alarms = messages.Levels(settings)
        self._levels: list[int] = []
        self._last = (0, 0)  # ROS time and steady time
        self._growth = {'deadline misses': Growth(), 'unreadable messages': Growth(),
                        'errors': Growth()}

    def update_settings(self, settings: MonitorSettings) -> None:
        self._settings = settings
        self._alarms.update_settings(settings)

    def report(self, assessments: Sequence[Assessment]) -> None:
        """Take note of a tick, and publish diagnostics if they are due."""
        levels = self._alarms.of(assessments)
        now, steady = assessments[0].time, time.monotonic_ns()
        period = 1e9 / self._settings.diagnostics_rate
        # simulated time may run faster or slower, or stand still
        due = abs(now - self._last[0]) >= period or steady - self._last[1] >= period
        if due or levels != self._levels:
            self._publish(assessments, levels, '')
            self._levels, self._last = levels, (now, steady)

    def report_unknown(self, assessments: Sequence[Assessment], reason: str) -> None:
        """Publish diagnostics of brakes of which nothing is known, as there are no ticks."""
        self._publish(assessments, self._alarms.of(assessments), reason)

    def _publish(self, assessments: Sequence[Assessment], levels: list[int],
                 stopped: str) -> None:
        self._outputs.publish_diagnostics(messages.diagnostics(
            self._library, self._name, assessments, levels,
            self._node_status(assessments, stopped)))

    def _node_status(self, assessments: Sequence[Assessment],
                     stopped: str) -> messages.NodeStatus:
        steady = time.monotonic_ns()
        wrong = self._inputs.look_around(steady)
        contradicted = self._contradicted(assessments)
        unreadable = self._unreadable() + self._inputs.undecodable
        counts = {'deadline misses': self._health.deadline_misses,
                  'unreadable messages': unreadable, 'errors': self._health.errors}
        faults = [f'{name}: {count}' for name, count in counts.items()
                  if self._growth[name].recent(count, steady)]
        values: Mapping[str, object] = {
            **self._health.values(), 'unreadable_messages': unreadable,
            'dropped_messages': self._inputs.dropped, 'wrong_publishers': len(wrong),
            'contradicted_topics': len(contradicted),
            'rate_hz': self._settings.rate, 'mode_shapes': self.mode_shapes,
            **self._model, **self._engine(),
            **self._inputs.values(steady)}
        if stopped:
            return messages.NodeStatus(values, messages.STALE, stopped)
        if wrong or contradicted or faults:
            return messages.NodeStatus(
                values, messages.WARN, '; '.join([*wrong, *contradicted, *faults]))
        return messages.NodeStatus(values)

    def _contradicted(self, assessments: Sequence[Assessment]) -> list[str]:
        """Return, in words, topics whose publishers contradict each other."""
        topics = [self._topics[found.brake, signal] for found in assessments
                  for signal, reading in found.inputs.items() if reading.status == 'contradicted']
        return [f'{topic}: {self._inputs.publishers(topic)} contradict each other'
                for topic in dict.fromkeys(topics)]


def _model_values(model: BrakeModel) -> dict[str, Any]:
    """Return what the model is, and what its audit found when it was built."""
    found = model.provenance.get('audit')
    checks = [check for check in (found if isinstance(found, list | tuple) else ())
              if isinstance(check, Mapping)]
    failed = [printable(check.get('name')) for check in checks if check.get('passed') is not True]
    return {'model': printable(model.provenance.get('brake', '')), 'model_modes': model.size,
            'audit_checks': len(checks), 'audit_failed': len(failed),
            'audit_failed_names': ', '.join(failed[:20])}
