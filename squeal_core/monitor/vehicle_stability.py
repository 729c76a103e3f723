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

"""What the brakes of one vehicle share: modes, risks and margins of their model, each by table."""

from dataclasses import replace
from functools import partial
import math
from typing import TypeVar

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.risk.margin import MarginSettings
from squeal_core.risk.risk_table import RiskSettings, RiskTable
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Tolerances
from squeal_core.surrogate.onset import Onset
from squeal_core.surrogate.steps import Steps
from squeal_core.surrogate.table_file import read_table
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from squeal_core.surrogate.workers import Work, Worker

_Result = TypeVar('_Result')

_SHARE = 0.25  # of the table's memory, for that of the margins and for the cells of the risks
_LEAST_CHANGE = 0.1  # of the inputs of a margin; by less a search would be given up by noise
_CLOSE = 0.5  # 1/s around the verdict: modes in it confirm a margin, as the full problem has them
_ROUGH = 10.0  # a margin needs verdicts, which are confirmed: its table may err by more


class VehicleStability:
    """
    The tables of one model; delays are counted in the solves of all brakes.

    Parameters
    ----------
    model : BrakeModel
    settings : MonitorSettings

    Raises
    ------
    TableFileError
        Where the settings name a table that cannot be used.

    """

    def __init__(self, model: BrakeModel, settings: MonitorSettings) -> None:
        self.model = model
        anchors = read_table(settings.table, model) if settings.table else ()
        self.tolerances = Tolerances.of(model, growth=settings.growth_threshold)
        self.modes = TabulatedSolver(model, tolerances=self.tolerances, anchors=anchors)
        self.onset = Onset(self.modes)
        self.margins = TabulatedSolver(model, tolerances=self.tolerances, anchors=anchors)
        self.risks = self._risk_table(settings)
        self._worker = Worker('margins')
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Take other settings; tables stay, but cells of another squeal band."""
        if self.risks.band_hz != band_of(settings):
            self.risks.close()
            self.risks = self._risk_table(settings)
        self._beside = settings.anchor_delay > 0.0
        self.modes.settings = _table_settings(settings)
        self.margins.settings = replace(
            _table_settings(settings), memory=1e6 * _SHARE * settings.table_memory,
            tolerance=_ROUGH * settings.engine_tolerance, audit_every=0, refines=True,
            delay=0)  # its anchors are made where the search waits for them, beside the ticks
        self.risks.settings = RiskSettings(
            memory=1e6 * _SHARE * settings.table_memory,
            delay=_solves(settings, settings.risk_delay))

    def _risk_table(self, settings: MonitorSettings) -> RiskTable:
        """Return an empty one, which takes of a tick what the modes leave of it."""
        return RiskTable(self.model, band_of(settings), tolerances=self.tolerances,
                         allowance=self.modes.allowance)

    def confirming(self, point: OperatingPoint) -> 'Steps[ComplexModes]':
        """Return the modes with those next to the verdict as the full problem has them."""
        found = yield from self.margins.solving(point, refined=_CLOSE)
        if found.source == 'table':
            found = yield partial(complex_modes, self.model, point, tolerances=self.tolerances)
        return found

    def beside(self, steps: 'Steps[_Result]') -> 'Work[_Result]':
        """
        Have a work of the margins done beside the ticks, after those before it.

        Done at once, while the caller waits, where anchors are too.
        """
        return self._worker.begin(steps, beside=self._beside)

    def granted(self, work: 'Work[_Result]') -> bool:
        """Grant it what modes and risks leave of a tick's steps; tell whether it is over."""
        return self._worker.granted(work, self.modes.allowance)

    def close(self) -> None:
        """End the workers; the engines can be used on, and start others."""
        self._worker.close()
        for table in (self.modes, self.margins, self.risks):
            table.close()

    def figures(self) -> dict[str, float]:
        """Return what was done so far, by name."""
        return {**{f'engine_{name}': value for name, value in self.modes.figures().items()},
                **{f'risk_{name}': value for name, value in self.risks.figures().items()},
                **{f'margin_{name}': self.margins.figures()[name]
                   for name in ('tabulated', 'full', 'anchors', 'megabytes')}}


def band_of(settings: MonitorSettings) -> tuple[float, float]:
    """Return the ends of the squeal band [Hz]."""
    return settings.squeal_band_low_hz, settings.squeal_band_high_hz


def _solves(settings: MonitorSettings, seconds: float) -> int:
    """Return how many there are of all brakes in some seconds."""
    return math.ceil(seconds * settings.rate) * len(settings.brakes)


def _table_settings(settings: MonitorSettings) -> SolverSettings:
    return SolverSettings(
        tolerance=settings.engine_tolerance, memory=1e6 * settings.table_memory,
        delay=_solves(settings, settings.anchor_delay),
        audit_every=round(settings.audit_interval))


def margin_settings(model: BrakeModel, settings: MonitorSettings) -> MarginSettings:
    """Look for margins where the model was validated."""
    assert model.caliper is not None
    per_pressure = model.caliper.preload(1.0)
    return MarginSettings(
        change=max(settings.margin_change, _LEAST_CHANGE), rest=0.5 * settings.margin_age,
        friction=(settings.validated_friction_low, settings.validated_friction_high),
        rotor_speed=(settings.validated_rotor_speed_low, settings.validated_rotor_speed_high),
        pressure=(settings.validated_preload_low / per_pressure,
                  settings.validated_preload_high / per_pressure))
