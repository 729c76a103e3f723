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
Stability at the points of a grid, by local expansions of the spectrum that full solutions check.

A box of the grid is expanded around its middle and compared with full solutions at the corners
where the last terms of the power series are largest; a box that is off by more than the tolerance
is halved. Few points are solved in full, and so are those whose verdict hangs on the error. Within
boxes some points are solved in full, too, to measure the error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import moving_eigenvalues, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.grid_columns import COLUMNS, columns_of, EXPANSION, FULL, IMPOSSIBLE
from squeal_core.surrogate.spectral_deviation import Deviation
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_cell import TableTolerances

_FEW = 24  # points of a box that full solutions take no longer for than an expansion
_DEGREE = 3  # of the series: higher ones reach further but cost more than that saves
_CORNERS = 3  # at which an expansion is checked: those where its last terms are largest
_REACH, _LEAST = 200.0, 5.0  # tolerances that the last terms may be, at first and at least
_SHORTER, _LONGER = 0.6, 1.2  # of that where it was too much; of what was not
_CHECK_EVERY = 499  # points from one check within boxes to the next
_FREQUENCY = 2e-5  # largest error of a frequency, relative
_MARGIN = 2.0  # measured errors that a growth rate has to be away from the limit
_TURN = 2.0 * np.pi

Box: TypeAlias = tuple[tuple[int, int], ...]


@dataclass
class SolverCounts:
    """What a grid took; the largest error is that of the points checked within boxes [1/s]."""

    full: int = 0
    expansions: int = 0
    checks: int = 0
    largest_error: float = 0.0


@dataclass(eq=False)
class GridStability:
    """
    Solves a grid of operating points of one model.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    band : (2,) floats
        In which the least stable mode is wanted [Hz].
    tolerances : TableTolerances, optional
        Errors that expansions keep to; None: every point is solved in full.
    limits : Tolerances, optional
        What counts as oscillation and growth; None: `Tolerances.of(model)`.

    """

    model: BrakeModel
    band: tuple[float, float]
    tolerances: TableTolerances | None = None
    limits: Tolerances | None = None
    counts: SolverCounts = field(default_factory=SolverCounts)

    def solve(self, points: Sequence[OperatingPoint | None],
              shape: Sequence[int]) -> dict[str, FloatArray]:
        """
        Return `COLUMNS` (P,) at the points of a grid.

        Parameters
        ----------
        points : sequence of OperatingPoint
            The last axis runs fastest; None is an impossible point.
        shape : ints
            Of the grid.

        """
        limits = self.limits or Tolerances.of(self.model)
        grid = _Grid(self, points, tuple(shape), limits)
        grid.fill(tuple((0, n) for n in shape))
        return grid.columns


