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

"""Risks of sliding brakes: from the map, to first order, certain."""

from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.risk.evaluator import RiskEvaluator
from squeal_core.risk.first_order import first_order_probabilities
from squeal_core.risk.operating_map import MapError, OperatingMap
from squeal_core.risk.probability import Risk
from squeal_core.risk.uncertainty import InputUncertainty, RiskParameters
from squeal_core.stability.eigensolution import complex_modes

NONE = InputUncertainty(friction=0.0, pressure=0.0, rotor_speed=0.0, contact_stiffness=0.0)
USUAL = InputUncertainty(friction=0.02, pressure=0.03, rotor_speed=0.01, contact_stiffness=0.1)
PARAMETERS = RiskParameters(band_hz=(1250.0, 16000.0), growth_threshold=0.01, uncertainty=USUAL)
AT = SlidingConditions(rotor_speed=12.0, pressure=2e6, friction=0.4)
# one mode at 2 kHz that a falling friction excites, in proportion to pressure
ONE = BrakeModel(
    angular_frequencies=np.array([4e3 * np.pi]), damping_ratios=0.002, caliper=Caliper(2.5e-3),
    negative_slope=np.array([[1.2e-3]]), friction_law=FrictionLaw())


def ones_map(parameters: RiskParameters = PARAMETERS) -> OperatingMap:
    """Return a map whose risk is the friction."""
    friction = np.linspace(0.1, 0.5, 5)
    score = np.broadcast_to(ndtri(friction), (2, 2, 5)).astype(np.float32)
    return OperatingMap(parameters, np.array([1.0, 100.0]), np.array([1e4, 1e7]), friction,
                        score, score, MapError(4, 0.01, 0.005))


def assess(evaluator: RiskEvaluator, at: SlidingConditions, model: BrakeModel = ONE) -> Risk:
    modes = complex_modes(model, model.operating_point(**vars(at)))
    return evaluator.assess([at], [modes])[0]


def test_risk_of_the_map_and_modes_to_first_order() -> None:
    evaluator = RiskEvaluator(ONE, PARAMETERS, ones_map())
    found = assess(evaluator, AT)
    assert (found.basis, found.error, evaluator.remedy) == ('precomputed', 0.01, '')
    assert found.probability == pytest.approx(0.4)
    assert [mode.index for mode in found.modes] == [1]
    assert found.modes[0].frequency_hz == pytest.approx(2000.0, rel=1e-3)
    backwards = assess(evaluator, replace(AT, rotor_speed=-12.0))
    assert backwards.probability == found.probability
    assert (evaluator.precomputed, evaluator.first_order) == (2, 0)


def test_several_conditions_at_once() -> None:
    evaluator = RiskEvaluator(ONE, PARAMETERS, ones_map())
    conditions = [replace(AT, friction=mu) for mu in (0.15, 0.6, 0.3)]  # one is outside
    modes = [complex_modes(ONE, ONE.operating_point(**vars(at))) for at in conditions]
    found = evaluator.assess(conditions, modes)
    assert [risk.basis for risk in found] == ['precomputed', 'first order', 'precomputed']
    assert [risk == assess(evaluator, at) for risk, at in zip(found, conditions, strict=True)
            ] == [True] * 3
    assert evaluator.assess([], []) == []


@pytest.mark.parametrize('changes', [
    {'band_hz': (2000.0, 3000.0)}, {'growth_threshold': 1.0},
    {'uncertainty': replace(USUAL, pressure=0.05)}])
def test_other_parameters_than_the_maps_are_first_order(changes: dict[str, Any]) -> None:
    evaluator = RiskEvaluator(ONE, replace(PARAMETERS, **changes), ones_map())
    found = assess(evaluator, AT)
    assert found.basis == 'first order'
    assert math.isnan(found.error)
    assert 'squeal tabulate --config' in evaluator.remedy


def test_without_a_map_first_order_with_a_remedy() -> None:
    evaluator = RiskEvaluator(ONE, PARAMETERS)
    assert assess(evaluator, AT).basis == 'first order'
    assert 'no operating map' in evaluator.remedy
    assert RiskEvaluator(ONE, replace(PARAMETERS, uncertainty=NONE)).remedy == ''


def test_own_contact_stiffness_is_first_order() -> None:
    evaluator = RiskEvaluator(ONE, PARAMETERS, ones_map())
    assert assess(evaluator, replace(AT, contact_stiffness=1e10)).basis == 'first order'


@pytest.mark.parametrize('threshold', [-20.0, 0.0, 5.0, 20.0])
def test_first_order_is_exact_where_growth_is_linear(threshold: float) -> None:
    """A growth rate in proportion to pressure, the only uncertain input."""
    uncertainty = replace(NONE, pressure=0.05)
    mode = complex_modes(ONE, ONE.operating_point(**vars(AT))).modes[0]
    decay = 0.002 * 4e3 * np.pi
    deviation = 0.05 * (mode.growth_rate + decay)
    found = list(first_order_probabilities(ONE, AT, [mode], uncertainty, threshold))
    assert found == pytest.approx([ndtr((mode.growth_rate - threshold) / deviation)], rel=1e-3)


@pytest.mark.parametrize('name', ['friction', 'pressure', 'rotor_speed', 'contact_stiffness'])
def test_first_order_deviation_is_the_change_over_one_deviation(
        name: str, kang: BrakeModel) -> None:
    at = replace(AT, contact_stiffness=kang.nominal_contact_stiffness)
    mode = complex_modes(kang, kang.operating_point(**vars(at))).least_stable(1250.0, 16e3)[0]
    step = 1e-3 * (1.0 if name == 'friction' else getattr(at, name))
    low, high = (complex_modes(kang, kang.operating_point(**vars(replace(
        at, **{name: getattr(at, name) + sign * step})))) for sign in (-0.5, 0.5))
    near = [modes.eigenvalues[np.abs(modes.eigenvalues - mode.eigenvalue).argmin()].real
            for modes in (low, high)]
    deviation = abs(near[1] - near[0])
    found = list(first_order_probabilities(kang, at, [mode], replace(NONE, **{name: 1e-3}),
                                           mode.growth_rate - 0.5 * deviation))
    assert found == pytest.approx([ndtr(0.5)], abs=2e-3)


@pytest.mark.parametrize('friction', [0.1, 0.3, 0.42])
def test_without_uncertainty_the_verdict(friction: float, kang: BrakeModel) -> None:
    parameters = replace(PARAMETERS, uncertainty=NONE)
    at = SlidingConditions(rotor_speed=10.0, pressure=2e6, friction=friction)
    modes = complex_modes(kang, kang.operating_point(**vars(at)))
    unstable = modes.flutter_in(*parameters.band_hz)
    found = RiskEvaluator(kang, parameters).assess([at], [modes])[0]
    assert (found.probability, found.error, found.basis) == (float(bool(unstable)), 0.0, 'certain')
    assert [mode.index for mode in found.modes] == [mode.index for mode in unstable]


def test_no_mode_in_the_band() -> None:
    found = assess(RiskEvaluator(ONE, replace(PARAMETERS, band_hz=(9e3, 16e3))), AT)
    assert (found.probability, found.modes) == (0.0, ())
