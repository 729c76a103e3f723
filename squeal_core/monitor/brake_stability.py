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

"""Result of evaluating a brake that slides under load."""

from dataclasses import dataclass

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.monitor.margins import Margins
from squeal_core.stability.eigensolution import ComplexModes, Mode


@dataclass(frozen=True, kw_only=True)
class BrakeStability:
    """
    Stability of a brake at one operating point.

    Parameters
    ----------
    point : OperatingPoint
    modes : ComplexModes
    worst : Mode or None
        The least stable mode that oscillates within the squeal band.
    margins : Margins

    """

    point: OperatingPoint
    modes: ComplexModes
    worst: Mode | None
    margins: Margins
