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

"""Probabilities of squeal in many candidate brakes, against routes of their own."""

import numpy as np
import pytest
from squeal_core.calibration.applications import BrakeApplication
from squeal_core.calibration.candidates import BrakeCandidates
from squeal_core.calibration.squeal_probability import SquealPredictor
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_records import EmulatedGrowth
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.squeal_risk import SquealRisk
from support.heard_brakes import brake_applications, listen, Stops
from support.linear_growth import LinearGrowth
from support.whole_applications import over_application

GROWTH = LinearGrowth([1655.0, 3210.0], [45.0, 95.0], [350.0, 620.0])
STOPS = Stops(friction=(0.38, 0.48), duration=(1.5, 3.5))


def test_probabilities_are_those_of_the_risk(kang: BrakeModel) -> None:
    """The predictor, many applications at once, against the risk of each tick by tick."""
    ensemble = prior_ensemble(EnsemblePrior(count=32))
    applications = brake_applications(np.random.default_rng(2), 6, STOPS)
    found = SquealPredictor(kang, GROWTH, applications).evaluate(
        BrakeCandidates.of_ensemble(ensemble))
    risk = SquealRisk(GROWTH, ensemble)
    for place, one in enumerate(applications):
        stiffness = [kang.contact_stiffness_at(p) for p in one.contact_pressure.tolist()]
        growth = risk.growth(one.rotor_speed, one.contact_pressure, one.friction, stiffness)
        whole = over_application(risk, [round(1e9 * t) + 10**9 for t in one.time], growth)
        own = ensemble.weights @ risk.exceedances(whole.peak)
        assert found.squeals[:, place].mean() == pytest.approx(own, abs=0.03)
    assert 0.1 < found.squeals.mean() < 0.9
    assert found.known.min() == 1.0


def test_probabilities_are_those_of_listening(kang: BrakeModel) -> None:
    """The same against a sum over random friction and damping."""
    rng = np.random.default_rng(3)
    applications = brake_applications(rng, 16, STOPS)
    values = np.array([0.1, 0.0, 0.01, 1.0, 5.0])
    brake = BrakeCandidates(*values[:, None], np.array([0.02]), np.array([0.15]))
    found = SquealPredictor(kang, GROWTH, applications).evaluate(brake).squeals[0]
    truth = listen(GROWTH, applications, values, rng, draws=256)
    # linear between nodes with 14 % between them, and damping linear in its logarithm
    assert np.abs(found - truth.probability).max() < 0.08
    assert np.abs(found - truth.probability).mean() < 0.03


def test_no_condition_is_evaluated_twice_in_a_row(kang: BrakeModel) -> None:
    """Ends of applications and padding repeat a knot; growth is the same, of all at once."""
    applications = brake_applications(np.random.default_rng(2), 6, STOPS)
    rows = []

    class Counted(LinearGrowth):

        def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
            rows.append(inputs[:, 0, :3])
            return super().evaluate(inputs)

    brakes = BrakeCandidates.of_ensemble(prior_ensemble(EnsemblePrior(count=8)))
    found = SquealPredictor(kang, Counted([1655.0], [45.0], [350.0]), applications).evaluate(
        brakes)
    knots = [one.knots(0.25)[0] for one in applications]
    assert len(rows) == 1
    assert len(rows[0]) == sum(np.unique(one).size for one in knots)
    assert len({one.size for one in knots}) > 1
    for place, one in enumerate(applications):
        alone = SquealPredictor(kang, LinearGrowth([1655.0], [45.0], [350.0]), [one])
        np.testing.assert_array_equal(alone.evaluate(brakes).squeals[:, 0],
                                      found.squeals[:, place])


def test_a_lone_tick_is_an_application(kang: BrakeModel) -> None:
    one = BrakeApplication('fl', 'a', np.zeros(1), np.full(1, 20.0), np.full(1, 1e6),
                           np.full(1, 0.9))
    found = SquealPredictor(kang, GROWTH, [one]).evaluate(
        BrakeCandidates.of_ensemble(prior_ensemble(EnsemblePrior(count=8))))
    assert found.squeals.shape == (8, 1)
    assert not one.is_observation
