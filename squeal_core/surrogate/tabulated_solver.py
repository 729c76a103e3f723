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
The fast engine: anchors made on demand where the brake is driven, and kept (ISAT).

A point is answered from the series of an anchor near it when the error estimate of every root is
within the tolerance and no verdict hangs on it, and by a full solve otherwise. Anchors are made
beside the work, in a thread of their own, and taken into use a fixed number of solves after the
one that asked for them: the same points in the same order give the same numbers. Where the thread
has not got far enough by then, a solve makes a step of them itself, which takes no longer than a
full solution.

S. B. Pope, Combust. Theory Model. 1 (1997) 41-63, is where in-situ adaptive tabulation is from.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Source, Tolerances
from squeal_core.stability.eigenvectors import refined_eigenvalue
from squeal_core.surrogate.anchor_requests import AnchorRequests, Count
from squeal_core.surrogate.expansion_builder import expansion_steps
from squeal_core.surrogate.expansion_table import (
    ExpansionTable,
    Lookup,
    SolverSettings,
    TableEntry,
)
from squeal_core.surrogate.neighbours import ahead, amid, Trail
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.steps import completed, Steps
from squeal_core.surrogate.workers import Allowance

__all__ = ['SolverSettings', 'SolverStatistics', 'TabulatedSolver']

_LOOK = 3  # calls from one look ahead to the next: it costs as much as some answers
_HORIZONS = (1.2, 2.0)  # times what an anchor takes: how far ahead, so that no gap is passed over
_REFINED = 4  # roots of a point; for more of them a full solution is no dearer
_APART = 1e-6  # between eigenvalues that are two, in tolerances of oscillation


@dataclass
class SolverStatistics:
    """What the engine did so far."""

    tabulated: int = 0
    full: int = 0
    audits: int = 0
    mismatches: int = 0
    worst_audit: float = 0.0  # of what is tolerated
    made: int = 0
    dropped: int = 0
    failed: int = 0


