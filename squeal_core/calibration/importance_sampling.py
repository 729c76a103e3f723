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
Adaptive importance sampling of a posterior with a standard normal prior (population Monte Carlo).

The likelihood is raised to a power that rises from round to round to its end, as far as the
effective sample size allows; each round draws from a Student t distribution about the weighted
sample so far, and all rounds count, by the mixture of what they were drawn from (Cornuet, Marin,
Mira and Robert, Scand. J. Stat. 39 (2012) 798). Reweighting draws of the prior alone degenerates.
"""

from collections.abc import Callable
from dataclasses import dataclass
import math
from typing import TypeAlias

import numpy as np
from scipy.special import gammaln, logsumexp
from squeal_core.common.arrays import FloatArray, repr_with_shapes

Proposal: TypeAlias = tuple[FloatArray, FloatArray]
"""Mean (d,) and covariance (d, d)."""
_FREEDOM = 6.0  # degrees of the Student t distribution: heavier tails than a posterior's
_DEFENSIVE = 0.1  # fraction of each round that is drawn from the prior
LEAST_VARIANCE = 0.02  # of a proposal, in each direction, the prior's being 1
_POWERS = np.geomspace(1.0, 1e-6, 140)  # a tenth apart
_LEAST_EFFECTIVE = 0.25  # of a round's size: effective size to which the power is raised
_OF_START = 1.0 / 16.0  # likewise, by draws about a start: less than those of the prior among them


@dataclass(frozen=True)
class SamplingRound:
    """One round: draws so far, power of the likelihood, effective sample size."""

    draws: int
    power: float
    effective_size: float


@dataclass(frozen=True, eq=False)
class WeightedSample:
    """
    Draws of a posterior.

    Parameters
    ----------
    values : (n, d) array
        In standard deviations of the prior, from its mean.
    weights : (n,) array
        Their sum is 1.
    rounds : tuple of SamplingRound

    """

    values: FloatArray
    weights: FloatArray
    rounds: tuple[SamplingRound, ...]

    __repr__ = repr_with_shapes

    @property
    def effective_size(self) -> float:
        """Return the number of draws of equal weight that are worth as much."""
        return self.rounds[-1].effective_size

    @property
    def mean(self) -> FloatArray:
        """Return the weighted mean, (d,)."""
        return np.asarray(self.weights @ self.values)

    @property
    def covariance(self) -> FloatArray:
        """Return the weighted covariance, (d, d)."""
        from_mean = self.values - self.mean
        return np.asarray((self.weights[:, None] * from_mean).T @ from_mean)

    def proposal(self, least_variance: float = LEAST_VARIANCE) -> Proposal:
        """Return mean and covariance of the distribution of further draws."""
        return self.mean, self.covariance + least_variance * np.eye(self.values.shape[1])

    def resampled(self, count: int) -> FloatArray:
        """
        Return draws of equal weight (count, d): systematic resampling along the main direction.

        It takes the same ones at each call, and those of large weight more than once.
        """
        order = np.argsort(self.values @ np.linalg.eigh(self.covariance)[1][:, -1])
        places = np.searchsorted(np.cumsum(self.weights[order]),
                                 (np.arange(count) + 0.5) / count * self.weights.sum())
        return np.asarray(self.values[order[np.minimum(places, order.size - 1)]])


def sample_posterior(log_likelihood: Callable[[FloatArray], FloatArray], dimensions: int, *,
                     power: float = 1.0, draws: int = 256, rounds: int = 12, enough: float = 200.0,
                     seed: int = 0, start: Proposal | None = None,
                     least_variance: float = LEAST_VARIANCE,
                     progress: Callable[[SamplingRound], None] = lambda _: None
                     ) -> WeightedSample:
    """
    Sample a posterior whose prior is standard normal.

    Parameters
    ----------
    log_likelihood : callable
        Of (n, d) draws, returns (n,); -inf excludes a draw.
    dimensions : int
        d.
    power : float
        To which the likelihood is raised in the end, 0 to 1.
    draws : int
        Of a round, a power of two.
    rounds : int
        Most of them.
    enough : float
        Effective sample size at the full power at which it ends.
    seed : int
        Of the Sobol points.
    start : tuple of mean and covariance, optional
        What the first round is drawn from; by default the prior.
    least_variance : float
        Of what is drawn from, in each direction, the prior's being 1.
    progress : callable
        Told each round.

    """
    proposals: list[Proposal | None] = [start]  # None: the prior
    values, likelihood = np.empty((0, dimensions)), np.empty(0)
    done: list[SamplingRound] = []
    reached = 0.0
    while True:
        fresh = _draw(proposals[-1], draws, dimensions, seed + len(proposals))
        values = np.vstack([values, fresh])
        likelihood = np.append(likelihood, log_likelihood(fresh))
        base = _log_normal(values) - logsumexp(
            [_log_density(one, values) for one in proposals], axis=0)
        wanted = draws * (_LEAST_EFFECTIVE if done or start is None else _OF_START)
        reached = max(reached, _largest_power(base, likelihood, power, wanted))
        weights = _weights(base, reached, likelihood)
        done.append(SamplingRound(len(values), reached, _effective(weights)))
        progress(done[-1])
        sample = WeightedSample(values, weights, tuple(done))
        if len(done) == rounds or (reached == power and done[-1].effective_size >= enough):
            return sample
        proposals.append(sample.proposal(least_variance))


def _weights(base: FloatArray, power: float, likelihood: FloatArray) -> FloatArray:
    if not power:  # 0 times -inf
        likelihood = np.where(np.isneginf(likelihood), -np.inf, 0.0)
    else:
        likelihood = power * likelihood
    logs = base + likelihood
    return np.asarray(np.exp(logs - logsumexp(logs)))


def _effective(weights: FloatArray) -> float:
    return float(1.0 / np.square(weights).sum())


def _largest_power(base: FloatArray, likelihood: FloatArray, most: float, wanted: float) -> float:
    """Return the largest power of the likelihood that leaves the wanted effective size."""
    powers = [*(most * _POWERS), 0.0]
    sizes = [_effective(_weights(base, one, likelihood)) for one in powers]
    best = max(sizes) * (1.0 - 1e-9)
    return float(next(power for power, size in zip(powers, sizes, strict=True)
                      if size >= min(wanted, best)))


def _draw(proposal: Proposal | None, count: int, dimensions: int, seed: int) -> FloatArray:
    from scipy.special import chdtri, ndtri
    from scipy.stats import qmc
    points = qmc.Sobol(dimensions + 2, scramble=True, seed=seed).random(count)
    normal = ndtri(np.clip(points[:, :dimensions], 1e-9, 1.0 - 1e-9))
    if proposal is None:
        return np.asarray(normal)
    mean, covariance = proposal
    stretch = np.sqrt(_FREEDOM / chdtri(_FREEDOM, np.clip(points[:, -2], 1e-9, 1.0 - 1e-9)))
    moved = mean + stretch[:, None] * (normal @ np.linalg.cholesky(covariance).T)
    return np.asarray(np.where(points[:, -1:] < _DEFENSIVE, normal, moved))


def _log_normal(values: FloatArray) -> FloatArray:
    size = values.shape[1]
    return np.asarray(-0.5 * (np.square(values).sum(axis=1) + size * math.log(2.0 * math.pi)))


def _log_density(proposal: Proposal | None, values: FloatArray) -> FloatArray:
    prior = _log_normal(values)
    if proposal is None:
        return prior
    mean, covariance = proposal
    size, root = len(mean), np.linalg.cholesky(covariance)
    squares = np.square(np.linalg.solve(root, (values - mean).T)).sum(axis=0)
    student = (gammaln(0.5 * (_FREEDOM + size)) - gammaln(0.5 * _FREEDOM)
               - 0.5 * size * math.log(_FREEDOM * math.pi) - np.log(np.diag(root)).sum()
               - 0.5 * (_FREEDOM + size) * np.log1p(squares / _FREEDOM))
    return np.asarray(np.logaddexp(math.log(_DEFENSIVE) + prior,
                                   math.log1p(-_DEFENSIVE) + student))
