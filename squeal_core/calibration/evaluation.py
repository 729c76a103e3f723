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

"""Evaluation of a calibration on observations that it has not seen."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from squeal_core.calibration import baselines, scores
from squeal_core.calibration.applications import BrakeApplication, inputs_of, Observation
from squeal_core.calibration.calibrate import Calibration
from squeal_core.calibration.candidates import BrakeCandidates
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.calibration.squeal_probability import SquealPredictor
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import prior_ensemble
from squeal_core.risk.risk_records import GrowthSource, RiskSettings

_LEAST = 4  # brakings of the vehicle, below which draws of them say nothing
_OF_TABLE = 3  # first columns of `inputs_of`: pressure, speed, temperature


@dataclass(frozen=True)
class Evaluation:
    """
    Scores on held-out observations.

    Parameters
    ----------
    heard, count : int
        Observations with squeal, and all.
    scores : dict
        `Score` of 'calibrated', 'prior', 'base rate', 'table' and 'logistic regression'.
    curve : list of (3,) tuples
        Mean probability, fraction heard and number in each bin of the calibrated ensemble.
    frequency_error : float
        Median relative error of the pitch of the most probable family; NaN without pitches.
    without : str
        What was not computed and why; empty: nothing.

    """

    heard: int
    count: int
    scores: dict[str, scores.Score]
    curve: list[tuple[float, float, int]]
    frequency_error: float
    without: str


def of_one(observations: Sequence[Observation]) -> list[Observation]:
    """Return the observations of one application each, which can be scored."""
    return [one for one in observations if len(one.applications) == 1]


def evaluate(result: Calibration, model: BrakeModel, emulator: GrowthSource,
             applications: Sequence[BrakeApplication], train: Sequence[Observation],
             test: Sequence[Observation], hearing: HearingModel,
             settings: RiskSettings | None = None) -> Evaluation:
    """
    Return the scores of a calibration beside those of its prior and of plain baselines.

    Parameters
    ----------
    result : Calibration
        By `train`.
    model, emulator, applications, hearing, settings
        As of `calibrate`.
    train, test : sequences of Observation
        Seen and held out; those of several brakes do not count here.

    """
    seen, unseen = of_one(train), of_one(test)
    known, new = ([applications[one.applications[0]] for one in some] for some in (seen, unseen))
    before, heard = (np.array([one.heard for one in some]) for some in (seen, unseen))
    predictor = SquealPredictor(model, emulator, new, settings=settings)
    after = predictor.evaluate(result.candidates)
    prior = predictor.evaluate(BrakeCandidates.of_ensemble(prior_ensemble(result.prior)))
    inputs, at = inputs_of([*known, *new]), len(known)
    rate = baselines.base_rate_of(before)
    probability = {
        'calibrated': hearing.heard(after.squeals.mean(axis=0)),
        'prior': hearing.heard(prior.squeals.mean(axis=0)),
        'base rate': np.full(len(new), rate),
        'table': baselines.lookup_table(inputs[:at, :_OF_TABLE], before, inputs[at:, :_OF_TABLE])}
    without = ''
    if baselines.has_sklearn():
        probability['logistic regression'] = baselines.logistic_regression(
            inputs[:at], before, inputs[at:])
    else:
        without = f'logistic regression: {baselines.EXTRA}'
    pitch = np.array([one.frequency_hz for one in unseen])
    likely = after.by_family.mean(axis=0).argmax(axis=-1)
    off = np.abs(pitch / after.frequency_hz[np.arange(len(new)), likely] - 1.0)[heard]
    off = off[np.isfinite(off)]
    numbers = scores.braking_numbers([(one.recording, one.time[0], one.time[-1]) for one in new])
    draws = scores.bootstrap_draws(numbers) if np.unique(numbers).size >= _LEAST else []
    return Evaluation(
        int(heard.sum()), heard.size,
        {name: scores.score(values, heard, rate, draws=draws)
         for name, values in probability.items()},
        scores.calibration_curve(probability['calibrated'], heard),
        float(np.median(off)) if off.size else math.nan, without)


def evaluation_lines(result: Evaluation) -> list[str]:
    """Return the scores as text."""
    lines = [f'held out: {result.count} applications, squeal in {result.heard}',
             f'{"":21}{"Brier":>7}{"skill":>7}{"log loss":>10}{"slope":>7}{"ECE":>7}'
             f'{"by chance":>11}{"MCC":>7}'
             f'{"ROC area (95 %)":>22}{"PR area (95 %)":>22}']
    for name, one in result.scores.items():
        areas = ''.join(f'{area:8.3f} ({low:.3f}, {high:.3f})' for area, (low, high) in (
            (one.roc_area, one.roc_interval), (one.precision_area, one.precision_interval)))
        lines.append(
            f'{name:21}{one.brier:7.3f}{one.brier_skill:7.2f}{one.log_loss:10.3f}'
            f'{one.calibration_slope:7.2f}{one.calibration_error:7.3f}'
            f'{one.chance_error:11.3f}{one.correlation:7.2f}{areas}')
    lines.append('calibration curve, predicted and heard (number): ' + ', '.join(
        f'{p:.2f} {y:.2f} ({n})' for p, y, n in result.curve))
    if math.isfinite(result.frequency_error):
        lines.append('pitch of the most probable modes: median error '
                     f'{result.frequency_error:.1%}')
    return lines + [f'not computed: {result.without}'] * bool(result.without)
