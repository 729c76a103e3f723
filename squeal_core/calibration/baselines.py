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

"""Baselines for a physical prediction: base rate, table, logistic regression."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError

EXTRA = "needs scikit-learn: pip install -e '.[calibration]' in the checkout"
_TERCILES = (1.0 / 3.0, 2.0 / 3.0)


def has_sklearn() -> bool:
    """Return whether scikit-learn is there."""
    from importlib.util import find_spec
    return find_spec('sklearn') is not None


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
