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
Growth rates of a brake's families of modes, from functions fitted to full solutions beforehand.

Eigenvalues that meet are no smooth functions of the inputs, but the entries of the small matrix
that they are the eigenvalues of are: analytic in the coefficients of the affine family D(q), K(q).
So they are polynomials in these here, in pieces of contact stiffness. Growth rates of single modes
and pairs follow in closed form; where families cross, they have a larger matrix in common.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly, RealArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.risk.polynomial_basis import BRAKE, OPERATION, PolynomialBasis
from squeal_core.risk.small_matrices import (
    CommonMatrix,
    complex_entries,
    lead_of_pairs,
    least_stable,
    matrices_of,
)

INPUTS = ('ln_rotor_speed', 'ln_contact_pressure', 'friction', 'ln_contact_stiffness',
          'ln_damping', 'slope_scale')
"""ln of |Omega| [rad/s] and of p0 [Pa]; mu [-]; ln of the factors on the model's k_c at this p0
and on its damping; factor on the friction slope by the model's law."""

_WITH_FRICTION = np.array([[0.0], [1.0], [1.0], [1.0]])  # which of them are in proportion to it
_WITH_DAMPING = np.array([[0.0], [1.0]])
_CHUNK = 256  # rows evaluated at once: their terms stay in the cache


@dataclass(frozen=True, eq=False)
class EmulatorDomain:
    """
    Inputs that an emulator covers: a box without its steepest corner.

    Parameters
    ----------
    low, high : (6,) arrays
        Ends of the inputs, in the order of `INPUTS`.
    steepest : float
        p0 mu / Omega [Pa s] up to which it is covered; beyond, the brake creeps under full load.

    """

    low: FloatArray
    high: FloatArray
    steepest: float = math.inf

    def covers(self, inputs: FloatArray) -> Any:
        """Tell which rows (...) of inputs (..., 6) are covered."""
        inside = ((inputs >= self.low) & (inputs <= self.high)).all(axis=-1)
        with np.errstate(over='ignore', invalid='ignore'):
            load = np.exp(inputs[..., 1] - inputs[..., 0]) * inputs[..., 2]
        return inside & (load <= self.steepest)


@dataclass(frozen=True)
class EmulatorError:
    """
    Error of growth rates above -30 1/s, by full solutions at points that no fit has seen.

    Parameters
    ----------
    rms, largest : float
        [1/s].
    points : int
        Number of full solutions.

    """

    rms: float
    largest: float
    points: int = 0


class EmulatedGrowth(NamedTuple):
    """
    Least stable mode of each family, (..., F); NaN outside the domain.

    Attributes
    ----------
    growth_rate, frequency_hz : arrays
        [1/s], [Hz].
    by_friction : array
        d growth rate / d mu, along the friction law [1/s].
    by_damping : array
        d growth rate / d ln(damping scale) [1/s].

    """

    growth_rate: FloatArray
    frequency_hz: FloatArray
    by_friction: FloatArray
    by_damping: FloatArray


