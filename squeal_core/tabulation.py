"""The fast engine: anchors made on demand where the brake is driven, and kept (ISAT).

A point is answered from the series of an anchor near it when the error estimate of every root is
within the tolerance and no verdict hangs on it, and by a full solve otherwise. Anchors are made
beside the work, in a thread of their own, and taken into use a fixed number of solves after the
one that asked for them: the same points in the same order give the same numbers, and no solve
waits for more than one full solution.

S. B. Pope, Combust. Theory Model. 1 (1997) 41-63, is where in-situ adaptive tabulation is from.
"""

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from squeal_core.anchor import Anchor, DEGREE
from squeal_core.anchor_solution import anchor_at
from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.brake_model import BrakeModel
from squeal_core.operating_point import OperatingPoint
from squeal_core.stability import classify, complex_modes, ComplexModes, Tolerances

_EDGE = 0.2  # of the tolerance: from here on the next anchor is asked for
_TRIED = 3  # anchors tried for a point, the last one used first
_PATIENCE = 6  # anchors nobody used before the next are asked for less often
_FAR = 3.0  # reaches beyond which an anchor is not tried


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
    decay_tolerance: float = 0.01
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
    due: int
    anchor: 'Future[Anchor]'


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
        self._reaches = np.zeros((0, 0))
        self._index()
        self._last: _Entry | None = None
        self._request: _Request | None = None
        self._worker: ThreadPoolExecutor | None = None
        self._solves = 0
        self._unused = 0  # anchors in a row that were never used
        self._pause_until = 0

    @property
    def anchors(self) -> tuple[Anchor, ...]:
        return tuple(entry.anchor for entry in self._entries)

    @property
    def nbytes(self) -> int:
        """Size of the anchors [bytes]."""
        return sum(entry.anchor.nbytes for entry in self._entries)

    def complex_modes(self, point: OperatingPoint) -> ComplexModes:
        """Return the complex modes at a point; as `stability.complex_modes`, with errors."""
        self._solves += 1
        self._adopt()
        found, worst, entry = self._from_table(point)
        ahead = _EDGE if self.settings.delay else 1.0
        if worst > ahead * self.settings.tolerance or found is None:
            self._ask(point)
            if self.settings.delay == 0 and self._request is not None:
                self._adopt()
                found, worst, entry = self._from_table(point)
        if found is None:
            self.statistics.full += 1
            return complex_modes(self.model, point, tolerances=self._tolerances)
        assert entry is not None
        entry.used, self._last = self._solves, entry
        entry.hits += 1
        self.statistics.tabulated += 1
        every = self.settings.audit_every
        if every and self.statistics.tabulated % every == 0:
            return self._audited(point, found, entry)
        return found

    def _from_table(self, point: OperatingPoint
                    ) -> tuple[ComplexModes | None, float, '_Entry | None']:
        """Return modes, their largest error, and where they are from; None beyond the limit."""
        coefficients = np.array(point.coefficients())[:, None]
        least = np.inf
        for entry in self._near(coefficients[:, 0]):
            roots, errors = entry.anchor.roots(coefficients)
            roots, errors = roots[:, 0], errors[:, 0]
            worst = self._worst(roots, errors)
            if worst <= self.settings.tolerance and self._decided(roots, errors):
                found = self._classified(entry.anchor, roots, errors)
                if found is not None:
                    return found, worst, entry
            least = min(least, worst)
        return None, max(least, self.settings.tolerance), None

    def _worst(self, roots: ComplexArray, errors: FloatArray) -> float:
        """Return the largest error, in growth rates of the tolerance."""
        worst = float(errors.max(initial=0.0))
        if worst <= self.settings.tolerance:
            return worst
        allowed = self.settings.decay_tolerance / self.settings.tolerance * -roots.real
        return float((errors / np.maximum(allowed, 1.0)).max())

    def _decided(self, roots: ComplexArray, errors: FloatArray) -> bool:
        """Whether no verdict hangs on the errors: growth, or oscillation of what grows."""
        near = np.abs(roots.real - self._tolerances.growth) <= errors
        if not near.any():
            return True
        # roots at zero of coordinates that nothing holds: they are rigid, whatever the error
        oscillates = np.abs(roots[near].imag) > self._tolerances.oscillation
        return not bool((oscillates | (errors[near] > self._tolerances.growth)).any())

    def _classified(self, anchor: Anchor, roots: ComplexArray,
                    errors: FloatArray) -> ComplexModes | None:
        """Return the modes; None where roots and their mirror images do not make 2N."""
        mirrored = anchor.mirrored & (np.abs(roots.imag) > 0.0)
        images = roots[mirrored].conj()
        rest = 2 * self.model.size - roots.size - images.size
        free = int(np.count_nonzero(self.model.free_coordinates))
        if rest != free:
            return None
        every = np.concatenate([np.zeros(rest), roots, images])
        off = np.concatenate([np.zeros(rest), errors, errors[mirrored]])
        return classify(every, self._tolerances, off, source='table')

    def _near(self, coefficients: FloatArray) -> Sequence[_Entry]:
        """Return the entries to try: the last one used, then by distance over reach."""
        if not self._entries:
            return ()
        away = np.abs(coefficients - self._centres) / self._reaches
        distance = np.einsum('ij,ij->i', away, away)
        nearest = np.argsort(distance, kind='stable')[:_TRIED]
        found = [self._entries[i] for i in nearest.tolist() if distance[i] < _FAR**2]
        if self._last is not None and self._last not in found:
            found.insert(0, self._last)
        return found

    def _index(self) -> None:
        """Lay out the anchors' places for the search; what has no effect counts for nothing."""
        count = len(self._entries)
        self._centres, self._reaches = np.zeros((count, 6)), np.full((count, 6), np.inf)
        for i, entry in enumerate(self._entries):
            self._centres[i] = entry.anchor.point.coefficients()
            self._reaches[i, entry.anchor.rows] = entry.anchor.reach

    def _ask(self, point: OperatingPoint) -> None:
        """Have an anchor made here, unless one is being made already."""
        if self._request is not None or self._solves < self._pause_until:
            return
        if self.settings.delay == 0:
            future: Future[Anchor] = Future()
            try:
                future.set_result(anchor_at(self.model, point, degree=self.settings.degree))
            except np.linalg.LinAlgError as error:
                future.set_exception(error)
        else:
            if self._worker is None:
                self._worker = ThreadPoolExecutor(1, 'anchors')
            future = self._worker.submit(
                anchor_at, self.model, point, degree=self.settings.degree)
        self._request = _Request(self._solves + self.settings.delay, future)

    def _adopt(self) -> None:
        """Take the anchor asked for into use, when its time has come."""
        request = self._request
        if request is None or self._solves < request.due:
            return
        self._request = None
        try:
            anchor = request.anchor.result()
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
        pause = self.settings.delay * 2 ** min(max(self._unused - _PATIENCE, 0), _PATIENCE)
        self._pause_until = self._solves + pause

    def _forget_oldest(self) -> None:
        while self.nbytes > self.settings.memory and len(self._entries) > 1:
            oldest = min(self._entries[:-1], key=lambda entry: entry.used)
            self._drop(oldest)

    def _drop(self, entry: _Entry) -> None:
        self._entries = [kept for kept in self._entries if kept is not entry]
        if self._last is entry:
            self._last = None
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
