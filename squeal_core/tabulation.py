"""The fast engine: anchors made on demand where the brake is driven, and kept (ISAT).

A point is answered from the series of an anchor near it when the error estimate of every root is
within the tolerance and no verdict hangs on it, and by a full solve otherwise. Anchors are made
beside the work, in a thread of their own, and taken into use a fixed number of solves after the
one that asked for them: the same points in the same order give the same numbers, and no solve
waits for more than one full solution.

S. B. Pope, Combust. Theory Model. 1 (1997) 41-63, is where in-situ adaptive tabulation is from.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from squeal_core.anchor import Anchor, DEGREE
from squeal_core.anchor_solution import anchor_at
from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.brake_model import BrakeModel
from squeal_core.operating_point import OperatingPoint
from squeal_core.stability import classify, complex_modes, ComplexModes, Tolerances
from squeal_core.workers import Worker

_EDGE = 0.2  # of the tolerance: from here on the next anchor is asked for
_LOOK = 7  # solves from one look at that to the next; a prime, so that every brake has its turn
_TRIED = 3  # anchors tried for a point, the last one used first
_PATIENCE = 6  # anchors nobody used before the next are asked for less often
_AHEAD = 0.6  # of the way from the last anchor: how far beyond a point the next one is made
_DRIFT = 2.0  # ratio of a parameter over that way from which on it is a jump
_FAR = 3.0  # reaches beyond which an anchor is not tried
_PENDING = 2  # anchors being made at a time: brakes of both axles ask
_ALIKE = 0.1  # relative difference of parameters up to which one anchor is enough for the time


@dataclass(frozen=True, kw_only=True)
class TableSettings:
    """How the engine works.

    Parameters
    ----------
    tolerance : float
        Error of a growth rate [1/s] above which a point is solved in full.
    decay_tolerance : float
        The same for a mode that decays, as a part of its rate of decay, where that is more.
    memory : float
        Limit of the anchors' size [bytes]; the least recently used go.
    delay : int
        Solves between asking for an anchor and its first use; 0: made at once, while the caller
        waits.
    audit_every : int
        Every so many answers from the table one is solved in full and compared; 0: none.
    degree : int
        Of the series.
    """

    tolerance: float = 0.1
    decay_tolerance: float = 0.02
    memory: float = 200e6
    delay: int = 0
    audit_every: int = 2000
    degree: int = DEGREE


@dataclass
class TableStatistics:
    """What the engine did so far."""

    tabulated: int = 0
    full: int = 0
    audits: int = 0
    mismatches: int = 0
    worst_audit: float = 0.0  # of what is tolerated
    made: int = 0
    dropped: int = 0
    failed: int = 0


@dataclass
class _Entry:
    anchor: Anchor
    used: int  # the solve at which it was last used
    hits: int = 0


@dataclass
class _Request:
    point: OperatingPoint
    due: int
    anchor: 'Future[Anchor]'


@dataclass(frozen=True)
class _Answer:
    """What the table says of a point; without an entry, nothing."""

    entry: _Entry | None = None
    roots: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    errors: FloatArray = field(default_factory=lambda: np.zeros(0))
    worst: float = np.inf


class Tabulation:
    """Complex modes of one model at operating points, each near the last ones.

    Parameters
    ----------
    model : BrakeModel
    settings : TableSettings, optional
    tolerances : Tolerances, optional
        What counts as oscillation and growth.
    anchors : sequence of Anchor
        To start with, as `squeal tabulate` lays them down.
    """

    def __init__(self, model: BrakeModel, settings: TableSettings | None = None, *,
                 tolerances: Tolerances | None = None, anchors: Sequence[Anchor] = ()) -> None:
        self.model = model
        self.settings = settings or TableSettings()
        self.statistics = TableStatistics()
        self._tolerances = tolerances or Tolerances()
        self._entries = [_Entry(anchor, 0) for anchor in anchors]
        self._centres = np.zeros((0, 0))
        self._per_reach = np.zeros((0, 0))
        self._index()
        self._requests: list[_Request] = []  # in order of their due
        self._worker = Worker('anchors')
        self._zeros = np.zeros(np.count_nonzero(model.free_coordinates), complex)
        self._solves = 0
        self._unused = 0  # anchors in a row that were never used
        self._pause_until = 0

    def _edge(self) -> float:
        """Return the error [1/s] from which on others are looked at.

        Early where making one takes time; but not at every solve, as it costs several answers.
        """
        early = self.settings.delay and self._solves % _LOOK == 0
        return (_EDGE if early else 1.0) * self.settings.tolerance

    @property
    def tolerances(self) -> Tolerances:
        return self._tolerances

    @property
    def anchors(self) -> tuple[Anchor, ...]:
        return tuple(entry.anchor for entry in self._entries)

    @property
    def nbytes(self) -> int:
        """Size of the anchors [bytes]."""
        return sum(entry.anchor.nbytes for entry in self._entries)

    def figures(self) -> dict[str, float]:
        """Return what the engine did so far and how large its table is, by name."""
        return {**asdict(self.statistics), 'anchors': len(self._entries),
                'megabytes': round(1e-6 * self.nbytes, 3)}

    def complex_modes(self, point: OperatingPoint) -> ComplexModes:
        """Return the complex modes at a point; as `stability.complex_modes`, with errors."""
        self._solves += 1
        self._adopt()
        edge = self._edge()
        answer = self._best(point, edge)
        if answer.worst > edge:
            self._prepare(point, answer)
            if self.settings.delay == 0:
                answer = self._best(point, edge)
        found = self._modes(answer)
        if found is None or answer.entry is None:
            self.statistics.full += 1
            full = complex_modes(self.model, point, tolerances=self._tolerances)
            return full if answer.entry is None else replace(full, series=answer.entry.anchor)
        answer.entry.used = self._solves
        answer.entry.hits += 1
        self.statistics.tabulated += 1
        every = self.settings.audit_every
        if every and self.statistics.tabulated % every == 0:
            return self._audited(point, found, answer.entry)
        return found

    def covers(self, point: OperatingPoint) -> bool:
        """Tell whether the table answers at a point, without any solve and any trace."""
        return self._modes(self._best(point, self.settings.tolerance)) is not None

    def add(self, anchor: Anchor) -> None:
        """Take an anchor into the table; the least recently used ones make room for it."""
        self._entries.append(_Entry(anchor, self._solves))
        self._forget_oldest()
        self._index()

    def close(self) -> None:
        """End the worker; the engine can be used on, and starts another."""
        self._worker.close()
        self._requests = []

    def _best(self, point: OperatingPoint, enough: float) -> '_Answer':
        """Return the first answer with no larger an error, or else the best of those tried."""
        coefficients = np.array(point.coefficients())
        best = _Answer()
        for entry in self._near(coefficients):
            roots, errors = entry.anchor.roots_at(coefficients)
            worst = self._worst(roots, errors)
            if worst < best.worst:
                best = _Answer(entry, roots, errors, worst)
            if worst <= enough:
                break
        return best

    def _modes(self, answer: '_Answer') -> ComplexModes | None:
        """Return the modes, where the answer is good enough and no verdict hangs on its errors."""
        if answer.entry is None or answer.worst > self.settings.tolerance or (
                not self._decided(answer.roots, answer.errors)):
            return None
        return self._classified(answer.entry.anchor, answer.roots, answer.errors)

    def _prepare(self, point: OperatingPoint, answer: '_Answer') -> None:
        """Have an anchor made for a point at or beyond the edge of the table, or for what follows.
        """
        limit = self.settings.tolerance
        target = point if answer.entry is None else ahead(point, answer.entry.anchor.point)
        if target is not point and self._best(target, limit).worst <= limit:
            if answer.worst <= limit:
                return
            target = point
        self._ask(target)
        if self.settings.delay == 0:
            self._adopt()
            if target is not point and self._best(point, limit).worst > limit:
                self._ask(point)  # the table does not reach back to here
                self._adopt()

    def _worst(self, roots: ComplexArray, errors: FloatArray) -> float:
        """Return the largest error, in growth rates of the tolerance."""
        worst = float(errors.max()) if errors.size else 0.0
        if worst <= self.settings.tolerance:
            return worst
        allowed = self.settings.decay_tolerance / self.settings.tolerance * -roots.real
        return float((errors / np.maximum(allowed, 1.0)).max())

    def _decided(self, roots: ComplexArray, errors: FloatArray) -> bool:
        """Whether no verdict hangs on the errors: growth, or oscillation of what grows."""
        close = np.abs(roots.real - self._tolerances.growth) <= errors
        if not close.any():
            return True
        near = close.nonzero()[0]
        # roots at zero of coordinates that nothing holds: they are rigid, whatever the error
        oscillates = np.abs(roots[near].imag) > self._tolerances.oscillation
        return not bool((oscillates | (errors[near] > self._tolerances.growth)).any())

    def _classified(self, anchor: Anchor, roots: ComplexArray,
                    errors: FloatArray) -> ComplexModes | None:
        """Return the modes; None where a pair became real: the next anchor's business.

        It shows in their number, as the anchor has one root of each pair.
        """
        found = classify(np.concatenate([self._zeros, roots]), self._tolerances,
                         np.concatenate([self._zeros.real, errors]), series=anchor)
        return found if found.errors.size == self.model.size else None

    def _near(self, coefficients: FloatArray) -> Iterator[_Entry]:
        """Yield the entries to try, by distance over reach."""
        if not self._entries:
            return
        away = coefficients * self._per_reach - self._centres
        distance = np.einsum('ij,ij->i', away, away)
        for _ in range(_TRIED):
            nearest = int(distance.argmin())
            if distance[nearest] > _FAR**2:
                return
            yield self._entries[nearest]
            distance[nearest] = np.inf

    def _index(self) -> None:
        """Lay out the anchors' places for the search; what has no effect counts for nothing."""
        count = len(self._entries)
        self._centres, self._per_reach = np.zeros((count, 6)), np.zeros((count, 6))
        for i, entry in enumerate(self._entries):
            self._per_reach[i, entry.anchor.rows] = 1.0 / entry.anchor.reach
            self._centres[i] = self._per_reach[i] * entry.anchor.point.coefficients()

    def _ask(self, point: OperatingPoint) -> None:
        """Have an anchor made here, unless one is being made near here, or enough are."""
        if self._solves < self._pause_until or len(self._requests) >= _PENDING or any(
                _alike(point, request.point) for request in self._requests):
            return
        future = self._worker.submit(self.settings.delay > 0, anchor_at, self.model, point,
                                     degree=self.settings.degree)
        self._requests.append(_Request(point, self._solves + self.settings.delay, future))

    def _adopt(self) -> None:
        """Take the anchors asked for into use, when their time has come."""
        while self._requests and self._requests[0].due <= self._solves:
            self._take(self._requests.pop(0).anchor)

    def _take(self, future: 'Future[Anchor]') -> None:
        try:
            anchor = future.result()
        except np.linalg.LinAlgError:  # no eigensolution: the vectors do not span the space
            self.statistics.failed += 1
            self._unused += 1
        else:
            self._entries.append(_Entry(anchor, self._solves))
            self.statistics.made += 1
            self._unused = 0 if any(e.hits for e in self._entries[-_PATIENCE:]) else (
                self._unused + 1)
            self._forget_oldest()
            self._index()
        pause = 2 ** min(max(self._unused - _PATIENCE, 0), _PATIENCE) - 1
        self._pause_until = self._solves + pause * self.settings.delay

    def _forget_oldest(self) -> None:
        while self.nbytes > self.settings.memory and len(self._entries) > 1:
            oldest = min(self._entries[:-1], key=lambda entry: entry.used)
            self._drop(oldest)

    def _drop(self, entry: _Entry) -> None:
        self._entries = [kept for kept in self._entries if kept is not entry]
        self.statistics.dropped += 1

    def _audited(self, point: OperatingPoint, found: ComplexModes, entry: _Entry) -> ComplexModes:
        """Compare an answer with the full solve; an anchor that was wrong goes."""
        truth = complex_modes(self.model, point, tolerances=self._tolerances)
        self.statistics.audits += 1
        off = _distance(found, truth, self.settings)
        self.statistics.worst_audit = max(self.statistics.worst_audit, off)
        if off <= 1.0:
            return found
        self.statistics.mismatches += 1
        self._drop(entry)
        self._index()
        return truth