def affine_coefficients(model: BrakeModel, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Return (Omega, p0 mu / Omega, p0 mu_v, k_c, mu, damping scale) at inputs (P, 6), and p0.

    These six say all that the coefficients of the affine family, `OperatingPoint.coefficients`,
    say but for the follower force's.
    """
    speed, pressure = np.exp(inputs[:, 0]), np.exp(inputs[:, 1])
    friction = inputs[:, 2]
    slope, stiffness = sliding_laws(model, speed, pressure, friction)
    found = np.column_stack([
        speed, pressure * friction / speed, pressure * slope * inputs[:, 5],
        stiffness * np.exp(inputs[:, 3]), friction, np.exp(inputs[:, 4])])
    return found, pressure


_Crossing: TypeAlias = tuple[IndexArray, int, IndexArray, FloatArray]
"""Families, group, columns (n,) and entries (3, 2 m^2, n) of a common matrix."""


class GrowthEmulator:
    """
    Growth rates of families of modes over speed, pressure and what is uncertain.

    Parameters
    ----------
    model : BrakeModel
        Whose modes they are.
    families : tuple of ModeFamily
        Single modes first.
    domain : EmulatorDomain
    basis : PolynomialBasis
    weights : (W, T, 2 K) array
        Real and imaginary part, in turns, of the factor of each term in each of K invariants, in
        each piece of contact stiffness: the means of families, and of the pairs' matrices half the
        difference on the diagonal, the entry above it, and that below.
    common : tuple of CommonMatrix
        They are used instead, where there are any.
    error : EmulatorError

    """

    def __init__(self, model: BrakeModel, families: tuple[ModeFamily, ...],
                 domain: EmulatorDomain, basis: PolynomialBasis, weights: FloatArray,
                 common: tuple[CommonMatrix, ...], error: EmulatorError) -> None:
        self.model, self.families, self.domain = model, families, domain
        self.basis, self.weights, self.common = basis, readonly(weights), common
        self.error = error

    @cached_property
    def _common_of(self) -> list[list[CommonMatrix]]:
        """Return the common matrices of each piece."""
        return [[common for common in self.common if common.piece == piece]
                for piece in range(len(self.weights))]

    @cached_property
    def _rows(self) -> list[NDArray[np.float32]]:
        """
        Return the weights in each piece: (2 K + common, T).

        Imaginary and real parts of means, then real and imaginary parts of the pairs' entries in
        turns, then those of common matrices.
        """
        count, found = len(self.families), []
        for weights, common in zip(self.weights, self._common_of, strict=True):
            parts = weights.T.reshape(-1, 2, len(weights))  # (K, 2, T)
            others = [matrix.weights.T for matrix in common]
            found.append(np.concatenate(
                [parts[:count, 1], parts[:count, 0], *parts[count:], *others], dtype=np.float32))
        return found

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
        """
        Return the least stable mode of each family (..., F) at inputs (..., 6).

        The last but one axis of the inputs is of what is evaluated together: numbers do not depend
        on those before it, by not one bit.
        """
        shape = np.shape(inputs)
        if not np.size(inputs):
            return EmulatedGrowth(*np.empty((4, *shape[:-1], len(self.families)), np.float32))
        groups = np.reshape(inputs, (-1, *(1, *shape)[-2:]))
        step = max(1, _CHUNK // groups.shape[1])
        found = np.concatenate([self._evaluate(groups[start:start + step])
                                for start in range(0, len(groups), step)], axis=1)
        return EmulatedGrowth(*found.swapaxes(2, 3).reshape(4, *shape[:-1], len(self.families)))

    def eigenvalues(self, inputs: FloatArray) -> ComplexArray:
        """Return all of the families, (P, K), at inputs of the domain, (P, 6) [1/s]."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        variables, _ = self.basis.variables(coefficients)
        none = np.empty((0, 1, 1))
        [terms] = self.basis.terms(*self.basis.factors(variables, none, none))
        piece, pairs = self.basis.pieces(coefficients), self._pairs
        weights = self.weights[piece].view(complex)  # (P, T, K)
        entries = np.einsum('tp,ptk->pk', terms, weights)
        mean, half, above, below = np.split(
            entries, len(self.families) + pairs * np.arange(3), axis=1)
        single, half = len(self.families) - pairs, np.sqrt(half * half + above * below)
        found = np.concatenate([mean, mean[:, single:] - half], axis=1)
        found[:, single:len(self.families)] += half
        for common in self.common:
            rows = np.flatnonzero(piece == common.piece)
            places = np.append(common.families,
                               common.families[common.families >= single] + pairs)
            values = np.linalg.eigvals(matrices_of(common.weights.T @ terms[:, rows]))
            leading = np.argsort(-values.real, axis=1)[:, :places.size]
            found[np.ix_(rows, places)] = np.take_along_axis(values, leading, axis=1)
        return found

    @property
    def _pairs(self) -> int:
        return int(self.weights.shape[2] // 2 - len(self.families)) // 3

    def _evaluate(self, inputs: FloatArray) -> RealArray:
        """Return what `EmulatedGrowth` has at inputs (G, P, 6), (4, G, F, P)."""
        count, shape = len(self.families), inputs.shape[:2]
        with np.errstate(all='ignore'):  # outside the domain
            coefficients, _ = affine_coefficients(self.model, inputs.reshape(-1, 6))
            piece = self.basis.pieces(coefficients).reshape(shape)
            order = piece.argsort(axis=1, kind='stable')  # so that pieces are without gaps
            rows = (shape[1] * np.arange(shape[0])[:, None] + order).ravel()
            factors = [part.reshape(*part.shape[:2], *shape)
                       for part in self._factors(coefficients[rows])]
        piece, inside = (np.take_along_axis(values, order, axis=1)
                         for values in (piece, self.domain.covers(inputs)))
        values, slopes, crossing = self._polynomials(factors, piece, inside)
        found: RealArray = np.stack([values[:, count:2 * count], values[:, :count],
                                     *slopes[:, :, :count]])
        found[:, :, count - self._pairs:] += lead_of_pairs(
            *(complex_entries(part, (3, self._pairs)) for part in (
                values[:, 2 * count:], slopes[:, :, count:])))
        for parts in crossing.values():
            least = least_stable(matrices_of(np.concatenate(
                [entries for *_, entries in parts], axis=2)))
            for families, group, columns, _ in parts:
                own, least = np.split(least, [columns.size], axis=1)
                found[:, group, families[:, None], columns] = own[:, None]
        found[1] /= np.float32(2.0 * np.pi)
        np.copyto(found, np.float32(np.nan), where=~inside[:, None])
        return np.take_along_axis(found, order.argsort(axis=1)[None, :, None], axis=3)

    def _polynomials(self, factors: Sequence[RealArray], piece: IndexArray,
                     inside: NDArray[np.bool_]) -> tuple[
                         RealArray, RealArray, dict[int, list[_Crossing]]]:
        """Return polynomials (G, 2 K, P), slopes (2, G, 2 K - F, P), common matrices by size."""
        skipped, size = len(self.families), self.weights.shape[2]  # frequencies need no slopes
        values = np.empty((len(piece), size, piece.shape[1]), np.float32)
        slopes = np.empty((2, len(piece), size - skipped, piece.shape[1]), np.float32)
        crossing: dict[int, list[_Crossing]] = {}
        for group, pieces in enumerate(piece):  # its terms stay in the cache
            terms = self.basis.terms(*(part[:, :, group] for part in factors))
            ends = pieces.searchsorted(np.arange(len(self.weights) + 1)).tolist()
            for place, (a, b) in enumerate(pairwise(ends)):
                if a == b:
                    continue
                rows = self._rows[place]
                at, by = rows @ terms[0, :, a:b], rows[skipped:] @ terms[1:, :, a:b]
                values[group, :, a:b], slopes[:, group, :, a:b] = at[:size], by[:, :size - skipped]
                start, own = size, inside[group, a:b].nonzero()[0]
                for common in self._common_of[place]:
                    end = start + common.weights.shape[1]
                    entries = np.stack([at[start:end], *by[:, start - skipped:end - skipped]])
                    crossing.setdefault(end - start, []).append(
                        (common.families, group, a + own, entries[:, :, own]))
                    start = end
        return values, slopes, crossing

    def _factors(self, coefficients: FloatArray) -> tuple[RealArray, ...]:
        """Return the factors of terms at P points, and their slopes by friction, damping."""
        variables, by_own = self.basis.variables(coefficients)
        change = (coefficients * by_own).T
        # radial dissipation and slope are in proportion to the friction coefficient
        by_friction = change[None, OPERATION] * _WITH_FRICTION / coefficients[:, 4]
        return self.basis.factors(variables, by_friction, change[None, BRAKE] * _WITH_DAMPING,
                                  np.float32)
