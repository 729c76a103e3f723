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

"""Evaluation of prepared ticks: stability of each brake, and the risk of its application."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.assessment import (
    Assessment,
    AssessmentContext,
    explained,
    from_stability,
    PreparedTick,
)
from squeal_core.monitor.brake_risk import BrakeRisk
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_risk import VehicleRisk
from squeal_core.monitor.vehicle_stability import Evaluated, VehicleStability


class VehicleEvaluator:
    """
    Makes assessments of the prepared ticks of a vehicle, in the order of time.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : MonitorSettings

    Raises
    ------
    TableFileError
        Where the settings name a table, an emulator or a calibration that cannot be used.

    """

    def __init__(self, model: BrakeModel, settings: MonitorSettings) -> None:
        self.stability = VehicleStability(model, settings)
        self.risk = VehicleRisk(model, settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings; what is known of brake applications stays."""
        self.stability.update_settings(settings)
        self.risk.update_settings(settings)

    def reset(self) -> None:
        """Forget all brake applications."""
        self.risk.reset()

    def warm_up(self, brakes: Sequence[str]) -> None:
        """Evaluate brakes once, uncounted, so that the first tick takes no longer than others."""
        result = self.stability.warm_up(len(brakes))
        self.risk.warm_up(brakes, result)

    def complete(self, ticks: Sequence[PreparedTick]) -> list[tuple[Assessment, ...]]:
        """
        Return the assessments of ticks; many at once cost less than each alone.

        Parameters
        ----------
        ticks : sequence of PreparedTick
            Those that follow the ticks before: a risk depends on its brake application.

        """
        contexts = [one for tick in ticks for one in tick if isinstance(one, AssessmentContext)]
        result = self.stability.evaluate([one.conditions for one in contexts],
                                         [one.confirm for one in contexts])
        risks, stabilities = iter(self.risk.evaluate(ticks, result)), iter(result)
        return [tuple(_assessment(one, next(risks), stabilities) for one in tick)
                for tick in ticks]

    @property
    def notes(self) -> tuple[str, ...]:
        """Return lines for a log: precomputed data, and the basis of the risk."""
        return tuple(filter(None, (self.stability.note, self.risk.note)))

    def figures(self) -> dict[str, float]:
        """Return the counts of answers since the start, by name."""
        return {**self.stability.figures(), **self.risk.figures()}


def _assessment(one: Assessment | AssessmentContext, risk: BrakeRisk | None,
                stabilities: Iterator[Evaluated]) -> Assessment:
    if isinstance(one, AssessmentContext):
        return explained(from_stability(one, next(stabilities), risk))
    if risk is None:
        return one
    # result of the whole application, once at its release
    return replace(one, build_up=risk.result.build_up, application_risk=risk.result.squeal_risk)
