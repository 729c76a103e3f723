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

"""Ensemble of brakes: the persistent uncertainty of a brake as fixed, weighted members."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes
from squeal_core.common.errors import SquealError

_TRUNCATED = 3.0  # standard deviations beyond which no member lies
_LEAST_BUILD_UP = 1.0  # neper; with less, the noise floor itself would be heard
_LEAST_POWER = 0.7  # power of the likelihood below which a calibration hardly moves the level
MOSTLY_PRIOR = 'the level of the risk is mostly the prior of damping'
NOT_CALIBRATED = f'not calibrated: {MOSTLY_PRIOR}'
_SLOPES = (0.0, 2.0)  # factors on the friction slope that emulators cover
MEMBERS = ('ln_damping', 'ln_contact_stiffness', 'friction_bias', 'slope_scale',
           'audible_build_up')
Persistent: TypeAlias = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]


def risk_basis(calibrated: str, likelihood_power: float) -> str:
    """Return the basis of the level of a squeal risk, in words; as attributes of `Ensemble`."""
    if not calibrated:
        return NOT_CALIBRATED
    return f'{calibrated}: {MOSTLY_PRIOR}' if likelihood_power < _LEAST_POWER else calibrated


@dataclass(frozen=True, kw_only=True)
class EnsemblePrior:
    """
    Uncertainty of a brake before anything was measured; all quantities are independent Gaussians.

    Parameters
    ----------
    damping : float
        Standard deviation of ln(damping scale) [-]; 20 to 40 % is what nominally equal brakes
        scatter by.
    contact_stiffness : float
        Standard deviation of ln k_c [-].
    friction : float
        Standard deviation of the bias of the measured friction coefficient [-].
    slope : float
        Standard deviation of the factor on the friction slope, of mean 1 [-].
    audible_build_up, audible_build_up_deviation : float
        N*, build-up from which a mode is audible, and its standard deviation [nepers].
    friction_scatter : float
        Standard deviation of the friction coefficient from one brake application to the next [-].
    damping_scatter : float
        Likewise of ln(damping scale) [-].
    count : int
        Number of members, a power of 2.
    seed : int
        Of the scrambling.

    Raises
    ------
    SquealError
        For a negative standard deviation or a count that is no power of 2.

    """

    damping: float = 0.3
    contact_stiffness: float = 0.1
    friction: float = 0.03
    slope: float = 0.3
    audible_build_up: float = 5.5
    audible_build_up_deviation: float = 2.0
    friction_scatter: float = 0.02
    damping_scatter: float = 0.15
    count: int = 64
    seed: int = 18  # of the first 200, correlations between members' quantities are least: 0.02

    def __post_init__(self) -> None:
        for name in ('damping', 'contact_stiffness', 'friction', 'slope', 'audible_build_up',
                     'audible_build_up_deviation', 'friction_scatter', 'damping_scatter'):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise SquealError(f'{name} is {getattr(self, name):g}; give zero or a positive '
                                  'number')
        if self.count < 1 or self.count & (self.count - 1) or self.count > 2**16:
            raise SquealError(f'count is {self.count}; give a power of 2 up to {2**16}')


@dataclass(frozen=True, eq=False)
class Ensemble:
    """
    Members that may be the brake, each with a weight.

    Parameters
    ----------
    ln_damping, ln_contact_stiffness : (M,) arrays
        ln of the factors on the model's damping and contact stiffness [-].
    friction_bias : (M,) array
        True minus measured friction coefficient [-].
    slope_scale : (M,) array
        Factor on the friction slope [-].
    audible_build_up : (M,) array
        Build-up from which a mode is audible [nepers].
    weights : (M,) array
        Probabilities of the members, of sum 1.
    friction_scatter, damping_scatter : float
        Standard deviations of friction [-] and of ln(damping scale) [-] from one brake
        application to the next.
    calibrated : str
        Where the weights come from; empty: a prior.
    likelihood_power : float
        To which the likelihood of measured squeal was raised, 0 to 1; 1: it counts in full.

    Raises
    ------
    SquealError
        For arrays of different lengths, values that are not finite, negative or no weights.

    """

    ln_damping: FloatArray
    ln_contact_stiffness: FloatArray
    friction_bias: FloatArray
    slope_scale: FloatArray
    audible_build_up: FloatArray
    weights: FloatArray
    friction_scatter: float
    damping_scatter: float
    calibrated: str = ''
    likelihood_power: float = 1.0

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        for name in (*MEMBERS, 'weights'):
            array = readonly(getattr(self, name))
            if array.shape != np.shape(self.weights) or array.ndim != 1 or not (
                    array.size and np.isfinite(array).all()):
                raise SquealError(f'{name}: shape {array.shape}; give as many finite numbers as '
                                  'members')
            object.__setattr__(self, name, array)
        total = float(self.weights.sum())
        if self.weights.min() < 0.0 or not total > 0.0:
            raise SquealError(f'weights: from {self.weights.min():g}, sum {total:g}; give weights '
                              'of zero or more, not all zero')
        object.__setattr__(self, 'weights', readonly(self.weights / total))

    @property
    def count(self) -> int:
        """Return the number of members."""
        return int(self.weights.size)

    def inputs(self, rotor_speed: ArrayLike, contact_pressure: ArrayLike,
               friction: ArrayLike) -> FloatArray:
        """
        Return the inputs of a growth emulator for each member, (..., M, 6).

        Parameters
        ----------
        rotor_speed, contact_pressure, friction : array_like, (...)
            Measured: [rad/s] of either sign, [Pa], [-]; broadcast together.

        """
        speed, pressure, measured = np.broadcast_arrays(*(
            np.asarray(value, float)[..., None] for value in (
                rotor_speed, contact_pressure, friction)))
        result = np.empty((*speed.shape[:-1], self.count, 6))
        with np.errstate(divide='ignore', invalid='ignore'):  # outside of any domain
            result[..., 0], result[..., 1] = np.log(np.abs(speed)), np.log(pressure)
        result[..., 2] = measured + self.friction_bias
        result[..., 3], result[..., 4] = self.ln_contact_stiffness, self.ln_damping
        result[..., 5] = self.slope_scale
        return result


def prior_ensemble(prior: EnsemblePrior) -> Ensemble:
    """
    Return equally weighted members of a prior, in the order of their contact stiffness.

    Notes
    -----
    Scrambled Sobol points (A. B. Owen, J. Complexity 14 (1998) 466-489), by the inverse of the
    normal distribution; the same bits for the same prior.

    """
    from scipy.special import ndtri  # slow to load, and few commands draw
    from scipy.stats import qmc

    points = qmc.Sobol(len(MEMBERS), seed=prior.seed).random(prior.count)
    points = points[points[:, 1].argsort()]  # a growth emulator evaluates them fastest then
    return Ensemble(*persistent(prior, ndtri(points)), weights=np.ones(prior.count),
                    friction_scatter=prior.friction_scatter,
                    damping_scatter=prior.damping_scatter)


def persistent(prior: EnsemblePrior, deviations: FloatArray) -> Persistent:
    """
    Return the arrays (M,) of members, in the order of `MEMBERS`.

    Parameters
    ----------
    prior : EnsemblePrior
        Its standard deviations.
    deviations : (M, 5) array
        In standard deviations of the prior from its means.

    """
    z = np.clip(deviations, -_TRUNCATED, _TRUNCATED).T
    return (prior.damping * z[0], prior.contact_stiffness * z[1], prior.friction * z[2],
            np.clip(1.0 + prior.slope * z[3], *_SLOPES),
            np.maximum(prior.audible_build_up + prior.audible_build_up_deviation * z[4],
                       _LEAST_BUILD_UP))
