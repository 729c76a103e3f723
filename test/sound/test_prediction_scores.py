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

"""Scores of predictions against closed forms, scikit-learn and simulated halves."""

import math
from typing import Any

import numpy as np
import pytest
from squeal_core.sound.prediction_scores import score_predictions, ScoredApplications


def known(risk: Any, measured: Any, alarm: Any = None, clusters: Any = None) -> ScoredApplications:
    p, y = np.array(risk, dtype=float), np.array(measured, dtype=bool)
    conditions = np.random.default_rng(0).uniform(size=(p.size, 3))
    return ScoredApplications(p, p >= 0.5 if alarm is None else np.array(alarm), y,
                              np.arange(p.size) if clusters is None else np.array(clusters),
                              conditions)


def test_scores_against_closed_forms() -> None:
    """Count four hits, one miss, two false alarms and three silences."""
    risk = [0.9, 0.8, 0.7, 0.6, 0.2, 0.9, 0.5, 0.1, 0.1, 0.2]
    found = score_predictions(known(risk, [1, 1, 1, 1, 1, 0, 0, 0, 0, 0]))
    own = found.predictors['prediction']
    assert (own.precision, own.recall) == (pytest.approx(4 / 6), pytest.approx(4 / 5))
    assert own.score.correlation == pytest.approx(
        (4 * 3 - 2 * 1) / math.sqrt(6 * 5 * 5 * 4))
    y = np.array([1] * 5 + [0] * 5)
    assert own.score.brier == pytest.approx(np.mean((np.array(risk) - y)**2))
    # ranks: pairs of a squealing and a silent application in the right order, ties by half
    pairs = [(p > q) + 0.5 * (p == q) for p in risk[:5] for q in risk[5:]]
    assert own.score.roc_area == pytest.approx(np.mean(pairs))
    base = found.predictors['base rate'].score
    assert (base.roc_area, base.precision_area) == (0.5, pytest.approx(0.5))
    assert base.brier_skill == 0.0
    assert any('only 5 with measured squeal of 10 applications' in one for one in found.notes)


def test_scores_are_those_of_scikit_learn() -> None:
    metrics = pytest.importorskip('sklearn.metrics')
    rng = np.random.default_rng(3)
    risk = rng.uniform(size=300).round(2)
    squeal = rng.uniform(size=300) < risk
    own = score_predictions(known(risk, squeal)).predictors['prediction']
    said = risk >= 0.5
    for value, other in (
            (own.precision, metrics.precision_score(squeal, said)),
            (own.recall, metrics.recall_score(squeal, said)),
            (own.score.correlation, metrics.matthews_corrcoef(squeal, said)),
            (own.score.roc_area, metrics.roc_auc_score(squeal, risk)),
            (own.score.precision_area, metrics.average_precision_score(squeal, risk)),
            (own.score.brier, metrics.brier_score_loss(squeal, risk)),
            (own.score.log_loss, metrics.log_loss(squeal, np.clip(risk, 1e-3, 1.0 - 1e-3)))):
        assert value == pytest.approx(other)
    assert own.score.calibration_error < 0.08
    assert own.score.brier_skill > 0.1
    for name, value in (('precision', own.precision), ('recall', own.recall)):
        low, high = own.intervals[name]
        width = 2.0 * 1.96 * math.sqrt(value * (1.0 - value) / 150.0)
        assert low < value < high
        assert high - low == pytest.approx(width, rel=0.35)


def test_brakes_applied_at_once_count_as_one_in_intervals() -> None:
    """Of four equal copies of each, the interval is that of one, not half as wide."""
    rng = np.random.default_rng(5)
    risk = rng.uniform(size=60)
    squeal = rng.uniform(size=60) < risk

    def width(copies: int, clusters: Any) -> float:
        found = score_predictions(known(np.repeat(risk, copies), np.repeat(squeal, copies),
                                        clusters=clusters)).predictors['prediction']
        return found.intervals['recall'][1] - found.intervals['recall'][0]

    one = width(1, None)
    assert width(4, np.repeat(np.arange(60), 4)) == pytest.approx(one, rel=0.25)
    assert width(4, None) < 0.65 * one


def test_halves_that_learn_from_each_other() -> None:
    """A table finds squeal that hangs on the pressure; no risk of its own half leaks in."""
    rng = np.random.default_rng(7)
    conditions = rng.uniform(size=(240, 3))
    squeal = conditions[:, 0] > 2.0 / 3.0
    some = known(np.full(240, 0.3), squeal)._replace(conditions=conditions)
    found = score_predictions(some).predictors
    assert found['table'].score.brier_skill > 0.65
    assert found['base rate'].score.brier_skill == 0.0
    # labels at random: what a table saw of its own half would look like skill
    shuffled = score_predictions(some._replace(measured=rng.permutation(squeal))).predictors
    assert shuffled['table'].score.brier_skill < 0.05


def test_one_class_and_too_few() -> None:
    silent = score_predictions(known([0.1, 0.2, 0.3, 0.4, 0.6], [0] * 5))
    own = silent.predictors['prediction']
    assert math.isnan(own.score.roc_area)
    assert math.isnan(own.score.correlation)
    assert own.precision == 0.0
    assert any('not known, as all 5 applications were silent' in one for one in silent.notes)
    few = score_predictions(known([0.1, 0.9, 0.3], [0, 1, 0]))
    assert not few.predictors
    assert few.lines()[0].startswith('scores: not known; 3 brake applications')
    at_once = score_predictions(known([0.1] * 8, [0] * 8, clusters=[0] * 8))
    assert not at_once.predictors
