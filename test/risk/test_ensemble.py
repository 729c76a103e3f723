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

"""Ensemble of brakes: its moments, its bits, what it feeds to an emulator, what it refuses."""

from dataclasses import fields, replace

import numpy as np
import pytest
from squeal_core.common.errors import SquealError
from squeal_core.risk.ensemble import Ensemble, EnsemblePrior, prior_ensemble

PRIOR = EnsemblePrior()
MOMENTS = {'ln_damping': (0.0, 0.3), 'ln_contact_stiffness': (0.0, 0.1),
           'friction_bias': (0.0, 0.03), 'slope_scale': (1.0, 0.3),
           'audible_build_up': (5.5, 2.0)}


@pytest.mark.parametrize('count', [64, 1024])
@pytest.mark.parametrize('seed', [0, 1, 2, 18])
def test_members_have_the_moments_of_the_prior(count: int, seed: int) -> None:
    ensemble = prior_ensemble(EnsemblePrior(count=count, seed=seed))
    columns = []
    for name, (mean, deviation) in MOMENTS.items():
        values = getattr(ensemble, name)
        assert abs(values.mean() - mean) < 4.0 / count * deviation
        assert values.std() == pytest.approx(deviation, rel=0.08 if count == 64 else 0.02)
        columns.append(values)
    assert np.abs(np.corrcoef(columns) - np.eye(5)).max() < (
        0.02 if (count, seed) == (PRIOR.count, PRIOR.seed) else 0.25 if count == 64 else 0.05)
    assert np.array_equal(ensemble.weights, np.full(count, 1.0 / count))
    assert ensemble.calibrated == ''


def test_members_are_the_same_to_the_bit_for_the_same_prior_only() -> None:
    first, second, other = (prior_ensemble(replace(PRIOR, seed=seed)) for seed in (0, 0, 1))
    for item in fields(Ensemble):
        ours, theirs = getattr(first, item.name), getattr(second, item.name)
        assert np.asarray(ours).tobytes() == np.asarray(theirs).tobytes()
    assert not np.array_equal(first.ln_damping, other.ln_damping)


def test_members_stay_where_emulators_are() -> None:
    wide = prior_ensemble(EnsemblePrior(slope=5.0, audible_build_up_deviation=50.0, count=4096))
    assert wide.slope_scale.min() == 0.0
    assert wide.slope_scale.max() == 2.0
    assert wide.audible_build_up.min() == 1.0
    assert np.abs(wide.ln_damping).max() <= 3.0 * 0.3 + 1e-12


def test_inputs_are_the_measured_ones_and_the_members_own() -> None:
    ensemble = prior_ensemble(PRIOR)
    one = ensemble.inputs(-20.0, 5e5, 0.4)
    assert one.shape == (64, 6)
    assert np.array_equal(one, np.column_stack([
        np.full(64, np.log(20.0)), np.full(64, np.log(5e5)), 0.4 + ensemble.friction_bias,
        ensemble.ln_contact_stiffness, ensemble.ln_damping, ensemble.slope_scale]))
    many = ensemble.inputs([3.0, -20.0], 5e5, [[0.3, 0.4], [0.3, 0.3]])
    assert many.shape == (2, 2, 64, 6)
    assert np.array_equal(many[0, 1], one)
    assert ensemble.inputs(0.0, 0.0, 0.4)[0, 0] == -np.inf


@pytest.mark.parametrize(('changes', 'words'), [
    ({'damping': -0.1}, 'damping is -0.1; give zero'), ({'slope': np.nan}, 'slope is nan'),
    ({'count': 48}, 'count is 48; give a power of 2'), ({'count': 0}, 'count is 0')])
def test_priors_that_make_no_sense_are_refused(changes: dict[str, float], words: str) -> None:
    with pytest.raises(SquealError, match=words):
        replace(PRIOR, **changes)  # type: ignore[arg-type]


@pytest.mark.parametrize(('changes', 'words'), [
    ({'weights': np.zeros(64)}, 'sum 0'), ({'weights': -np.ones(64)}, 'from -1'),
    ({'ln_damping': np.zeros(63)}, r'ln_damping: shape \(63,\)'),
    ({'friction_bias': np.full(64, np.nan)}, 'friction_bias'), ({'weights': 1.0}, 'shape')])
def test_ensembles_that_make_no_sense_are_refused(changes: dict[str, object],
                                                  words: str) -> None:
    with pytest.raises(SquealError, match=words):
        replace(prior_ensemble(PRIOR), **changes)  # type: ignore[arg-type]


def test_weights_become_probabilities() -> None:
    weights = np.arange(64.0)
    ensemble = replace(prior_ensemble(PRIOR), weights=weights, calibrated='by hand')
    np.testing.assert_allclose(ensemble.weights, weights / weights.sum(), rtol=1e-15)
    assert ensemble.count == 64
