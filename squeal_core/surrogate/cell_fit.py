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
One cell of a table: the eigenvalues that matter in a region, fitted to full solutions.

A power series around the centre of the cell tells which eigenvalue of a full solution elsewhere in
the cell is which, and which of them meet. The invariants of each block are then fitted by least
squares to full solutions on the surface of the cell, or to the series where that is as good at all
corners, and the residuals, at points of the fit and at others inside, bound the error.
"""

from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.full_solutions import FullSolutions
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.table_cell import (
    BlockInvariants,
    DEGREE,
    fit_terms,
    not_known,
    TableCell,
    TableTolerances,
    verdict_within_error,
)

_CORNERS = 8
_HELD_OUT = 8  # points that are not fitted
_SPREAD = np.array([0.2, 0.25, 0.03])  # ln speed, ln pressure, friction: the usual reach
_MARGIN = 1 / 3  # of that decay rate, between omitted modes at the samples and their bound
_QUIET = 1 / 5  # of that decay rate: up to it the series has modes flutter
_DAMPED = 1e4  # times that decay rate: bound where no mode is omitted
_SAFETY = 2.0  # on the residuals, for between the samples
_HANGING = 0.02  # fraction of a cell that may be without a verdict, and is solved in full
_WITHIN = 256  # points at which that is counted
_CLOSE = 0.2  # tolerances that a series is off at a corner, up to which it is fitted itself
_CORRECTED = 0.25  # of that: tolerances by which solutions are fitted better than the series
_ASTRAY = 40.0  # times the tolerance that a series is off at a corner, beyond which no fit helps
_FAR = 8.0  # times that, from which half the cell would be too large as well


@dataclass(frozen=True)
class Rejection:
    """
    A cell that is too large, and the axes along which to halve it, one after the other.

    With contents where it will do if it cannot be halved.
    """

    axes: tuple[int, ...]
    cell: TableCell | None = None


@cache
def samples() -> FloatArray:
    """
    Return the points of full solutions (S, 3) in cell coordinates: corners, others, held out.

    Those of the fit are on the edges, at quarters, and amid the faces: cells side by side share
    them, and the halves of a cell many of those of the whole.
    """
    grid = np.array(list(product((-1.0, -0.5, 0.0, 0.5, 1.0), repeat=3)))
    size = np.sort(np.abs(grid), axis=1)
    edges = grid[size[:, 1] == 1.0]
    # the steepest corners first, as series go astray there: slow, high pressure and friction
    inner = np.abs(edges).min(axis=1) < 1.0
    edges = edges[np.lexsort((edges @ (1.0, -1.0, -1.0), inner))]
    return np.vstack([edges, np.eye(3), -np.eye(3), _spread(_HELD_OUT)])


def _spread(count: int) -> FloatArray:
    """Return points (count, 3) that fill a cell evenly: the R3 sequence."""
    steps = np.array([0.8191725134, 0.6710436067, 0.5497004779])
    return np.asarray(2.0 * ((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1.0) - 1.0)


@cache
def _within() -> FloatArray:
    """Return the terms at points all over a cell."""
    return fit_terms(DEGREE).at(_spread(_WITHIN))


@cache
def _inner() -> FloatArray:
    """Return points (125, 3) inside a cell, at which the series alone looks for flutter."""
    return np.array(list(product((-0.8, -0.4, 0.0, 0.4, 0.8), repeat=3)))


@cache
def _fitting(degree: int) -> FloatArray:
    """Return the least-squares operator (terms, fitted samples)."""
    return np.asarray(np.linalg.pinv(fit_terms(degree).at(samples()[:-_HELD_OUT])))


def fit_cell(solutions: FullSolutions, centre: FloatArray, half: FloatArray,
             tolerances: TableTolerances, limits: Tolerances) -> TableCell | Rejection:
    """
    Return the modes that matter in a cell, or along which axes to halve it.

    Parameters
    ----------
    solutions : FullSolutions
        Of the model in the envelope that the cell is part of.
    centre, half : (3,) arrays
        Centre and half the edges of the cell in the domain's coordinates.
    tolerances : TableTolerances
        Errors to keep to.
    limits : Tolerances
        What counts as oscillation.

    """
    model, domain = solutions.model, solutions.domain
    x = np.vstack([centre, centre + half * samples()])
    points = domain.points(model, x)
    try:
        expansion = expand_spectrum(model, points[0])
    except np.linalg.LinAlgError:
        return Rejection((int(np.argmax(half / _SPREAD)),))
    fit = _Fit(expansion, points.coefficients().T[1:], tolerances, limits)
    fit.look_inside(domain.points(model, centre + half * _inner()).coefficients().T)
    fit.look_along(domain.points(model, centre + half * _lines()).coefficients().T)
    for place in range(_CORNERS):
        fit.add(solutions.at(x[1 + place], points[1 + place]))
        astray = fit.astray()
        if astray > _ASTRAY:
            return Rejection(fit.axes(2 if astray > _FAR * _ASTRAY else 1))
    if fit.is_hopeless():
        return Rejection(fit.axes())
    if astray < _CLOSE:
        fit.trust_series()
    for place in range(len(fit), len(samples())):
        fit.add(solutions.at(x[1 + place], points[1 + place]))
    return fit.cell()


@cache
def _lines() -> FloatArray:
    """Return points (12, 3) on the axes, from which third differences are taken."""
    return np.concatenate([np.outer((-1.0, -1 / 3, 1 / 3, 1.0), axis) for axis in np.eye(3)])


class _Fit:
    """The full solutions at the samples of a cell, sorted as the series has its eigenvalues."""

    def __init__(self, expansion: SpectralExpansion, coefficients: FloatArray,
                 tolerances: TableTolerances, limits: Tolerances) -> None:
        self._expansion, self._tolerances, self._limits = expansion, tolerances, limits
        self._predicted = expansion.eigenvalues(coefficients)
        self._own = np.repeat(np.arange(expansion.sizes.size), expansion.sizes)
        self._roots = np.zeros((0, self._own.size), complex)
        self._flutters = np.zeros(self._own.size, bool)

    def look_inside(self, coefficients: FloatArray) -> None:
        """
        Record modes that grow somewhere inside the cell by the series.

        Two modes that decay may meet and flutter in a region too narrow for the samples.
        """
        top = self._expansion.eigenvalues(coefficients).real.max(axis=0)
        self._flutters = top > _QUIET * self._tolerances.matters

    def look_along(self, coefficients: FloatArray) -> None:
        """Record the third differences of blocks (3, blocks) along the axes."""
        eigenvalues = self._expansion.eigenvalues(coefficients).reshape(3, 4, -1)
        means = np.add.reduceat(eigenvalues, np.searchsorted(
            self._own, np.arange(self._expansion.sizes.size)), axis=-1)
        self._thirds = np.abs(means[:, 3] - 3 * means[:, 2] + 3 * means[:, 1] - means[:, 0])
        self._matter = means.real.max(axis=(0, 1)) > (
            self._tolerances.matters * self._expansion.sizes)

    def axes(self, count: int = 1, blocks: Any = None) -> tuple[int, ...]:
        """Return axes to halve the cell along: where blocks, or all that matter, bend most."""
        bends = self._thirds[:, self._matter if blocks is None else blocks].sum(axis=-1)
        result = []
        for _ in range(count):
            result.append(int(np.argmax(bends)))
            bends[result[-1]] /= 8.0  # what halving leaves of a third difference
        return tuple(result)

    def add(self, solution: ComplexArray) -> None:
        """Take the full solution at the next sample."""
        predicted = self._predicted[len(self)]
        away = np.abs(predicted[:, None] - solution)
        nearest = away.argmin(axis=1)
        if np.unique(nearest).size < nearest.size:
            nearest = linear_sum_assignment(away)[1]
        self._roots = np.vstack([self._roots, solution[nearest]])

    def __len__(self) -> int:
        return len(self._roots)

    def astray(self) -> float:
        """Return by how much the series is off at the samples so far, in tolerances."""
        off = np.abs(self._roots - self._predicted[:len(self)])
        off /= self._tolerances.allowed(self._roots)
        return float(off[:, self._needed(self._roots)].max(initial=0.0))

    def is_hopeless(self) -> bool:
        """Return whether no polynomials will fit, by the series, before most solutions."""
        factor = 1.0 + _CORRECTED * self.astray()
        loose = replace(self._tolerances, growth=factor * self._tolerances.growth,
                        decay=factor * self._tolerances.decay)
        return self._fails(self._fitted(self._predicted), loose)

    def trust_series(self) -> None:
        """Take the series for the solutions that the fit lacks; those held out check it."""
        self._roots = np.vstack([self._roots, self._predicted[len(self):-_HELD_OUT]])

    def cell(self) -> TableCell | Rejection:
        """Return the fit to the full solutions, or along which axes to halve the cell."""
        cell = self._fitted(self._roots)
        if self._fails(cell, self._tolerances):
            return Rejection(self.axes())
        hanging = verdict_within_error(*cell.at(_within()), self._limits)
        if hanging.any(axis=1).mean() <= _HANGING:
            return cell
        blocks = self._own[self._kept(self._roots)][hanging.any(axis=0)]
        return Rejection(self.axes(blocks=np.unique(blocks)), cell)

    def _fails(self, cell: TableCell, tolerances: TableTolerances) -> bool:
        if not np.isfinite(cell.series).all():  # a block too large for single precision
            return True
        eigenvalues, errors = cell.at(fit_terms(DEGREE).at(samples()))
        return bool(not_known(eigenvalues, errors, cell.mirrored, cell.omitted_below, tolerances,
                              self._limits).any())

    def _oscillating(self, eigenvalues: ComplexArray) -> Any:
        return (eigenvalues.imag > self._limits.oscillation).any(axis=0)

    def _needed(self, eigenvalues: ComplexArray) -> Any:
        """Return whether each eigenvalue (n,) matters somewhere in the cell."""
        top = eigenvalues.real.max(axis=0)
        quiet = (np.abs(eigenvalues.imag) <= self._limits.oscillation).any(axis=0)
        matters = self._flutters | (top > self._below(eigenvalues))
        return (self._oscillating(eigenvalues) & matters) | (
            quiet & (top > -self._tolerances.growth))

    def _kept(self, eigenvalues: ComplexArray) -> Any:
        """Return whether each eigenvalue (n,) is of a block that matters."""
        return np.isin(self._own, self._own[self._needed(eigenvalues)])

    def _below(self, eigenvalues: ComplexArray) -> float:
        """Return the growth rate below which modes are omitted: the band's worst one is kept."""
        low, high = self._tolerances.band
        hertz = eigenvalues.imag / (2.0 * np.pi)
        inside = (hertz >= low) & (hertz <= high)
        worst = np.where(inside, eigenvalues.real, np.inf if not inside.any() else -np.inf)
        return min(self._tolerances.matters, float(worst.max(axis=1).min())
                   + 2.0 * _MARGIN * self._tolerances.matters)

    def _fitted(self, eigenvalues: ComplexArray) -> TableCell:
        """Fit the blocks that matter to eigenvalues (S, n) at all samples."""
        kept = self._kept(eigenvalues)
        layout = BlockInvariants(self._expansion.sizes[np.unique(self._own[kept])])
        invariants = layout.of(eigenvalues[:, kept])
        omitted, matters = ~kept & self._oscillating(eigenvalues), self._tolerances.matters
        series = _fitting(DEGREE) @ invariants[:-_HELD_OUT].view(float)
        series[1:] = _single(series[1:])  # the frequency itself has more digits
        with np.errstate(invalid='ignore'):
            fitted = (fit_terms(DEGREE).at(samples()) @ series).view(complex)
        return TableCell(
            layout.sizes, series,
            _single(_SAFETY * np.abs(fitted - invariants).max(axis=0, initial=0.0)),
            self._expansion.mirrored[kept],
            _single(_fitting(2) @ eigenvalues.imag[:-_HELD_OUT, omitted]),
            float(np.float32(eigenvalues.real[:, omitted].max(initial=_DAMPED * matters)
                             - _MARGIN * matters)))


def _single(values: FloatArray) -> FloatArray:
    """Return values in single precision, as a file keeps them."""
    with np.errstate(over='ignore'):
        return np.asarray(values.astype(np.float32), float)
