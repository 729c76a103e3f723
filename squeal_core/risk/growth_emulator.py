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

Eigenvalues that meet are no smooth functions of the inputs, but the coefficients of the
characteristic polynomial of a family are: its mean m and c_2 ... c_n of prod (z - z_k) = z^n + c_2
z^(n-2) + ... + c_n, z = lambda - m. They are analytic in the coefficients of the affine family
D(q), K(q); so they are polynomials in these here, and growth rates follow in closed form.
"""

from collections.abc import Iterator
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

_LEAST_GAP = 2.0  # 1/s of eigenvalues, below which slopes no longer rise as they meet


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
        """Return the variables (P, 6) at coefficients (P, 6), and their slopes by each own."""
        found, slopes = coefficients.copy(), np.ones_like(coefficients)
        found[:, :3] = np.arcsinh(coefficients[:, :3] / self.scales)
        slopes[:, :3] = 1.0 / np.hypot(coefficients[:, :3], self.scales)
        half = 0.5 * (self.high - self.low)
        return (found - self.low) / half - 1.0, slopes / half

    def terms(self, variables: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return factors and their slopes by the own variable, (6, P, T) each."""
        values, slopes = [np.ones_like(variables), variables], [np.zeros_like(variables),
                                                                np.ones_like(variables)]
        for _ in range(2, int(self.exponents.max(initial=1)) + 1):
            slopes.append(2.0 * (values[-1] + variables * slopes[-1]) - slopes[-2])
            values.append(2.0 * variables * values[-1] - values[-2])
        stacks = np.stack(values, axis=1), np.stack(slopes, axis=1)  # (P, degree, 6)
        first, second = (np.stack([stack[:, self.exponents[:, i], i] for i in range(6)])
                         for stack in stacks)
        return first, second


def slope_terms(factors: FloatArray, slopes: FloatArray, place: int) -> FloatArray:
    """Return the slopes (P, T) of the products of factors (6, P, T) by one variable."""
    others = np.delete(factors, place, axis=0)
    return np.asarray(others.prod(axis=0) * slopes[place])


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
        In ascending order of size.
    domain : EmulatorDomain
    basis : PolynomialBasis
    weights : (T, 2 K) array
        Real and imaginary part, in turns, of the factor of each term in each of K invariants.
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
        if inside.any():
            found[:, inside] = self._evaluate(inputs.reshape(-1, 6)[inside])
        return EmulatedGrowth(*found.reshape(4, *shape))

    def eigenvalues(self, inputs: FloatArray) -> ComplexArray:
        """Return all eigenvalues (P, K) of the families at inputs (P, 6) of the domain [1/s]."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        factors, _ = self.basis.terms(self.basis.variables(coefficients)[0])
        invariants = self._invariants(factors.prod(axis=0))
        return np.concatenate([roots_of(invariants[:, columns]) for columns in self._columns],
                              axis=1)

    def _evaluate(self, inputs: FloatArray) -> FloatArray:
        """Return what `EmulatedGrowth` has (4, P, F)."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        variables, by_own = self.basis.variables(coefficients)
        factors, slopes = self.basis.terms(variables)
        by = [slope_terms(factors, slopes, i) * by_own[:, i:i + 1] for i in (1, 2, 4, 5)]
        friction = coefficients[:, 4:5]  # radial dissipation and slope are in proportion to it
        by_friction = (by[0] * coefficients[:, 1:2] + by[1] * coefficients[:, 2:3]
                       ) / friction + by[2]
        terms = np.stack([factors.prod(axis=0), by_friction, by[3] * coefficients[:, 5:]])
        invariants = self._invariants(terms)
        return np.stack([_least_stable(invariants[..., columns]) for columns in self._columns],
                        axis=-1)

    def _invariants(self, terms: FloatArray) -> ComplexArray:
        found: ComplexArray = (terms @ self.weights).view(complex)
        return found

    @cached_property
    def _columns(self) -> tuple[slice, ...]:
        return tuple(columns_of(len(family.numbers) for family in self.families))


def columns_of(sizes: Any) -> Iterator[slice]:
    """Yield where the invariants of families of these sizes are."""
    start = 0
    for size in sizes:
        yield slice(start, start + size)
        start += size


def roots_of(invariants: ComplexArray) -> ComplexArray:
    """Return the eigenvalues (P, n) of a family of these invariants (P, n)."""
    size = invariants.shape[1]
    if size == 1:
        return invariants
    if size == 2:
        half = np.sqrt(-invariants[:, 1])
        return np.stack([invariants[:, 0] + half, invariants[:, 0] - half], axis=1)
    companion = np.zeros((len(invariants), size, size), complex)
    companion[:, range(1, size), range(size - 1)] = 1.0
    companion[:, 0, 1:] = -invariants[:, 1:]
    return np.asarray(invariants[:, :1] + np.linalg.eigvals(companion))


def _least_stable(invariants: ComplexArray) -> FloatArray:
    """Return growth, frequency and slopes (4, P) from invariants and their slopes (3, P, n)."""
    value, size = invariants[0], invariants.shape[2]
    roots = roots_of(value)
    root = roots[np.arange(len(roots)), roots.real.argmax(axis=1)]
    z = root - value[:, 0]
    slopes = invariants[1:, :, 0]
    if size > 1:
        powers = z[:, None] ** np.arange(size - 2, -1, -1)
        steep = size * z ** (size - 1) + (
            powers[:, 1:] * value[:, 1:-1] * np.arange(size - 2, 0, -1)).sum(axis=1)
        gap = np.abs(steep)
        limited = steep.conj() / np.maximum(gap, _LEAST_GAP) / np.maximum(gap, 1e-200)
        slopes = slopes - (invariants[1:, :, 1:] * powers).sum(axis=2) * limited
    return np.stack([root.real, root.imag / (2.0 * np.pi), *slopes.real])
