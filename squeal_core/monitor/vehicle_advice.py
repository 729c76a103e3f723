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
Advice for the brakes of a vehicle, computed on request.

Advice, never a command: no safety function may rest on it.
"""

from collections.abc import Sequence
from functools import partial
import math

from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.advice import AdviceSettings, PressureAdvice, PressureAdviser
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.axles import axle_partners
from squeal_core.monitor.force_split import NOTHING_KNOWN, SplitAdvice, SplitAdviser, SplitSteps
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.risk.holding import nominal_least_stable
from squeal_core.risk.squeal_risk import SquealRisk

_DEVIATIONS = 2.0  # of the emulator's error


class VehicleAdvice:
    """
    Advises on the brakes of one vehicle, by the table of their model, or by its emulator.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : MonitorSettings
    stability : VehicleStability
        With the table, where there is one.
    risk : SquealRisk, optional
        Of the model.

    """

    def __init__(self, model: BrakeModel, settings: MonitorSettings, stability: VehicleStability,
                 risk: SquealRisk | None) -> None:
        self._front = front_brakes([brake.name for brake in settings.brakes], settings.axles)
        table = stability.solver.table
        limits = AdviceSettings(
            band_hz=stability.bounds.band_hz, pressure=stability.bounds.pressure,
            error=stability.bounds.error if table else (
                _DEVIATIONS * risk.emulator.error.rms if risk else 0.0),
            hold=settings.advice_hold, rear_force=settings.rear_force_ratio,
            front_share=(settings.advice_front_share_low, settings.advice_front_share_high))
        look_up = stability.least_stable if table else (
            partial(nominal_least_stable, risk, model) if risk else None)
        self._pressures = None if look_up is None else PressureAdviser(
            model, limits, stability.tolerances, look_up=look_up, risk=risk)
        self._split = SplitAdviser(model, limits, stability.tolerances, look_up=look_up, risk=risk)

    def pressures(self, result: Assessment) -> PressureAdvice:
        """Return the quiet pressures of a brake at its assessed conditions."""
        if result.state != 'steady':
            return PressureAdvice(present=math.nan, reason=f'{result.state}: {result.reason}')
        at = _conditions(result)
        if self._pressures is None:
            return PressureAdvice(present=at.pressure, reason=NOTHING_KNOWN)
        return self._pressures(at)

    def split(self, result: Sequence[Assessment]) -> SplitSteps:
        """Return the split of the brake force, in steps of some milliseconds."""
        idle = next((one for one in result if one.state != 'steady'), None)
        if not any(self._front) or all(self._front):
            return SplitAdvice(reason='the brakes are not those of two axles (setting axles)')
        if idle is not None:
            return SplitAdvice(reason=f'{idle.brake} {idle.state}: {idle.reason}')
        return (yield from self._split.steps([*map(_conditions, result)], self._front))


def _conditions(result: Assessment) -> SlidingConditions:
    return SlidingConditions(rotor_speed=result.inputs['rotor_speed'].value,
                             pressure=result.inputs['pressure'].value, friction=result.friction)


def front_brakes(brakes: Sequence[str], axles: Sequence[str]) -> tuple[bool, ...]:
    """
    Return whether each brake is on the front axle, the first brake's; none without two axles.

    Brakes without a partner on the other side are an axle each.
    """
    partners = axle_partners(brakes, axles)
    groups = [frozenset((name, partners.get(name, name))) for name in brakes]
    return tuple(len(set(groups)) == 2 and group == groups[0] for group in groups)
