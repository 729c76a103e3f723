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

"""Cells laid out by place: made where the brakes are driven, beside the work, and kept."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
import math
from typing import NamedTuple, TypeAlias

import numpy as np
from squeal_core.risk.quadrature import rule_for, TensorQuadrature
from squeal_core.risk.risk_cell import box_around, Cell, Family, Spread
from squeal_core.risk.risk_cell_making import cell_steps
from squeal_core.surrogate.steps import completed, Steps
from squeal_core.surrogate.workers import Allowance, Work, Worker

Triple: TypeAlias = tuple[float, float, float]  # speed [rad/s], pressure [Pa], friction

_DEGREE = 3  # of the cells' series
_EDGE = 0.75  # part of a cell from which on the next one is asked for
_STEPS = 7  # of a cell's making, at each contact stiffness
_LADDER = 1.5  # cells are made for deviations of friction in steps of this ratio


class Wanted(NamedTuple):
    """The inputs for which a cell is wanted, and what they may be off by."""

    inputs: Triple
    spread: Spread


@dataclass(frozen=True, kw_only=True)
class RiskSettings:
    """
    How cells are made and kept.

    Parameters
    ----------
    memory : float
        Limit of the cells' size [bytes]; the least recently used go.
    delay : int
        Assessments between asking for a cell and its first use, or more where the allowance does
        not grant its hundred steps sooner; 0: made at once, while the caller waits. A cell takes
        about a second of one core.

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
    due: int  # call from which on its steps are
    work: Work[Cell]


