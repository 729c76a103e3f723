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

from squeal_core.monitor.alarm import Alarm
from squeal_core.monitor.margins import OtherMargin, OTHERS
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment

NAMES = ('squeal_risk', 'unstable_frequencies', 'growth_rate', 'friction_margin')
TYPES = {'squeal_risk': 'std_msgs/msg/Float64', 'growth_rate': 'std_msgs/msg/Float64',
         'friction_margin': 'std_msgs/msg/Float64',
         'unstable_frequencies': 'std_msgs/msg/Float64MultiArray'}
DIAGNOSTICS_TYPE = 'diagnostic_msgs/msg/DiagnosticArray'
MARKERS_TYPE = 'visualization_msgs/msg/MarkerArray'

OK, WARN, ERROR, STALE = range(4)

RISK_BY_MODE = 'risk_by_mode'
COSTLY = (RISK_BY_MODE, *OTHERS)  # figures of a brake that cost a quarter of a full solution each


class MessageLibrary(Hashable, Protocol):
    """What differs between rclpy's and rosbags' message classes."""

    def type(self, name: str) -> Any:  # noqa: A003
        """Return the class of `package/msg/Name`."""

    def floats(self, values: Sequence[float]) -> Any:
        """Return what a float64[] field holds."""

    def byte(self, value: int) -> Any:
        """Return what a byte field holds."""


def brake_messages(library: MessageLibrary,
                   assessment: Assessment) -> Iterator[tuple[str, Any]]:
    """Yield (name, message) for each name of `NAMES`; what is not known is NaN."""
    float64 = library.type('std_msgs/msg/Float64')
    for name, value in brake_values(assessment):
        yield name, float64(data=value)
    yield 'unstable_frequencies', frequency_list(library, frequencies_hz(assessment))


def brake_values(assessment: Assessment) -> tuple[tuple[str, float], ...]:
    """Return (name, value) for each Float64 of `TYPES`."""
    return (('squeal_risk', float(assessment.risk)),
            ('growth_rate', float(assessment.growth_rate)),
            ('friction_margin', float(assessment.friction_margin)))


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


class Levels:
    """Diagnostic levels of a vehicle's brakes (REP-107), tick after tick: no chatter."""

    def __init__(self, settings: MonitorSettings) -> None:
        self._alarms = {brake.name: Alarm(*_thresholds(settings)) for brake in settings.brakes}

    def update_settings(self, settings: MonitorSettings) -> None:
        for alarm in self._alarms.values():
            alarm.update_settings(*_thresholds(settings))

    def of(self, assessments: Sequence[Assessment]) -> list[int]:
        """Return the level of each assessment of a tick."""
        return [_level(a, self._alarms[a.brake].update(a.time, a.risk)) for a in assessments]


def _thresholds(settings: MonitorSettings) -> tuple[float, float, float]:
    return settings.risk_warning, settings.risk_hysteresis, settings.risk_hold


def _level(assessment: Assessment, alarm: bool) -> int:
    if assessment.state in ('invalid', 'outside validated range'):
        return ERROR
    if assessment.state == 'stale':
        return STALE
    return WARN if alarm else OK


class StatusTexts(NamedTuple):
    """A DiagnosticStatus as plain texts."""

    level: int
    name: str
    message: str
    hardware_id: str
    values: Mapping[str, str]


@dataclass(frozen=True)
class NodeStatus:
    """How the node itself does: a diagnostic level, the same in words, and figures."""

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
    found = assessment.stability
    if found is None:
        return {}
    if name == RISK_BY_MODE:
        return {name: ' '.join(f'{m.frequency_hz:.1f}:{m.probability:.3f}'
                               for m in found.risk.modes)}
    if found.margins.compute_other is None:
        return {}
    margin = found.margins.compute_other(cast(OtherMargin, name))
    return {f'margin_{name}': margin.value, f'margin_{name}_hz': margin.frequency_hz,
            f'margin_{name}_reason': margin.reason}


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
        'squeal_risk': assessment.risk, 'growth_rate_1_s': assessment.growth_rate,
        'worst_frequency_hz': assessment.worst_frequency_hz,
        'friction_margin': assessment.friction_margin,
        'unstable_frequencies_hz': ' '.join(map(repr, assessment.unstable_frequencies_hz)),
        'unstable_growth_rates_1_s': ' '.join(map(repr, assessment.unstable_growth_rates)),
        'divergent_modes': sum(m.kind == 'divergence' for m in assessment.modes),
        'friction': assessment.friction, 'friction_source': assessment.friction_source,
        **_of_stability(assessment)}
    for signal, reading in assessment.inputs.items():
        figures[f'{signal}_input'] = reading.value
        figures[f'{signal}_age_s'] = round(reading.age, 6)
        figures[f'{signal}_status'] = reading.status
    return figures


def _of_stability(assessment: Assessment) -> dict[str, object]:
    """Return the source and error of modes and risk, and the friction margin with its reason."""
    found = assessment.stability
    if found is None:
        return {}
    margin = found.margins.friction
    return {
        'modes_from': found.modes.source, 'modes_error_1_s': float(found.modes.errors.max()),
        'risk_basis': found.risk.basis, 'risk_error': found.risk.error,
        'friction_margin_hz': margin.frequency_hz, 'friction_margin_reason': margin.reason,
        'friction_margin_confirmed': margin.confirmed}
