"""Probability of squeal: that at least one mode of the band grows, under uncertain inputs.

It is summed over the inputs' spread by a fixed rule (`squeal_core.risk_rule`) from growth rates
that a cell (`squeal_core.risk_cell`) has of the operating points around. Cells are made where the
brake is driven, beside the work, and kept. Until one is made the estimate is of first order, and
says so.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass
from functools import partial
import math
from typing import TypeAlias

import numpy as np

from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.brake_model import BrakeModel
from squeal_core.operating_point import OperatingPoint
from squeal_core.risk import Deviations, first_order_risk, Inputs, ModeRisk, Risk, risks_by_series
from squeal_core.risk_cell import Cell, Family, Spread
from squeal_core.risk_cell_making import cell_at
from squeal_core.risk_estimate import Estimate, estimate
from squeal_core.risk_rule import Rule, rule_for
from squeal_core.stability import ComplexModes, Tolerances
from squeal_core.workers import Worker

_Triple: TypeAlias = tuple[float, float, float]  # speed [rad/s], pressure [Pa], friction

_DEGREE = 3  # of the cells' series
_CANDIDATES = 3  # modes that the estimate of first order looks at: the least stable ones
_EDGE = 0.75  # part of a cell from which on the next one is asked for
_LADDER = 1.5  # cells are made for deviations of friction in steps of this ratio
_SHOWN = 1e-3  # probability from which on a mode is named


@dataclass(frozen=True, kw_only=True)
class RiskSettings:
    """How cells are made and kept.

    Parameters
    ----------
    memory : float
        Limit of the cells' size [bytes]; the least recently used go.
    delay : int
        Assessments between asking for a cell and its first use; 0: made at once, while the caller
        waits. A cell takes about a second of one core.
    """

    memory: float = 50e6
    delay: int = 0


@dataclass
class RiskStatistics:
    """What was done so far."""

    summed: int = 0
    first_order: int = 0
    made: int = 0
    dropped: int = 0
    failed: int = 0


@dataclass
class _Entry:
    cell: Cell
    used: int


@dataclass
class _Request:
    due: int
    cell: 'Future[Cell]'


@dataclass(frozen=True)
class _Place:
    """One of several brakes in a cell."""

    number: int
    cell: Cell
    inputs: _Triple
    modes: ComplexModes


class RiskTable:
    """Probabilities of squeal of one model at operating points, each near the last ones.

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
    """

    def __init__(self, model: BrakeModel, band_hz: tuple[float, float],
                 settings: RiskSettings | None = None, *,
                 tolerances: Tolerances | None = None) -> None:
        self.model, self.band_hz = model, band_hz
        self.settings = settings or RiskSettings()
        self.statistics = RiskStatistics()
        self._tolerances = tolerances or Tolerances()
        self._family = Family(model)
        self._band = (max(2.0 * math.pi * band_hz[0], self._tolerances.oscillation),
                      2.0 * math.pi * band_hz[1])
        self._rule: Rule = rule_for(0.0, _DEGREE)
        self._entries: list[_Entry] = []
        self._index()
        self._request: _Request | None = None
        self._worker = Worker('risk')
        self._calls = 0

    @property
    def cells(self) -> tuple[Cell, ...]:
        return tuple(entry.cell for entry in self._entries)

    @property
    def nbytes(self) -> int:
        """Size of the cells [bytes]."""
        return sum(entry.cell.nbytes for entry in self._entries)

    def figures(self) -> dict[str, float]:
        """Return what was done so far and how large the table is, by name."""
        return {**asdict(self.statistics), 'cells': len(self._entries),
                'megabytes': round(1e-6 * self.nbytes, 3)}

    def close(self) -> None:
        """End the worker; the table can be used on, and starts another."""
        self._worker.close()
        self._request = None

    def assess(self, at: Inputs, modes: ComplexModes, deviations: Deviations) -> Risk:
        """Return the probability of squeal.

        Parameters
        ----------
        at : Inputs
            Expected inputs; the contact stiffness has to be the model's at this pressure.
        modes : ComplexModes
            At the operating point of `at`.
        deviations : Deviations
        """
        return self.assess_together([(at, modes)], deviations)[0]

    def assess_together(self, brakes: Sequence[tuple[Inputs, ComplexModes]],
                        deviations: Deviations) -> list[Risk]:
        """Return the probability of squeal of several brakes: those of one cell cost less."""
        found: dict[int, Risk] = {}
        by_cell: dict[tuple[int, Spread], list[_Place]] = {}
        for number, (at, modes) in enumerate(brakes):
            self._calls += 1
            if deviations.none:
                found[number] = self._certain(modes)
                continue
            spread = Spread(min(deviations.friction, 0.5 * at.friction), deviations.pressure,
                            deviations.rotor_speed)
            inputs = (abs(at.rotor_speed), at.pressure, at.friction)
            entry = self._entry_for(inputs, spread, deviations.contact_stiffness)
            if entry is None:
                found[number] = self._first_order(at, modes, deviations)
            else:
                by_cell.setdefault((id(entry), spread), []).append(
                    _Place(number, entry.cell, inputs, modes))
        for (_, spread), places in by_cell.items():
            found.update(self._summed(places, spread))
        return [found[number] for number in range(len(brakes))]

    def _entry_for(self, inputs: _Triple, spread: Spread,
                   stiffness_deviation: float) -> _Entry | None:
        """Return an entry in whose cell the inputs lie; one is asked for near an end or beyond."""
        self._follow(stiffness_deviation)
        self._adopt()
        entry, depth = self._nearest(inputs, spread)
        if entry is None or (depth > _EDGE and self.settings.delay):
            self._ask(inputs, spread)
            if entry is None and self.settings.delay == 0:
                self._adopt()
                entry, depth = self._nearest(inputs, spread)
        if entry is not None:
            entry.used = self._calls
            self.statistics.summed += 1
        return entry

    def _summed(self, places: Sequence[_Place], spread: Spread) -> Iterator[tuple[int, Risk]]:
        """Yield the risks at places in one cell."""
        def found(these: Sequence[_Place]) -> Estimate:
            return estimate(these[0].cell, self._family, spread, [p.inputs for p in these],
                            self._band, self._tolerances.growth)

        def named(place: _Place) -> tuple[ModeRisk, ...]:  # a risk that is kept stays small
            return _named(found([place]).modes[0], place.cell.roots_near(
                self._family.coefficients(*place.inputs)), place.modes)

        probabilities, errors = found(places).overall
        for place, probability, error in zip(places, probabilities.tolist(), errors.tolist(),
                                             strict=True):
            yield place.number, Risk(probability, error, 'summed', partial(named, place))

    def _certain(self, modes: ComplexModes) -> Risk:
        growing = modes.flutter_in(*self.band_hz)
        return Risk(float(bool(growing)), 0.0, 'certain', lambda: tuple(
            ModeRisk(m.index, m.frequency_hz, m.growth_rate, 1.0) for m in growing))

    def _first_order(self, at: Inputs, modes: ComplexModes, deviations: Deviations) -> Risk:
        self.statistics.first_order += 1
        candidates = modes.least_stable(*self.band_hz, _CANDIDATES)
        if modes.series is not None:
            each = risks_by_series(modes.series, self._point, at, candidates, deviations)
            greatest = float(np.max(each, initial=0.0))  # not a number where one is none
        else:
            found = first_order_risk(self.model, self._point, at, candidates, deviations)
            each, greatest = found.each, found.probability
        ways = sorted(zip(each, candidates, strict=False), key=lambda way: -way[0])
        return Risk(greatest, math.nan, 'first order', lambda: tuple(
            ModeRisk(m.index, m.frequency_hz, m.growth_rate, p) for p, m in ways if p >= _SHOWN))

    def _point(self, inputs: Inputs) -> OperatingPoint:
        return self.model.operating_point(
            rotor_speed=inputs.rotor_speed, pressure=inputs.pressure, friction=inputs.friction,
            contact_stiffness=inputs.contact_stiffness)

    def _follow(self, deviation: float) -> None:
        """Begin anew where the deviation of the contact stiffness is another."""
        if deviation != self._rule.stiffness_deviation:
            self._rule = rule_for(deviation, _DEGREE)
            self._entries, self._request = [], None
            self._index()

    def _nearest(self, inputs: _Triple,
                 spread: Spread) -> tuple[_Entry | None, float]:
        """Return the entry in whose cell the inputs lie the deepest: 0 in the middle, 1 at an end.
        """
        if not self._entries:
            return None, math.inf
        depths = np.abs((np.array([inputs]).T - self._middles) / self._halves).max(axis=0)
        off = np.array([(spread.friction, spread.pressure, spread.rotor_speed)]).T
        depths[(off > self._spreads).any(axis=0)] = np.inf
        place = int(depths.argmin())
        depth = float(depths[place])
        return (self._entries[place], depth) if depth <= 1.0 else (None, depth)

    def _index(self) -> None:
        """Lay out the cells' places for the search (3, cells)."""
        cells = self.cells
        low, high = (np.array([getattr(c.box, end) for c in cells]).reshape(-1, 3).T
                     for end in ('low', 'high'))
        self._middles, self._halves = 0.5 * (low + high), 0.5 * (high - low)
        self._spreads = np.array([(c.spread.friction, c.spread.pressure, c.spread.rotor_speed)
                                  for c in cells]).reshape(-1, 3).T

    def _ask(self, inputs: _Triple, spread: Spread) -> None:
        """Have a cell made here, unless one is being made already."""
        if self._request is not None:
            return
        wide = Spread(_next_step(spread.friction), spread.pressure, spread.rotor_speed)
        future = self._worker.submit(self.settings.delay > 0, cell_at, self._family, inputs, wide,
                                     self._rule, self._band)
        self._request = _Request(self._calls + self.settings.delay, future)

    def _adopt(self) -> None:
        """Take the cell asked for into use, when its time has come."""
        request = self._request
        if request is None or self._calls < request.due:
            return
        self._request = None
        try:
            cell = request.cell.result()
        except np.linalg.LinAlgError:  # no eigensolution: the vectors do not span the space
            self.statistics.failed += 1
            return
        self._entries.append(_Entry(cell, self._calls))
        self.statistics.made += 1
        while self.nbytes > self.settings.memory and len(self._entries) > 1:
            oldest = min(self._entries[:-1], key=lambda entry: entry.used)
            self._entries = [entry for entry in self._entries if entry is not oldest]
            self.statistics.dropped += 1
        self._index()


def _named(each: FloatArray, roots: ComplexArray, modes: ComplexModes) -> tuple[ModeRisk, ...]:
    """Return what may grow: of each of the roots, given roughly, the nearest mode's index."""
    shown = np.flatnonzero(each >= _SHOWN)
    shown = shown[np.argsort(-each[shown], kind='stable')]
    places = np.abs(modes.roots - roots[shown, None]).argmin(axis=1)
    here = modes.roots[places]
    return tuple(map(ModeRisk, (places + 1).tolist(), (here.imag / (2.0 * np.pi)).tolist(),
                     here.real.tolist(), each[shown].tolist()))


def _next_step(deviation: float) -> float:
    """Return the least deviation of the ladder that is not smaller."""
    if deviation == 0.0:
        return 0.0
    step = math.ceil(math.log(deviation / 0.02) / math.log(_LADDER) - 1e-9)
    return max(deviation, 0.02 * _LADDER**step)
