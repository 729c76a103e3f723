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

"""Scores of squeal probabilities on applications that were held out, beside plain baselines."""

from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError

_LEAST = 1e-3  # probabilities are this far from 0 and 1 at least where a logarithm is taken
_BINS = 5  # of a calibration curve, equally full
_RESAMPLES = 200  # of the bootstrap
_TERCILES = (1.0 / 3.0, 2.0 / 3.0)
EXTRA = "needs scikit-learn: pip install -e '.[calibration]' in the checkout"


@dataclass(frozen=True)
class Score:
    """
    Scores of probabilities against what was heard; NaN where not defined or not computed.

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
    correlation : float
        Matthews coefficient at a probability of 0.5.
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
    correlation: float
    roc_area: float = math.nan
    precision_area: float = math.nan
    roc_interval: tuple[float, float] = (math.nan, math.nan)
    precision_interval: tuple[float, float] = (math.nan, math.nan)


def has_sklearn() -> bool:
    """Tell whether scikit-learn is there."""
    from importlib.util import find_spec
    return find_spec('sklearn') is not None


def score(probability: FloatArray, heard: NDArray[np.bool_], base_rate: float, *,
          seed: int = 0) -> Score:
    """
    Return the scores of probabilities.

    Parameters
    ----------
    probability : (n,) array
        Of an event.
    heard : (n,) array of bool
        Whether there was one.
    base_rate : float
        Of the training applications.
    seed : int
        Of the bootstrap.

    """
    p, y = np.clip(probability, _LEAST, 1.0 - _LEAST), heard.astype(float)
    brier = float(np.mean((probability - y)**2))
    reference = float(np.mean((base_rate - y)**2))
    areas = _areas(probability, heard, seed) if has_sklearn() and 0 < heard.sum() < y.size else {}
    return Score(
        brier, 1.0 - brier / reference if reference else math.nan,
        float(-np.mean(y * np.log(p) + (1.0 - y) * np.log1p(-p))),
        _slope(np.log(p / (1.0 - p)), y),
        sum(len(b) * abs(float((probability[b] - y[b]).mean()))
            for b in _bins(probability)) / y.size, _matthews(probability >= 0.5, heard), **areas)


def calibration_curve(probability: FloatArray, heard: NDArray[np.bool_]
                      ) -> list[tuple[float, float, int]]:
    """Return mean probability, fraction heard and number of each of five equally full bins."""
    return [(float(probability[b].mean()), float(heard[b].mean()), len(b))
            for b in _bins(probability)]


def _bins(probability: FloatArray) -> list[Any]:
    return [b for b in np.array_split(np.argsort(probability, kind='stable'), _BINS) if b.size]


def _slope(logit: FloatArray, y: FloatArray) -> float:
    """Return the slope of a logistic regression on one variable, by Newton's method."""
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


def _matthews(said: NDArray[np.bool_], heard: NDArray[np.bool_]) -> float:
    if said.all() or heard.all() or not said.any() or not heard.any():
        return math.nan
    return float(np.corrcoef(said, heard)[0, 1])


def _areas(probability: FloatArray, heard: NDArray[np.bool_], seed: int) -> dict[str, Any]:
    from sklearn.metrics import average_precision_score, roc_auc_score
    rng = np.random.default_rng(seed)
    found: dict[str, Any] = {}
    draws = [d for d in rng.integers(0, heard.size, (_RESAMPLES, heard.size))
             if 0 < heard[d].sum() < heard.size]
    for name, area in (('roc', roc_auc_score), ('precision', average_precision_score)):
        found[f'{name}_area'] = float(area(heard, probability))
        ends = np.quantile([area(heard[d], probability[d]) for d in draws], (0.025, 0.975))
        found[f'{name}_interval'] = tuple(ends.tolist())
    return found


def base_rate_of(heard: NDArray[np.bool_]) -> float:
    """Return the fraction heard, by the rule of succession: never 0 or 1."""
    return float((heard.sum() + 1.0) / (heard.size + 2.0))


def lookup_table(train: FloatArray, heard: NDArray[np.bool_], test: FloatArray) -> FloatArray:
    """
    Return probabilities by a table over the inputs: fractions heard in thirds of each.

    Parameters
    ----------
    train, test : (n, 3) and (m, 3) arrays
        Pressure, speed, temperature (or friction where there is none) of applications.
    heard : (n,) array of bool
        Of the training applications. Cells are drawn to the base rate by two applications.

    """
    edges = np.quantile(train, _TERCILES, axis=0)

    def cell(values: FloatArray) -> Any:
        return (values[:, None, :] > edges).sum(axis=1) @ 3**np.arange(values.shape[1])

    rate, cells = base_rate_of(heard), 3**train.shape[1]
    counts = np.bincount(cell(train), minlength=cells)
    sums = np.bincount(cell(train), heard, minlength=cells)
    return np.asarray(((sums + 2.0 * rate) / (counts + 2.0))[cell(test)])


def logistic_regression(train: FloatArray, heard: NDArray[np.bool_],
                        test: FloatArray) -> FloatArray:
    """
    Return probabilities by a logistic regression on standardised inputs (scikit-learn).

    Parameters
    ----------
    train, test : (n, k) and (m, k) arrays
        Inputs of applications.
    heard : (n,) array of bool
        Of the training applications.

    """
    try:
        from sklearn.linear_model import LogisticRegression
    except ImportError:
        raise SquealError(f'the logistic regression {EXTRA}') from None
    if heard.all() or not heard.any():
        return np.full(len(test), base_rate_of(heard))
    mean, scale = train.mean(axis=0), np.maximum(train.std(axis=0), 1e-9)
    fitted = LogisticRegression(max_iter=1000).fit((train - mean) / scale, heard)
    return np.asarray(fitted.predict_proba((test - mean) / scale)[:, 1])
