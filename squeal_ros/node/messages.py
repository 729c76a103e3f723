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

"""Assessment -> ROS messages, for any library that provides the message types."""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
import math
from typing import Any, cast, NamedTuple, Protocol

from squeal_core.monitor.alarm_events import AlarmEvent, AlarmEvents
from squeal_core.monitor.margins import OtherMargin, OTHERS
from squeal_core.monitor.vehicle_monitor import Assessment

NUMBERS = ('squeal_risk', 'instability_probability', 'build_up', 'growth_rate', 'damping_ratio',
           'friction_margin')
TYPES = {**dict.fromkeys(NUMBERS, 'std_msgs/msg/Float64'),
         'unstable_frequencies': 'std_msgs/msg/Float64MultiArray'}
DIAGNOSTICS_TYPE = 'diagnostic_msgs/msg/DiagnosticArray'
ADVICE = dict.fromkeys(('quiet_pressure_below', 'quiet_pressure_above'), 'std_msgs/msg/Float64')
FRONT_SHARE = 'least_risk_front_share'  # name of a topic of the vehicle, likewise Float64
EVENTS = 'events'  # name of the topic of alarms that begin and end, of DIAGNOSTICS_TYPE
# topics of which a late subscriber gets so many messages
LATCHED: Mapping[str, int] = {'unstable_frequencies': 1, 'mode_shape': 1, EVENTS: 50}
MARKERS_TYPE = 'visualization_msgs/msg/MarkerArray'

OK, WARN, ERROR, STALE = range(4)

COSTLY = OTHERS  # figures of a brake that cost a quarter of a full solution each


class MessageLibrary(Hashable, Protocol):
    """Interface to message classes in which rclpy and rosbags differ."""

    def type(self, name: str) -> Any:  # noqa: A003
        """Return the class of `package/msg/Name`."""

    def floats(self, values: Sequence[float]) -> Any:
        """Return the value of a float64[] field."""

    def byte(self, value: int) -> Any:
        """Return the value of a byte field."""


def brake_messages(library: MessageLibrary,
                   assessment: Assessment) -> Iterator[tuple[str, Any]]:
    """Yield (name, message) for each name of `TYPES`; what is not known is NaN."""
    float64 = library.type('std_msgs/msg/Float64')
    for name, value in zip(NUMBERS, brake_values(assessment), strict=True):
        yield name, float64(data=value)
    yield 'unstable_frequencies', frequency_list(library, frequencies_hz(assessment))


def brake_values(assessment: Assessment) -> tuple[float, ...]:
    """Return the values of `NUMBERS`."""
    return (assessment.risk, assessment.instability_probability, assessment.build_up,
            assessment.growth_rate, assessment.damping_ratio, assessment.friction_margin)


def frequencies_hz(assessment: Assessment) -> tuple[float, ...]:
    """Return those of all flutter modes [Hz], worst first; empty: none; one NaN: not known."""
    return assessment.unstable_frequencies_hz if assessment.is_valid else (math.nan,)


def frequency_list(library: MessageLibrary, frequencies: Sequence[float]) -> Any:
    """Return the message of some frequencies [Hz]."""
    return library.type('std_msgs/msg/Float64MultiArray')(
        layout=_layout(library, len(frequencies)), data=library.floats(frequencies))


@lru_cache(maxsize=64)
def _layout(library: MessageLibrary, count: int) -> Any:
    """Return the layout of a list; messages share it, as they are only written out."""
    dimension = library.type('std_msgs/msg/MultiArrayDimension')(
        label='frequency_hz', size=count, stride=count)
    return library.type('std_msgs/msg/MultiArrayLayout')(dim=[dimension], data_offset=0)


def levels(assessments: Sequence[Assessment], alarms: AlarmEvents) -> list[int]:
    """Return the diagnostic level (REP-107) of each assessment of a tick, given its alarms."""
    return [_level(one, alarms.is_up(one.brake)) for one in assessments]


def _level(assessment: Assessment, alarm: bool) -> int:
    if assessment.state in ('invalid', 'outside validated range'):
        return ERROR
    if assessment.state == 'stale':
        return STALE
    unknown = assessment.state == 'steady' and math.isnan(assessment.risk)
    return WARN if alarm or unknown else OK


class StatusTexts(NamedTuple):
    """A DiagnosticStatus as plain texts."""

    level: int
    name: str
    message: str
    hardware_id: str
    values: Mapping[str, str]


@dataclass(frozen=True)
class NodeStatus:
    """Status of the node itself: a diagnostic level, the same in words, and figures."""

    values: Mapping[str, object]
    level: int = OK
    message: str = 'running'

    def of(self, node: str) -> StatusTexts:
        """Return the status under a node's name."""
        return StatusTexts(self.level, f'{node}: node', self.message, node,
                           _as_texts(self.values))


