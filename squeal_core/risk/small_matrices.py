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
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, RealArray

_LEAST_HALF = 1.0  # 1/s; slopes of eigenvalues nearer to each other than twice that are limited
_FAR_BELOW = -3000.0  # 1/s; what modes do not come near to
_ROUNDING = 1e-4  # of matrices, by which eigenvalues in closed form may be off
_BESIDE = 1e-3  # 1/s; of an eigenvalue, where the resolvent is nearly that of this one alone


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
    found = np.zeros((len(weights), 4, 4, 2))
    found[:, :3, :3] = weights.reshape(-1, 3, 3, 2)
    found[0, 3, 3] = found[0, 2, 2] + (_FAR_BELOW, 0.0)  # the first term is 1
    return found.reshape(len(found), -1)


def complex_entries(parts: RealArray, shape: tuple[int, ...]) -> ComplexArray:
    """Return complex numbers (..., *shape, P) of real and imaginary parts in turns (..., n, P)."""
    parts = parts.reshape(*parts.shape[:-2], *shape, 2, parts.shape[-1])
    return np.asarray(parts[..., 0, :] + 1j * parts[..., 1, :])


def lead_of_pairs(entries: ComplexArray, by: ComplexArray) -> FloatArray:
    """
    Return by how much the less stable mode of pairs grows and oscillates faster than their mean.

    And the slopes of the former: (4, G, pairs, P).

    Parameters
    ----------
    entries, by : (G, 3, pairs, P), (2, G, 3, pairs, P) arrays
        Half the difference on the diagonal, the entries beside it, and their slopes.

    """
    half, above, below = np.moveaxis(entries, 1, 0).astype(complex)
    square = half * half + above * below
    size = np.abs(square)
    rate = np.sqrt(0.5 * (size + square.real))  # the less stable one's
    angular = np.copysign(np.sqrt(0.5 * (size - square.real)), square.imag)
    turn = half * by[:, :, 0] + 0.5 * (above * by[:, :, 2] + below * by[:, :, 1])
    slopes = (rate * turn.real + angular * turn.imag) / np.maximum(size, _LEAST_HALF**2)
    return np.stack([rate, angular, *slopes])


def matrices_of(entries: RealArray) -> ComplexArray:
    """Return matrices (..., P, m, m) of real and imaginary parts of entries (..., 2 m^2, P)."""
    size = math.isqrt(entries.shape[-2] // 2)
    return np.moveaxis(complex_entries(entries.astype(float), (size, size)), -1, -3)


def least_stable(matrices: ComplexArray) -> FloatArray:
    """
    Return growth rate and angular frequency of the least stable eigenvalue, and slopes (4, P).

    The slopes are those of the trace of the resolvent's pole, computed beside it.

    Parameters
    ----------
    matrices : (3, P, m, m) array
        Matrices and their slopes in two directions.

    """
    values = small_eigenvalues(matrices[0])
    least = np.take_along_axis(values, values.real.argmax(axis=1)[:, None], axis=1)[:, 0]
    resolvent = np.linalg.inv(
        (least + _BESIDE)[:, None, None] * np.eye(matrices.shape[-1]) - matrices[0])
    slopes = (np.einsum('pij,kpji->kp', resolvent, matrices[1:])
              / np.trace(resolvent, axis1=1, axis2=2))
    return np.stack([least.real, least.imag, *slopes.real])


def small_eigenvalues(matrices: ComplexArray) -> ComplexArray:
    """Return the eigenvalues (P, m) of matrices (P, m, m): of m = 4 in closed form."""
    if matrices.shape[-1] != 4:
        return np.asarray(np.linalg.eigvals(matrices), complex)
    mean = np.trace(matrices, axis1=1, axis2=2) / 4.0
    of_zero = matrices - mean[:, None, None] * np.eye(4)
    square = of_zero @ of_zero
    second, third, fourth = (np.einsum('pij,pji->p', *factors) for factors in (
        (of_zero, of_zero), (square, of_zero), (square, square)))
    # x^4 + p x^2 + q x + r, by Newton's identities
    p, q, r = -second / 2.0, -third / 3.0, second * second / 8.0 - fourth / 4.0
    with np.errstate(divide='ignore', invalid='ignore'):  # zeros of several times
        roots = _quartic_roots(p, q, r)
        most = _ROUNDING * np.sqrt(np.abs(second))
        for _ in range(2):  # of Newton's, as the closed form rounds
            square = roots * roots
            step = (((square + p) * roots + q) * roots + r) / (
                (4.0 * square + 2.0 * p) * roots + q)
            roots = roots - np.where(np.abs(step) <= most, step, 0.0)
    return np.asarray((roots + mean).T)


def _cubic_roots(p: ComplexArray, q: ComplexArray) -> ComplexArray:
    """Return the roots (3, P) of x^3 + p x + q."""
    root = np.sqrt(q * q / 4.0 + p * p * p / 27.0)
    larger = np.where((np.conj(q) * root).real > 0.0, -q / 2.0 - root, root - q / 2.0)
    sides = larger ** (1.0 / 3.0) * np.exp(2j * np.pi / 3.0 * np.arange(3))[:, None]
    return np.asarray(sides - np.where(larger == 0.0, 0.0, p / (3.0 * sides)))


def _quartic_roots(p: ComplexArray, q: ComplexArray, r: ComplexArray) -> ComplexArray:
    """Return the roots (4, P) of x^4 + p x^2 + q x + r, of two quadratic factors."""
    # (x^2 + s x + t) (x^2 - s x + u): a cubic equation of s^2
    squares = _cubic_roots(-p * p / 3.0 - 4.0 * r,
                           (8.0 * r / 3.0 - 2.0 * p * p / 27.0) * p - q * q) - 2.0 * p / 3.0
    square = np.take_along_axis(squares, np.abs(squares).argmax(axis=0)[None], axis=0)[0]
    side = np.sqrt(square)
    apart = np.where(side == 0.0, 0.0, q / side)
    halves = np.stack([-side, side]) / 2.0
    roots = np.sqrt(halves * halves - (p + square + np.stack([-apart, apart])) / 2.0)
    return np.concatenate([halves + roots, halves - roots])
