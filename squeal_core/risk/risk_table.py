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
Probability of squeal: that at least one mode of the band grows, under uncertain inputs.

It is summed over the inputs' spread by a fixed rule (`risk.quadrature`) from growth rates
that a cell (`risk.risk_cell`) has of the operating points around. Until there is one the
estimate is of first order, and says so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, partial
import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.cell_table import CellTable, RiskSettings, RiskStatistics, Triple, Wanted
from squeal_core.risk.integration import Estimate, estimate
from squeal_core.risk.probability import (
    first_order_risk,
    Inputs,
    InputUncertainty,
    ModeRisk,
    Risk,
    risks_by_series,
)
from squeal_core.risk.risk_cell import Cell, Family, Spread
from squeal_core.stability.eigensolution import ComplexModes, Mode, Tolerances
from squeal_core.surrogate.workers import Allowance

__all__ = ['RiskSettings', 'RiskStatistics', 'RiskTable']

_CANDIDATES = 3  # modes that the estimate of first order looks at: the least stable ones
_SHOWN = 1e-3  # probability from which on a mode is named


@dataclass(frozen=True)
class _Place:
    """One of several brakes."""

    number: int
    at: Inputs
    modes: ComplexModes

    @property
    def inputs(self) -> Triple:
        return abs(self.at.rotor_speed), self.at.pressure, self.at.friction

    def wanted(self, deviations: InputUncertainty) -> Wanted:
        return Wanted(self.inputs, Spread(min(deviations.friction, 0.5 * self.at.friction),
                                          deviations.pressure, deviations.rotor_speed))


