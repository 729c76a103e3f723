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

Eigenvalues that meet are no smooth functions of the inputs, but the mean of a pair and the square
of half its difference are. They are analytic in the coefficients of the affine family D(q), K(q);
so they are polynomials in these here, and growth rates follow in closed form.
"""

from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any, NamedTuple

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.mode_families import ModeFamily

INPUTS = ('ln_rotor_speed', 'ln_contact_pressure', 'friction', 'ln_contact_stiffness',
          'ln_damping', 'slope_scale')
"""ln of |Omega| [rad/s] and of p0 [Pa]; mu [-]; ln of the factors on the model's k_c at this p0
and on its damping; factor on the friction slope by the model's law."""

_CHUNK = 128  # rows evaluated at once: their terms stay in the cache
_LEAST_HALF = 1.0  # 1/s; slopes of eigenvalues nearer to each other than twice that are limited


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
    low, high : (6,) arrays
        Coordinates at which the polynomials' variable is -1 and 1.

    """

    exponents: IndexArray
    scales: FloatArray
    low: FloatArray
    high: FloatArray

    def variables(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the polynomials' variables at coefficients, and their slopes by each own."""
        found, slopes = coefficients.copy(), np.ones_like(coefficients)
        found[:, :3] = np.arcsinh(coefficients[:, :3] / self.scales)
        slopes[:, :3] = 1.0 / np.hypot(coefficients[:, :3], self.scales)
        half = 0.5 * (self.high - self.low)
        return (found - self.low) / half - 1.0, slopes / half

    def terms(self, coefficients: FloatArray, directions: FloatArray) -> FloatArray:
        """
        Return the terms and their slopes in D directions (1 + D, P, T).

        Parameters
        ----------
        coefficients : (P, 6) array
            By `affine_coefficients`.
        directions : (D, P, 6) array
            Changes of the coefficients.

        """
        variables, by_own = self.variables(coefficients)
        values, slopes = self._chebyshev(variables)
        turns = np.concatenate([np.zeros((1, *variables.shape)), directions * by_own])
        first, second = (self._products(values, slopes, turns, start) for start in (0, 3))
        second[1:] *= first[0]  # the product rule, without arrays beside these two
        first *= second[0]
        first[1:] += second[1:]
        return first

    def _chebyshev(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return all polynomials of all variables and their slopes (P, degree, 6)."""
        values = [np.ones_like(variables), variables]
        slopes = [np.zeros_like(variables), np.ones_like(variables)]
        for _ in range(2, int(self.exponents.max(initial=1)) + 1):
            slopes.append(2.0 * (values[-1] + variables * slopes[-1]) - slopes[-2])
            values.append(2.0 * variables * values[-1] - values[-2])
        return np.stack(values, axis=1), np.stack(slopes, axis=1)

    def _products(self, values: FloatArray, slopes: FloatArray, turns: FloatArray,
                  start: int) -> FloatArray:
        """Return the factors (1 + D, P, T) of terms by three variables, and their slopes."""
        powers, places = self._halves[start // 3]
        axes = [start, start + 1, start + 2]
        x, y, z = (values[:, powers[:, i], axis] for i, axis in enumerate(axes))
        u, v, w = (slopes[:, powers[:, i], axis] for i, axis in enumerate(axes))
        found = np.stack([turn[:, start:start + 1] * (u * y * z)
                          + turn[:, start + 1:start + 2] * (x * v * z)
                          + turn[:, start + 2:start + 3] * (x * y * w) for turn in turns])
        found[0] = x * y * z
        return np.take(found, places, axis=-1)

    @cached_property
    def _halves(self) -> tuple[tuple[IndexArray, IndexArray], ...]:
        """Return different degrees in the first three variables and each term's, so the others."""
        halves = (np.unique(self.exponents[:, start:start + 3], axis=0, return_inverse=True)
                  for start in (0, 3))
        return tuple((powers, places.ravel()) for powers, places in halves)


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
    weights : (T, 2 K) array
        Real and imaginary part, in turns, of the factor of each term in each of K invariants: the
        eigenvalues of single modes, the means of pairs, and the squares of half their differences.
    error : EmulatorError

    """

    def __init__(self, model: BrakeModel, families: tuple[ModeFamily, ...],
                 domain: EmulatorDomain, basis: PolynomialBasis, weights: FloatArray,
                 error: EmulatorError) -> None:
        self.model, self.families, self.domain = model, families, domain
        self.basis, self.weights, self.error = basis, readonly(weights), error

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
        """Return the least stable mode of each family (..., F) at inputs (..., 6)."""
        inputs = np.asarray(inputs, float)
        shape = (*inputs.shape[:-1], len(self.families))
        inside = self.domain.covers(inputs).ravel()
        found = np.full((4, inside.size, len(self.families)), np.nan)
        rows = np.flatnonzero(inside)
        for start in range(0, rows.size, _CHUNK):
            part = rows[start:start + _CHUNK]
            found[:, part] = self._evaluate(inputs.reshape(-1, 6)[part])
        return EmulatedGrowth(*found.reshape(4, *shape))

    def eigenvalues(self, inputs: FloatArray) -> ComplexArray:
        """Return all of the families, (P, K), at inputs of the domain, (P, 6) [1/s]."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        [terms] = self.basis.terms(coefficients, np.empty((0, *coefficients.shape)))
        single, mean, square = self._invariants(terms)
        half = np.sqrt(square)
        return np.concatenate([single, mean + half, mean - half], axis=1)

    def _evaluate(self, inputs: FloatArray) -> FloatArray:
        """Return what `EmulatedGrowth` has (4, P, F)."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        directions = np.zeros((2, *coefficients.shape))
        # radial dissipation and slope are in proportion to the friction coefficient
        directions[0, :, 1:3] = coefficients[:, 1:3] / coefficients[:, 4:5]
        directions[0, :, 4], directions[1, :, 5] = 1.0, coefficients[:, 5]
        terms = self.basis.terms(coefficients, directions)
        single, mean, square = self._invariants(terms)
        half = np.sqrt(square[0])  # of a real part above zero, so it leads to the less stable one
        slopes = 0.5 * half.conj() / np.maximum(np.abs(half), _LEAST_HALF) ** 2 * square[1:]
        found = np.concatenate([single, mean + np.stack([half, *slopes])], axis=2)
        return np.stack([found[0].real, found[0].imag / (2.0 * np.pi), *found[1:].real])

    def _invariants(self, terms: FloatArray) -> Any:
        """Return the invariants of single modes, the means of pairs and their squares."""
        pairs = self.weights.shape[1] // 2 - len(self.families)
        found: ComplexArray = (terms @ self.weights).view(complex)
        return np.split(found, [len(self.families) - pairs, len(self.families)], axis=-1)