def statuses(node: str, assessments: Sequence[Assessment], levels: Sequence[int],
             status: NodeStatus) -> list[StatusTexts]:
    """Return the diagnostics of one tick: a status for each brake, then one for the node."""
    return [*(brake_status(node, assessment, level)
              for assessment, level in zip(assessments, levels, strict=True)),
            status.of(node)]


def _as_texts(values: Mapping[str, object]) -> dict[str, str]:
    return {key: value if isinstance(value, str) else str(value)
            for key, value in values.items()}


def brake_status(node: str, assessment: Assessment, level: int,
                 more: Mapping[str, object] | None = None) -> StatusTexts:
    """Return the diagnostics of one brake, with more values if given."""
    return StatusTexts(
        level, f'{node}: {assessment.brake}', assessment.reason, assessment.brake,
        _as_texts({'state': assessment.state, **_figures(assessment), **(more or {})}))


def costly_figure(assessment: Assessment, name: str) -> dict[str, object]:
    """Return the values of one name of `COSTLY`; none where it is not known."""
    result = assessment.stability
    if result is None or result.margins.compute_other is None:
        return {}
    margin = result.margins.compute_other(cast(OtherMargin, name))
    return {f'margin_{name}': margin.value, f'margin_{name}_hz': margin.frequency_hz,
            f'margin_{name}_reason': margin.reason}


def event_status(node: str, event: AlarmEvent) -> StatusTexts:
    """Return the start or the end of an alarm: level WARN or OK."""
    return StatusTexts(
        WARN if event.kind == 'start' else OK, f'{node}: {event.brake}', event.in_words,
        event.brake, _as_texts({
            'event': event.kind, 'brake': event.brake, 'modes': ' '.join(map(str, event.modes)),
            'frequency_hz': event.frequency_hz, 'squeal_risk': event.risk,
            'peak_risk': event.peak_risk, 'duration_s': round(event.duration, 9),
            'cause': event.cause}))


def diagnostics(library: MessageLibrary, time: int, statuses: Sequence[StatusTexts]) -> Any:
    """Return a DiagnosticArray at a time [ns]."""
    seconds, nanoseconds = divmod(time, 1_000_000_000)
    stamp = library.type('builtin_interfaces/msg/Time')(sec=seconds, nanosec=nanoseconds)
    header = library.type('std_msgs/msg/Header')(stamp=stamp, frame_id='')
    return library.type(DIAGNOSTICS_TYPE)(
        header=header, status=[_status(library, one) for one in statuses])


def _status(library: MessageLibrary, status: StatusTexts) -> Any:
    key_value = library.type('diagnostic_msgs/msg/KeyValue')
    return library.type('diagnostic_msgs/msg/DiagnosticStatus')(
        level=library.byte(status.level), name=status.name, message=status.message,
        hardware_id=status.hardware_id,
        values=[key_value(key=key, value=value) for key, value in status.values.items()])


def _figures(assessment: Assessment) -> dict[str, object]:
    figures: dict[str, object] = {
        'squeal_risk': assessment.risk,
        'instability_probability': assessment.instability_probability,
        'build_up_nepers': assessment.build_up, 'time_to_squeal_s': assessment.time_to_squeal,
        'growth_rate_1_s': assessment.growth_rate, 'damping_ratio': assessment.damping_ratio,
        'worst_frequency_hz': assessment.worst_frequency_hz,
        'worst_mode_number': assessment.worst_mode_number,
        'friction_margin': assessment.friction_margin,
        'unstable_frequencies_hz': ' '.join(map(repr, assessment.unstable_frequencies_hz)),
        'unstable_mode_numbers': ' '.join(map(str, assessment.mode_numbers)),
        'unstable_growth_rates_1_s': ' '.join(map(repr, assessment.unstable_growth_rates)),
        'unstable_build_ups_nepers': ' '.join(map(repr, assessment.build_ups)),
        'divergent_modes': sum(m.kind == 'divergence' for m in assessment.modes),
        'friction': assessment.friction, 'friction_source': assessment.friction_source,
        **_of_stability(assessment)}
    for signal, reading in assessment.inputs.items():
        figures[f'{signal}_input'] = reading.value
        figures[f'{signal}_age_s'] = round(reading.age, 6)
        figures[f'{signal}_status'] = reading.status
    return figures


def _of_stability(assessment: Assessment) -> dict[str, object]:
    """Return values on modes, risk and friction margin, with their source, error or reason."""
    result = assessment.stability
    if result is None:
        return {}
    margin, risk = result.margins.friction, assessment.risk_result
    return {
        'modes_from': result.modes.source, 'modes_error_1_s': float(result.modes.errors.max()),
        **({} if risk is None else {
            'risk_basis': risk.result.basis, 'risk_error': risk.result.error,
            'risk_incomplete': risk.result.incomplete, 'peak_risk': risk.result.peak_risk,
            'likely_modes': ' '.join(map(str, risk.modes)),
            'likely_frequency_hz': risk.result.frequency_hz}),
        'friction_margin_hz': margin.frequency_hz, 'friction_margin_reason': margin.reason,
        'friction_margin_confirmed': margin.confirmed}
