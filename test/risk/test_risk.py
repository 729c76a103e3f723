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

"""Risk: the rule against closed forms, cells against samples of full solves."""

from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ndtr
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.risk.evaluator import RiskEvaluator
from squeal_core.risk.integration import _roots, Estimate, estimate
from squeal_core.risk.probability import Inputs, InputUncertainty, Risk
from squeal_core.risk.quadrature import rule_for, TensorQuadrature
from squeal_core.risk.risk_cell import box_around, Family, inside, Spread
from squeal_core.risk.risk_cell_making import build_cell
from squeal_core.stability.eigensolution import complex_modes, eigenvalues, Tolerances

BAND = (1250.0, 16000.0)
DEVIATIONS = InputUncertainty(
    friction=0.02, pressure=0.03, rotor_speed=0.01, contact_stiffness=0.1)
NONE = InputUncertainty(friction=0.0, pressure=0.0, rotor_speed=0.0, contact_stiffness=0.0)
WITHIN = 0.02  # of a probability, as is asked of the estimate


def small_model(**changes: Any) -> BrakeModel:
    """Four modes; those at 2000 and 2060 Hz merge at mu = 0.24, or with another stiffness."""
    couple = np.zeros((4, 4))
    couple[2, 3], couple[3, 2] = 2e-3, -2e-3
    shape = np.random.default_rng(0).standard_normal((4, 4))
    return BrakeModel(**{
        'angular_frequencies': 2 * np.pi * np.array([900.0, 1500.0, 2000.0, 2060.0]),
        'contact_stiffness': 1e-4 * np.diag([1.0, 0.5, 2.0, 1.0]), 'friction_couple': couple,
        'gyroscopic': 1e-3 * (shape - shape.T), 'radial_dissipation': 1e-8 * (shape @ shape.T),
        'negative_slope': 1e-6 * (shape @ shape.T), 'nominal_contact_stiffness': 1e10,
        'caliper': Caliper(2.5e-3), 'friction_law': FrictionLaw(), **changes})


SMALL = small_model()


def at(model: BrakeModel, speed: float = 10.0, pressure: float = 2e6,
       friction: float = 0.3) -> Inputs:
    return Inputs(rotor_speed=speed, pressure=pressure, friction=friction,
                  contact_stiffness=model.nominal_contact_stiffness)


def summed(model: BrakeModel, inputs: Inputs, deviations: InputUncertainty = DEVIATIONS, *,
           band: tuple[float, float] = BAND, level: float = 1e-2) -> Estimate:
    """Return the estimate from a cell around the inputs."""
    family, rule = Family(model), rule_for(deviations.contact_stiffness, 3)
    spread = Spread(deviations.friction, deviations.pressure, deviations.rotor_speed)
    here = (inputs.rotor_speed, inputs.pressure, inputs.friction)
    angular = (2 * math.pi * band[0], 2 * math.pi * band[1])
    cell = build_cell(family, here, spread, rule, angular, level)
    return estimate(cell, family, spread, [here], angular, level)


def assess(model: BrakeModel, inputs: Inputs, deviations: InputUncertainty = DEVIATIONS, *,
           band: tuple[float, float] = BAND) -> Risk:
    """Return the risk without a map."""
    at = SlidingConditions(**vars(inputs))
    return RiskEvaluator(model, band, deviations, Tolerances.of(model)).assess(
        at, complex_modes(model, model.operating_point(**vars(at))))


def sampled(model: BrakeModel, inputs: Inputs, deviations: InputUncertainty, count: int,
            band: tuple[float, float]) -> tuple[float, float, float]:
    """Probability by full solves of random inputs, twice its standard error, growing modes."""
    rng = np.random.default_rng(7)
    growing = []
    for speed, pressure, friction, stiffness in rng.standard_normal((count, 4)):
        point = model.operating_point(
            rotor_speed=inputs.rotor_speed * (1.0 + deviations.rotor_speed * speed),
            pressure=inputs.pressure * (1.0 + deviations.pressure * pressure),
            friction=inputs.friction + deviations.friction * friction)
        point = replace(point, contact_stiffness=point.contact_stiffness * math.exp(
            deviations.contact_stiffness * stiffness))
        roots = eigenvalues(model, point)
        growing.append(np.count_nonzero(
            (roots.real > 1e-2) & (roots.imag > 2 * np.pi * band[0])
            & (roots.imag < 2 * np.pi * band[1])))
    p = float(np.mean(np.array(growing) > 0))
    return p, 2.0 * math.sqrt(max(p * (1.0 - p), 1.0 / count) / count), float(np.mean(growing))


