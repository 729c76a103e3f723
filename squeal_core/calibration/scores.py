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

"""Scores of squeal probabilities on applications that were held out."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import FloatArray, IndexArray

_LEAST = 1e-3  # probabilities are this far from 0 and 1 at least where a logarithm is taken
_BINS = 5  # of a calibration curve, equally full
_RESAMPLES = 200  # of the bootstrap


@dataclass(frozen=True)
class Score:
    """
    Scores of probabilities against observations; NaN where not defined.

    Parameters
    ----------
    brier : float
        Mean square of probability minus label.
    brier_skill : float
        One minus its ratio to that of the base rate of the training applications.
    log_loss : float
        Mean negative logarithm of the probability of the label.
    calibration_slope : float
        Of a logistic regression of the label on the logit; 1: neither too bold nor too timid.
    calibration_error : float
        Expected calibration error over five equally full bins.
    chance_error : float
        That of true probabilities: what so few labels alone make of it, in the mean.
    correlation : float
        Matthews coefficient of what was decided.
    roc_area, precision_area : float
        Areas under the ROC and the precision-recall curve.
    roc_interval, precision_interval : (2,) floats
        95 % intervals of them by bootstrap over the applications.

    """

    brier: float
    brier_skill: float
    log_loss: float
    calibration_slope: float
    calibration_error: float
    chance_error: float
    correlation: float
    roc_area: float = math.nan
    precision_area: float = math.nan
    roc_interval: tuple[float, float] = (math.nan, math.nan)
    precision_interval: tuple[float, float] = (math.nan, math.nan)


def score(probability: FloatArray, heard: NDArray[np.bool_], base_rate: ArrayLike, *,
          decided: NDArray[np.bool_] | None = None, draws: Sequence[IndexArray] | None = None,
          seed: int = 0) -> Score:
    """
    Return the scores of probabilities.

    Parameters
    ----------
    probability : (n,) array
        Of an event.
    heard : (n,) array of bool
        Whether there was one.
    base_rate : float or (n,) array
        Of the training applications.
    decided : (n,) array of bool, optional
        Whether an event was said to come; at a probability of 0.5 or more where None.
    draws : sequence of arrays of int, optional
        Of `bootstrap_draws`; of applications one by one where None.
    seed : int
        Of the bootstrap.

    """
    if decided is None:
        decided = probability >= 0.5
    if draws is None:
        draws = bootstrap_draws(np.arange(heard.size), seed=seed)
    p, y = np.clip(probability, _LEAST, 1.0 - _LEAST), heard.astype(float)
    brier = float(np.mean((probability - y)**2))
    reference = float(np.mean((np.asarray(base_rate) - y)**2))
    return Score(
        brier, 1.0 - brier / reference if reference else math.nan,
        float(-np.mean(y * np.log(p) + (1.0 - y) * np.log1p(-p))),
        calibration_slope(probability, heard),
        calibration_error(probability, heard), chance_error(probability, seed=seed),
        matthews(decided, heard), **_areas(probability, heard, draws))


def calibration_error(probability: FloatArray, heard: NDArray[np.bool_]) -> float:
    """Return the expected calibration error over five equally full bins."""
    off = probability - heard
    return sum(abs(float(off[b].sum())) for b in _bins(probability)) / off.size


def chance_error(probability: FloatArray, *, seed: int = 0) -> float:
    """Return the mean calibration error that probabilities have which are the true ones."""
    labels = np.random.default_rng(seed).random((_RESAMPLES, probability.size)) < probability
    return float(np.mean([calibration_error(probability, one) for one in labels]))


def unbiased_error(probability: FloatArray, heard: NDArray[np.bool_]) -> float:
    """
    Return the root mean square calibration error, less its bias by the number of labels.

    The square of each bin's difference has the variance of its fraction heard in it, which is
    subtracted (C. A. T. Ferro and T. E. Fricker, Q. J. R. Meteorol. Soc. 138 (2012) 1954); zero
    where less than nothing is left.
    """
    total = 0.0
    for b in _bins(probability):
        rate = float(heard[b].mean())
        total += len(b) * ((float(probability[b].mean()) - rate)**2
                           - rate * (1.0 - rate) / max(1, len(b) - 1))
    return math.sqrt(max(0.0, total / heard.size))


def calibration_curve(probability: FloatArray, heard: NDArray[np.bool_]
                      ) -> list[tuple[float, float, int]]:
    """Return mean probability, fraction heard and number of each of five equally full bins."""
    return [(float(probability[b].mean()), float(heard[b].mean()), len(b))
            for b in _bins(probability)]


def _bins(probability: FloatArray) -> list[Any]:
    return [b for b in np.array_split(np.argsort(probability, kind='stable'), _BINS) if b.size]


def calibration_slope(probability: FloatArray, heard: NDArray[np.bool_]) -> float:
    """Return the slope of a logistic regression of labels on logits, by Newton's method."""
    p, y = np.clip(probability, _LEAST, 1.0 - _LEAST), heard.astype(float)
    logit = np.log(p / (1.0 - p))
    if y.min() == y.max() or np.ptp(logit) < 1e-9:
        return math.nan
    x = np.column_stack([np.ones_like(logit), logit])
    b = np.array([0.0, 1.0])
    for _ in range(50):
        p = 1.0 / (1.0 + np.exp(-np.clip(x @ b, -30.0, 30.0)))
        hessian = (x * (p * (1.0 - p))[:, None]).T @ x + 1e-9 * np.eye(2)
        step = np.linalg.solve(hessian, x.T @ (y - p))
        b += np.clip(step, -2.0, 2.0)
        if np.abs(step).max() < 1e-9:
            break
    return float(b[1])


