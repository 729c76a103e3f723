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
One cell of a table's envelope, and its required accuracy.

Eigenvalues that meet are no smooth functions of the operating point, but the coefficients of the
characteristic polynomial of all that meet are. A block of n eigenvalues is n numbers: its mean m
and the coefficients c_2 ... c_n of prod (z - z_k) = z^n + c_2 z^(n-2) + ... + c_n, z = lambda - m.
"""

from dataclasses import dataclass
from functools import cache, cached_property
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.state_space import frequency_scale
from squeal_core.surrogate.monomials import Monomials

DEGREE = 4  # of the fit: 35 terms
_GROWTH = 4.9e-7  # of the model's largest frequency: ten times what counts as growth
_MATTERS = 2.47e-5  # of the model's largest frequency: decay rate of modes that do not matter
_TINY = 1e-200  # so small that nothing finite over it overflows


@cache
def fit_terms(degree: int) -> Monomials:
    """Return the polynomial terms of the cell coordinates."""
    return Monomials(3, degree)


@dataclass(frozen=True, kw_only=True)
class TableTolerances:
    """
    Modes that a table has to hold, and their required accuracy.

    Parameters
    ----------
    growth : float
        Largest error of an eigenvalue [1/s].
    decay : float
        Largest error of a mode that decays, as a fraction of its decay rate, where that is more.
    matters : float
        Modes whose growth rate stays below this throughout a cell are omitted from it [1/s].
    band : (2,) floats
        Band in which the least stable mode is always kept, whatever its growth rate [Hz].

    """

    growth: float = 0.1
    decay: float = 0.02
    matters: float = -5.0
    band: tuple[float, float] = (1250.0, 16000.0)

    def __post_init__(self) -> None:
        low, high = self.band
        if not (0.0 < self.growth < math.inf and 0.0 <= self.decay < math.inf
                and -math.inf < self.matters < math.inf and 0.0 <= low < high):
            raise SquealError(f'{self}: give finite tolerances above 0 and a rising band')

    @classmethod
    def of(cls, model: BrakeModel, *, growth: float | None = None) -> 'TableTolerances':
        """Return tolerances relative to the model's spectrum; 0.1 and -5 1/s for K09's."""
        scale = frequency_scale(model)
        if not scale:
            return cls() if growth is None else cls(growth=growth)
        return cls(growth=_GROWTH * scale if growth is None else growth,
                   matters=-_MATTERS * scale)

    def allowed(self, eigenvalues: Any) -> Any:
        """Return the largest error of each eigenvalue [1/s]."""
        return np.maximum(self.growth, -self.decay * eigenvalues.real)


@dataclass(frozen=True, eq=False)
class BlockInvariants:
    """
    Layout of the invariants of blocks: single eigenvalues, means and squares of pairs, others.

    There are as many of them as eigenvalues.

    Parameters
    ----------
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.

    """

    sizes: IndexArray

    @cached_property
    def count(self) -> int:
        """Return the number of eigenvalues."""
        return int(self.sizes.sum())

    @cached_property
    def larger(self) -> tuple[slice, ...]:
        """Place of each larger block among the eigenvalues and invariants."""
        ends = np.cumsum(self.sizes).tolist()
        return tuple(slice(end - size, end) for end, size in zip(
            ends, self.sizes.tolist(), strict=True) if size > 2)

    def of(self, eigenvalues: ComplexArray) -> ComplexArray:
        """Return the invariants (..., n) of eigenvalues (..., n), block by block."""
        result = np.array(eigenvalues, order='C')
        first, middle, end = self._ends
        one, other = eigenvalues[..., first:end:2], eigenvalues[..., first + 1:end:2]
        result[..., first:middle] = 0.5 * (one + other)
        result[..., middle:end] = (0.5 * (one - other)) ** 2
        for place in self.larger:
            result[..., place] = _polynomial(eigenvalues[..., place])
        return result

    @cached_property
    def _ends(self) -> tuple[int, int, int]:
        """Places of the means of pairs, of their squares, of the larger blocks."""
        singles, pairs = (int(np.count_nonzero(self.sizes == size)) for size in (1, 2))
        return singles, singles + pairs, singles + 2 * pairs

    def eigenvalues(self, invariants: ComplexArray,
                    bounds: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """
        Return the eigenvalues, (..., n) [1/s], and bounds of their errors, (..., n) [1/s].

        Parameters
        ----------
        invariants : (..., n) array
            Of all blocks.
        bounds : (n,) or (..., n) array
            Of the errors of the invariants.

        """
        first, middle, end = self._ends
        eigenvalues = invariants.copy()
        errors = np.empty(eigenvalues.shape)
        errors[...] = bounds
        if end > first:
            mean, s = invariants[..., first:middle], np.sqrt(invariants[..., middle:end])
            off, square = bounds[..., first:middle], bounds[..., middle:end]
            eigenvalues[..., first:end:2], eigenvalues[..., first + 1:end:2] = mean + s, mean - s
            off = off + np.minimum(np.sqrt(square), square / (np.abs(s) + _TINY))
            errors[..., first:end:2] = errors[..., first + 1:end:2] = off
        for place in self.larger:
            there = ~np.isnan(invariants[..., place.start])
            if there.any():
                eigenvalues[there, place], errors[there, place] = _solved(
                    invariants[there, place], errors[there, place])
        return eigenvalues, errors

    def places_in(self, other: 'BlockInvariants') -> tuple[IndexArray, IndexArray]:
        """Return the places of eigenvalues and invariants (n,) in a layout of more blocks."""
        within = np.arange(self.sizes.size) - np.searchsorted(self.sizes, self.sizes)
        blocks = np.searchsorted(other.sizes, self.sizes) + within  # as many of the same size
        moved = (np.cumsum(other.sizes) - other.sizes)[blocks] - np.cumsum(self.sizes) + self.sizes
        eigenvalues = np.arange(self.count) + np.repeat(moved, self.sizes)
        invariants = np.empty_like(eigenvalues)
        invariants[self._order] = other._order[eigenvalues]
        return eigenvalues, invariants

    @cached_property
    def _order(self) -> IndexArray:
        """Place (n,) of the invariant that stands for each eigenvalue."""
        first, middle, end = self._ends
        result = np.arange(self.count)
        result[first:end:2] = np.arange(first, middle)
        result[first + 1:end:2] = np.arange(middle, end)
        return result


@dataclass(frozen=True, eq=False)
class TableCell:
    """
    Blocks of eigenvalues in a cell, as polynomials of its coordinates u in [-1, 1]^3.

    Parameters
    ----------
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.
    series : (terms, 2 n) array
        Real and imaginary part of the blocks' invariants; the first row in double precision.
    bounds : (n,) array
        Of the errors of the invariants.
    mirrored : (n,) bool array
        Eigenvalues whose conjugates are not among them.
    omitted : (terms of degree 2, modes) array
        Angular frequency of the omitted modes [rad/s].
    omitted_below : float
        Growth rate that the omitted modes stay below [1/s].

    """

    sizes: IndexArray
    series: FloatArray
    bounds: FloatArray
    mirrored: Any
    omitted: FloatArray
    omitted_below: float

    @cached_property
    def layout(self) -> BlockInvariants:
        return BlockInvariants(self.sizes)

    def at(self, terms: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """
        Return eigenvalues (P, n) and their error bounds (P, n).

        Parameters
        ----------
        terms : (P, terms) array
            Of the cell coordinates, as `fit_terms` has them.

        """
        return self.layout.eigenvalues((terms @ self.series).view(complex), self.bounds)


def not_known(eigenvalues: ComplexArray, errors: FloatArray, mirrored: Any, omitted_below: Any,
              tolerances: TableTolerances, limits: Tolerances) -> Any:
    """
    Return whether each eigenvalue (..., n) of cells is not known well enough.

    Those are modes that matter with errors above the tolerance, and pairs that became real.
    """
    failing = (errors > tolerances.allowed(eigenvalues)) & (
        eigenvalues.real + errors > omitted_below)
    return failing | (mirrored & (eigenvalues.imag <= limits.oscillation))


def verdict_within_error(eigenvalues: ComplexArray, errors: FloatArray,
                         tolerances: Tolerances) -> Any:
    """Return whether each verdict is within the error."""
    return np.abs(eigenvalues.real - tolerances.growth) <= errors


def _polynomial(eigenvalues: ComplexArray) -> ComplexArray:
    """Return mean and coefficients (..., n) of a larger block."""
    mean = eigenvalues.mean(axis=-1, keepdims=True)
    coefficients = np.zeros((*eigenvalues.shape[:-1], eigenvalues.shape[-1] + 1), complex)
    coefficients[..., 0] = 1.0
    for eigenvalue in np.moveaxis(eigenvalues - mean, -1, 0):
        coefficients[..., 1:] -= eigenvalue[..., None] * coefficients[..., :-1]
    return np.concatenate([mean, coefficients[..., 2:]], axis=-1)


def _solved(invariants: ComplexArray, bounds: FloatArray) -> tuple[Any, Any]:
    """Return the eigenvalues (..., n) of a larger block and the bounds of their errors."""
    size = invariants.shape[-1]
    companion = np.zeros((*invariants.shape[:-1], size, size), complex)
    companion[..., range(1, size), range(size - 1)] = 1.0
    companion[..., 0, 1:] = -invariants[..., 1:]
    z = np.linalg.eigvals(companion)
    apart = np.abs(z[..., :, None] - z[..., None, :])
    apart[..., range(size), range(size)] = 1.0
    powers = np.abs(z)[..., None] ** np.arange(size - 2, -1, -1)
    off = (powers @ bounds[..., 1:, None])[..., 0] / (apart.prod(axis=-1) + _TINY)
    return invariants[..., :1] + z, bounds[..., :1] + off