class RiskTable:
    """
    Probabilities of squeal of one model at operating points, each near the last ones.

    Brakes of one model share it. The same calls in the same order give the same numbers.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    band_hz : (2,) floats
        The squeal band.
    settings : RiskSettings, optional
    tolerances : Tolerances, optional
        What counts as oscillation and growth.
    allowance : Allowance, optional
        Steps of a cell's making that a call may be kept by; any, where it is None.

    """

    def __init__(self, model: BrakeModel, band_hz: tuple[float, float],
                 settings: RiskSettings | None = None, *, tolerances: Tolerances | None = None,
                 allowance: Allowance | None = None) -> None:
        self.model, self.band_hz = model, band_hz
        self._tolerances = tolerances or Tolerances.of(model)
        self._family = Family(model)
        self._band = (max(2.0 * math.pi * band_hz[0], self._tolerances.oscillation),
                      2.0 * math.pi * band_hz[1])
        self._table = CellTable(self._family, self._band, settings or RiskSettings(),
                                allowance or Allowance(), self._tolerances.growth)

    @property
    def settings(self) -> RiskSettings:
        """May be replaced at any time; what is in the table stays."""
        return self._table.settings

    @settings.setter
    def settings(self, settings: RiskSettings) -> None:
        self._table.settings = settings

    @property
    def statistics(self) -> RiskStatistics:
        return self._table.statistics

    @property
    def cells(self) -> tuple[Cell, ...]:
        return self._table.cells

    @property
    def nbytes(self) -> int:
        """Size of the cells [bytes]."""
        return self._table.nbytes

    def figures(self) -> dict[str, float]:
        """Return what was done so far and how large the table is, by name."""
        return {**asdict(self.statistics), 'cells': len(self.cells),
                'megabytes': round(1e-6 * self.nbytes, 3)}

    def close(self) -> None:
        """End the worker; the table can be used on, and starts another."""
        self._table.close()

    def assess(self, at: Inputs, modes: ComplexModes, deviations: InputUncertainty) -> Risk:
        """
        Return the probability of squeal.

        Parameters
        ----------
        at : Inputs
            Expected inputs; the contact stiffness has to be the model's at this pressure.
        modes : ComplexModes
            At the operating point of `at`.
        deviations : InputUncertainty
            Standard deviations of the inputs.

        """
        return self.assess_together([(at, modes)], deviations)[0]

    def assess_together(self, brakes: Sequence[tuple[Inputs, ComplexModes]],
                        deviations: InputUncertainty) -> list[Risk]:
        """Return the probability of squeal of several brakes: those of one cell cost less."""
        if deviations.none:
            return [self._certain(modes) for _, modes in brakes]
        every = [_Place(number, *brake) for number, brake in enumerate(brakes)]
        wanted = [place.wanted(deviations) for place in every]
        cells = self._table.cells_for(wanted, deviations.contact_stiffness)
        found: dict[int, Risk] = {}
        inside: dict[tuple[int, Spread], tuple[Cell, list[_Place]]] = {}
        outside: dict[int, list[_Place]] = {}  # by the series of their modes
        for place, want, cell in zip(every, wanted, cells, strict=True):
            if cell is None:
                outside.setdefault(id(place.modes.series), []).append(place)
            else:
                inside.setdefault((id(cell), want.spread), (cell, []))[1].append(place)
        for (_, spread), (cell, places) in inside.items():
            found.update(self._summed(cell, places, spread))
        for places in outside.values():
            found.update(self._first_order(places, deviations))
        return [found[number] for number in range(len(brakes))]

    def _summed(self, cell: Cell, places: Sequence[_Place],
                spread: Spread) -> Iterator[tuple[int, Risk]]:
        """Yield the risks at places in one cell."""
        def found() -> Estimate:  # a risk that is kept stays small
            return estimate(cell, self._family, spread, [p.inputs for p in places],
                            self._band, self._tolerances.growth)

        @cache
        def each() -> FloatArray:
            return found().modes

        def named(row: int, place: _Place) -> tuple[ModeRisk, ...]:
            return _named(each()[row], cell.roots_near(
                self._family.coefficients(*place.inputs)), place.modes)

        probabilities, errors = found().overall
        for row, (place, probability, error) in enumerate(zip(
                places, probabilities.tolist(), errors.tolist(), strict=True)):
            yield place.number, Risk(probability, error, 'summed', partial(named, row, place))

    def _certain(self, modes: ComplexModes) -> Risk:
        growing = modes.flutter_in(*self.band_hz)
        return Risk(float(bool(growing)), 0.0, 'certain', lambda: tuple(
            ModeRisk(m.index, m.frequency_hz, m.growth_rate, 1.0) for m in growing))

    def _first_order(self, places: Sequence[_Place],
                     deviations: InputUncertainty) -> Iterator[tuple[int, Risk]]:
        """Yield the risks at places that have no cell, the modes of all from one series."""
        self.statistics.first_order += len(places)
        brakes = [(place.at, place.modes.least_stable(*self.band_hz, _CANDIDATES))
                  for place in places]
        series = places[0].modes.series
        if series is not None:
            every = risks_by_series(series, self._point, brakes, deviations,
                                    level=self._tolerances.growth)
        else:
            every = [first_order_risk(self.model, self._point, *brake, deviations,
                                      level=self._tolerances.growth).each
                     for brake in brakes]
        for place, each, (_, candidates) in zip(places, every, brakes, strict=True):
            greatest = float(np.max(each, initial=0.0))  # not a number where one is none
            yield place.number, Risk(greatest, math.nan, 'first order',
                                     partial(_listed, each, candidates))

    def _point(self, inputs: Inputs) -> OperatingPoint:
        return self.model.operating_point(
            rotor_speed=inputs.rotor_speed, pressure=inputs.pressure, friction=inputs.friction,
            contact_stiffness=inputs.contact_stiffness)


def _listed(each: Sequence[float], modes: Sequence[Mode]) -> tuple[ModeRisk, ...]:
    ways = sorted(zip(each, modes, strict=False), key=lambda way: -way[0])
    return tuple(ModeRisk(m.index, m.frequency_hz, m.growth_rate, p)
                 for p, m in ways if p >= _SHOWN)


def _named(each: FloatArray, roots: ComplexArray, modes: ComplexModes) -> tuple[ModeRisk, ...]:
    """Return what may grow: of each of the roots, given roughly, the nearest mode's index."""
    shown = np.flatnonzero(each >= _SHOWN)
    shown = shown[np.argsort(-each[shown], kind='stable')]
    places = np.abs(modes.mode_eigenvalues - roots[shown, None]).argmin(axis=1)
    here = modes.mode_eigenvalues[places]
    return tuple(map(ModeRisk, (places + 1).tolist(), (here.imag / (2.0 * np.pi)).tolist(),
                     here.real.tolist(), each[shown].tolist()))
