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

"""Evidence against the friction coefficient of a brake, from its neighbours."""

import math

from squeal_core.monitor.inputs.cross_evidence import Contradiction, though, Wheel
from squeal_core.monitor.settings import MonitorSettings

_OTHER_AXLES = 0.75  # of `friction_ratio`: pads of axles differ


def against_friction(wheel: Wheel, settings: MonitorSettings) -> tuple[list[Contradiction], bool]:
    """Return the evidence against a friction, and whether it can be compared at all."""
    own = wheel.own['friction'].mean
    least = settings.release_pressure
    if not settings.friction_ratio or math.isnan(own) or not (
            wheel.own['pressure'].smooth >= least):
        return [], False
    partner = wheel.partner
    result, known = [], False
    if partner is not None and partner.smooth >= least and not math.isnan(partner.friction):
        known = True
        if own < settings.friction_ratio * partner.friction:
            result.append(_friction_contradiction(wheel, partner, settings))
    others = sorted((other for other in wheel.others if other.smooth >= least
                     and not math.isnan(other.friction)), key=lambda other: other.friction)
    if len(others) >= 2:
        known = True
        middle = others[(len(others) - 1) // 2]
        if not result and own < _OTHER_AXLES * settings.friction_ratio * middle.friction:
            result.append(_friction_contradiction(wheel, middle, settings))
    return result, known


def _friction_contradiction(wheel: Wheel, other: Wheel,
                            settings: MonitorSettings) -> Contradiction:
    return Contradiction('low', 2.0 * settings.contradiction_time,
                         though(wheel, other, 'friction'))
