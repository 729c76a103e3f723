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

"""Diagnostics of the node and its brakes, and when each status is due."""

from collections.abc import Callable, Mapping, Sequence, Set
import math
import time
from typing import Any

from squeal_core.common.errors import printable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.alarm_events import AlarmEvents
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages
from squeal_ros.node.advice_reports import AdviceReports
from squeal_ros.node.costly_figures import CostlyFigures
from squeal_ros.node.node_statistics import Growth, Health, Turns
from squeal_ros.node.publishers import OutputTopics
from squeal_ros.node.subscriptions import InputTopics


class Reporter:
    """
    Publishes diagnostics: each status at their rate, of brakes also on a change of level.

    The statuses take turns, and a brake's figures that cost milliseconds are computed one after
    the other in the ticks before it is published, so that no tick takes them all.

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
    stability : callable
        Counts of answers of the table and of full solutions, by name.
    cross_checks : callable
        Which brakes are compared, in words.
    alarms : AlarmEvents
        Of the brakes, up to date.
    unknown_risk : callable
        Why no squeal risk is known of any brake; empty where it is.
    advice : AdviceReports
        Up to date.

    """

    def __init__(self, name: str, settings: MonitorSettings, library: messages.MessageLibrary,
                 health: Health, model: BrakeModel, inputs: InputTopics, outputs: OutputTopics,
                 unreadable: Callable[[], int],
                 stability: Callable[[], Mapping[str, float]],
                 cross_checks: Callable[[], str], alarms: AlarmEvents,
                 unknown_risk: Callable[[], str], advice: AdviceReports) -> None:
        self.name, self._settings = name, settings
        self._library, self._health = library, health
        self._inputs, self._outputs, self._unreadable = inputs, outputs, unreadable
        self._model = _model_values(model)
        self._stability, self._cross_checks = stability, cross_checks
        self._topics = {(brake.name, signal): source.topic for brake in settings.brakes
                        for signal, source in brake.inputs.items()}
        self.mode_shapes = 'off'
        self._alarms, self._unknown_risk, self._advice = alarms, unknown_risk, advice
        self._levels: list[int] = []
        self._turns, self._costly = Turns(len(settings.brakes) + 1), CostlyFigures(settings)
        self._confirmed: dict[str, int] = {}  # when margins of brakes last were [ns]
        self._growth = {'deadline misses': Growth(), 'unreadable messages': Growth(),
                        'errors': Growth(), 'table mismatches': Growth(),
                        'emulator mismatches': Growth()}

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings from the next report on."""
        self._settings = settings
        self._costly.update_settings(settings)

    def report(self, assessments: Sequence[Assessment]) -> None:
        """Record a tick, and publish diagnostics if they are due."""
        self._confirmed |= {one.brake: one.time for one in assessments if one.stability
                            and one.stability.margins.friction.confirmed}
        levels = messages.levels(assessments, self._alarms)
        changed = {place for place, (new, old) in enumerate(zip(
            levels, self._levels or levels, strict=True)) if new != old}
        self._levels = levels
        due = self._turns.due(
            assessments[0].time, time.monotonic_ns(),
            round(1e9 / self._settings.diagnostics_rate), self._settings.period)
        self._costly.begin(due - {len(levels)})
        figures = {place: self._dated(assessments[place], values)
                   for place, values in self._costly.compute(assessments).items()}
        self._publish(assessments, levels, changed, figures, node=len(levels) in due)

    def report_unknown(self, assessments: Sequence[Assessment], reason: str) -> None:
        """Publish diagnostics of brakes of which nothing is known, as there are no ticks."""
        self._costly.forget()
        levels = messages.levels(assessments, self._alarms)
        self._publish(assessments, levels, set(range(len(levels))), {}, node=True, stopped=reason)

    def _publish(self, assessments: Sequence[Assessment], levels: list[int], changed: Set[int],
                 figures: Mapping[int, Mapping[str, object]], *, node: bool,
                 stopped: str = '') -> None:
        """Publish the brakes that changed or have figures, by their place, and the node."""
        result = [messages.brake_status(self.name, assessment, level, figures.get(place))
                  for place, (assessment, level) in enumerate(zip(
                      assessments, levels, strict=True)) if place in changed | figures.keys()]
        if node:
            result.append(self._node_status(assessments, stopped).of(self.name))
        if result:
            self._outputs.publish_diagnostics(
                messages.diagnostics(self._library, assessments[0].time, result))

    def _dated(self, assessment: Assessment, figures: Mapping[str, object]) -> dict[str, object]:
        """Return the figures that not every tick has, and the age of the last confirmation."""
        if assessment.stability is None:
            return {}
        confirmed = self._confirmed.get(assessment.brake)
        age = math.nan if confirmed is None else round(1e-9 * (assessment.time - confirmed), 6)
        return {**figures, 'friction_margin_confirmed_age_s': age,
                **self._advice.of_brake(assessment.brake)}

    def _node_status(self, assessments: Sequence[Assessment],
                     stopped: str) -> messages.NodeStatus:
        steady = time.monotonic_ns()
        wrong = self._inputs.look_around(steady)
        contradicted = self._contradicted(assessments)
        unreadable = self._unreadable() + self._inputs.undecodable
        stability = self._stability()
        counts = {'deadline misses': self._health.deadline_misses,
                  'unreadable messages': unreadable, 'errors': self._health.errors,
                  'table mismatches': int(stability['solver_mismatches']),
                  'emulator mismatches': int(stability['emulator_mismatches'])}
        faults = [f'{name}: {count}' for name, count in counts.items()
                  if self._growth[name].recent(count, steady)]
        values: Mapping[str, object] = {
            **self._health.values(), 'unreadable_messages': unreadable,
            'dropped_messages': self._inputs.dropped, 'wrong_publishers': len(wrong),
            'contradicted_topics': len(contradicted),
            'rate_hz': self._settings.rate, 'mode_shapes': self.mode_shapes,
            **self._model, **stability, **self._advice.of_vehicle(),
            'cross_checks': self._cross_checks(), **self._inputs.values(steady)}
        if stopped:
            return messages.NodeStatus(values, messages.STALE, stopped)
        said = [*filter(None, [self._unknown_risk()]), *wrong, *contradicted, *faults]
        if said:
            return messages.NodeStatus(values, messages.WARN, '; '.join(said))
        return messages.NodeStatus(values)

    def _contradicted(self, assessments: Sequence[Assessment]) -> list[str]:
        """Return, in words, topics whose publishers contradict each other."""
        topics = [self._topics[result.brake, signal] for result in assessments
                  for signal, reading in result.inputs.items() if reading.status == 'contradicted']
        return [f'{topic}: {self._inputs.publishers(topic)} contradict each other'
                for topic in dict.fromkeys(topics)]


def _model_values(model: BrakeModel) -> dict[str, Any]:
    """Return the description of the model, and the result of its audit when it was built."""
    result = model.provenance.get('audit')
    checks = [check for check in (result if isinstance(result, list | tuple) else ())
              if isinstance(check, Mapping)]
    failed = [printable(check.get('name')) for check in checks if check.get('passed') is not True]
    return {'model': printable(model.provenance.get('brake', '')), 'model_modes': model.size,
            'audit_checks': len(checks), 'audit_failed': len(failed),
            'audit_failed_names': ', '.join(failed[:20])}
