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

"""ROS message types by name, without rosidl_runtime_py; no rclpy needed either."""

from array import array
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

from squeal_core.common.errors import ConfigurationError, did_you_mean


class RosMessages:
    """Message classes as rclpy takes them."""

    def __init__(self) -> None:
        self._known: dict[str, Any] = {}

    def type(self, name: str) -> Any:  # noqa: A003
        """Return the class of `package/msg/Name`, or raise ConfigurationError."""
        if name not in self._known:
            self._known[name] = _find(name)
        return self._known[name]

    def fields(self, name: str) -> Mapping[str, str]:
        """Return the fields of a message type and their types, as ROS writes them."""
        fields: Mapping[str, str] = self.type(name).get_fields_and_field_types()
        return fields

    def floats(self, values: Sequence[float]) -> Any:
        """Return an array, which rclpy does not check value by value."""
        return array('d', values)

    def byte(self, value: int) -> Any:
        """Return one byte, as rclpy requires."""
        return bytes([value])


def _find(name: str) -> Any:
    package, _, rest = name.partition('/')
    short = rest.rpartition('/')[2]
    try:
        module = import_module(f'{package}.msg')
    except (ImportError, ValueError, TypeError):
        raise ConfigurationError(
            'type', f'is {name!r}, and there is no message package {package!r} here',
            'source the workspace that has it, or correct the name') from None
    result = getattr(module, short, None)
    if not hasattr(result, 'get_fields_and_field_types'):  # whatever else a module holds lacks it
        types = [word for word in dir(module) if hasattr(
            getattr(module, word), 'get_fields_and_field_types')]
        raise ConfigurationError(
            'type', f'is {name!r}, and {package} has no message type {short!r} (package/msg/Name)',
            f'correct the name{did_you_mean(short, types)}')
    return result
