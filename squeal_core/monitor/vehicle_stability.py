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
from dataclasses import asdict
from functools import partial
from typing import TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint, SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.common.frozen_records import frozen_record
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.friction_scan import FrictionScan
from squeal_core.monitor.margin_evaluator import MarginEvaluator, table_growth
from squeal_core.monitor.margins import Kind, Margin, Margins, MarginSettings
from squeal_core.monitor.settings import band_of, MonitorSettings
from squeal_core.stability.eigensolution import ComplexModes, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_domain import places_of
from squeal_core.surrogate.table_file import find_table, read_table
from squeal_core.surrogate.tabulated_solver import SolverStatistics, TabulatedSolver

Evaluated: TypeAlias = BrakeStability | np.linalg.LinAlgError
NO_TABLE = 'none'  # value of the setting `table`


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
        self.solver = TabulatedSolver(model, _table(model, settings), limits=self.tolerances)
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings; the table and the counts of its answers stay."""
        self._band = band_of(settings)
        self.solver.band, self.solver.audit_every = self._band, round(settings.audit_interval)
        margins, known = _margin_settings(self.model, settings, self.solver.table), (
            self.solver.table is not None)
        self._margins = MarginEvaluator(
            self.model, margins, self.tolerances, growth=self._growth if known else None,
            scan=FrictionScan(lambda rows: self._growth(rows, 'squeal').real,
                              self.tolerances.growth, friction=margins.friction,
                              rotor_speed=margins.rotor_speed, pressure=margins.pressure)
            if known else None)

    def warm_up(self, brakes: int) -> list[Evaluated]:
        """Evaluate brakes once, uncounted."""
        bounds = self._margins.settings
        at = SlidingConditions(rotor_speed=0.5 * bounds.rotor_speed[1],
                               pressure=0.5 * bounds.pressure[1],
                               friction=0.5 * bounds.friction[1])
        result = self.evaluate([at] * brakes, [False] * brakes)
        self.solver.statistics = SolverStatistics()
        return result

    @property
    def note(self) -> str:
        """Return a line for a log about precomputed data."""
        table = self.solver.table
        if table is None:
            return ('no table: each assessment of a brake is a full solution, and there are no '
                    'margins; compute a table by `squeal tabulate`')
        return f'table of {len(table.cells)} cells; other points are solved in full'

    def evaluate(self, conditions: Sequence[SlidingConditions],
                 confirm: Sequence[bool]) -> list[Evaluated]:
        """
        Return the stability of brakes, or why a brake has none.

        Parameters
        ----------
        conditions : sequence of SlidingConditions
            Of brakes of one tick, or of many.
        confirm : sequence of bool
            Whose friction margin a full solution confirms.

        """
        if not conditions:
            return []
        points = [self.model.operating_point(**vars(at)) for at in conditions]
        modes = self.solver.solve_all(points, self._places(conditions, points))
        solved = [one for one in zip(conditions, points, modes, confirm, strict=True)
                  if isinstance(one[2], ComplexModes)]
        result = iter(self._evaluated(*zip(*solved, strict=True)) if solved else ())
        return [next(result) if isinstance(one, ComplexModes) else one for one in modes]

    def _places(self, conditions: Sequence[SlidingConditions],
                points: Sequence[OperatingPoint]) -> FloatArray | None:
        """Return the places of points in the table if these follow the model's laws, as usual."""
        table = self.solver.table
        if table is None or table.domain.stiffness_factor != 1.0 or any(
                at.contact_stiffness is not None for at in conditions):
            return None
        return places_of(points)

    def _evaluated(self, conditions: Sequence[SlidingConditions],
                   points: Sequence[OperatingPoint], modes: Sequence[ComplexModes],
                   confirm: Sequence[bool]) -> list[BrakeStability]:
        worst = [result.worst_in(*self._band) for result in modes]
        margins = self._margins.friction_margins(conditions, worst)
        return [frozen_record(BrakeStability, point=point, modes=result, worst=mode, margins=(
            frozen_record(Margins, friction=self._confirmed(margin, at) if due else margin,
                          compute_other=None if self.solver.table is None else partial(
                              self._margins.other_margin, at))))
                for at, point, result, mode, margin, due in zip(
                    conditions, points, modes, worst, margins, confirm, strict=True)]

    def _confirmed(self, margin: Margin, at: SlidingConditions) -> Margin:
        """Compare a margin with a full solution; the table's cell that is wrong goes."""
        result = self._margins.confirm(margin, at)
        if np.isfinite(margin.critical) and not result.confirmed:
            self.solver.distrust(self.model.operating_point(
                rotor_speed=at.rotor_speed, pressure=at.pressure, friction=margin.critical))
        return result

    def _growth(self, rows: FloatArray, kind: Kind) -> ComplexArray:
        assert self.solver.table is not None
        return table_growth(self.solver.table, self.model, self.tolerances, self._band, rows, kind)

    @property
    def bounds(self) -> MarginSettings:
        """Return the bounds in which model and table are valid, and the table's error."""
        return self._margins.settings

    def least_stable(self, at: SlidingConditions, pressures: FloatArray) -> ComplexArray:
        """Return the least stable mode in the band by the table, as `advice.LeastStableAt`."""
        rows = np.full((pressures.size, 3), (abs(at.rotor_speed), 0.0, at.friction))
        rows[:, 1] = pressures
        return self._growth(rows, 'squeal')

    def figures(self) -> dict[str, float]:
        """Return the counts of answers since the start, by name."""
        return {**{f'solver_{name}': value for name, value in self.solver.figures().items()},
                **{f'margins_{name}': value
                   for name, value in asdict(self._margins.statistics).items()}}


def _table(model: BrakeModel, settings: MonitorSettings) -> ExpansionTable | None:
    if settings.table == NO_TABLE:
        return None
    if settings.table:
        return read_table(settings.table, model)
    result = find_table(model)
    return result and result[1]


def _margin_settings(model: BrakeModel, settings: MonitorSettings,
                     table: ExpansionTable | None) -> MarginSettings:
    """Return the bounds of margins in which the model was validated and the table answers."""
    assert model.caliper is not None
    per_pressure, per_preload = model.contact_pressure(1.0), model.caliper.preload(1.0)
    bounds = {'friction': (0.0, settings.validated_friction_high),
              'rotor_speed': (settings.validated_rotor_speed_low,
                              settings.validated_rotor_speed_high),
              'pressure': (settings.validated_preload_low / per_preload,
                           settings.validated_preload_high / per_preload)}
    if table is not None:
        domain = table.domain
        ends = {'friction': domain.friction, 'rotor_speed': domain.rotor_speed, 'pressure': (
            domain.contact_pressure[0] / per_pressure, domain.contact_pressure[1] / per_pressure)}
        bounds = {name: (max(low, ends[name][0]), min(high, ends[name][1]))
                  for name, (low, high) in bounds.items()}
    return MarginSettings(band_hz=band_of(settings), **bounds,
                          error=0.0 if table is None else table.tolerances.growth)
