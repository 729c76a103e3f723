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
from functools import cached_property
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from squeal_core.brake.operating_point import coefficients_of, OperatingPoints
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly, RealArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.emulator_records import EmulatedGrowth, EmulatorDomain, EmulatorError
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.risk.polynomial_basis import BRAKE, OPERATION, PolynomialBasis
from squeal_core.risk.small_matrices import (
    CommonMatrix,
    in_four,
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
STABLE = -5.0  # 1/s; families that nowhere grow faster do not build up
_CHUNK = 1024  # rows evaluated at once


def points_at(model: BrakeModel, inputs: FloatArray) -> OperatingPoints:
    """Return the operating points of inputs (P, 6)."""
    speed, pressure, friction = np.exp(inputs[:, 0]), np.exp(inputs[:, 1]), inputs[:, 2]
    slope, stiffness = sliding_laws(model, speed, pressure, friction)
    return OperatingPoints(
        rotor_speed=speed, friction=friction, contact_pressure=pressure,
        contact_stiffness=stiffness * np.exp(inputs[:, 3]), friction_slope=slope * inputs[:, 5],
        damping_scale=np.exp(inputs[:, 4]))


def affine_coefficients(points: OperatingPoints) -> FloatArray:
    """
    Return (Omega, p0 mu / Omega, p0 mu_v, k_c, mu, damping scale) at points, (P, 6).

    These six say all that the coefficients of the affine family, `OperatingPoint.coefficients`,
    say but for the follower force's.
    """
    return np.column_stack([*coefficients_of(points)[:4], points.friction, points.damping_scale])


class _Crossing(NamedTuple):
    """Families of a common matrix in a piece; the columns of its entries, from start to end."""

    piece: int
    start: int
    end: int
    families: IndexArray

    def size(self) -> int:
        """Return the number of columns."""
        return self.end - self.start


class GrowthEmulator:
    """
    Growth rates of families of modes over speed, pressure and what is uncertain.

    Parameters
    ----------
    model : BrakeModel
        Whose modes they are.
    every : tuple of ModeFamily
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

    Attributes
    ----------
    families : tuple of ModeFamily
        Those that come near to growing anywhere in the domain; only they are evaluated.

    """

    def __init__(self, model: BrakeModel, every: tuple[ModeFamily, ...],
                 domain: EmulatorDomain, basis: PolynomialBasis, weights: FloatArray,
                 common: tuple[CommonMatrix, ...], error: EmulatorError) -> None:
        self.model, self.every, self.domain = model, every, domain
        self.basis, self.weights, self.common = basis, readonly(weights), common
        self.error = error
        self._single = sum(len(one.numbers) == 1 for one in every)
        self._places = np.flatnonzero([one.largest_growth > STABLE for one in every])
        self._pairs = self._places[self._places >= self._single] - self._single
        self.families = tuple(every[place] for place in self._places)

    @cached_property
    def _common_of(self) -> list[list[CommonMatrix]]:
        """Return the common matrices of each piece; those of three modes as of four."""
        return [[common._replace(weights=in_four(common.weights))
                 for common in self.common if common.piece == piece]
                for piece in range(len(self.weights))]

    @cached_property
    def _columns(self) -> list[NDArray[np.float32]]:
        """
        Return the weights of families that are evaluated in each piece: (T, 2 K + common).

        Imaginary and real parts of means, then real and imaginary parts of the pairs' entries in
        turns, then those of common matrices.
        """
        pieces, terms, _ = self.weights.shape
        parts = self.weights.reshape(pieces, terms, -1, 2)
        means, entries = np.split(parts, [len(self.every)], axis=2)
        means = means[:, :, self._places]
        entries = entries.reshape(pieces, terms, 3, -1, 2)[:, :, :, self._pairs]
        return [np.concatenate(
            [mean[..., 1], mean[..., 0], entry.reshape(terms, -1),
             *(matrix.weights for matrix in common)], axis=1, dtype=np.float32)
            for mean, entry, common in zip(means, entries, self._common_of, strict=True)]

    @cached_property
    def _crossings(self) -> list[_Crossing]:
        """Return the common matrices in the order of their sizes."""
        result = []
        for piece, common in enumerate(self._common_of):
            end = 2 * self._places.size + 6 * self._pairs.size
            for matrix in common:
                start, end = end, end + matrix.weights.shape[1]
                own = np.isin(self._places, matrix.families).nonzero()[0]
                result.append(_Crossing(piece, start, end, own))
        return sorted(result, key=_Crossing.size)

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
        """
        Return the least stable mode of each family (..., F) at inputs (..., 6).

        The last but one axis of the inputs is of what is evaluated together: numbers do not depend
        on those before it, by not one bit. Rows are evaluated fastest in the order of their
        contact stiffness.
        """
        shape = np.shape(inputs)
        if not np.size(inputs):
            return EmulatedGrowth(*np.empty((4, *shape[:-1], len(self.families)), np.float32))
        groups = np.reshape(inputs, (-1, *(1, *shape)[-2:]))
        step = max(1, _CHUNK // groups.shape[1])
        result = np.concatenate([self._evaluate(groups[start:start + step])
                                 for start in range(0, len(groups), step)], axis=1)
        return EmulatedGrowth(*result.reshape(4, *shape[:-1], len(self.families)))

    def eigenvalues(self, inputs: FloatArray) -> ComplexArray:
        """Return all of the families, (P, K), at inputs of the domain, (P, 6) [1/s]."""
        coefficients = affine_coefficients(points_at(self.model, inputs))
        variables, _ = self.basis.variables(coefficients)
        none = np.empty((0, 1, 1))
        [terms] = self.basis.terms(*self.basis.factors(variables, none, none))
        piece, single = self.basis.pieces(coefficients), self._single
        pairs = len(self.every) - single
        weights = self.weights[piece].view(complex)  # (P, T, K)
        entries = np.einsum('tp,ptk->pk', terms, weights)
        mean, half, above, below = np.split(
            entries, len(self.every) + pairs * np.arange(3), axis=1)
        half = np.sqrt(half * half + above * below)
        result = np.concatenate([mean, mean[:, single:] - half], axis=1)
        result[:, single:len(self.every)] += half
        for common in self.common:
            rows = np.flatnonzero(piece == common.piece)
            places = np.append(common.families,
                               common.families[common.families >= single] + pairs)
            values = np.linalg.eigvals(matrices_of(terms[:, rows].T @ common.weights))
            leading = np.argsort(-values.real, axis=1)[:, :places.size]
            result[np.ix_(rows, places)] = np.take_along_axis(values, leading, axis=1)
        return result

    def _evaluate(self, inputs: FloatArray) -> RealArray:
        """Return what `EmulatedGrowth` has at inputs (G, P, 6), (4, G, P, F)."""
        count, pairs, shape = self._places.size, self._pairs.size, inputs.shape[:2]
        with np.errstate(all='ignore'):  # outside the domain
            coefficients = affine_coefficients(points_at(self.model, inputs.reshape(-1, 6)))
            piece = self.basis.pieces(coefficients).reshape(shape)
            values = self._polynomials([
                np.ascontiguousarray(np.moveaxis(part.reshape(*part.shape[:2], *shape), 2, 0))
                for part in self._factors(coefficients)], piece)
            inside = self.domain.covers(inputs).ravel()
        values = values.reshape(-1, *values.shape[2:])
        result = np.empty((4, len(values), count), np.float32)
        result[1] = values[:, 0, :count]
        for own, place in enumerate((0, 2, 3)):
            result[place] = values[:, own, count:2 * count]
        entries = values[..., 2 * count:2 * count + 6 * pairs].view(np.complex64)
        result[..., count - pairs:] += lead_of_pairs(
            entries.reshape(len(values), 3, 3, pairs))
        self._cross(result, values, np.where(inside, piece.ravel(), -1))
        result[1] /= np.float32(2.0 * np.pi)
        if not inside.all():
            result[:, ~inside] = np.nan
        return result.reshape(4, *shape, count)

    def _cross(self, result: RealArray, values: RealArray, piece: IndexArray) -> None:
        """Set the growth of families where they have a common matrix."""
        rows = [np.flatnonzero(piece == own) for own in range(len(self.weights))]
        for _, some in groupby(self._crossings, key=_Crossing.size):
            crossings = [*some]
            matrices = matrices_of(np.concatenate([
                values[rows[one.piece], :, one.start:one.end] for one in crossings]))
            least, start = least_stable(matrices.swapaxes(0, 1))[..., None], 0
            for one in crossings:
                own = rows[one.piece]
                result[:, own[:, None], one.families] = least[:, start:start + own.size]
                start += own.size

    def _polynomials(self, factors: Sequence[RealArray], piece: IndexArray) -> RealArray:
        """Return the polynomials and their slopes by friction and damping (G, P, 3, columns)."""
        most = max(columns.shape[1] for columns in self._columns)
        result = np.empty((*piece.shape, 3, most), np.float32)
        for group, pieces in enumerate(piece):  # its terms stay in the cache
            terms = self.basis.terms(*(part[group] for part in factors))
            rows = terms.transpose(2, 0, 1).reshape(-1, terms.shape[1])
            ends = [0, *np.flatnonzero(np.diff(pieces)) + 1, pieces.size]
            for a, b in pairwise(ends):
                columns = self._columns[pieces[a]]
                np.matmul(rows[3 * a:3 * b], columns,
                          out=result[group, a:b].reshape(-1, most)[:, :columns.shape[1]])
        return result

    def _factors(self, coefficients: FloatArray) -> tuple[RealArray, ...]:
        """Return the factors of terms at P points, and their slopes by friction, damping."""
        variables, by_own = self.basis.variables(coefficients)
        change = (coefficients * by_own).T
        # radial dissipation and slope are in proportion to the friction coefficient
        by_friction = change[None, OPERATION] * _WITH_FRICTION / coefficients[:, 4]
        return self.basis.factors(variables, by_friction, change[None, BRAKE] * _WITH_DAMPING,
                                  np.float32)
