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

"""The message classes of rosbags."""

from collections.abc import Sequence
from typing import Any

try:
    from rosbags.typesys import get_types_from_msg, get_typestore, Stores
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error
import numpy as np
from squeal_core.common.resources import config_folder
from squeal_ros.node import state_message

STATE_DEFINITION = config_folder().parent / 'squeal_msgs' / 'msg' / 'BrakeSqueal.msg'

JAZZY = get_typestore(Stores.ROS2_JAZZY)
JAZZY.register(get_types_from_msg(
    STATE_DEFINITION.read_text(encoding='utf-8'), state_message.TYPE))


class BagMessages:
    """Message classes as rosbags provides them."""

    def type(self, name: str) -> Any:  # noqa: A003
        """Return the class of `package/msg/Name`."""
        return JAZZY.types[name]

    def floats(self, values: Sequence[float]) -> Any:
        """Return the array that rosbags writes."""
        return np.array(values, dtype=np.float64)

    def byte(self, value: int) -> Any:
        """Return the number that rosbags writes."""
        return value
