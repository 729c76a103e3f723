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

"""Anchors laid out by place, and what they say of operating points near them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import (
    classify,
    ComplexModes,
    frequency_scale,
    Tolerances,
)
from squeal_core.surrogate.spectral_expansion import DEGREE, SpectralExpansion

_TRIED = 3  # anchors tried for a point, the last one used first
_FAR = 3.0  # reaches beyond which an anchor is not tried
_TOLERANCE = 4.9e-7  # of the model's largest frequency: ten times what counts as growth


@dataclass(frozen=True, kw_only=True)
class SolverSettings:
    """
    How the engine works.

    Parameters
    ----------
    tolerance : float
        Error of a growth rate [1/s] above which a point is solved in full.
    decay_tolerance : float
        The same for a mode that decays, as a part of its rate of decay, where that is more.
    audit_every : int
        Every so many answers from the table one is solved in full and compared; 0: none.
    degree : int
        Of the series.

    """

    tolerance: float = 0.1
    decay_tolerance: float = 0.02
    audit_every: int = 3000
    degree: int = DEGREE

    @classmethod
    def of(cls, model: BrakeModel) -> 'SolverSettings':
        """Return settings with a tolerance relative to the model's spectrum; 0.1 1/s for K09's."""
        scale = frequency_scale(model)
        return cls(tolerance=_TOLERANCE * scale) if scale else cls()


@dataclass(frozen=True, eq=False)
class TableEntry:
    """An expansion of the table."""

    anchor: SpectralExpansion


@dataclass(frozen=True)
class Lookup:
    """What the table says of a point; without an entry, nothing."""

    entry: TableEntry | None = None
    eigenvalues: ComplexArray = field(default_factory=lambda: np.zeros(0, complex))
    errors: FloatArray = field(default_factory=lambda: np.zeros(0))
    worst: float = np.inf


class ExpansionTable:
    """
    The anchors of one model, searched by place.

    Parameters
    ----------
    model : BrakeModel
    settings : SolverSettings
    tolerances : Tolerances
        What counts as oscillation and growth.
    anchors : sequence of SpectralExpansion
        To start with.

    """

    def __init__(self, model: BrakeModel, settings: SolverSettings, tolerances: Tolerances,
                 anchors: Sequence[SpectralExpansion] = ()) -> None:
        self.settings = settings
        self.entries = [TableEntry(anchor) for anchor in anchors]
        self._size, self._tolerances = model.size, tolerances
        self._zeros = np.zeros(np.count_nonzero(model.free_coordinates), complex)
        self._index()

    @property
    def nbytes(self) -> int:
        """Size of the anchors [bytes]."""
        return sum(entry.anchor.nbytes for entry in self.entries)

    def add(self, anchor: SpectralExpansion) -> None:
        self.entries.append(TableEntry(anchor))
        self._index()

    def drop(self, entry: TableEntry) -> None:
        self.entries = [kept for kept in self.entries if kept is not entry]
        self._index()

    def best(self, point: OperatingPoint) -> Lookup:
        """Return the first answer within the tolerance, or else the best of those tried."""
        coefficients = np.array(point.coefficients())
        best = Lookup()
        for entry in self._near(coefficients):
            roots, errors = entry.anchor.eigenvalues_at(coefficients)
            worst = float(self._worst(roots, errors))
            if worst < best.worst:
                best = Lookup(entry, roots, errors, worst)
            if worst <= self.settings.tolerance:
                break
        return best

    def modes(self, answer: Lookup) -> ComplexModes | None:
        """Return the modes, where the answer is good enough and no verdict hangs on its errors."""
        if answer.entry is None or answer.worst > self.settings.tolerance or (
                verdict_within_error(answer.eigenvalues, answer.errors, self._tolerances).any()):
            return None
        found = classify(np.concatenate([self._zeros, answer.eigenvalues]), self._tolerances,
                         np.concatenate([self._zeros.real, answer.errors]),
                         series=answer.entry.anchor, source='table')
        return found if self._complete(found) else None

    def _complete(self, found: ComplexModes) -> bool:
        """
        Whether no pair became real, which is the next anchor's business.

        It shows in their number, as an anchor has one root of each pair.
        """
        return found.errors.size == self._size

    def _worst(self, roots: ComplexArray, errors: FloatArray) -> FloatArray:
        """Return the largest error (...), in growth rates of the tolerance."""
        worst = errors.max(axis=-1, initial=0.0)
        if (worst > self.settings.tolerance).any():
            allowed = self.settings.decay_tolerance / self.settings.tolerance * -roots.real
            worst = (errors / np.maximum(allowed, 1.0)).max(axis=-1)
        return np.asarray(worst)

    def _near(self, coefficients: FloatArray) -> Iterator[TableEntry]:
        """Yield the entries to try, by distance over reach."""
        if not self.entries:
            return
        distances = self._distances(coefficients)
        for _ in range(_TRIED):
            nearest = int(distances.argmin())
            if distances[nearest] > _FAR**2:
                return
            yield self.entries[nearest]
            distances[nearest] = np.inf

    def _distances(self, coefficients: FloatArray) -> FloatArray:
        """Return the square of the distance over reach (..., entries)."""
        away = coefficients * self._per_reach - self._centres
        return np.asarray(np.einsum('...i,...i->...', away, away))

    def _index(self) -> None:
        """Lay out the anchors' places for the search; what has no effect counts for nothing."""
        count = len(self.entries)
        self._centres, self._per_reach = np.zeros((count, 6)), np.zeros((count, 6))
        for i, entry in enumerate(self.entries):
            self._per_reach[i, entry.anchor.rows] = 1.0 / entry.anchor.trust_radius
            self._centres[i] = self._per_reach[i] * entry.anchor.point.coefficients()


def verdict_within_error(roots: ComplexArray, errors: FloatArray, tolerances: Tolerances) -> Any:
    """Tell where a verdict hangs on the errors: growth, or oscillation of what grows."""
    close = np.abs(roots.real - tolerances.growth) <= errors
    if not close.any():
        return close
    # roots at zero of coordinates that nothing holds: they are rigid, whatever the error
    oscillates = np.abs(roots.imag) > tolerances.oscillation
    return close & (oscillates | (errors > tolerances.growth))
