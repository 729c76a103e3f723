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

    Parameters
    ----------
    matrices : (3, P, m, m) array
        Matrices and their slopes in two directions.

    """
    values, right = np.linalg.eig(matrices[0])
    rows, place = np.arange(len(values)), values.real.argmax(axis=1)
    left, vectors = np.linalg.inv(right)[rows, place], right[rows, :, place]
    slopes = (left[:, None] @ matrices[1:] @ vectors[..., None])[..., 0, 0]
    return np.stack([values[rows, place].real, values[rows, place].imag, *slopes.real])
