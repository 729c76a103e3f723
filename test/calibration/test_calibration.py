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

"""Calibration on brakes whose squeal is known, its sampling, its probabilities and its scores."""

from dataclasses import replace
import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from squeal_core.calibration import baselines, scores
from squeal_core.calibration.applications import Observation
from squeal_core.calibration.calibrate import calibrate
from squeal_core.calibration.calibration_report import (
    factor_in_words,
    parameter_rows,
    ParameterRow,
    remarks,
)
from squeal_core.calibration.candidates import BrakeCandidates, PARAMETERS
from squeal_core.calibration.evaluation import evaluate
from squeal_core.calibration.hearing_model import HearingModel
from squeal_core.calibration.importance_sampling import sample_posterior
from squeal_core.calibration.likelihood import log_likelihood
from squeal_core.calibration.squeal_probability import SquealProbabilities
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import EnsemblePrior
from support.heard_brakes import brake_applications, listen, Stops, trial
from support.linear_growth import LinearGrowth
from support.rows import each

GROWTH = LinearGrowth([1655.0, 3210.0], [45.0, 95.0], [350.0, 620.0])
STOPS = Stops(friction=(0.38, 0.48), duration=(1.5, 3.5))


def test_a_gaussian_posterior_is_sampled() -> None:
    """A narrow ridge across three of seven parameters, and one parameter of its own."""
    across = np.zeros((2, 7))
    across[0, :3], across[1, 3] = (1.0, -1.0, 1.0), 1.0
    middle, width = np.array([2.0, 0.5]), np.array([0.1, 0.5])
    covariance = np.linalg.inv(np.eye(7) + (across.T / width**2) @ across)
    found = sample_posterior(lambda z: -0.5 * np.square((z @ across.T - middle) / width).sum(
        axis=1), 7, enough=400.0)
    assert found.effective_size > 400.0
    assert [one.power for one in found.rounds][-1] == 1.0
    np.testing.assert_allclose(found.mean, covariance @ (across.T / width**2) @ middle, atol=0.15)
    np.testing.assert_allclose(np.diag(found.covariance), np.diag(covariance), rtol=0.2)
    equal = found.resampled(64)
    np.testing.assert_allclose(equal.mean(axis=0), found.mean, atol=0.35)
    assert len(np.unique(equal[:, 0])) > 40
    assert np.linalg.norm(equal @ across[0] - middle[0]) / 8.0 < 0.15


def test_a_sample_goes_on_from_where_it_starts() -> None:
    """Though draws about a start are worth less than the few of the prior among them."""
    width = np.array([0.05, 0.05, 0.1, 0.1, 1.0, 1.0, 1.0])
    variance = 1.0 / (1.0 + 1.0 / width**2 / 9.0)  # of the posterior at a power of 1/9
    side = np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0])
    found = sample_posterior(
        lambda z: -0.5 * np.square((z - 0.5) / width).sum(axis=1), 7, least_variance=0.002,
        start=(0.5 * (1.0 - variance) + 0.5 * side * np.sqrt(variance), np.diag(variance)))
    assert found.rounds[0].power > 0.2
    assert len(found.rounds) <= 4
    np.testing.assert_allclose(found.mean[:4], 0.5 / (1.0 + width[:4]**2), atol=0.03)