# ---------------------------------------------------------------- the rule

@pytest.mark.parametrize('deviation', [0.0, 0.01, 0.1, 0.3])
def test_masses_are_probabilities(deviation: float) -> None:
    rule = rule_for(deviation, 3)
    for masses in (rule.stiffness_masses, rule.friction_masses, rule.coarse_masses):
        assert masses.sum() == pytest.approx(1.0)
        assert masses.min() >= 0.0
    every = np.add.outer(np.log(rule.factors), rule.offsets).ravel()
    mean, square = (float(rule.stiffness_masses.ravel() @ every**n) for n in (1, 2))
    assert mean == pytest.approx(0.0, abs=1e-12)
    # what lies beyond the ends, 0.7 %, takes a little away
    assert math.sqrt(square) == pytest.approx(deviation, rel=0.03)


def test_polynomials_of_friction_are_continued_exactly() -> None:
    rule = rule_for(0.1, 3)
    points = np.linspace(-3.0, 3.0, rule.friction_points)
    cubic = np.poly1d([0.3, -1.0, 2.0, 0.5])
    assert cubic(rule.friction_steps) @ rule.continuation == pytest.approx(cubic(points))


@pytest.mark.parametrize('mean', [-8.0, -2.0, -0.3, 0.0, 1.0, 5.0])
@pytest.mark.parametrize('slopes', [(0.0, 0.0, 1.0), (3.0, 0.0, 0.0), (0.0, 3.0, 0.0),
                                    (1.0, -2.0, 0.5), (1.0, 2.0, 4.0)])
@pytest.mark.parametrize('step', [1, 2])
def test_growth_linear_in_the_inputs(mean: float, slopes: tuple[float, float, float],
                                     step: int) -> None:
    rule = rule_for(0.1, 3)
    friction = np.linspace(-3.0, 3.0, rule.friction_points)[::step]
    stiffness = np.add.outer(np.log(rule.factors), rule.offsets).ravel() / 0.1
    growth = mean + np.add.outer(slopes[0] * friction, slopes[1] * stiffness)
    found = rule.probability(growth, rule.widths(growth, np.array(slopes[2])))
    # what lies beyond the ends
    assert found == pytest.approx(ndtr(mean / np.linalg.norm(slopes)), abs=2e-3)


def test_no_width_no_estimate_between() -> None:
    rule = rule_for(0.0, 3)
    for growth in (-1e-3, 1e-3):
        grid = np.full((rule.friction_points, 1), growth)
        found = rule.probability(grid, rule.widths(grid, np.array(0.0)))
        assert found == pytest.approx(float(growth > 0.0), abs=1e-12)


@pytest.mark.parametrize('size', [1, 2, 3, 4])
def test_roots_of_blocks(size: int) -> None:
    rng = np.random.default_rng(size)
    blocks = rng.standard_normal((50, size, size, 3)) + 1j * rng.standard_normal(
        (50, size, size, 3))
    blocks[0] = 0.0
    blocks[1] = np.eye(size)[:, :, None] * 2j
    found = _roots(size, blocks.reshape(-1, 3)).reshape(50, size, 3)
    expected = np.linalg.eigvals(blocks.transpose(0, 3, 1, 2)).transpose(0, 2, 1)
    away = np.abs(found[:, :, None] - expected[:, None])
    assert max(away.min(axis=1).max(), away.min(axis=2).max()) < 1e-9
    assert (np.diff(found.real, axis=1) >= 0.0).all()


def test_inside_is_growth_within_the_band_and_continuous() -> None:
    roots = np.array(5.0 + 1j * np.linspace(80.0, 220.0, 141), complex)
    found = inside(roots, (100.0, 200.0))
    assert ((found > 0.0) == ((roots.imag > 100.0) & (roots.imag < 200.0))).all()
    assert np.abs(np.diff(found)).max() <= 1.0 + 1e-9
    assert (inside(roots, None) == 5.0).all()


@pytest.mark.parametrize('changes', [
    {}, {'friction_law': None},
    {'stiffness_table': StiffnessTable((0.0, 2e5, 4e6), (0.5e10, 1e10, 3e10))}])
