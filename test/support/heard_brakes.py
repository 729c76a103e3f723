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
Brakes whose squeal is known: brake applications, the true probability of squeal, and labels.

The truth is computed by a route of its own: each application has its own friction and damping, the
growth rates are those at these values at every tick, and the energy is summed up tick by tick.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import qmc
from squeal_core.calibration.applications import BrakeApplication, inputs_of, Observation
from squeal_core.calibration.baselines import (
    base_rate_of,
    has_sklearn,
    logistic_regression,
    lookup_table,
)
from squeal_core.calibration.calibrate import calibrate
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import EnsemblePrior
from squeal_core.risk.risk_records import GrowthSource

TICK = 0.1  # s
_DRAWS = 64
_CAP = math.exp(2.0 * 9.9)  # of the energy over the floor's


@dataclass(frozen=True)
class Stops:
    """Ranges of random brake applications: [rad/s], p0 [Pa], [-], [s]."""

    rotor_speed: tuple[float, float] = (15.0, 95.0)
    contact_pressure: tuple[float, float] = (3e5, 3e6)
    friction: tuple[float, float] = (0.36, 0.50)
    duration: tuple[float, float] = (1.5, 4.0)


def brake_applications(rng: np.random.Generator, count: int,
                       stops: Stops | None = None) -> list[BrakeApplication]:
    """Return random stops: falling speed, rising pressure, friction that drifts."""
    stops = stops or Stops()
    found = []
    for _ in range(count):
        duration = rng.uniform(*stops.duration)
        time = np.arange(0.0, duration, TICK)
        speed = math.exp(rng.uniform(*np.log(stops.rotor_speed)))
        end = max(stops.rotor_speed[0], speed * rng.uniform(0.2, 0.9))
        pressure = math.exp(rng.uniform(*np.log(stops.contact_pressure)))
        wave = np.sin(time + rng.uniform(0.0, 6.0))
        found.append(BrakeApplication(
            'fl', 'stops', time, speed + (end - speed) * time / duration,
            pressure * (1.0 + 0.1 * wave) * np.minimum(1.0, (time + TICK) / 0.3),
            rng.uniform(*stops.friction) + 0.01 * wave))
    return found


class Truth(NamedTuple):
    """Of A applications: probability of squeal, whether one squealed, its pitch [Hz]."""

    probability: FloatArray
    squealed: NDArray[np.bool_]
    frequency_hz: FloatArray


def listen(source: GrowthSource, applications: Sequence[BrakeApplication], values: FloatArray,
           rng: np.random.Generator, *, friction: float = 0.02, damping: float = 0.15,
           draws: int = _DRAWS) -> Truth:
    """
    Return what applications do in a true brake.

    Parameters
    ----------
    source : GrowthSource
        Of the true growth rates.
    applications : sequence of BrakeApplication
        What the driver does.
    values : (5,) array
        ln damping, ln k_c, friction bias, slope scale, N* of the brake.
    rng : Generator
        Of the scatter.
    friction, damping : float
        Scatter of friction and of ln damping from application to application.
    draws : int
        For the probability, a power of two.

    """
    scatter = np.array([friction, damping])
    spread = scatter * ndtri(qmc.Sobol(2, scramble=True, seed=5).random(draws))
    rows = []
    for one in applications:
        own = scatter * rng.standard_normal((1, 2))
        squeals, family, pitch = _squeals(source, one, values, np.vstack([spread, own]))
        rows.append((squeals[:-1].mean(), squeals[-1], pitch[-1]))
    probability, squealed, pitch = map(np.array, zip(*rows, strict=True))
    return Truth(probability, squealed.astype(bool), pitch)


def _squeals(source: GrowthSource, one: BrakeApplication, values: FloatArray,
             shifts: FloatArray) -> tuple[Any, Any, Any]:
    inputs = np.empty((one.time.size, len(shifts), 6))
    inputs[..., 0] = np.log(one.rotor_speed)[:, None]
    inputs[..., 1] = np.log(one.contact_pressure)[:, None]
    inputs[..., 2] = one.friction[:, None] + values[2] + shifts[:, 0]
    inputs[..., 3], inputs[..., 4] = values[1], values[0] + shifts[:, 1]
    inputs[..., 5] = values[3]
    found = source.evaluate(inputs)
    rate = np.nan_to_num(found.growth_rate, nan=-50.0)
    decay = np.array([family.decay_rate for family in source.families])
    energy = most = np.ones(rate.shape[1:])
    between = np.vstack([rate[:1], 0.5 * (rate[1:] + rate[:-1]), rate[-1:]])
    for k, growth in enumerate(between):  # half a tick before the first and after the last
        time = TICK * (0.5 if k in (0, len(rate)) else 1.0)
        x = np.where(np.abs(growth) > 1e-6, 2.0 * growth, 1e-6)
        energy = np.minimum(energy * np.exp(x * time) + 2.0 * decay * np.expm1(x * time) / x, _CAP)
        most = np.maximum(most, energy)
    family = most.argmax(axis=-1)
    fastest = rate.argmax(axis=0)
    draws = np.arange(len(shifts))
    pitch = found.frequency_hz[fastest[draws, family], draws, family]
    return 0.5 * np.log(most.max(axis=-1)) > values[4], family, pitch


