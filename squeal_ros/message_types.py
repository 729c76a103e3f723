"""ROS message types by name, without rosidl_runtime_py; no rclpy needed either."""

from array import array
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from squeal_core.errors import ConfigurationError


class RosMessages:
    """Message classes as rclpy takes them."""

    def __init__(self) -> None:
        self._known: dict[str, Any] = {}

    def type(self, name: str) -> Any:
        """Return the class of `package/msg/Name`, or raise ConfigurationError."""
        if name not in self._known:
            self._known[name] = _find(name)
        return self._known[name]

    def floats(self, values: Sequence[float]) -> Any:
        return array('d', values)

    def byte(self, value: int) -> Any:
        return bytes([value])


def _find(name: str) -> Any:
    package, _, rest = name.partition('/')
    try:
        found = getattr(import_module(f'{package}.msg'), rest.rpartition('/')[2])
        found.get_fields_and_field_types  # noqa: B018 - whatever else a module holds lacks it
    except (ImportError, AttributeError, ValueError, TypeError):
        raise ConfigurationError('type', f'{name!r} is no message type known here',
                                 'install its package or mend the name') from None
    return found