def test_coefficients_are_those_of_the_operating_point(changes: dict[str, Any]) -> None:
    model = small_model(**changes)
    family, frictions = Family(model), np.array([0.2, 0.35, 0.5])
    factors = np.array([0.9, 1.0, 1.3])
    for speed, pressure in ((0.7, 1e5), (12.0, 3e6)):
        points = [family.point(speed, pressure, friction, factor)
                  for friction, factor in zip(frictions.tolist(), factors.tolist(), strict=True)]
        expected = np.array([point.coefficients() for point in points]).T
        found = family.coefficients(speed, pressure, frictions, factors)
        np.testing.assert_allclose(found, expected, rtol=1e-13)
        np.testing.assert_allclose(family.coefficients(speed, pressure, 0.35), expected[:, 1],
                                   rtol=1e-13)


def test_series_are_evaluated_where_the_rule_says() -> None:
    rule = rule_for(0.1, 3)
    cubic = np.poly1d([0.3, -1.0, 2.0, 0.5])
    growth = cubic(rule.friction_moves) + np.log(rule.stiffness_moves)
    found = np.concatenate([growth, np.arange(4.0)]) @ rule.continued
    points = np.linspace(-3.0, 3.0, rule.friction_points)
    expected = np.add.outer(cubic(points), rule.offsets).ravel()
    assert found[:-4] == pytest.approx(expected)
    assert found[-4:].tolist() == [0.0, 1.0, 2.0, 3.0]


# ---------------------------------------------------------------- closed forms and samples

@pytest.mark.parametrize(('friction', 'level'), [
    (0.3, 0.01), (0.35, 0.01), (0.4, 0.01), (0.45, 0.01), (0.5, 0.01), (0.4, 5.0), (0.5, 5.0)])
def test_one_mode_with_a_falling_friction(friction: float, level: float) -> None:
    """Growth where pressure times friction exceeds a limit: a product of two Gaussians."""
    model = BrakeModel(
        angular_frequencies=np.array([4e3 * np.pi]), damping_ratios=0.002, caliper=Caliper(2.5e-3),
        negative_slope=np.array([[1.2e-3]]), friction_law=FrictionLaw())
    inputs = at(model, speed=12.0, friction=friction)
    rng = np.random.default_rng(3)
    speed, pressure, mu = rng.standard_normal((3, 200_000))
    law = FrictionLaw()
    sliding = model.contact_radius * 12.0 * (1.0 + 0.01 * speed)
    fall = np.exp(-sliding) * (law.static - law.kinetic)
    slope = -fall / (law.kinetic + fall) * (friction + 0.02 * mu)
    p0 = 2e6 * (1.0 + 0.03 * pressure) * 2.5e-3 / model.contact_area
    expected = float(np.mean(-0.5 * (2 * 0.002 * 4e3 * np.pi + 1.2e-3 * p0 * slope) > level))
    found = summed(model, inputs, level=level).overall[0][0]
    assert found == pytest.approx(expected, abs=5e-3)  # sampling: 1e-3


@pytest.mark.parametrize('friction', [0.16, 0.2, 0.24, 0.28, 0.4])
@pytest.mark.parametrize('deviation', [0.0, 0.03, 0.1])
def test_merging_modes_against_samples(friction: float, deviation: float) -> None:
    deviations = replace(DEVIATIONS, contact_stiffness=deviation)
    inputs = at(SMALL, friction=friction)
    expected, error, growing = sampled(SMALL, inputs, deviations, 2000, BAND)
    found = summed(SMALL, inputs, deviations)
    assert found.overall[0][0] == pytest.approx(expected, abs=WITHIN + error)
    assert found.modes.sum() == pytest.approx(growing, abs=WITHIN + error)
    assert found.overall[1][0] < WITHIN


def test_a_mode_that_enters_the_band_against_samples() -> None:
    inputs, band = at(SMALL, friction=0.4), (2039.5, 16000.0)
    expected, error, _ = sampled(SMALL, inputs, DEVIATIONS, 3000, band)
    assert 0.1 < expected < 0.9
    assert summed(SMALL, inputs, band=band).overall[0][0] == pytest.approx(
        expected, abs=WITHIN + error)


@pytest.mark.parametrize(('speed', 'pressure', 'friction', 'band'), [
    (8.165, 4.403e5, 0.425, (6500.0, 8000.0)), (36.25, 1.635e6, 0.388, (2000.0, 3000.0))])
def test_shipped_model_against_samples(kang: BrakeModel, speed: float, pressure: float,
                                       friction: float, band: tuple[float, float]) -> None:
    """Away from the middle of the cell, where it is the least exact."""
    family, spread, rule = Family(kang), Spread(0.02, 0.03, 0.01), rule_for(0.1, 3)
    angular = (2 * np.pi * band[0], 2 * np.pi * band[1])
    cell = build_cell(
        family, (1.2 * speed, 1.2 * pressure, friction - 0.015), spread, rule, angular)
    inputs = (speed, pressure, friction)
    assert ((cell.box.low <= inputs) & (inputs <= cell.box.high)).all()
    found = estimate(cell, family, spread, [inputs], angular, 1e-2)
    expected, error, growing = sampled(kang, at(kang, *inputs), DEVIATIONS, 150, band)
    assert found.overall[0][0] == pytest.approx(expected, abs=WITHIN + error)
    assert found.modes.sum() == pytest.approx(growing, abs=WITHIN + 2.0 * error)


