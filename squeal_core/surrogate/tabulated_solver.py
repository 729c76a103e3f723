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

"""Complex modes of one model at sliding points: from its table, or in full."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Tolerances
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_cell import TableTolerances
from squeal_core.surrogate.table_domain import places_of

AUDIT_EVERY = 3000  # answers: some hundredths of the time of all of them


@dataclass
class SolverStatistics:
    """Counts since the start; `worst_audit` in units of the tolerance."""

    tabulated: int = 0
    full: int = 0
    audits: int = 0
    mismatches: int = 0
    worst_audit: float = 0.0


class TabulatedSolver:
    """
    Complex modes of a model, by look-up in a table or in full.

    Every so many answers of the table one is compared with a full solution. A cell that was wrong
    is not used again.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    table : ExpansionTable, optional
        Of this model; None: every point is solved in full.
    limits : Tolerances, optional
        What counts as oscillation and growth; None: `Tolerances.of(model)`.
    band : (2,) floats, optional
        Band in which the least stable mode is wanted, whatever its growth rate [Hz]; points at
        which it may be among the omitted modes are solved in full.
    audit_every : int
        Answers from one comparison to the next; 0: none.

    """

    def __init__(self, model: BrakeModel, table: ExpansionTable | None = None, *,
                 limits: Tolerances | None = None, band: tuple[float, float] | None = None,
                 audit_every: int = AUDIT_EVERY) -> None:
        self.model, self.table = model, table
        self.limits = limits or Tolerances.of(model)
        self.band, self.audit_every = band, audit_every
        self.statistics = SolverStatistics()
        self._distrusted: set[int] = set()

    def solve(self, point: OperatingPoint) -> ComplexModes:
        """Return the complex modes at a point."""
        result, = self.solve_all([point])
        if isinstance(result, np.linalg.LinAlgError):
            raise result
        return result

    def solve_all(self, points: Sequence[OperatingPoint], places: FloatArray | None = None
                  ) -> list[ComplexModes | np.linalg.LinAlgError]:
        """
        Return the complex modes at several points, or why a point has none.

        The same bit for bit whatever else is solved; those of a cell cost little more than one.

        Parameters
        ----------
        points : sequence of OperatingPoint
            Sliding points.
        places : (P, 3) array, optional
            Their places in the table's domain, see `TableDomain.places`, if already known.

        """
        if self.table is None or not points:
            return [self._in_full(point) for point in points]
        if places is None:
            places = self.table.domain.places(self.model, points)
        known = self.table.evaluate(places, self.limits, self.band)
        listed = known.listed()
        result: list[ComplexModes | np.linalg.LinAlgError] = []
        for place, cell in enumerate(known.cells.tolist()):
            if cell < 0 or cell in self._distrusted:
                result.append(self._in_full(points[place]))
                continue
            self.statistics.tabulated += 1
            modes = listed[place]
            due = self.audit_every and self.statistics.tabulated % self.audit_every == 0
            result.append(self._spot_check(points[place], modes, cell) if due else modes)
        return result

    def distrust(self, point: OperatingPoint) -> None:
        """Do not use the table's cell at a point again, as it was found wrong."""
        if self.table is not None:
            self._distrust(int(self.table.locate(places_of([point]))[0]))

    def figures(self) -> dict[str, float]:
        """Return the counts, by name, and the size of the table."""
        cells = len(self.table.cells) if self.table else 0
        size = 1e-6 * self.table.nbytes if self.table else 0.0
        return {**asdict(self.statistics), 'cells': cells, 'megabytes': round(size, 3)}

    def _in_full(self, point: OperatingPoint, *,
                 audit: bool = False) -> ComplexModes | np.linalg.LinAlgError:
        self.statistics.full += not audit
        try:
            return complex_modes(self.model, point, tolerances=self.limits)
        except np.linalg.LinAlgError as error:
            return error

    def _spot_check(self, point: OperatingPoint, result: ComplexModes,
                    cell: int) -> ComplexModes | np.linalg.LinAlgError:
        """Compare an answer with the full solution, and distrust a cell that is wrong."""
        assert self.table is not None
        truth = self._in_full(point, audit=True)
        if isinstance(truth, np.linalg.LinAlgError):
            return truth
        off = deviation(result, truth, self.table.tolerances)
        self.statistics.audits += 1
        self.statistics.worst_audit = max(self.statistics.worst_audit, off)
        if off <= 1.0:
            return result
        self._distrust(cell)
        return truth

    def _distrust(self, cell: int) -> None:
        assert self.table is not None
        self.statistics.mismatches += 1
        self._distrusted.add(cell)
        self.table = self.table.without(cell)


def deviation(result: ComplexModes, truth: ComplexModes, tolerances: TableTolerances) -> float:
    """
    Return the largest distance of table and full solution, in tolerances.

    Of every oscillating mode that the table has or should have: that grows more than its bound on
    omitted modes.
    """
    limit, below = result.tolerances.oscillation, result.omitted_below
    ours, theirs = (m.mode_eigenvalues[(m.mode_eigenvalues.imag > limit)] for m in (result, truth))
    if not ours.size or not theirs.size:
        return 0.0 if ours.size == theirs.size else np.inf
    away = np.abs(ours[:, None] - theirs)
    listed = (away.min(axis=1) / tolerances.allowed(ours))[ours.real > below]
    due = (away.min(axis=0) / tolerances.allowed(theirs))[theirs.real > below]
    return float(max(listed.max(initial=0.0), due.max(initial=0.0)))
