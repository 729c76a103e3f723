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

"""Calibration of an ensemble of brakes by brake applications and the squeal observed in them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
import math
from typing import NamedTuple

import numpy as np
from squeal_core.calibration.applications import BrakeApplication, Observation
from squeal_core.calibration.candidates import BrakeCandidates, PARAMETERS
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.calibration.importance_sampling import (
    LEAST_VARIANCE,
    Proposal,
    sample_posterior,
    SamplingRound,
    WeightedSample,
)
from squeal_core.calibration.likelihood import log_likelihood
from squeal_core.calibration.squeal_probability import SquealPredictor
from squeal_core.common.arrays import FloatArray, IndexArray, repr_with_shapes
from squeal_core.common.errors import SquealError
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import Ensemble, EnsemblePrior
from squeal_core.risk.risk_records import GrowthSource, RiskSettings

ENOUGH_EVENTS = 10
"""Events below which the likelihood counts in part only: silence may be a dead microphone."""
_FIRST = 400  # observations; with many more, draws begin at the posterior of so many: time
_LEAST_KNOWN = 0.5  # of what the best known candidate has inside the emulator's domain


@dataclass(frozen=True, eq=False)
class Calibration:
    """
    Result of a calibration.

    Parameters
    ----------
    prior : EnsemblePrior
    candidates : BrakeCandidates
        Members, of equal weight.
    sample : WeightedSample
        Posterior, in standard deviations of the prior.
    heard, silent : int
        Observations with squeal and without.
    power : float
        To which the likelihood was raised, below 1 where there are few events.

    """

    prior: EnsemblePrior
    candidates: BrakeCandidates
    sample: WeightedSample
    heard: int
    silent: int
    power: float

    __repr__ = repr_with_shapes

    @property
    def likelihood_power(self) -> float:
        """Return the power of the likelihood that was reached, at most `power`."""
        return self.sample.rounds[-1].power

    def ensemble(self, calibrated: str) -> Ensemble:
        """Return the members; `calibrated` says by what, and counts only if something did."""
        return self.candidates.ensemble(calibrated if self.likelihood_power else '',
                                        self.likelihood_power)

    def probabilities(self, model: BrakeModel, emulator: GrowthSource,
                      applications: Sequence[BrakeApplication],
                      hearing: HearingModel | None = None,
                      settings: RiskSettings | None = None) -> FloatArray:
        """Return the probability of squeal in applications; of an event, given a hearing model."""
        result = SquealPredictor(model, emulator, applications, settings=settings).evaluate(
            self.candidates)
        mean = result.squeals.mean(axis=0)
        return mean if hearing is None else hearing.heard(mean)


def calibrate(model: BrakeModel, emulator: GrowthSource,
              applications: Sequence[BrakeApplication], observations: Sequence[Observation], *,
              prior: EnsemblePrior | None = None, hearing: HearingModel | None = None,
              settings: RiskSettings | None = None, seed: int = 0, workers: int = 0,
              progress: Callable[[SamplingRound], None] = lambda _: None) -> Calibration:
    """
    Return the calibration of a model by the squeal observed in brake applications.

    Parameters
    ----------
    model : BrakeModel
        Of all brakes.
    emulator : GrowthSource
        Of the model.
    applications : sequence of BrakeApplication
        Of any number of recordings.
    observations : sequence of Observation
        `match_events` of them.
    prior : EnsemblePrior, optional
        Before any squeal was measured.
    hearing : HearingModel, optional
        Rates of detection and errors.
    settings : RiskSettings, optional
        Squeal band and noise floor.
    seed : int
        Of the draws.
    workers : int
        Processes among which draws are divided; 0: this one.
    progress : callable
        Told each round.

    Raises
    ------
    SquealError
        Without an observation.

    """
    if not observations:
        raise SquealError('no brake application was observed; give recordings in which the brakes '
                          'slide under load')
    prior, hearing = prior or EnsemblePrior(), hearing or HearingModel()
    heard = sum(one.heard for one in observations)
    power = min(1.0, math.sqrt(heard / ENOUGH_EVENTS))
    nth = len(observations) // _FIRST  # a posterior is as much narrower as there are more

    def sampled(some: Sequence[Observation], start: Proposal | None = None) -> WeightedSample:
        used = sorted({i for one in some for i in one.applications})
        place = {i: k for k, i in enumerate(used)}
        task = _Task(SquealPredictor(model, emulator, [applications[i] for i in used],
                                     settings=settings), prior, hearing,
                     [replace(one, applications=tuple(place[i] for i in one.applications))
                      for one in some])
        return sample_posterior(partial(_of_draws, task, workers), len(PARAMETERS), power=power,
                                seed=seed, start=start, progress=progress,
                                least_variance=LEAST_VARIANCE / (nth if start else 1))

    sample = sampled(observations, sampled(observations[::nth]).proposal() if nth > 1 else None)
    values = sample.resampled(prior.count)
    members = BrakeCandidates.of_standard(prior, values[_order(values)])
    return Calibration(prior, members, sample, heard, len(observations) - heard, power)


class _Task(NamedTuple):
    """Arguments of the likelihood of draws, the same in every process."""

    predictor: SquealPredictor
    prior: EnsemblePrior
    hearing: HearingModel
    observations: Sequence[Observation]


def _order(values: FloatArray) -> IndexArray:
    """Return the order of draws by contact stiffness, in which growth is evaluated fastest."""
    return values[:, PARAMETERS.index('ln_contact_stiffness')].argsort()


def _of_draws(task: _Task, workers: int, values: FloatArray) -> FloatArray:
    order = _order(values)
    parts = dict(enumerate(np.array_split(order, max(1, workers))))
    result = dict(run_jobs(_log_likelihood, {i: (task, values[part]) for i, part in parts.items()},
                           workers))
    return np.concatenate([result[i] for i in parts])[order.argsort()]


def _log_likelihood(task: _Task, values: FloatArray) -> FloatArray:
    candidates = BrakeCandidates.of_standard(task.prior, values)
    result = task.predictor.evaluate(candidates)
    # the prior ends where the emulator's domain does
    inside = result.known >= _LEAST_KNOWN * result.known.max(initial=0.0)
    return np.where(inside, log_likelihood(result, task.observations, task.hearing), -np.inf)
