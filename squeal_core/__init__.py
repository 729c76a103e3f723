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

"""
Online eigen-stability of disc brakes: the model, its stability and the monitor; no ROS.

What a user needs is here; the packages have the rest. What is not needed to solve a model is
imported at first use.
"""

from importlib import import_module
from typing import Any, TYPE_CHECKING

from squeal_core import stability
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability import complex_modes

if TYPE_CHECKING:
    from squeal_core.assembly.build import build_model
    from squeal_core.brake.brake_yaml import read_brake
    from squeal_core.modes.readers import read_modes
    from squeal_core.monitor.settings import load_settings
    from squeal_core.monitor.vehicle_monitor import VehicleMonitor
    from squeal_core.stability.critical_parameter import critical_value
    from squeal_core.studies.sweep import sweep

__all__ = [
    '__version__', 'BrakeModel', 'build_model', 'complex_modes', 'critical_value', 'load_settings',
    'OperatingPoint', 'read_brake', 'read_modes', 'SquealError', 'stability', 'sweep',
    'VehicleMonitor']

_AT_FIRST_USE = {
    'build_model': 'assembly.build', 'critical_value': 'stability.critical_parameter',
    'load_settings': 'monitor.settings', 'read_brake': 'brake.brake_yaml',
    'read_modes': 'modes.readers', 'sweep': 'studies.sweep',
    'VehicleMonitor': 'monitor.vehicle_monitor'}


def __getattr__(name: str) -> Any:
    if name not in _AT_FIRST_USE:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    return getattr(import_module(f'{__name__}.{_AT_FIRST_USE[name]}'), name)