class CellTable:
    """
    The cells of one model and squeal band, searched by place.

    Parameters
    ----------
    family : Family
    band : (2,) floats
        Of the angular frequencies that count [rad/s].
    settings : RiskSettings
    allowance : Allowance
        Steps that a call may be kept by.
    level : float
        Growth rate that counts as unstable [1/s].

    """

    def __init__(self, family: Family, band: tuple[float, float], settings: RiskSettings,
                 allowance: Allowance, level: float = 0.0) -> None:
        self.settings = settings
        self.statistics = RiskStatistics()
        self._family, self._band, self._level = family, band, level
        self._rule: TensorQuadrature = rule_for(0.0, _DEGREE)
        self._entries: list[_Entry] = []
        self._index()
        self._request: _Request | None = None
        self._worker, self._allowance = Worker('risk'), allowance
        self._calls = 0

    @property
    def cells(self) -> tuple[Cell, ...]:
        return tuple(entry.cell for entry in self._entries)

    @property
    def nbytes(self) -> int:
        """Size of the cells [bytes]."""
        return sum(entry.cell.nbytes for entry in self._entries)

    def close(self) -> None:
        """End the worker; the table can be used on, and starts another."""
        self._worker.close()
        self._request = None

    def cells_for(self, wanted: Sequence[Wanted], stiffness_deviation: float
                  ) -> list[Cell | None]:
        """
        Return the cells in which inputs lie; one is asked for near an end of them or beyond.

        The same cell for all, where it has all of them well inside.
        """
        self._calls += len(wanted)
        self._follow(stiffness_deviation)
        self._adopt()
        return [self._used(*self._sought(want, nearest, wanted)) for want, nearest in zip(
            wanted, self._nearest(wanted), strict=True)]

    def _sought(self, want: Wanted, nearest: tuple[_Entry | None, float],
                company: Sequence[Wanted]) -> tuple[_Entry | None, float]:
        """
        Return the nearest entry and its depth; where that is not well inside, ask for one.

        Where it does for all of the company, in the middle of it.
        """
        entry, depth = nearest
        beside = self.settings.delay > 0
        if depth <= _EDGE or (entry is not None and not beside) or (beside and self._request):
            return nearest
        middle = want._replace(inputs=_between(want.inputs, [one.inputs for one in company]))
        if beside:
            self._ask(middle if self._nearest([middle])[0][1] > _EDGE else want)
            return nearest
        for place in dict.fromkeys((middle, want)):  # the one in the middle may turn out small
            if self._nearest([want])[0][0] is None:
                self._take(partial(completed, self._making(place)))
        return self._nearest([want])[0]

    def _used(self, entry: _Entry | None, depth: float) -> Cell | None:
        if entry is None:
            return None
        entry.used = self._calls
        self.statistics.summed += 1
        return entry.cell

    def _follow(self, deviation: float) -> None:
        """Begin anew where the deviation of the contact stiffness is another."""
        if deviation != self._rule.stiffness_deviation:
            self._rule = rule_for(deviation, _DEGREE)
            self._entries, self._request = [], None
            self._index()

    def _nearest(self, wanted: Sequence[Wanted]) -> list[tuple[_Entry | None, float]]:
        """Return the entries in whose cells inputs lie deepest: 0 in the middle, 1 at an end."""
        if not self._entries:
            return [(None, math.inf)] * len(wanted)
        inputs, spreads = np.array([(want.inputs, _deviations(want.spread)) for want in wanted]
                                   ).transpose(1, 0, 2)[..., None]
        depths = np.abs((inputs - self._middles) / self._halves).max(axis=1)
        depths[(spreads > self._spreads).any(axis=1)] = np.inf
        places = depths.argmin(axis=1).tolist()
        farthest = depths.max(axis=0)
        shared = int(farthest.argmin())
        if farthest[shared] <= _EDGE:
            places = [shared] * len(wanted)
        found = [(self._entries[place], float(own[place]))
                 for place, own in zip(places, depths, strict=True)]
        return [(entry if depth <= 1.0 else None, depth) for entry, depth in found]

    def _index(self) -> None:
        """Lay out the cells' places for the search (3, cells)."""
        cells = self.cells
        low, high = (np.array([getattr(c.box, end) for c in cells]).reshape(-1, 3).T
                     for end in ('low', 'high'))
        self._middles, self._halves = 0.5 * (low + high), 0.5 * (high - low)
        self._spreads = np.array([_deviations(c.spread) for c in cells]).reshape(-1, 3).T

    def _making(self, want: Wanted) -> 'Steps[Cell]':
        spread = want.spread
        wide = Spread(_next_step(spread.friction), spread.pressure, spread.rotor_speed)
        return cell_steps(self._family, want.inputs, wide, self._rule, self._band, self._level)

    def _ask(self, want: Wanted) -> None:
        """Have a cell made here."""
        lead = 0 if self._allowance.endless else _STEPS * self._rule.nodes
        self._request = _Request(self._calls + max(self.settings.delay - lead, 0),
                                 self._worker.begin(self._making(want)))

    def _adopt(self) -> None:
        """Take the cell asked for into use, when its time has come."""
        request = self._request
        if request is None or self._calls < request.due or not self._worker.granted(
                request.work, self._allowance):
            return
        self._request = None
        self._take(request.work.result)

    def _take(self, made: Callable[[], Cell]) -> None:
        """Take a cell into use; the least recently used ones make room for it."""
        try:
            cell = made()
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


def _deviations(spread: Spread) -> Triple:
    return spread.friction, spread.pressure, spread.rotor_speed


def _between(inputs: Triple, others: Sequence[Triple]) -> Triple:
    """Return the middle of inputs and of those others for which one cell could be enough."""
    box = box_around(inputs)
    near = np.array([inputs, *(other for other in others if np.all(
        (box.low <= other) & (other <= box.high)))])
    low, high = near.min(axis=0), near.max(axis=0)
    speed, pressure = np.sqrt(low[:2] * high[:2]).tolist()
    return speed, pressure, float(0.5 * (low[2] + high[2]))


def _next_step(deviation: float) -> float:
    """Return the least deviation of the ladder that is not smaller."""
    if deviation == 0.0:
        return 0.0
    step = math.ceil(math.log(deviation / 0.02) / math.log(_LADDER) - 1e-9)
    return max(deviation, 0.02 * _LADDER**step)
