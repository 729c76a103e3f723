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

"""Stability of all brakes of one vehicle, a function of model, table, settings and conditions."""

from collections.abc import Sequence

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.risk.evaluator import RiskEvaluator
from squeal_core.risk.probability import InputUncertainty
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.table_file import read_table
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver


class VehicleStability:
    """
    Evaluates brakes of one model.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : MonitorSettings

    Raises
    ------
    TableFileError
        Where the settings name a table that cannot be used.

    """

    def __init__(self, model: BrakeModel, settings: MonitorSettings) -> None:
        self.model = model
        self.tolerances = Tolerances.of(model, growth=settings.growth_threshold)
        expansions = read_table(settings.table, model) if settings.table else ()
        self.solver = TabulatedSolver(model, tolerances=self.tolerances, anchors=expansions)
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Take other settings; counts and the table stay."""
        self._band = band_of(settings)
        self.solver.settings = SolverSettings(
            tolerance=settings.engine_tolerance, audit_every=round(settings.audit_interval))
        self._risks = RiskEvaluator(self.model, self._band, _deviations(settings),
                                    self.tolerances)

    def evaluate(self, conditions: Sequence[SlidingConditions]
                 ) -> list[BrakeStability | np.linalg.LinAlgError]:
        """
        Return the stability of brakes, or why a brake has none.

        Parameters
        ----------
        conditions : sequence of SlidingConditions
            Of brakes of one tick, or of many.

        """
        return [self._evaluated(at) for at in conditions]

    def _evaluated(self, at: SlidingConditions) -> BrakeStability | np.linalg.LinAlgError:
        point = self.model.operating_point(**vars(at))
        try:
            modes = self.solver.complex_modes(point)
        except np.linalg.LinAlgError as error:
            return error
        return BrakeStability(point=point, modes=modes, worst=modes.worst_in(*self._band),
                              risk=self._risks.assess(at, modes))

    def figures(self) -> dict[str, float]:
        """Return the counts of answers since the start, by name."""
        return {f'solver_{name}': value for name, value in self.solver.figures().items()}


def band_of(settings: MonitorSettings) -> tuple[float, float]:
    """Return the ends of the squeal band [Hz]."""
    return settings.squeal_band_low_hz, settings.squeal_band_high_hz


def _deviations(settings: MonitorSettings) -> InputUncertainty:
    return InputUncertainty(
        friction=settings.friction_deviation, pressure=settings.pressure_deviation,
        rotor_speed=settings.rotor_speed_deviation,
        contact_stiffness=settings.contact_stiffness_deviation)