def test_brakes_of_one_stop_make_no_interval_narrower(kang: BrakeModel) -> None:
    """Four brakes that were applied together and are alike say what one of them says."""
    brake = BrakeCandidates(*np.zeros((5, 1)), np.array([0.02]), np.array([0.15]))
    found = cast(Any, SimpleNamespace(candidates=brake, prior=EnsemblePrior(count=8)))
    single = [replace(one, time=one.time + 100.0 * place) for place, one in enumerate(
        brake_applications(np.random.default_rng(6), 24, STOPS))]
    intervals = []
    for brakes in (1, 4):
        applications = [one for one in single for _ in range(brakes)]
        train, test = ([Observation((i,), i // brakes % 3 == 0) for i in range(*ends)]
                       for ends in ((0, 12 * brakes), (12 * brakes, 24 * brakes)))
        own = evaluate(found, kang, GROWTH, applications, train, test,
                       HearingModel()).scores['calibrated']
        intervals.append((*own.roc_interval, *own.precision_interval))
    assert intervals[1] == pytest.approx(intervals[0])
    assert intervals[0][1] - intervals[0][0] > 0.2


def test_calibration_beats_what_knows_no_physics(kang: BrakeModel) -> None:
    trials = [trial(kang, GROWTH, GROWTH, seed, train=50, test=50, stops=STOPS)
              for seed in range(3)]
    mean = {name: np.mean([one.brier[name] for one in trials]) for name in trials[0].brier}
    assert mean['calibrated'] < mean['truth'] + 0.01
    assert mean['calibrated'] < min(mean['base rate'], mean['table']) - 0.01
    if baselines.has_sklearn():
        assert mean['calibrated'] < mean['logistic']
    assert min(one.effective_size for one in trials) > 150.0
    together = scores.score(np.concatenate([one.probability for one in trials]),
                            np.concatenate([one.heard for one in trials]), 0.5)
    assert 0.7 < together.calibration_slope < 1.4  # of 150 applications
    assert together.calibration_error < 0.08  # true probabilities: 0.06


def test_few_events_leave_the_prior(kang: BrakeModel) -> None:
    applications = brake_applications(np.random.default_rng(4), 6, STOPS)
    observations = [Observation((i,), i < 2, 1655.0 if i < 2 else math.nan) for i in range(6)]
    found = calibrate(kang, GROWTH, applications, observations)
    assert found.power == pytest.approx(math.sqrt(0.2))
    assert max(row.shrinkage for row in parameter_rows(found)) < 0.15
    assert remarks(found)[0].startswith('2 events, fewer than 10')
    assert found.ensemble('by 2 events').likelihood_power == found.power
    silent = calibrate(kang, GROWTH, applications, [Observation((i,), False) for i in range(6)])
    np.testing.assert_allclose(silent.sample.mean, 0.0, atol=0.12)
    assert silent.ensemble('by no event').calibrated == ''
    assert remarks(silent) == ['no event was fitted: the ensemble is the prior, not calibrated; '
                               'record squeal']
    with pytest.raises(SquealError, match='no brake application was observed'):
        calibrate(kang, GROWTH, applications, [])


@each(('name', 'mean', 'words'), [
    ('ln_damping', -0.082, '  8 % less damping'),
    ('ln_contact_stiffness', 0.3, '  35 % more contact stiffness'),
    ('ln_contact_stiffness', -0.004, ''), ('friction_bias', 0.3, '')])
def test_logarithms_of_factors_are_told_in_percent(name: str, mean: float, words: str) -> None:
    assert factor_in_words(ParameterRow(name, 0.0, 0.3, mean, 0.2, 0.3)) == words


def test_damping_is_learnt_and_the_ridge_told(kang: BrakeModel) -> None:
    """A brake with 40 % more damping: damping over friction rises, each alone hardly."""
    rng = np.random.default_rng(5)
    applications = brake_applications(rng, 60, Stops(friction=(0.38, 0.56)))
    truth = listen(GROWTH, applications, np.array([0.35, 0.0, 0.0, 1.0, 5.5]), rng, draws=8)
    observations = [Observation((i,), bool(truth.squealed[i]), float(truth.frequency_hz[i])
                                if truth.squealed[i] else math.nan) for i in range(60)]
    found = calibrate(kang, GROWTH, applications, observations)
    ratio = np.exp(found.candidates.ln_damping) * 45.0 / 350.0 - found.candidates.friction_bias
    assert ratio.mean() == pytest.approx(math.exp(0.35) * 45.0 / 350.0, abs=0.02)
    text = ' '.join(remarks(found))
    assert 'lie on a ridge' in text
    assert 'ln damping and friction bias +' in text
    assert 'not identified alone, as wide as before: ln contact stiffness' in text
    assert [row.name for row in parameter_rows(found)] == list(PARAMETERS)


def test_many_observations_begin_at_the_posterior_of_a_few(
        kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """The same posterior, in fewer rounds of all observations."""
    rng = np.random.default_rng(5)
    applications = brake_applications(rng, 96, STOPS)
    truth = listen(GROWTH, applications, np.array([0.2, 0.0, 0.0, 1.0, 5.5]), rng, draws=8)
    observations = [Observation((i,), bool(truth.squealed[i])) for i in range(96)]
    whole = calibrate(kang, GROWTH, applications, observations).sample
    monkeypatch.setattr('squeal_core.calibration.calibrate._FIRST', 32)
    found = calibrate(kang, GROWTH, applications, observations).sample
    assert len(found.rounds) < len(whole.rounds)
    assert found.rounds[-1].power == 1.0
    np.testing.assert_allclose(found.mean, whole.mean, atol=0.25)
    np.testing.assert_allclose(np.diag(found.covariance), np.diag(whole.covariance), rtol=0.5)


def test_the_best_known_is_called_what_it_is(kang: BrakeModel) -> None:
    applications = brake_applications(np.random.default_rng(4), 2, STOPS)
    found = calibrate(kang, GROWTH, applications, [Observation((i,), False) for i in range(2)])
    rounds = (replace(found.sample.rounds[-1], power=1.0),)

    def told(*narrow: str) -> str:
        widths = np.array([0.2 if name in narrow else 1.0 for name in PARAMETERS])
        sample = replace(found.sample, values=found.sample.values * widths, rounds=rounds)
        return ' '.join(remarks(replace(found, sample=sample, heard=12, power=1.0)))

    assert 'known best: effective damping = +1.00 ln damping (' in told('ln_damping')
    assert 'known best: +1.00 slope scale (' in told('slope_scale')
    assert told() == 'no combination of the parameters is known better than before'


def test_likelihood_of_hits_misses_and_pitches() -> None:
    hearing = HearingModel(detection=0.9, false_alarm=0.1, label_error=0.05)
    squeals = np.array([[0.0, 1.0]])
    found = SquealProbabilities(squeals, np.stack([squeals, 0.0 * squeals], axis=-1),
                                np.array([[1600.0, 3000.0]] * 2), np.ones(1))
    heard = 0.05 + 0.9 * np.array([0.1, 0.9])

    def likelihood(*observations: Observation) -> float:
        return math.exp(log_likelihood(found, observations, hearing)[0])

    assert likelihood(Observation((0,), True)) == pytest.approx(heard[0])
    assert likelihood(Observation((1,), False)) == pytest.approx(1.0 - heard[1])
    assert likelihood(Observation((0, 1), True)) == pytest.approx(
        1.0 - (1.0 - heard[0]) * (1.0 - heard[1]))
    right, wrong = (likelihood(Observation((1,), True, hz)) for hz in (1610.0, 3000.0))
    assert right > 20.0 * wrong
    # noted right (0.9), detected (0.9) and of the family (mean 0.69): at its pitch; else anywhere
    uniform, peak = 1.0 / math.log(16_000.0 / 1250.0), 1.0 / (0.03 * math.sqrt(2.0 * math.pi))
    own = 0.9 * 0.9 * 0.69
    assert likelihood(Observation((1,), True, 1600.0)) == pytest.approx(
        own * peak + (heard[1] - own) * uniform)
    both = found._replace(by_family=np.stack([squeals, squeals], axis=-1))
    assert math.exp(log_likelihood(both, [Observation((1,), True, 1610.0)], hearing)[0]
                    ) == pytest.approx(right)  # another family's squeal is no doubt of this one
    grid = np.exp(np.linspace(math.log(1250.0), math.log(16_000.0), 20_001))
    total = sum(likelihood(Observation((1,), True, hz)) for hz in grid[::10]) * 10 * math.log(
        grid[1] / grid[0])
    assert total == pytest.approx(heard[1], rel=0.02)  # a density over ln frequency
    with pytest.raises(SquealError, match='detection is 0.4'):
        HearingModel(detection=0.4)


def test_scores() -> None:
    rng = np.random.default_rng(1)
    p = rng.random(4000)
    heard = rng.random(4000) < p
    found = scores.score(p, heard, 0.5)
    assert found.brier == pytest.approx(1.0 / 6.0, abs=0.01)
    assert found.brier_skill == pytest.approx(1.0 / 3.0, abs=0.03)
    assert found.calibration_slope == pytest.approx(1.0, abs=0.1)
    assert found.calibration_error < 0.03
    assert scores.unbiased_error(p, heard) < 0.02
    assert found.chance_error == pytest.approx(  # five bins of 800, half normal
        math.sqrt(2.0 / math.pi / 6.0 / 800.0), rel=0.1)
    bold = p**2 / (p**2 + (1.0 - p)**2)  # twice the logit
    assert scores.score(bold, heard, 0.5).calibration_slope == pytest.approx(0.5, abs=0.06)
    off = [(a - b)**2 for a, b, _ in scores.calibration_curve(bold, heard)]
    assert scores.unbiased_error(bold, heard) == pytest.approx(np.sqrt(np.mean(off)), rel=0.1)
    flat = scores.score(np.full(9, 0.5), np.zeros(9, bool), 0.5)
    assert math.isnan(flat.calibration_slope)
    assert math.isnan(flat.correlation)
    inputs = rng.random((4000, 3))
    wet = rng.random(4000) < inputs[:, 0]
    table = baselines.lookup_table(inputs[:2000], wet[:2000], inputs[2000:])
    assert scores.score(table, wet[2000:], 0.5).brier < 0.19


def test_scores_by_scikit_learn() -> None:
    pytest.importorskip('sklearn', reason='needs scikit-learn')
    rng = np.random.default_rng(0)
    x = rng.standard_normal((400, 2))
    heard = rng.random(400) < 1.0 / (1.0 + np.exp(-3.0 * x[:, 0]))
    found = scores.score(baselines.logistic_regression(x[:200], heard[:200], x[200:]), heard[200:],
                         0.5)
    assert found.roc_area > 0.85
    assert found.roc_interval[0] < found.roc_area < found.roc_interval[1]
    assert found.precision_interval[0] < found.precision_area < found.precision_interval[1]


def test_areas_without_scikit_learn() -> None:
    found = scores.score(np.array([0.2, 0.8, 0.6]), np.array([False, True, True]), 0.5)
    assert (found.roc_area, found.precision_area) == (1.0, 1.0)
    assert found.brier == pytest.approx(0.08)


def test_applications_within_a_longer_one_are_of_its_braking() -> None:
    """Also one that begins after another one within it has ended."""
    rows = [('a', 0.0, 10.0), ('a', 1.0, 2.0), ('a', 3.0, 4.0), ('a', 11.0, 12.0),
            ('b', 11.5, 12.0)]
    assert scores.braking_numbers(rows).tolist() == [0, 0, 0, 1, 2]
    assert scores.braking_numbers(rows[::-1]).tolist() == [2, 1, 0, 0, 0]
