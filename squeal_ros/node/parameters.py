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

"""Parameters of the node: declared from the table of keys, checked on set, applied after."""

from collections.abc import Callable, Iterable
import re
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.node import Node
from rclpy.parameter import Parameter
from squeal_core.common.errors import ConfigurationError
from squeal_core.monitor.setting_specs import SettingSpec
from squeal_core.monitor.settings import (
    flatten,
    is_built_in,
    MonitorSettings,
    read_settings,
    settings_keys,
)

_QOS = 'qos_overrides.'
_EXPONENT = re.compile(r'[-+]?\d+(\.\d*)?[eE][-+]?\d+')
_CHANGE = {'tick': 'takes effect at the next tick',
           'configure': 'takes effect when the node is configured; fixed from then to its cleanup',
           'start': 'fixed at the start of the node'}


class NodeParameters:
    """
    Declares all settings on a node and keeps them, checked, in `settings`.

    Parameters
    ----------
    node : rclpy.node.Node
        Made with `automatically_declare_parameters_from_overrides`: so what is given is known.
    configured : callable
        Whether the node holds a configuration, which fixes some parameters.
    applied : callable
        Given the new settings after a successful change.

    Raises
    ------
    ConfigurationError
        For a bad value or an unknown name.

    """

    def __init__(self, node: Node, configured: Callable[[], bool],
                 applied: Callable[[MonitorSettings], None]) -> None:
        self._node, self._configured, self._applied = node, configured, applied
        given = {name: parameter.value
                 for name, parameter in node.get_parameters_by_prefix('').items()
                 if not is_built_in(name)}
        self.settings = read_settings(flatten(given))
        self._keys = {key.name: key for key in settings_keys(
            tuple(brake.name for brake in self.settings.brakes))}
        self._values = {name: key.read(given.get(name, key.default))
                        for name, key in self._keys.items()}
        for name, key in self._keys.items():
            if name in given:
                node.undeclare_parameter(name)
            value = self._values[name]
            node.declare_parameter(name, list(value) if isinstance(value, tuple) else value,
                                   _descriptor(key), ignore_override=True)
        node.add_pre_set_parameters_callback(self._as_declared)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._take)

    def _as_declared(self, parameters: list[Parameter]) -> list[Parameter]:
        """Convert whole numbers to real ones, as in a file at the start."""
        unknown = [p.name for p in parameters if not self._node.has_parameter(p.name)]
        if unknown:  # rclpy would refuse them without saying which
            raise ParameterNotDeclaredException(unknown)
        return [Parameter(p.name, Parameter.Type.DOUBLE, number)
                if self._is_real(p.name) and (number := _real(p)) is not None else p
                for p in parameters]

    def _is_real(self, name: str) -> bool:
        return name in self._keys and isinstance(self._keys[name].default, float)

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Refuse with the reason; an exception would reach whoever sets, or end the node."""
        try:
            for parameter in parameters:
                self._check_time(parameter)
            changes = self._changes(parameters)
            if changes:
                read_settings({**self._values, **changes})
        except Exception as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _check_time(self, parameter: Parameter) -> None:
        name = parameter.name
        key = self._keys.get(name)
        waits = key.change == 'configure' if key else name.startswith(_QOS)
        if waits and self._configured() and parameter.value != self._values.get(name):
            raise ConfigurationError(name, 'is fixed while the node is configured',
                                     'deactivate it and clean it up, set, then configure it again')

    def _changes(self, parameters: Iterable[Parameter]) -> dict[str, Any]:
        return {p.name: p.value for p in parameters if not is_built_in(p.name)}

    def _take(self, parameters: list[Parameter]) -> None:
        changes = self._changes(parameters)
        if not changes:
            return
        self._values.update({name: self._keys[name].read(value)
                             for name, value in changes.items()})
        self.settings = read_settings(self._values)
        self._applied(self.settings)


def _real(parameter: Parameter) -> float | None:
    """Return a whole number as a real one, and so 1e-06, which YAML takes for a text."""
    if parameter.type_ == Parameter.Type.INTEGER:
        return float(parameter.value)
    if parameter.type_ != Parameter.Type.STRING or not _EXPONENT.fullmatch(parameter.value):
        return None
    return float(parameter.value)


def _descriptor(key: SettingSpec) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=f'{key.meaning} [{key.unit}]', additional_constraints=_CHANGE[key.change],
        read_only=key.change == 'start')
    if isinstance(key.default, float) and abs(key.minimum) < 1e300:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=key.minimum, to_value=key.maximum)]
    return descriptor
