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

"""Complex modes by look-up in a table of expansions, by a full solution where it has no answer."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable, SolverSettings, TableEntry
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

__all__ = ['SolverSettings', 'SolverStatistics', 'TabulatedSolver']


@dataclass
class SolverStatistics:
    """Counts of answers since the start."""

    tabulated: int = 0
    full: int = 0
    audits: int = 0
    mismatches: int = 0
    worst_audit: float = 0.0  # of what is tolerated


class TabulatedSolver:
    """
    Complex modes of one model at operating points.

    Parameters
    ----------
    model : BrakeModel
    settings : SolverSettings, optional
    tolerances : Tolerances, optional
        What counts as oscillation and growth; `Tolerances.of(model)` where None.
    anchors : sequence of SpectralExpansion
        The table, as `squeal tabulate` computes it.

    """

    def __init__(self, model: BrakeModel, settings: SolverSettings | None = None, *,
                 tolerances: Tolerances | None = None,
                 anchors: Sequence[SpectralExpansion] = ()) -> None:
        self.model = model
        self.statistics = SolverStatistics()
        self.tolerances = tolerances or Tolerances.of(model)
        self._table = ExpansionTable(model, settings or SolverSettings.of(model), self.tolerances,
                                     anchors)

    @property
    def settings(self) -> SolverSettings:
        """May be replaced at any time."""
        return self._table.settings

    @settings.setter
    def settings(self, settings: SolverSettings) -> None:
        self._table.settings = settings

    @property
    def anchors(self) -> tuple[SpectralExpansion, ...]:
        return tuple(entry.anchor for entry in self._table.entries)

    @property
    def nbytes(self) -> int:
        """Size of the expansions [bytes]."""
        return self._table.nbytes

    def figures(self) -> dict[str, float]:
        """Return the counts and the size of the table, by name."""
        return {**asdict(self.statistics), 'expansions': len(self._table.entries),
                'megabytes': round(1e-6 * self.nbytes, 3)}

    def complex_modes(self, point: OperatingPoint) -> ComplexModes:
        """Return the complex modes at a point; as `complex_modes`, with errors."""
        answer = self._table.best(point)
        found = self._table.modes(answer)
        if found is None or answer.entry is None:
            self.statistics.full += 1
            return complex_modes(self.model, point, tolerances=self.tolerances)
        self.statistics.tabulated += 1
        every = self.settings.audit_every
        if every and self.statistics.tabulated % every == 0:
            return self._spot_check(point, found, answer.entry)
        return found

    def covers(self, point: OperatingPoint) -> bool:
        """Tell whether the table answers at a point."""
        return self._table.modes(self._table.best(point)) is not None

    def add(self, anchor: SpectralExpansion) -> None:
        """Take an expansion into the table."""
        self._table.add(anchor)

    def _spot_check(self, point: OperatingPoint, found: ComplexModes,
                    entry: TableEntry) -> ComplexModes:
        """Compare an answer with the full solution; an expansion that was wrong goes."""
        truth = complex_modes(self.model, point, tolerances=self.tolerances)
        self.statistics.audits += 1
        off = _distance(found, truth, self.settings)
        self.statistics.worst_audit = max(self.statistics.worst_audit, off)
        if off <= 1.0:
            return found
        self.statistics.mismatches += 1
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
