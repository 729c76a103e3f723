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

"""Eigenvalues of many small complex matrices at once: the least stable ones and their slopes."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, RealArray

_LEAST_HALF = 1.0  # 1/s; slopes of eigenvalues nearer to each other than twice that are limited
_FAR_BELOW = -3000.0  # 1/s; what modes do not come near to
_ROUNDING = 1e-4  # of matrices, by which eigenvalues in closed form may be off
_NOTHING = 1e-20  # in place of zero, in single precision
_BESIDE = 1e-3  # 1/s; of an eigenvalue, where the resolvent is nearly that of this one alone
_TURNS = np.exp(2j * np.pi / 3.0 * np.arange(3))[:, None]


class CommonMatrix(NamedTuple):
    """
    Matrix that several families have in common where they cross, in a piece.

    Attributes
    ----------
    piece : int
    families : (n,) index array
    weights : (T, 2 m^2) array
        Real and imaginary part, in turns, of the factor of each term in each entry (m, m).

    """

    piece: int
    families: IndexArray
    weights: FloatArray


def in_four(weights: FloatArray) -> FloatArray:
    """Return the weights of a common matrix of three modes with a fourth, decoupled and stable."""
    if weights.shape[1] != 18:
        return weights
    result = np.zeros((len(weights), 4, 4, 2))
    result[:, :3, :3] = weights.reshape(-1, 3, 3, 2)
    result[0, 3, 3] = result[0, 2, 2] + (_FAR_BELOW, 0.0)  # the first term is 1
    return result.reshape(len(result), -1)


def lead_of_pairs(entries: NDArray[np.complex64]) -> RealArray:
    """
    Return by how much the less stable mode of pairs grows and oscillates faster than their mean.

    And the slopes of the former: (4, P, pairs).

    Parameters
    ----------
    entries : (P, 3, 3, pairs) array
        Values and slopes of half the difference on the diagonal, and of the entries beside it.

    """
    half, above, below = np.ascontiguousarray(entries.transpose(2, 1, 0, 3))
    square = half[0] * half[0] + above[0] * below[0]
    size = np.sqrt(square.real * square.real + square.imag * square.imag)
    larger = np.sqrt(0.5 * (size + np.abs(square.real)))
    # nothing cancels, so that single precision is enough
    smaller = np.abs(square.imag) / (2.0 * np.maximum(larger, _NOTHING))
    grows = square.real > 0.0
    rate = np.where(grows, larger, smaller)  # the less stable one's
    angular = np.copysign(np.where(grows, smaller, larger), square.imag)
    turn = half[0] * half[1:] + 0.5 * (above[0] * below[1:] + below[0] * above[1:])
    slopes = (rate * turn.real + angular * turn.imag) / np.maximum(size, _LEAST_HALF**2)
    return np.stack([rate, angular, *slopes])


def matrices_of(entries: RealArray) -> ComplexArray:
    """Return matrices (..., m, m) of their entries' real and imaginary parts (..., 2 m^2)."""
    size = math.isqrt(entries.shape[-1] // 2)
    return entries.astype(float, 'C').view(complex).reshape(*entries.shape[:-1], size, size)


def least_stable(matrices: ComplexArray) -> FloatArray:
    """
    Return growth rate and angular frequency of the least stable eigenvalue, and slopes (4, P).

    The slopes are those of the trace of the resolvent's pole, computed beside it.

    Parameters
    ----------
    matrices : (3, P, m, m) array
        Matrices and their slopes in two directions.

    """
    four = FourModes.of(matrices[0]) if matrices.shape[-1] == 4 else None
    values = four.eigenvalues() if four else np.linalg.eigvals(matrices[0])
    least = values[np.arange(len(values)), values.real.argmax(axis=1)]
    beside = least + _BESIDE
    # in proportion to the resolvent, which is all that counts
    resolvent = four.adjugate(beside) if four else np.linalg.inv(
        beside[:, None, None] * np.eye(matrices.shape[-1]) - matrices[0])
    slopes = (np.einsum('pij,kpji->kp', resolvent, matrices[1:])
              / np.einsum('pii->p', resolvent))
    return np.stack([least.real, least.imag, *slopes.real])


class FourModes(NamedTuple):
    """
    Matrices of four modes less their mean eigenvalues: their polynomial is x^4 + p x^2 + q x + r.

    Attributes
    ----------
    mean : (P,) array
    powers : (4, P, 4, 4) array
        Of the traceless matrices, from the zeroth to the third.
    coefficients : (3, P) array
        p, q, r.

    """

    mean: ComplexArray
    powers: ComplexArray
    coefficients: ComplexArray

    @classmethod
    def of(cls, matrices: ComplexArray) -> 'FourModes':
        """Return those of matrices (P, 4, 4)."""
        mean = np.einsum('pii->p', matrices) / 4.0
        powers = np.empty((4, *matrices.shape), complex)
        powers[0] = np.eye(4)
        powers[1] = matrices - mean[:, None, None] * powers[0]
        for power in (2, 3):
            np.matmul(powers[power - 1], powers[1], out=powers[power])
        p, q = np.einsum('npii->np', powers[2:]) / ((-2.0,), (-3.0,))  # Newton's identities
        r = p * p / 2.0 - np.einsum('pij,pji->p', powers[2], powers[2]) / 4.0
        return cls(mean, powers, np.stack([p, q, r]))

    def eigenvalues(self) -> ComplexArray:
        """Return all of them in closed form: (P, 4)."""
        p, q, r = self.coefficients
        roots = _quartic_roots(p, q, r)
        most = _ROUNDING * np.sqrt(np.abs(p))
        with np.errstate(divide='ignore', invalid='ignore'):  # zeros of several times
            for _ in range(2):  # of Newton's, as the closed form rounds
                square = roots * roots
                step = (((square + p) * roots + q) * roots + r) / (
                    (4.0 * square + 2.0 * p) * roots + q)
                roots = roots - np.where(np.abs(step) <= most, step, 0.0)
        return np.asarray((roots + self.mean).T)

    def adjugate(self, values: ComplexArray) -> ComplexArray:
        """Return the adjugates (P, 4, 4) of values (P,) minus the matrices."""
        x, (p, q, _) = values - self.mean, self.coefficients
        square = x * x + p
        return np.asarray(np.einsum('np,npij->pij', np.stack(
            [x * square + q, square, x, np.ones_like(x)]), self.powers))


def _cubic_roots(p: ComplexArray, q: ComplexArray) -> ComplexArray:
    """Return the roots (3, P) of x^3 + p x + q."""
    third, half = p / 3.0, q / 2.0
    root = np.sqrt(half * half + third * third * third)
    root *= np.where((np.conj(half) * root).real < 0.0, -1.0, 1.0)
    sides = (-half - root) ** (1.0 / 3.0) * _TURNS
    return np.asarray(sides - third / _nonzero(sides))


def _quartic_roots(p: ComplexArray, q: ComplexArray, r: ComplexArray) -> ComplexArray:
    """Return the roots (4, P) of x^4 + p x^2 + q x + r, of two quadratic factors."""
    # (x^2 + s x + t) (x^2 - s x + u): a cubic equation of s^2
    square = p * p
    squares = _cubic_roots(square / -3.0 - 4.0 * r,
                           (8.0 / 3.0 * r - 2.0 / 27.0 * square) * p - q * q) - 2.0 / 3.0 * p
    square = squares[np.abs(squares).argmax(axis=0), np.arange(p.size)]
    side = np.sqrt(square)
    halves: ComplexArray = np.stack([-0.5 * side, 0.5 * side])
    roots = np.sqrt(q / (-4.0 * _nonzero(halves)) - (0.25 * square + 0.5 * p))
    return np.concatenate([halves + roots, halves - roots])


def _nonzero(values: ComplexArray) -> ComplexArray:
    """Return values that can be divided by: 1 in place of 0."""
    return np.asarray(values + (values == 0.0))
