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

"""Online eigen-stability of disc brakes: the model, its stability and the monitor; no ROS."""

from squeal_core import stability
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel

__version__ = '0.1.0'  # the one place: pyproject.toml reads it, a test holds package.xml to it

__all__ = ['BrakeModel', 'OperatingPoint', 'SquealError', '__version__', 'stability']