def true_brake(source: GrowthSource, applications: Sequence[BrakeApplication],
               prior: EnsemblePrior, rng: np.random.Generator) -> Truth:
    """Return the truth of a random brake of the prior that squeals sometimes."""
    return listen(source, applications, random_brake(source, applications, prior, rng), rng)


def random_brake(source: GrowthSource, applications: Sequence[BrakeApplication],
                 prior: EnsemblePrior, rng: np.random.Generator,
                 rates: tuple[float, float] = (0.15, 0.85)) -> FloatArray:
    """Return the values, as of `listen`, of a brake of the prior that squeals sometimes."""
    for _ in range(100):
        z = rng.standard_normal(5)
        values = np.array([
            prior.damping * z[0], prior.contact_stiffness * z[1], prior.friction * z[2],
            max(0.0, 1.0 + prior.slope * z[3]),
            max(1.0, prior.audible_build_up + prior.audible_build_up_deviation * z[4])])
        few = listen(source, applications[::4], values, rng, draws=8)
        if rates[0] < few.probability.mean() < rates[1]:
            return values
    raise AssertionError('no brake of the prior squeals sometimes')


class Trial(NamedTuple):
    """Scores by name; calibrated and true probabilities of the held-out labels."""

    brier: dict[str, float]
    probability: FloatArray
    true: FloatArray
    heard: NDArray[np.bool_]
    effective_size: float


def trial(model: BrakeModel, truth_of: GrowthSource, source: GrowthSource, seed: int, *,
          train: int = 60, test: int = 60, wrong: float = 0.05, events: bool = False,
          stops: Stops | None = None, prior: EnsemblePrior | None = None) -> Trial:
    """
    Calibrate with applications of a true brake and score on others of it.

    Parameters
    ----------
    model : BrakeModel
        Of the brake.
    truth_of, source : GrowthSource
        True growth rates, and those that are calibrated.
    seed : int
        Of brake, applications and labels.
    train, test : int
        Applications to fit and to score.
    wrong : float
        Fraction of wrong labels.
    events : bool
        `train` is a number of events, and the applications until there are as many.
    stops, prior
        Of the applications and of the brake.

    """
    rng, prior = np.random.default_rng(seed), prior or EnsemblePrior()
    most = (8 if events else 1) * train
    applications = brake_applications(rng, most + test, stops)
    truth = true_brake(truth_of, applications, prior, rng)
    return fitted(model, source, applications, truth, rng, prior=prior, seed=seed, train=train,
                  test=test, wrong=wrong, events=events)


def fitted(model: BrakeModel, source: GrowthSource, applications: Sequence[BrakeApplication],
           truth: Truth, rng: np.random.Generator, *, prior: EnsemblePrior, seed: int, train: int,
           test: int, wrong: float, events: bool) -> Trial:
    """Return the scores of a calibration with the first applications on the last; as `trial`."""
    most = len(applications) - test
    heard = truth.squealed ^ (rng.random(truth.squealed.size) < wrong)
    pitch = np.where(truth.squealed, truth.frequency_hz * np.exp(
        0.01 * rng.standard_normal(heard.size)), np.exp(rng.uniform(
            math.log(1250.0), math.log(16_000.0), heard.size)))
    known = np.arange(train)
    if events:
        known = np.arange(min(most, int(np.searchsorted(np.cumsum(heard), train)) + 1))
    new = np.arange(most, most + test)
    observations = [Observation((int(i),), bool(heard[i]), float(pitch[i]) if heard[i]
                                else math.nan) for i in known]
    found = calibrate(model, source, applications, observations, prior=prior, seed=seed)
    hearing, held = HearingModel(), [applications[i] for i in new]
    inputs, rate = inputs_of(applications), base_rate_of(heard[known])
    calibrated = found.probabilities(model, source, held, hearing)
    probability = {
        'base rate': np.full(test, rate),
        'table': lookup_table(inputs[known, :3], heard[known], inputs[new, :3]),
        'calibrated': calibrated,
        'truth': wrong + (1.0 - 2.0 * wrong) * truth.probability[new]}
    if has_sklearn():
        probability['logistic'] = logistic_regression(inputs[known], heard[known], inputs[new])
    return Trial({name: float(np.mean((values - heard[new])**2))
                  for name, values in probability.items()}, calibrated,
                 probability['truth'], heard[new], found.sample.effective_size)