class _Grid:
    """The columns of one grid as they are filled, and full solutions by place."""

    def __init__(self, solver: GridStability, points: Sequence[OperatingPoint | None],
                 shape: tuple[int, ...], limits: Tolerances) -> None:
        self._solver, self._points, self._limits = solver, points, limits
        self._places = np.arange(len(points)).reshape(shape)
        self._solved: dict[int, ComplexArray] = {}
        self._scales = np.array([np.nan if p is None else p.damping_scale for p in points])
        self._coefficients = np.array([[np.nan] * 9 if p is None else p.coefficients()
                                       for p in points])
        tolerances = solver.tolerances
        self._reach = _REACH * tolerances.growth if tolerances else 0.0
        self.columns = {name: np.full(len(points), np.nan) for name in COLUMNS}
        self.columns['source'][:] = 0.0

    def fill(self, box: Box, ends: FloatArray | None = None) -> None:
        """
        Fill the columns of a box, by halves where one expansion does not do.

        Parameters
        ----------
        box : pairs of ints
            First place and the one after the last, along each axis.
        ends : (axes,) array, optional
            Last terms of a series at the ends of each axis, as that of a larger box has them.

        """
        places = self._places[tuple(slice(*pair) for pair in box)]
        if self._solver.tolerances is None or places.size <= _FEW:
            self._in_full(places.ravel())
            return
        axis = self._uneven(places)
        if axis is None and (ends is None or _together(ends) <= self._reach):
            ends = self._expanded(places)
            if ends is None:
                return
        if axis is None:
            assert ends is not None
            axis = int(np.argmax(places.shape)) if np.isnan(ends).any() else int(np.argmax(ends))
        if ends is not None:
            ends = np.where(np.arange(ends.size) == axis, 0.5**_DEGREE, 1.0) * ends
        low, high = box[axis]
        middle = (low + high) // 2
        for pair in ((low, middle), (middle, high)):
            self.fill((*box[:axis], pair, *box[axis + 1:]), ends)

    def _uneven(self, places: IndexArray) -> int | None:
        """Return an axis along which an expansion does not reach: damping, or no point there."""
        scales = self._scales[places]
        for axis in range(places.ndim):
            first = np.take(scales, [0], axis=axis)
            if not np.array_equal(np.broadcast_to(first, scales.shape), scales):
                return axis
        return None if not np.isnan(scales).any() else int(np.argmax(places.shape))

    def _expanded(self, places: IndexArray) -> FloatArray | None:
        """Fill a box by an expansion and return None, or its last terms at the ends of axes."""
        tolerances, middle = self._solver.tolerances, tuple(n // 2 for n in places.shape)
        centre = self._points[places[middle]]
        assert tolerances is not None
        assert centre is not None
        try:
            expansion = expand_spectrum(self._solver.model, centre, degree=_DEGREE)
        except np.linalg.LinAlgError:
            return np.full(places.ndim, np.nan)
        self._solver.counts.expansions += 1
        ends = np.array([0.0 if n == 1 else self._last_terms(expansion, places[(
            *middle[:axis], slice(None, None, n - 1), *middle[axis + 1:])]).max()
            for axis, n in enumerate(places.shape)])
        if not ends.any():
            ends[:] = np.nan
        corners = places[np.ix_(*([0, -1] if n > 1 else [0] for n in places.shape))].ravel()
        last = self._last_terms(expansion, corners)
        if last.max() > self._reach:
            return ends
        corners = corners[np.argsort(-last, kind='stable')[:_CORNERS]]
        worst = Deviation.none(expansion)
        for place, roots in zip(corners.tolist(), expansion.eigenvalues(
                self._coefficients[corners]), strict=True):
            worst = worst.with_(self._deviation(roots, self._roots(place)))
            if worst.off > 1.0:
                self._reach = max(_SHORTER * self._reach, _LEAST * tolerances.growth)
                return ends
        self._reach = max(self._reach, _LONGER * float(last.max()))
        return None if self._accept(expansion, places.ravel(), worst) else ends

    def _accept(self, expansion: SpectralExpansion, places: IndexArray,
                worst: Deviation) -> bool:
        """Fill the columns by an expansion, unless a check within the box finds it wrong."""
        counts = self._solver.counts
        roots = expansion.eigenvalues(self._coefficients[places])
        for i in np.flatnonzero(places % _CHECK_EVERY == _CHECK_EVERY // 2).tolist():
            here = self._deviation(roots[i], self._roots(int(places[i])))
            counts.checks += 1
            if here.off > 1.0:
                return False
            worst = worst.with_(here)
            counts.largest_error = max(counts.largest_error, here.growth)
        close = np.abs(roots.real - self._limits.growth) <= _MARGIN * worst.of_each(expansion)
        self._keep(places, roots, worst.growth, EXPANSION)
        self._in_full(places[(close & (roots.imag > self._limits.oscillation)).any(axis=1)])
        return True

    def _in_full(self, places: IndexArray) -> None:
        for place in places.tolist():
            if self._points[place] is None:
                self.columns['source'][place] = IMPOSSIBLE
            else:
                self._keep(np.array([place]), self._roots(place)[None], 0.0, FULL)

    def _roots(self, place: int) -> ComplexArray:
        """Return the eigenvalues at a point from a full solution, known zeros left out."""
        if place not in self._solved:
            point = self._points[place]
            assert point is not None
            self._solved[place] = moving_eigenvalues(self._solver.model, point)
            self._solver.counts.full += 1
        return self._solved[place]

    def _keep(self, places: IndexArray, roots: ComplexArray, error: float, source: float) -> None:
        found = {**columns_of(roots, self._solver.model.size, self._limits, self._solver.band),
                 'error': error, 'source': source}
        for name, values in found.items():
            self.columns[name][places] = values

    def _last_terms(self, expansion: SpectralExpansion, places: IndexArray) -> FloatArray:
        """Return the largest sum of the series' terms of the highest degree at places [1/s]."""
        steps = (self._coefficients[places][:, expansion.rows] - expansion.centre) / (
            expansion.scales)
        count = len(expansion.monomials.terms[-1])
        terms = expansion.monomials.at(steps)[:, -count:] @ expansion.series[
            -count:, self._entries(expansion)]
        return np.asarray(np.abs(terms).max(axis=1, initial=0.0))

    def _entries(self, expansion: SpectralExpansion) -> Any:
        """Tell which entries of the blocks are those of modes that matter at the centre."""
        tolerances, highest = self._solver.tolerances, _TURN * self._solver.band[1]
        assert tolerances is not None
        entries, start = np.zeros(expansion.series.shape[1], bool), 0
        for size in expansion.sizes.tolist():
            own = expansion.series[0, start:start + size**2:size + 1]
            entries[start:start + size**2] = np.any(
                (own.real > tolerances.matters) & (own.imag <= highest))
            start += size**2
        return entries

    def _deviation(self, found: ComplexArray, truth: ComplexArray) -> Deviation:
        """Compare spectra: modes close to growing, and the least stable one in the band."""
        tolerances = self._solver.tolerances
        assert tolerances is not None
        each, off = np.full(found.size, -1.0), 0.0
        for one, other in ((found, truth), (truth, found)):
            matter = self._matters(one, tolerances)
            if not matter.any() or not other.size:
                off = np.inf if matter.any() else off
                continue
            mine = one[matter]
            nearest = other[np.abs(mine[:, None] - other).argmin(axis=1)]
            growth, turning = np.abs(mine.real - nearest.real), np.abs(mine.imag - nearest.imag)
            allowed = tolerances.allowed(mine)
            off = max(off, float((growth / allowed).max()), float((
                turning / np.maximum(allowed, _FREQUENCY * np.abs(mine.imag))).max()))
            if one is found:
                each[matter] = growth
        return Deviation(off, each)

    def _matters(self, roots: ComplexArray, tolerances: TableTolerances) -> Any:
        oscillating = roots.imag > self._limits.oscillation
        close = np.where(oscillating, roots.real > tolerances.matters,
                         (roots.real > tolerances.growth) & (
                             np.abs(roots.imag) <= self._limits.oscillation))
        low, high = (_TURN * end for end in self._solver.band)
        inside = np.where(oscillating & (roots.imag >= low) & (roots.imag <= high),
                          roots.real, -np.inf)
        close[np.argmax(inside)] |= np.isfinite(inside.max())
        return close


def _together(ends: FloatArray) -> float:
    """Return the last terms at a corner, by those at the ends of axes."""
    return float(np.sum(ends ** (1.0 / _DEGREE)) ** _DEGREE)
