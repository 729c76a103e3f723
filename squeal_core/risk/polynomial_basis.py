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
Polynomials in the coefficients of the affine family, and their slopes.

A term is a product of polynomials of six variables. Different products of those of four of them,
and of two, are a third of the terms, so terms come from these.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import DTypeLike
from squeal_core.common.arrays import FloatArray, IndexArray, RealArray

OPERATION, BRAKE = (0, 1, 2, 4), (3, 5)  # variables that change in a drive, and by the brake


@dataclass(frozen=True, eq=False)
class PolynomialBasis:
    """
    Products of Chebyshev polynomials in scaled coefficients of the affine family.

    Parameters
    ----------
    exponents : (T, 6) index array
        Degree of each term in each coordinate.
    scales : (3,) array
        Of Omega [rad/s], p0 mu / Omega [Pa s], p0 mu_v [Pa s/m]; coordinates are asinh(value /
        scale) of these, then k_c, mu and the damping scale as they are.
    low, high : (W, 6) arrays
        Coordinates at which the polynomials' variable is -1 and 1, in each piece of contact
        stiffness, in rising order.

    """

    exponents: IndexArray
    scales: FloatArray
    low: FloatArray
    high: FloatArray

    def variables(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the polynomials' variables at coefficients, and their slopes by each own."""
        result, slopes = coefficients.copy(), np.ones_like(coefficients)
        result[:, :3] = np.arcsinh(coefficients[:, :3] / self.scales)
        slopes[:, :3] = 1.0 / np.sqrt(coefficients[:, :3]**2 + self.scales**2)
        piece = self.pieces(coefficients)
        low, half = self.low[piece], 0.5 * (self.high - self.low)[piece]
        return (result - low) / half - 1.0, slopes / half

    def pieces(self, coefficients: FloatArray) -> IndexArray:
        """Return the pieces of contact stiffness that coefficients (P, 6) are in."""
        return np.searchsorted(self.low[1:, 3], coefficients[:, 3])

    def factors(self, variables: FloatArray, operation: FloatArray, brake: FloatArray,
                kind: DTypeLike = float) -> tuple[RealArray, ...]:
        """
        Return the different products of polynomials of either kind of variables, and their slopes.

        Parameters
        ----------
        variables : (P, 6) array
            As returned by `variables`.
        operation : (C, 4, P) array
            Changes of the variables `OPERATION` in C directions.
        brake : (D, 2, P) array
            Changes of the variables `BRAKE` in D directions.
        kind : dtype
            Of the result.

        Returns
        -------
        (1 + C, n, P), (1 + D, m, P) arrays

        """
        at, count = np.ascontiguousarray(variables.T), int(self.exponents.max(initial=1)) + 1
        result = np.empty((count, 2, *at.shape))  # polynomials of each degree and their slopes
        result[0], result[1, 0], result[1, 1] = [[[1.0]], [[0.0]]], at, 1.0
        twice = 2.0 * at
        for n in range(2, count):
            np.multiply(twice, result[n - 1], out=result[n])
            result[n] -= result[n - 2]
            result[n, 1] += 2.0 * result[n - 1, 0]
        result = result.astype(kind)
        return tuple(_products(result[:, :, axes], turns.astype(kind), powers)
                     for axes, turns, (powers, _) in zip(
                         (OPERATION, BRAKE), (operation, brake), self._powers, strict=True))

    def terms(self, first: RealArray, second: RealArray) -> Any:
        """Return the terms by their factors, and their slopes (1 + C + D, T, P)."""
        (_, places), (_, own) = self._powers
        first, second = np.take(first, places, axis=1), np.take(second, own, axis=1)
        result = np.empty((len(first) + len(second) - 1, *first.shape[1:]), first.dtype)
        np.multiply(first, second[:1], out=result[:len(first)])
        np.multiply(first[:1], second[1:], out=result[len(first):])
        return result

    @cached_property
    def _powers(self) -> tuple[tuple[IndexArray, IndexArray], ...]:
        """Return different degrees in the variables of either kind, and each term's."""
        result = (np.unique(self.exponents[:, axes], axis=0, return_inverse=True)
                  for axes in (OPERATION, BRAKE))
        return tuple((powers, places.ravel()) for powers, places in result)


def _products(polynomials: RealArray, turns: RealArray, powers: IndexArray) -> RealArray:
    """
    Return products (n, P) of polynomials of V variables, and their slopes: (1 + D, n, P).

    Parameters
    ----------
    polynomials : (degree + 1, 2, V, P) array
        And their slopes.
    turns : (D, V, P) array
        Changes of the variables.
    powers : (n, V) array
        Degrees.

    """
    factors = np.concatenate([polynomials[None, :, 0], turns[:, None] * polynomials[:, 1]])
    result, *others = (np.take(factors[:, :, axis], powers[:, axis], axis=1)
                       for axis in range(powers.shape[1]))
    for factor in others:
        result[1:] *= factor[0]
        factor[1:] *= result[0]
        result[1:] += factor[1:]
        result[0] *= factor[0]
    return result