def test_first_order_is_exact_where_growth_is_linear() -> None:
    model = BrakeModel(
        angular_frequencies=np.array([4e3 * np.pi]), damping_ratios=0.002, caliper=Caliper(2.5e-3),
        negative_slope=np.array([[1.2e-3]]), friction_law=FrictionLaw())
    deviations = replace(NONE, pressure=0.05)

    inputs = at(model, speed=12.0, friction=0.4)
    found = assess(model, inputs, deviations)
    assert (found.basis, math.isnan(found.error)) == ('first order', True)
    assert found.probability == pytest.approx(
        summed(model, inputs, deviations).overall[0][0], abs=5e-3)


# ---------------------------------------------------------------- without a map

@pytest.mark.parametrize('friction', [0.1, 0.2, 0.3, 0.4])
@pytest.mark.parametrize('band', [BAND, (2100.0, 16000.0), (1250.0, 1400.0)])
def test_without_uncertainty_the_verdict(friction: float, band: tuple[float, float],
                                         kang: BrakeModel) -> None:
    for model in (SMALL, kang):
        inputs = at(model, friction=friction)
        point = model.operating_point(rotor_speed=10.0, pressure=2e6, friction=friction)
        growing = complex_modes(model, point).flutter_in(*band)
        found = assess(model, inputs, NONE, band=band)
        assert (found.probability, found.error, found.basis) == (
            float(bool(growing)), 0.0, 'certain')
        assert [m.index for m in found.modes] == [m.index for m in growing]


def test_a_tiny_uncertainty_comes_to_the_verdict() -> None:
    tiny = InputUncertainty(friction=1e-6, pressure=1e-6, rotor_speed=1e-6, contact_stiffness=1e-6)
    for friction in (0.1, 0.4):
        certain = assess(SMALL, at(SMALL, friction=friction), NONE).probability
        found = assess(SMALL, at(SMALL, friction=friction), tiny).probability
        assert found == pytest.approx(certain, abs=1e-9)


def test_backwards_as_forwards() -> None:
    backwards, forwards = (assess(SMALL, at(SMALL, speed=s, friction=0.24))
                           for s in (-10.0, 10.0))
    assert backwards.probability == pytest.approx(forwards.probability, abs=1e-9)
    assert [m.index for m in backwards.modes] == [m.index for m in forwards.modes]


def test_modes_are_the_same_whenever_they_are_asked_for() -> None:
    early, late, other = (assess(SMALL, at(SMALL, friction=f)) for f in (0.26, 0.26, 0.2))
    modes = early.modes
    assert len(modes) > 0
    assert late.modes == modes
    assert late.probability == early.probability
    assert early != other


def test_modes_are_named_by_their_index() -> None:
    found = assess(SMALL, at(SMALL, friction=0.4))
    point = SMALL.operating_point(rotor_speed=10.0, pressure=2e6, friction=0.4)
    modes = complex_modes(SMALL, point).modes
    assert found.modes[0].probability > 0.9
    for mode in found.modes:
        there = modes[mode.index - 1]
        assert mode.frequency_hz == pytest.approx(there.frequency_hz)
        assert mode.growth_rate == pytest.approx(there.growth_rate)


def test_no_mode_in_the_band() -> None:
    found = assess(SMALL, at(SMALL), band=(9000.0, 16000.0))
    assert (found.probability, found.modes) == (0.0, ())


def test_a_box_covers_its_middle_and_shrinks() -> None:
    for inputs in ((0.6, 5e4, 0.1), (100.0, 1e7, 0.8)):
        wide, narrow = box_around(inputs), box_around(inputs, 0.2)
        rising = np.stack([wide.low, narrow.low, inputs, narrow.high, wide.high])
        assert (np.diff(rising, axis=0) > 0.0).all()
        assert wide.low[1] > 0.0


def test_rule_is_fixed() -> None:
    assert rule_for(0.1, 3) == TensorQuadrature(
        nodes=15, spacing=0.04, parts=3, stiffness_deviation=0.1, friction_nodes=4,
        friction_points=17)