class TabulatedSolver:
    """
    Complex modes of one model at operating points, each near the last ones.

    Parameters
    ----------
    model : BrakeModel
    settings : SolverSettings, optional
    tolerances : Tolerances, optional
        What counts as oscillation and growth; `Tolerances.of(model)` where None.
    anchors : sequence of SpectralExpansion
        To start with, as `squeal tabulate` lays them down.

    Attributes
    ----------
    allowance : Allowance
        Steps that a call may still be kept by: one for each of its points; what it leaves is for
        other works of the same tick.

    """

    def __init__(self, model: BrakeModel, settings: SolverSettings | None = None, *,
                 tolerances: Tolerances | None = None,
                 anchors: Sequence[SpectralExpansion] = ()) -> None:
        self.model = model
        self.statistics = SolverStatistics()
        self.allowance = Allowance()
        self._tolerances = tolerances or Tolerances.of(model)
        self._table = ExpansionTable(model, settings or SolverSettings.of(model), self._tolerances,
                                     anchors)
        self._requests = AnchorRequests(self._making)
        self._solves = self._calls = 0
        self._trail = Trail()

    @property
    def settings(self) -> SolverSettings:
        """May be replaced at any time; what is in the table stays."""
        return self._table.settings

    @settings.setter
    def settings(self, settings: SolverSettings) -> None:
        self._table.settings = settings

    @property
    def tolerances(self) -> Tolerances:
        return self._tolerances

    @property
    def anchors(self) -> tuple[SpectralExpansion, ...]:
        return tuple(entry.anchor for entry in self._table.entries)

    @property
    def nbytes(self) -> int:
        """Size of the anchors [bytes]."""
        return self._table.nbytes

    def figures(self) -> dict[str, float]:
        """Return what the engine did so far and how large its table is, by name."""
        return {**asdict(self.statistics), 'anchors': len(self._table.entries),
                'megabytes': round(1e-6 * self.nbytes, 3)}

    def complex_modes(self, point: OperatingPoint, *, refined: float = 0.0) -> ComplexModes:
        """
        Return the complex modes at a point; as `stability.complex_modes`, with errors.

        Parameters
        ----------
        point : OperatingPoint
            Operating point.
        refined : float
            Where the settings let roots be solved for one by one: the growth rate [1/s], either
            way, up to which that is done though no verdict hangs on it.

        """
        return completed(self.solving(point, refined=refined))

    def solving(self, point: OperatingPoint, *, refined: float = 0.0) -> 'Steps[ComplexModes]':
        """Return the same as `complex_modes`, in steps."""
        self.allowance.renew(1)
        found = yield from self._solved(point, [point], 1, refined)
        self._look_ahead([point])
        return found

    def complex_modes_of(self, points: Sequence[OperatingPoint]) -> list[ComplexModes]:
        """
        Return the complex modes at several points, for less than one after the other.

        Those that the anchors in the table answer well are found together.
        """
        if len(points) == 1:
            return [self.complex_modes(points[0])]
        self.allowance.renew(len(points))
        self._adopt()
        found = []
        together = self._table.together(points)
        lacking = sum(one is None for one in together)
        for point, one in zip(points, together, strict=True):
            if one is None:
                found.append(completed(self._solved(point, points, lacking)))
                continue
            self._solves += 1
            found.append(self._used(point, one.modes, one.entry))
        self._look_ahead(points)
        return found

    def expect(self, point: OperatingPoint | None, count: int) -> bool:
        """
        Count a call of so many points of which none is asked for.

        An anchor is made beside the work for one that may be, where none in the table answers it;
        tells whether it is begun with.
        """
        if not self.settings.delay:
            return False
        self.allowance.renew(count)
        self._solves += count
        self._adopt()
        return (point is not None and self._table.best(point).worst > self.settings.tolerance
                and self._ask(point, count, expected=True))

    def _solved(self, point: OperatingPoint, company: Sequence[OperatingPoint], lacking: int,
                refined: float = 0.0) -> 'Steps[ComplexModes]':
        """Return the modes at one of several points, from the table or in full."""
        self._solves += 1
        self._adopt()
        limit = self.settings.tolerance
        answer = self._table.best(point)
        if answer.worst > limit:
            target = self._target(point, answer, company)
            if self.settings.delay:
                self._ask(target, len(company), lacking)
            else:
                answer = yield from self._laid_down(point, target)
        answer, source = yield from self._refined(point, answer, refined)
        found = self._table.modes(answer, source)
        if found is None or answer.entry is None:
            self.statistics.full += 1
            full: ComplexModes = yield partial(complex_modes, self.model, point,
                                               tolerances=self._tolerances)
            return full if answer.entry is None else replace(full, series=answer.entry.anchor)
        return self._used(point, found, answer.entry)

    def _look_ahead(self, points: Sequence[OperatingPoint]) -> None:
        """Have an anchor made where the points will be by the time it takes."""
        self._calls += 1
        if not self.settings.delay or self._calls % _LOOK:
            return
        there = self._trail.foreseen(points, self._solves, [
            round(times * self.settings.delay) for times in _HORIZONS])
        missing = self._table.missing([point for company in there for point in company])
        if missing:
            company, place = there[missing[0] // len(points)], missing[0] % len(points)
            answer = self._table.best(company[place])
            if answer.worst > self.settings.tolerance:
                self._ask(self._target(company[place], answer, company), len(company))

    def _refined(self, point: OperatingPoint, answer: Lookup,
                 within: float) -> 'Steps[tuple[Lookup, Source]]':
        """
        Solve for roots next to the verdict in the full problem, where the settings want it.

        Nothing comes of it where a root is elsewhere than the series has it, or two become one.
        """
        settings, growth = self.settings, self._tolerances.growth
        if not settings.refines or answer.worst > settings.tolerance:
            return answer, 'table'
        off = np.maximum(answer.errors, within)
        places = np.flatnonzero((np.abs(answer.eigenvalues.real - growth) <= off)
                                & (answer.eigenvalues.imag > self._tolerances.oscillation))
        if not places.size or places.size > _REFINED:
            return answer, 'table'
        roots, errors = answer.eigenvalues.copy(), answer.errors.copy()
        for place, root in zip(places.tolist(), roots[places].tolist(), strict=True):
            roots[place], errors[place] = yield partial(refined_eigenvalue, self.model, point,
                                                        root)
        wrong = np.abs(roots - answer.eigenvalues) > answer.errors + errors
        apart = np.abs(roots[places, None] - roots) > errors[places, None] + (
            _APART * self._tolerances.oscillation)
        if wrong.any() or np.count_nonzero(~apart) > places.size:
            return Lookup(answer.entry), 'table'
        return replace(answer, eigenvalues=roots, errors=errors), 'refined'

    def _used(self, point: OperatingPoint, found: ComplexModes, entry: TableEntry) -> ComplexModes:
        """Count an answer from the table; every so often it is audited."""
        entry.used = self._solves
        entry.hits += 1
        self.statistics.tabulated += 1
        every = self.settings.audit_every
        if every and self.statistics.tabulated % every == 0:
            return self._spot_check(point, found, entry)
        return found

    def covers(self, point: OperatingPoint) -> bool:
        """Tell whether the table answers at a point, without any solve and any trace."""
        return self._table.modes(self._table.best(point)) is not None

    def add(self, anchor: SpectralExpansion) -> None:
        """Take an anchor into the table; the least recently used ones make room for it."""
        self.statistics.dropped += self._table.add(anchor, self._solves)

    def close(self) -> None:
        """End the worker; the engine can be used on, and starts another."""
        self._requests.close()

    def _target(self, point: OperatingPoint, answer: Lookup,
                company: Sequence[OperatingPoint]) -> OperatingPoint:
        """Return where to make an anchor for a point that none answers, and for what follows."""
        target = amid(point, company)
        if answer.entry is not None:
            target = ahead(target, answer.entry.anchor.point)
        reached = target is not point and self._table.best(target).worst <= self.settings.tolerance
        return point if reached else target

    def _laid_down(self, point: OperatingPoint, target: OperatingPoint) -> 'Steps[Lookup]':
        """Make an anchor now; another one, if it does not reach back to the point."""
        for place in dict.fromkeys((target, point)):
            try:
                anchor = yield from self._making(place)
            except np.linalg.LinAlgError:
                anchor = None
            self._take(anchor)
            answer = self._table.best(point)
            if answer.worst <= self.settings.tolerance:
                break
        return answer

    def _making(self, point: OperatingPoint) -> 'Steps[SpectralExpansion]':
        return expansion_steps(self.model, point, degree=self.settings.degree)

    @property
    def _now(self) -> Count:
        return Count(self._solves, self.statistics.full)

    def _ask(self, point: OperatingPoint, brakes: int, lacking: int = 1, *,
             expected: bool = False) -> bool:
        return self._requests.ask(point, brakes, self._now, self.settings.delay, lacking=lacking,
                                  expected=expected)

    def _adopt(self) -> None:
        """Take the anchors asked for into use, when their time has come, a step at a time."""
        while request := self._requests.over(self._now, self.allowance):
            try:
                self._take(request.work.result(), expected=request.expected)
            except np.linalg.LinAlgError:
                self._take(None, expected=request.expected)

    def _take(self, anchor: SpectralExpansion | None, *, expected: bool = False) -> None:
        """Take an anchor into use; none: no eigensolution, or vectors that span no space."""
        if anchor is None:
            self.statistics.failed += 1
        else:
            self.statistics.made += 1
            self.add(anchor)
        if not expected:
            self._requests.note(None if anchor is None else self._table.entries[-1], self._now,
                                self.settings.delay)

    def _spot_check(self, point: OperatingPoint, found: ComplexModes,
                    entry: TableEntry) -> ComplexModes:
        """Compare an answer with the full solve; an anchor that was wrong goes."""
        truth = complex_modes(self.model, point, tolerances=self._tolerances)
        self.statistics.audits += 1
        off = _distance(found, truth, self.settings)
        self.statistics.worst_audit = max(self.statistics.worst_audit, off)
        if off <= 1.0:
            return found
        self.statistics.mismatches += 1
        self.statistics.dropped += 1
        self._table.drop(entry)
        return truth


def _distance(found: ComplexModes, truth: ComplexModes, settings: SolverSettings) -> float:
    """Return how far roots of oscillating modes are from the true ones, over what may be."""
    limit = found.tolerances.oscillation
    ours, theirs = (m.mode_eigenvalues[m.mode_eigenvalues.imag > limit] for m in (found, truth))
    if ours.size != theirs.size:
        return np.inf
    away = np.abs(ours[:, None] - theirs) / np.maximum(
        settings.tolerance, -settings.decay_tolerance * theirs.real)
    return float(max(away.min(axis=0).max(), away.min(axis=1).max())) if ours.size else 0.0