def ahead(point: OperatingPoint, behind: OperatingPoint) -> OperatingPoint:
    """Return a point further on the way from one behind: an anchor serves on both sides of it.

    A long way, or one through a change of sign, is no drift; the point itself then.
    """
    there = {}
    for name in ('rotor_speed', 'contact_pressure', 'contact_stiffness', 'friction'):
        here, before = getattr(point, name), getattr(behind, name)
        if here == before:
            continue
        ratio = here / before if before else 0.0
        if not 1.0 / _DRIFT < ratio < _DRIFT:
            return point
        there[name] = here * ratio**_AHEAD
    slope = point.friction_slope
    return replace(point, **there, friction_slope=slope + _AHEAD * (slope - behind.friction_slope))


def _alike(one: OperatingPoint, other: OperatingPoint) -> bool:
    """Whether two points are as near each other as those of both brakes of an axle."""
    return all(abs(getattr(one, name) - there) <= _ALIKE * abs(there)
               for name, there in other.__dict__.items() if name != 'friction_slope')


def _distance(found: ComplexModes, truth: ComplexModes, settings: TableSettings) -> float:
    """Return how far roots of oscillating modes are from the next of the truth, over what may be.
    """
    limit = found.tolerances.oscillation
    ours, theirs = (m.roots[m.roots.imag > limit] for m in (found, truth))
    if ours.size != theirs.size:
        return np.inf
    away = np.abs(ours[:, None] - theirs) / np.maximum(
        settings.tolerance, -settings.decay_tolerance * theirs.real)
    return float(max(away.min(axis=0).max(), away.min(axis=1).max())) if ours.size else 0.0
