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

"""Evaluation of margins by look-up along friction, speed and pressure."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
import math
from typing import TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.common.frozen_records import frozen_record
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.friction_scan import FrictionScan
from squeal_core.monitor.margins import (
    Kind,
    least_stable,
    Margin,
    MarginSettings,
    MarginStatistics,
    OtherMargin,
    Parameter,
)
from squeal_core.stability.boundaries import Boundaries, Crossing, NO_MODE
from squeal_core.stability.boundary_search import BoundarySearch
from squeal_core.stability.eigensolution import complex_modes, Mode, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_domain import coordinates

Growth: TypeAlias = Callable[[FloatArray, Kind], ComplexArray]
"""
Eigenvalues [1/s] (P,) of the least stable mode of a kind at rows (P, 3) of rotor speed [rad/s],
brake pressure [Pa] and friction: `NO_MODE` where there is none, NaN where it is not known.
"""
NO_TABLE = 'no table; compute one by `squeal tabulate` and name it in the setting table'

_COLUMNS: dict[Parameter, int] = {'rotor_speed': 0, 'pressure': 1, 'friction': 2}
_STEP = 0.02  # of friction, from one value of a walk to the next
_RATIO = 1.2  # of speed and pressure, likewise
# of a bracket: of friction [-], of speed and pressure as a fraction; not what trials make of a
# step (1e-3), so that rounding does not decide whether it is narrow enough
_WIDTH = 1.2e-3
_TRIALS = 8  # that narrow a bracket at once: look-ups cost by the call rather than by the value
# trials about an estimate of friction by the scan: nine of ten boundaries are between the inner
# ones, which are as close as a bracket has to be
_ABOUT = np.array([-0.02, -1.65e-3, -0.55e-3, 0.55e-3, 1.65e-3, 0.02])


class MarginEvaluator:
    """
    Margins of brakes of one model, by look-up along the parameters; no memory but counts.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : MarginSettings
    tolerances : Tolerances
        What counts as oscillation and as unstable.
    growth : callable, optional
        Look-up in the table, see `Growth`; None: no table.
    scan : FrictionScan, optional
        Where to look first along friction for the margin of squeal.

    """

    def __init__(self, model: BrakeModel, settings: MarginSettings, tolerances: Tolerances, *,
                 growth: Growth | None = None, scan: FrictionScan | None = None) -> None:
        self.model, self.settings, self.tolerances = model, settings, tolerances
        self.statistics = MarginStatistics()
        self._growth, self._scan = growth, scan

    def friction_margins(self, conditions: Sequence[SlidingConditions],
                         worst: Sequence[Mode | None]) -> list[Margin]:
        """
        Return the friction margins of brakes, of one tick or of many.

        Towards less friction where the brake is unstable, towards more where it is stable.

        Parameters
        ----------
        conditions : sequence of SlidingConditions
            Of the brakes.
        worst : sequence of Mode or None
            Least stable mode of the band at these conditions.

        """
        if self._growth is None or not conditions:
            return [Margin(parameter='friction', kind='squeal', present=at.friction,
                           reason=NO_TABLE) for at in conditions]
        here = np.array([mode.eigenvalue if mode else NO_MODE for mode in worst])
        return self._along_friction(_rows(conditions), here, 'squeal')

    def other_margin(self, conditions: SlidingConditions, name: OtherMargin) -> Margin:
        """
        Return the margin along 'rotor_speed' or 'pressure', or of 'groan' or 'divergence'.

        Groan and divergence are those along friction. Each costs a quarter of a full solution, or
        so, by the table, which has to be there.
        """
        assert self._growth is not None
        row = _rows([conditions])
        if name == 'rotor_speed' or name == 'pressure':
            return self._along(row, name)
        return self._along_friction(row, self._growth(row, name), name)[0]

    def confirm(self, margin: Margin, conditions: SlidingConditions) -> Margin:
        """
        Compare the table with a full solution at the critical value of a friction margin.

        Returns
        -------
        Margin
            Confirmed; or without a critical value, saying why.

        """
        if math.isnan(margin.critical):
            return margin
        point = self.model.operating_point(rotor_speed=conditions.rotor_speed,
                                           pressure=conditions.pressure, friction=margin.critical)
        try:
            modes = complex_modes(self.model, point, tolerances=self.tolerances)
        except np.linalg.LinAlgError as error:
            return replace(margin, critical=math.nan,
                           reason=f'{margin.reason}: not confirmed, no eigensolution ({error})')
        full = least_stable(modes.mode_eigenvalues[None], margin.kind, self.settings.band_hz,
                            self.tolerances)[0]
        assert self._growth is not None
        result = self._growth(_rows([replace(conditions, friction=margin.critical)]), margin.kind)
        if abs(full.real - result[0].real) <= self.settings.error:
            self.statistics.confirmed += 1
            return replace(margin, confirmed=True)
        self.statistics.not_confirmed += 1
        return replace(margin, critical=math.nan, reason=(
            f'{margin.reason}: not confirmed, a full solution has a growth rate of '
            f'{full.real:+.3g} 1/s there, not {result[0].real:+.3g} 1/s'))

    def _along_friction(self, rows: FloatArray, here: ComplexArray, kind: Kind) -> list[Margin]:
        start, side = rows[:, 2:], np.where(here.real[:, None] > self.tolerances.growth, -1.0, 1.0)
        ends = np.where(side < 0.0, *self.settings.friction)

        def trials() -> Iterator[FloatArray]:
            if self._scan is not None and kind == 'squeal':
                estimate = self._scan.nearest(rows, side)[:, None]
                values = estimate + side * _ABOUT
                values = np.where(side * values > side * start, values, start)
                values = np.where(side * values < side * ends, values, ends)
                yield np.where(np.isfinite(estimate), values, start)
            yield _walks(start, ends)

        result = self._search(rows, here, trials(), 'friction', kind)
        return [_margin(crossing, result.level, 'friction', kind, present)
                for crossing, present in zip(result.crossings(), rows[:, 2].tolist(), strict=True)]

    def _along(self, row: FloatArray, parameter: Parameter) -> Margin:
        """Return the nearer one of the margins of squeal towards less and towards more."""
        assert self._growth is not None
        present = float(row[0, _COLUMNS[parameter]])
        walks = [_geometric(present, end) for end in getattr(self.settings, parameter)]
        length = max(walk.size for walk in walks)
        padded = np.array([np.pad(walk, (0, length - walk.size), 'edge') for walk in walks])
        rows, here = np.repeat(row, 2, axis=0), np.repeat(self._growth(row, 'squeal'), 2)
        result = self._search(rows, here, [padded], parameter, 'squeal')
        both = [_margin(crossing, result.level, parameter, 'squeal', present)
                for crossing in result.crossings()]
        known = [margin for margin in both if not math.isnan(margin.critical)]
        return min(known, key=lambda margin: abs(margin.value), default=replace(
            both[0], reason='; '.join(margin.reason for margin in both)))

    def _search(self, rows: FloatArray, here: ComplexArray, trials: Iterable[FloatArray],
                parameter: Parameter, kind: Kind) -> Boundaries:
        growth, column = self._growth, _COLUMNS[parameter]
        assert growth is not None
        scale = 1.0 if parameter == 'friction' else float(rows[0, column])

        def evaluate(asking: IndexArray, values: FloatArray) -> ComplexArray:
            conditions = np.repeat(rows[asking], values.shape[1], axis=0)
            conditions[:, column] = values.ravel()
            return growth(conditions, kind).reshape(values.shape)

        search = BoundarySearch(parameter=parameter, level=self.tolerances.growth,
                                width=_WIDTH * scale, trials=_TRIALS)
        return search(rows[:, column], here, trials, evaluate)


def table_growth(table: ExpansionTable, model: BrakeModel, tolerances: Tolerances,
                 band_hz: tuple[float, float], rows: FloatArray, kind: Kind) -> ComplexArray:
    """Return eigenvalues as `Growth`, by look-up, also where a verdict is within the error."""
    x = coordinates(rows * (1.0, model.contact_pressure(1.0), 1.0))
    eigenvalues, answered = table.eigenvalues(x, tolerances)
    result = least_stable(eigenvalues, kind, band_hz, tolerances)
    result[~answered] = complex(math.nan, math.nan)
    return result


def _margin(crossing: Crossing, level: float, parameter: Parameter, kind: Kind,
            present: float) -> Margin:
    critical, growth_rate = crossing.value, level
    if math.isnan(critical):
        growth_rate = math.nan
    elif not crossing.converged:  # by a jump: the unstable end of the bracket
        growth_rate, critical = max(zip(crossing.growth_rates, crossing.bracket, strict=True))
    return frozen_record(
        Margin, parameter=parameter, kind=kind, present=present, critical=critical,
        growth_rate=growth_rate, frequency_hz=crossing.frequency_hz, reason=crossing.reason)


def _rows(conditions: Sequence[SlidingConditions]) -> FloatArray:
    return np.array([(abs(at.rotor_speed), at.pressure, at.friction) for at in conditions])


def _walks(start: FloatArray, ends: FloatArray) -> FloatArray:
    """Return values (P, n) in steps of friction from starts (P, 1) to ends, which are repeated."""
    far = ends - start
    count = max(math.ceil(float(np.abs(far).max()) / _STEP - 1e-9), 1)
    steps = _STEP * np.arange(1.0, count + 1.0)
    return np.where(steps < np.abs(far), start + np.sign(far) * steps, ends)


def _geometric(start: float, end: float) -> FloatArray:
    """Return values after a start to an end, in equal ratios; none where it is beyond the end."""
    count = max(math.ceil(abs(math.log(end / start)) / math.log(_RATIO)), 1)
    return np.geomspace(start, end, count + 1)[1:]
