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

"""Scores of predicted squeal risks against measured squeal, beside two plain baselines."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from squeal_core.calibration.baselines import base_rate_of, lookup_table
from squeal_core.calibration.scores import (
    bootstrap_draws,
    braking_numbers,
    calibration_curve,
    interval,
    matthews,
    Score,
    score,
)
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.common.ranges import Ends
from squeal_core.common.wording import counted
from squeal_core.sound.brakings import Braking
from squeal_core.sound.matching import MatchedApplication

_FEW = 10  # events, or silent applications, below which intervals are wide
SCORES_NOT_KNOWN = 'scores: not known; '  # begins the note that says why
_LEAST = 4  # applications that two halves can be made of
_DECIDED = 0.5  # probability from which a baseline says that there is squeal
PREDICTION, BASE_RATE, TABLE = 'prediction', 'base rate', 'table'

_Labels = NDArray[np.bool_]


class ScoredApplications(NamedTuple):
    """Data of known applications for scores, (n,) and (n, 3) arrays."""

    risk: FloatArray
    alarm: _Labels
    measured: _Labels
    clusters: IndexArray  # of brakes that were applied at once
    conditions: FloatArray  # pressure, speed, temperature


@dataclass(frozen=True)
class PredictorScore:
    """
    Scores of one predictor; NaN where not defined.

    Parameters
    ----------
    score : Score
        Of its probabilities; the Matthews coefficient of its decisions.
    precision, recall : float
        Of its decisions.
    intervals : dict
        95 % intervals of precision, recall, correlation (Matthews) and brier by bootstrap over
        brakings.

    """

    score: Score
    precision: float
    recall: float
    intervals: Mapping[str, Ends]


@dataclass(frozen=True)
class PredictionScores:
    """
    Scores of the prediction and of the baselines.

    Parameters
    ----------
    measured, count : int
        Applications with measured squeal, and all that are scored.
    predictors : dict of PredictorScore
        'prediction', 'base rate' and 'table', the latter two learned on the other half each.
    curve : list of (3,) tuples
        Mean risk, fraction with squeal and number in each bin of the prediction.
    notes : list of str
        What they cannot say.

    """

    measured: int
    count: int
    predictors: dict[str, PredictorScore] = field(default_factory=dict)
    curve: list[tuple[float, float, int]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def as_json(self) -> dict[str, Any]:
        return {
            'measured': self.measured, 'applications': self.count,
            'predictors': {name: {**asdict(one.score), 'precision': one.precision,
                                  'recall': one.recall, 'intervals': dict(one.intervals)}
                           for name, one in self.predictors.items()},
            'calibration_curve': [list(one) for one in self.curve], 'notes': list(self.notes)}

    def lines(self) -> list[str]:
        """Return the scores as a table of text."""
        if not self.predictors:
            return list(self.notes)
        lines = [f'{"":11}{"Brier":>7}{"skill":>7}{"ECE":>7}{"precision (95 %)":>22}'
                 f'{"recall (95 %)":>22}{"Matthews (95 %)":>22}{"ROC area (95 %)":>22}'
                 f'{"PR area (95 %)":>22}']
        for name, one in self.predictors.items():
            own, ends = one.score, one.intervals
            lines.append(
                f'{name:11}{_number(own.brier, 7)}{_number(own.brier_skill, 7, 2)}'
                f'{_number(own.calibration_error, 7)}'
                + ''.join(f'{_number(value, 8)} {_span(span)}' for value, span in (
                    (one.precision, ends['precision']), (one.recall, ends['recall']),
                    (own.correlation, ends['correlation']), (own.roc_area, own.roc_interval),
                    (own.precision_area, own.precision_interval))))
        lines.append('calibration curve, predicted and measured (number): ' + ', '.join(
            f'{p:.2f} {y:.2f} ({n})' for p, y, n in self.curve))
        return lines + self.notes


def _number(value: float, width: int, digits: int = 3) -> str:
    return f'{"-":>{width}}' if math.isnan(value) else f'{value:{width}.{digits}f}'


def _span(ends: Ends) -> str:
    return f'{"":13}' if math.isnan(ends[0]) else f'({ends[0]:5.2f},{ends[1]:5.2f})'


def scored(applications: Sequence[MatchedApplication]) -> ScoredApplications:
    """Return the data for scores, of applications with known prediction and measurement."""
    known = [one for one in applications
             if one.outcome != 'not known' and not math.isnan(one.braking.risk)]
    return ScoredApplications(
        np.array([one.braking.risk for one in known], dtype=float),
        np.array([bool(one.braking.alarm) for one in known], dtype=bool),
        np.array([one.measured for one in known], dtype=bool),
        braking_numbers([(one.braking.recording, one.braking.start, one.braking.end)
                         for one in known]),
        _conditions([one.braking for one in known]))


def _conditions(brakings: Sequence[Braking]) -> FloatArray:
    """Return pressure, speed and temperature (friction where one is not known), (n, 3)."""
    own = [one.worst for one in brakings]
    result = np.array([(one.pressure_pa, abs(one.rotor_speed_rad_s), one.temperature_k)
                       for one in own], dtype=float).reshape(-1, 3)
    if np.isnan(result[:, 2]).any():
        result[:, 2] = [one.friction for one in own]
    return np.asarray(np.nan_to_num(result))


def score_predictions(known: ScoredApplications, *, seed: int = 0) -> PredictionScores:
    """
    Return the scores of predictions, beside base rate and table.

    Parameters
    ----------
    known : ScoredApplications
        By `scored`.
    seed : int
        Of the bootstrap.

    """
    count, measured = known.risk.size, int(known.measured.sum())
    if count < _LEAST or np.unique(known.clusters).size < _LEAST:
        return PredictionScores(measured, count, notes=[
            f'{SCORES_NOT_KNOWN}{counted(count, "brake application")} of known outcome, fewer '
            f'than {_LEAST} at different times'])
    halves = _halves(known)
    rate, table = np.zeros(count), np.zeros(count)
    for half in (False, True):
        train, test = halves != half, halves == half
        rate[test] = base_rate_of(known.measured[train])
        table[test] = lookup_table(known.conditions[train], known.measured[train],
                                   known.conditions[test])
    draws = bootstrap_draws(known.clusters, seed=seed)

    def score_of(probability: FloatArray, decided: _Labels) -> PredictorScore:
        return _score(probability, decided, known.measured, rate, draws)

    return PredictionScores(
        measured, count,
        {PREDICTION: score_of(known.risk, known.alarm),
         BASE_RATE: _without_order(score_of(rate, rate >= _DECIDED), score_of(
             np.full(count, 0.5), rate >= _DECIDED)), TABLE: score_of(table, table >= _DECIDED)},
        calibration_curve(known.risk, known.measured), _notes(count, measured))


def _without_order(one: PredictorScore, constant: PredictorScore) -> PredictorScore:
    """Return scores with the areas of a constant: two halves with two rates are no ranking."""
    areas = {name: getattr(constant.score, name) for name in (
        'roc_area', 'precision_area', 'roc_interval', 'precision_interval')}
    return replace(one, score=replace(one.score, **areas))


def _halves(known: ScoredApplications) -> _Labels:
    """Return the half (n,) of each application: brakings in turn, squealing and silent alike."""
    result = np.zeros(known.clusters.size, dtype=bool)
    turn = {True: False, False: False}
    for number in np.unique(known.clusters):
        own = known.clusters == number
        squeals = bool(known.measured[own].any())
        result[own] = turn[squeals]
        turn[squeals] = not turn[squeals]
    return result


def _score(probability: FloatArray, decided: _Labels, measured: _Labels, rate: FloatArray,
           draws: Sequence[IndexArray]) -> PredictorScore:
    statistics: dict[str, Callable[[Any], float]] = {
        'precision': lambda d: _share(measured[d], decided[d]),
        'recall': lambda d: _share(decided[d], measured[d]),
        'correlation': lambda d: matthews(decided[d], measured[d]),
        'brier': lambda d: float(np.mean((probability[d] - measured[d])**2))}
    whole = np.arange(measured.size)
    return PredictorScore(
        score(probability, measured, rate, decided=decided, draws=draws),
        statistics['precision'](whole), statistics['recall'](whole),
        {name: interval([of(draw) for draw in draws]) for name, of in statistics.items()})


def _share(values: _Labels, among: _Labels) -> float:
    """Return the fraction that is true among some; NaN of none."""
    return float(values[among].mean()) if among.any() else math.nan


def _notes(count: int, measured: int) -> list[str]:
    silent = count - measured
    notes = []
    if not measured or not silent:
        notes.append(f'areas under ROC and precision-recall, Matthews coefficient: not known, as '
                     f'all {count} applications {"squealed" if measured else "were silent"}')
    elif min(measured, silent) < _FEW:
        what = f'{measured} with measured squeal' if measured < _FEW else f'{silent} silent'
        notes.append(f'only {what} of {count} applications: read the intervals, which are wide; '
                     'the calibration curve says little')
    return notes
