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
from numpy.typing import NDArray
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly, RealArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.sliding_laws import sliding_laws
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.risk.polynomial_basis import BRAKE, OPERATION, PolynomialBasis

INPUTS = ('ln_rotor_speed', 'ln_contact_pressure', 'friction', 'ln_contact_stiffness',
          'ln_damping', 'slope_scale')
"""ln of |Omega| [rad/s] and of p0 [Pa]; mu [-]; ln of the factors on the model's k_c at this p0
and on its damping; factor on the friction slope by the model's law."""

_WITH_FRICTION = np.array([[0.0], [1.0], [1.0], [1.0]])  # which of them are in proportion to it
_WITH_DAMPING = np.array([[0.0], [1.0]])
_CHUNK = 256  # rows evaluated at once: their terms stay in the cache
_LEAST = 2.0  # 1/s^2; slopes of eigenvalues nearer to each other than 2 1/s are limited


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

    @cached_property
    def _rows(self) -> NDArray[np.float32]:
        """Return the weights of Im, Re of single modes and means, Re, Im of squares, (2 K, T)."""
        parts = self.weights.T.reshape(-1, 2, len(self.weights))  # (K, 2, T)
        count = len(self.families)
        return np.concatenate([parts[:count, 1], parts[:count, 0], parts[count:, 0],
                               parts[count:, 1]], dtype=np.float32)

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
        variables, _ = self.basis.variables(affine_coefficients(self.model, inputs)[0])
        none = np.empty((0, 1, 1))
        [terms] = self.basis.terms(*self.basis.factors(variables, none, none))
        mean, square = np.split((terms.T @ self.weights).view(complex), [len(self.families)],
                                axis=1)
        half = np.zeros_like(mean)
        half[:, mean.shape[1] - square.shape[1]:] = np.sqrt(square)
        return np.concatenate([mean + half, (mean - half)[:, -square.shape[1]:]], axis=1)

    def _evaluate(self, inputs: FloatArray) -> FloatArray:
        """Return what `EmulatedGrowth` has at inputs (G, P, 6), (4, G, F, P)."""
        count, shape = len(self.families), inputs.shape[:2]
        with np.errstate(all='ignore'):  # outside the domain
            factors = [part.reshape(*part.shape[:2], *shape)
                       for part in self._factors(inputs.reshape(-1, 6))]
        values = np.empty((shape[0], len(self._rows), shape[1]), np.float32)
        slopes = np.empty((2, shape[0], len(self._rows) - count, shape[1]), np.float32)
        for group in range(len(inputs)):  # its terms stay in the cache
            terms = self.basis.terms(*(part[:, :, group] for part in factors))
            values[group], slopes[:, group] = self._rows @ terms[0], self._rows[count:] @ terms[1:]
        end = len(self._rows) // 2 + count
        angular, rate = values[:, :count], values[:, count:2 * count]
        pairs = slice(2 * count - len(self._rows) // 2, count)
        real, imaginary = values[:, 2 * count:end].astype(float), values[:, end:]
        size = np.sqrt(real * real + imaginary * imaginary)
        # half of a difference with a real part above zero leads to the less stable one
        grown = np.sqrt(0.5 * (size + real)).astype(np.float32)
        turned = np.copysign(np.sqrt(0.5 * (size - real)).astype(np.float32), imaginary)
        rate[:, pairs] += grown
        angular[:, pairs] += turned
        by = grown * slopes[:, :, count:end - count] + turned * slopes[:, :, end - count:]
        slopes[:, :, pairs] += by / np.maximum(2.0 * size.astype(np.float32), _LEAST)
        found = np.stack([rate, angular / np.float32(2.0 * np.pi), *slopes[:, :, :count]])
        np.copyto(found, np.float32(np.nan), where=~self.domain.covers(inputs)[:, None])
        return found

    def _factors(self, inputs: FloatArray) -> tuple[RealArray, ...]:
        """Return the factors of terms at inputs (P, 6), and their slopes by friction, damping."""
        coefficients, _ = affine_coefficients(self.model, inputs)
        variables, by_own = self.basis.variables(coefficients)
        change = (coefficients * by_own).T
        # radial dissipation and slope are in proportion to the friction coefficient
        by_friction = change[None, OPERATION] * _WITH_FRICTION / coefficients[:, 4]
        return self.basis.factors(variables, by_friction, change[None, BRAKE] * _WITH_DAMPING,
                                  np.float32)
