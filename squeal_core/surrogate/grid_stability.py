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

A box of the grid is expanded around its middle and compared with full solutions at its corners,
where a power series is worst; a box that is off by more than the tolerance is halved. Few points
are solved in full, and so are those whose verdict hangs on the error. Within boxes some points
are solved in full, too, to measure the error where nothing was fitted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import eigenvalues, Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_cell import TableTolerances

COLUMNS = ('growth_rate', 'frequency_hz', 'damping_ratio', 'mode', 'squeal_modes',
           'flutter_modes', 'divergent_modes', 'error', 'source')
"""Of each point: growth rate [1/s], frequency, damping ratio and number of the least stable mode
in the band; flutter modes in the band, in all; divergent ones; error bound [1/s]; source."""
FULL, EXPANSION, IMPOSSIBLE = 1.0, 2.0, 3.0  # sources; 0: not done

_FEW = 24  # points of a box that full solutions take no longer for than an expansion
_CORNERS = 8  # at which an expansion is checked
_HOPELESS = 10.0  # tolerances that the last terms of a series may be before it is checked
_CHECK_EVERY = 499  # points from one check within boxes to the next
_CLOSE = 10.0  # tolerances from zero growth up to which an error is one of verdicts
_MARGIN = 2.0  # measured errors that a growth rate has to be away from the limit
_WIDTH = 2.0 * np.pi

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
        Return `COLUMNS` (P,) at the points of a grid; None is a point that there cannot be.

        Parameters
        ----------
        points : sequence of OperatingPoint
            The last axis runs fastest.
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
        self._free = int(np.count_nonzero(solver.model.free_coordinates))
        self._solved: dict[int, ComplexArray] = {}
        self._scales = np.array([np.nan if p is None else p.damping_scale for p in points])
        self._coefficients = np.array([[np.nan] * 9 if p is None else p.coefficients()
                                       for p in points])
        self.columns = {name: np.full(len(points), np.nan) for name in COLUMNS}
        self.columns['source'][:] = 0.0

    def fill(self, box: Box) -> None:
        """Fill the columns of a box, by halves where one expansion does not do."""
        places = self._places[tuple(slice(*ends) for ends in box)]
        if self._solver.tolerances is None or places.size <= _FEW:
            self._in_full(places.ravel())
            return
        axis = self._uneven(places)
        if axis is None:
            axis = self._expanded(places)
        if axis is None:
            return
        low, high = box[axis]
        middle = (low + high) // 2
        for ends in ((low, middle), (middle, high)):
            self.fill((*box[:axis], ends, *box[axis + 1:]))

    def _uneven(self, places: IndexArray) -> int | None:
        """Return an axis along which an expansion does not reach: damping, or no point there."""
        scales = self._scales[places]
        for axis in range(places.ndim):
            first = np.take(scales, [0], axis=axis)
            if not np.array_equal(np.broadcast_to(first, scales.shape), scales):
                return axis
        return None if not np.isnan(scales).any() else int(np.argmax(places.shape))

    def _expanded(self, places: IndexArray) -> int | None:
        """Fill a box by an expansion and return None, or the axis to halve."""
        tolerances, middle = self._solver.tolerances, tuple(n // 2 for n in places.shape)
        centre = self._points[places[middle]]
        assert tolerances is not None
        assert centre is not None
        longest = int(np.argmax(places.shape))
        try:
            expansion = expand_spectrum(self._solver.model, centre)
        except np.linalg.LinAlgError:
            return longest
        self._solver.counts.expansions += 1
        ends = [self._last_terms(expansion, places[tuple(
            slice(None) if i == axis else slice(at, at + 1) for i, at in enumerate(middle))])
            for axis in range(places.ndim)]
        axis = int(np.argmax(ends)) if max(ends) > 0.0 else longest
        corners = _corners(places)
        if self._last_terms(expansion, corners) > _HOPELESS * tolerances.growth:
            return axis
        found = expansion.eigenvalues(self._coefficients[corners])
        worst = _Deviation()
        for place, roots in zip(corners.tolist(), found, strict=True):
            worst = worst.with_(self._deviation(roots, self._roots(place)))
            if worst.off > 1.0:
                return axis
        return None if self._accept(expansion, places.ravel(), worst) else axis

    def _accept(self, expansion: SpectralExpansion, places: IndexArray,
                worst: '_Deviation') -> bool:
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
        close = np.abs(roots.real - self._limits.growth) <= _MARGIN * worst.of_verdicts
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
            self._solved[place] = eigenvalues(self._solver.model, point)[self._free:]
            self._solver.counts.full += 1
        return self._solved[place]

    def _keep(self, places: IndexArray, roots: ComplexArray, error: float, source: float) -> None:
        found = {**columns_of(roots, self._solver.model.size, self._limits, self._solver.band),
                 'error': error, 'source': source}
        for name, values in found.items():
            self.columns[name][places] = values

    def _last_terms(self, expansion: SpectralExpansion, places: IndexArray) -> float:
        """Return the largest sum of the series' terms of the highest degree at both ends [1/s]."""
        ends = places.ravel()[[0, -1]] if places.ndim > 1 else places
        steps = (self._coefficients[ends][:, expansion.rows] - expansion.centre) / expansion.scales
        count = len(expansion.monomials.terms[-1])
        terms = expansion.monomials.at(steps)[:, -count:] @ expansion.series[-count:]
        return float(np.abs(terms[:, :expansion.sizes.size]).max(initial=0.0))

    def _deviation(self, found: ComplexArray, truth: ComplexArray) -> '_Deviation':
        """Compare spectra: modes close to growing, and the least stable one in the band."""
        tolerances = self._solver.tolerances
        assert tolerances is not None
        worst = _Deviation()
        for one, other in ((found, truth), (truth, found)):
            mine = one[self._matters(one, tolerances)]
            if not mine.size or not other.size:
                worst = worst.with_(_Deviation(np.inf if mine.size else 0.0))
                continue
            nearest = other[np.abs(mine[:, None] - other).argmin(axis=1)]
            growth = np.abs(mine.real - nearest.real)
            close = np.abs(mine.real - self._limits.growth) <= _CLOSE * tolerances.growth
            worst = worst.with_(_Deviation(
                float((np.abs(mine - nearest) / tolerances.allowed(mine)).max()),
                float(growth.max()), float(growth[close].max(initial=-1.0))))
        return worst

    def _matters(self, roots: ComplexArray, tolerances: TableTolerances) -> Any:
        oscillating = roots.imag > self._limits.oscillation
        close = np.where(oscillating, roots.real > tolerances.matters,
                         (roots.real > tolerances.growth) & (
                             np.abs(roots.imag) <= self._limits.oscillation))
        low, high = (_WIDTH * end for end in self._solver.band)
        inside = np.where(oscillating & (roots.imag >= low) & (roots.imag <= high),
                          roots.real, -np.inf)
        close[np.argmax(inside)] |= np.isfinite(inside.max())
        return close


@dataclass(frozen=True)
class _Deviation:
    """Largest distance in tolerances, errors of growth of all modes and of those close to 0."""

    off: float = 0.0
    growth: float = 0.0
    close: float = -1.0  # 1/s; below 0: there are none

    def with_(self, other: '_Deviation') -> '_Deviation':
        return _Deviation(max(self.off, other.off), max(self.growth, other.growth),
                          max(self.close, other.close))

    @property
    def of_verdicts(self) -> float:
        """Return the error of growth rates that verdicts hang on [1/s]."""
        return self.close if self.close >= 0.0 else self.growth


def _corners(places: IndexArray) -> IndexArray:
    """Return the places of a box's corners, those of opposite ends first, so many at most."""
    ends = [(0,) if n == 1 else (0, n - 1) for n in places.shape]
    every = list(product(*ends))
    if len(every) > _CORNERS:  # evenly out of them, each with the opposite one
        half = len(every) // 2
        chosen = np.linspace(0, half - 1, _CORNERS // 2).round().astype(int).tolist()
        every = [every[i] for i in (*chosen, *(len(every) - 1 - i for i in chosen))]
    return np.array([places[corner] for corner in every])


def columns_of(roots: ComplexArray, modes: int, limits: Tolerances,
               band: tuple[float, float]) -> Mapping[str, FloatArray]:
    """
    Return what `COLUMNS` says of spectra.

    Parameters
    ----------
    roots : (P, n) complex array
        Eigenvalues in any order [1/s]; those with Im < 0 may be missing.
    modes : int
        N of the model.
    limits : Tolerances
        What counts as oscillation and growth.
    band : (2,) floats
        [Hz]

    """
    oscillating, growing = roots.imag > limits.oscillation, roots.real > limits.growth
    hertz = roots.imag / _WIDTH
    inside = oscillating & (hertz >= band[0]) & (hertz <= band[1])
    growth = np.where(inside, roots.real, -np.inf)
    rows, worst = np.arange(len(roots)), growth.argmax(axis=1)
    least = np.where(inside.any(axis=1), roots[rows, worst], complex(np.nan, np.nan))
    above = (oscillating & (roots.imag > least.imag[:, None])).sum(axis=1)
    still = np.abs(roots.imag) <= limits.oscillation
    return {
        'growth_rate': least.real, 'frequency_hz': least.imag / _WIDTH,
        'damping_ratio': -least.real / np.abs(least),
        'mode': np.where(np.isnan(least.real), np.nan, modes - above),
        'squeal_modes': (inside & growing).sum(axis=1).astype(float),
        'flutter_modes': (oscillating & growing).sum(axis=1).astype(float),
        'divergent_modes': (still & growing).sum(axis=1).astype(float)}