def matthews(said: NDArray[np.bool_], heard: NDArray[np.bool_]) -> float:
    """Return the Matthews coefficient; NaN where one of both is always the same."""
    if said.all() or heard.all() or not said.any() or not heard.any():
        return math.nan
    return float(np.corrcoef(said, heard)[0, 1])


def braking_numbers(applications: Sequence[tuple[str | int, float, float]]) -> IndexArray:
    """
    Return numbers of brakings of the vehicle: one for all applications at overlapping times.

    Parameters
    ----------
    applications : sequence of tuples
        Recording, start and end [s] of each.

    """
    result = np.zeros(len(applications), dtype=np.intp)
    number, last, end = -1, None, -math.inf
    for i in sorted(range(len(applications)), key=lambda i: applications[i][:2]):
        recording, start, until = applications[i]
        if recording != last or start > end:
            number, last, end = number + 1, recording, until
        end = max(end, until)
        result[i] = number
    return result


def bootstrap_draws(clusters: IndexArray, *, count: int = _RESAMPLES,
                    seed: int = 0) -> list[IndexArray]:
    """
    Return applications drawn with replacement, those of one cluster together.

    Parameters
    ----------
    clusters : (n,) array of int
        Number of the cluster of each application, as of brakes that were applied at once.
    count, seed : int
        Of the draws.

    """
    members = np.split(np.argsort(clusters, kind='stable'),
                       np.flatnonzero(np.diff(np.sort(clusters))) + 1)
    rng = np.random.default_rng(seed)
    return [np.concatenate([members[i] for i in draw])
            for draw in rng.integers(0, len(members), (count, len(members)))]


def interval(values: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of values by resampling; NaN where most are not defined."""
    known = [value for value in values if not math.isnan(value)]
    if 2 * len(known) <= len(values):
        return math.nan, math.nan
    low, high = np.quantile(known, (0.025, 0.975)).tolist()
    return low, high


def roc_area(probability: FloatArray, heard: NDArray[np.bool_]) -> float:
    """Return the area under the ROC curve: the probability of the right order; ties count half."""
    from scipy.stats import rankdata
    events = int(heard.sum())
    above = float(rankdata(probability)[heard].sum()) - 0.5 * events * (events + 1)
    pairs = events * (heard.size - events)
    return above / pairs if pairs else math.nan


def average_precision(probability: FloatArray, heard: NDArray[np.bool_]) -> float:
    """Return the area under the precision-recall curve, in steps: precision at each event."""
    order = np.argsort(-probability, kind='stable')
    last = np.append(np.flatnonzero(np.diff(probability[order])), heard.size - 1)  # of ties
    events = np.cumsum(heard[order])[last]
    if not events[-1] or events[-1] == heard.size:
        return math.nan
    return float(np.sum(np.diff(events, prepend=0) * events / (last + 1.0)) / events[-1])


def _areas(probability: FloatArray, heard: NDArray[np.bool_],
           draws: Sequence[IndexArray]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for name, area in (('roc', roc_area), ('precision', average_precision)):
        result[f'{name}_area'] = area(probability, heard)
        result[f'{name}_interval'] = interval([area(probability[d], heard[d]) for d in draws])
    return result
