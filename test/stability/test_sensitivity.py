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

"""Sensitivities against differences of the roots, and first-order risk against Monte Carlo."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import trapezoid
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.operating_point import Coefficients
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.risk.probability import first_order_risk, Inputs, InputUncertainty
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.sensitivity import growth_change, root_sensitivity

POINT = OperatingPoint(rotor_speed=7.0, friction=0.5, friction_slope=-0.1, contact_pressure=5e5,
                       contact_stiffness=1e9)
DAMPING = ('gyroscopic', 'radial_dissipation', 'negative_slope')
WITHOUT_FOLLOWER = Coefficients._fields[:5]


def random_model(seed: int, size: int = 4) -> BrakeModel:
    """All six arrays, none of them small, at POINT."""
    rng = np.random.default_rng(seed)
    skew, *square = rng.standard_normal((6, size, size))
    a, r, s = (x @ x.T for x in square[:3])
    return BrakeModel(
        angular_frequencies=np.sort(rng.uniform(1e3, 1e4, size)), damping_ratios=0.01,
        gyroscopic=skew - skew.T, contact_stiffness=1e-3 * a, friction_couple=1e-3 * square[3],
        radial_dissipation=1e-4 * r, negative_slope=1e-4 * s, follower=square[4])


def kang_point(model: BrakeModel, speed: float) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=0.42, friction_slope=-0.02,
                          contact_pressure=2000.0 / model.contact_area,
                          contact_stiffness=0.35e11)


def roots_at(model: BrakeModel, coefficients: Coefficients) -> ComplexArray:
    """Roots for any coefficients, whether an operating point has them or not."""
    damping, stiffness = np.diag(model.structural_damping), np.diag(model.angular_frequencies**2)
    for name, factor in coefficients._asdict().items():
        array = getattr(model, name)
        if array is not None and name in DAMPING:
            damping = damping + factor * array
        elif array is not None:
            stiffness = stiffness + factor * array
    n = model.size
    return np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -damping]]))


def difference(model: BrakeModel, at: Coefficients, name: str, root: complex,
               step: float) -> complex:
    """Return d root / d coefficient by fourth-order central differences, following the root."""
    def moved(times: float) -> complex:
        roots = roots_at(model, at._replace(**{name: getattr(at, name) + times * step}))
        return complex(roots[np.abs(roots - root).argmin()])

    return (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * step)


# ---------------------------------------------------------------- sensitivities

@pytest.mark.parametrize('name', Coefficients._fields)
@pytest.mark.parametrize('seed', range(3))
def test_against_differences(seed: int, name: str) -> None:
    model, at = random_model(seed), POINT.coefficients()
    for root in roots_at(model, at):
        found = root_sensitivity(model, POINT, complex(root))[name]
        step = 1e-3 * abs(getattr(at, name))
        expected = difference(model, at, name, complex(root), step)
        # (1e-3)^4 cut off; roots rounded to eps * 1e4 * 1e2, over the step
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 / step)
        assert abs(expected) * step > 1e-6  # so the roots do move


@pytest.mark.parametrize('name', WITHOUT_FOLLOWER)
@pytest.mark.parametrize('speed', [5.0, 20.0])
def test_shipped_model_against_differences(speed: float, name: str, kang: BrakeModel) -> None:
    point = kang_point(kang, speed)
    at = point.coefficients()
    unstable = [m for m in complex_modes(kang, point).unstable if m.kind == 'flutter']
    assert len(unstable) > 1
    for mode in unstable:
        found = root_sensitivity(kang, point, mode.eigenvalue)[name]
        step = 1e-4 * abs(getattr(at, name))
        expected = difference(kang, at, name, mode.eigenvalue, step)
        # roots rounded to eps * 2e5 * 1e3, over the step
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 / step)


def test_only_what_the_model_has(kang: BrakeModel) -> None:
    point = kang_point(kang, 5.0)
    root = complex_modes(kang, point).unstable[0].eigenvalue
    assert tuple(root_sensitivity(kang, point, root)) == WITHOUT_FOLLOWER
    bare = BrakeModel(angular_frequencies=[1e3, 2e3], negative_slope=[[1e-3, 1e-4], [1e-4, 1e-3]])
    found = root_sensitivity(bare, POINT, complex_modes(bare, POINT).modes[0].eigenvalue)
    assert tuple(found) == ('negative_slope',)


def test_one_mode_in_closed_form() -> None:
    """lambda^2 + (c + s S) lambda + w^2 + k A = 0, differentiated by hand."""
    model = BrakeModel(angular_frequencies=[1e3], damping_ratios=0.01,
                       contact_stiffness=[[2e-4]], negative_slope=[[3e-4]])
    root = complex_modes(model, POINT).modes[0].eigenvalue
    found = root_sensitivity(model, POINT, root)
    damping = 20.0 - 5e4 * 3e-4
    # one mode: nothing but rounding
    assert found['negative_slope'] == pytest.approx(
        -3e-4 * root / (2.0 * root + damping), rel=1e-12)
    assert found['contact_stiffness'] == pytest.approx(-2e-4 / (2.0 * root + damping), rel=1e-12)


def test_growth_change_is_first_order() -> None:
    """All coefficients at once: what the tangent misses falls with the step's square."""
    model, at = random_model(2), POINT.coefficients()

    def missed(step: float, root: complex) -> tuple[float, float]:
        """Return what `growth_change` is off, and the change itself."""
        there = Coefficients(*(c * (1.0 + sign * step) for c, sign in zip(
            at, (1, -1, 1, 1, -1, 1), strict=True)))
        moved = roots_at(model, there)
        change = float(moved[np.abs(moved - root).argmin()].real - root.real)
        return growth_change(root_sensitivity(model, POINT, root), at, there) - change, change

    for root in map(complex, roots_at(model, at)):
        (coarse, change), (fine, _) = missed(1e-2, root), missed(5e-3, root)
        assert abs(coarse) < 0.01 * abs(change)
        assert coarse / fine == pytest.approx(4.0, abs=0.05)  # the cubic term is 1e-2 of it


# ---------------------------------------------------------------- first-order risk

TWO = BrakeModel(
    angular_frequencies=[1e4, 1.03e4], damping_ratios=0.01,
    contact_stiffness=[[2e-3, 1e-4], [1e-4, 1e-3]], gyroscopic=[[0.0, 4.0], [-4.0, 0.0]],
    friction_couple=[[0.0, 2.0e-3], [-1.5e-3, 0.0]],
    radial_dissipation=[[5e-4, 0.0], [0.0, 1e-4]], negative_slope=[[3e-3, 1e-4], [1e-4, 2e-3]])
SPREAD = InputUncertainty(friction=0.004, pressure=0.02, rotor_speed=0.02, contact_stiffness=0.005)


def point_of(inputs: Inputs) -> OperatingPoint:
    """Return a point: the slope goes with the friction, as a scaled law's does."""
    return OperatingPoint(
        rotor_speed=inputs.rotor_speed, friction=inputs.friction,
        friction_slope=-0.1 * inputs.friction, contact_pressure=inputs.pressure,
        contact_stiffness=inputs.contact_stiffness)


def inputs(friction: float) -> Inputs:
    return Inputs(rotor_speed=5.0, pressure=1e6, friction=friction, contact_stiffness=1e10)


def growing(at: Inputs) -> tuple[Mode, ...]:
    """Return the mode nearest to growing."""
    modes = complex_modes(TWO, point_of(at)).modes
    return (max(modes, key=lambda m: m.growth_rate),)


def monte_carlo(at: Inputs, samples: int = 40000) -> tuple[float, FloatArray]:
    """Probability of growth, and the growth rates, by eigenvalues of samples of the inputs."""
    rng = np.random.default_rng(5)
    mu, p, speed, k = (rng.normal(mean, spread, samples)[:, None, None] for mean, spread in (
        (at.friction, SPREAD.friction), (at.pressure, SPREAD.pressure * at.pressure),
        (at.rotor_speed, SPREAD.rotor_speed * at.rotor_speed),
        (at.contact_stiffness, SPREAD.contact_stiffness * at.contact_stiffness)))
    stiffness = np.diag(TWO.angular_frequencies**2) + k * (
        TWO.contact_stiffness + mu * TWO.friction_couple)
    damping = (np.diag(TWO.structural_damping) + speed * TWO.gyroscopic
               + p * mu / speed * TWO.radial_dissipation - 0.1 * mu * p * TWO.negative_slope)
    upper = np.broadcast_to(np.hstack([np.zeros((2, 2)), np.eye(2)]), (samples, 2, 4))
    state = np.concatenate([upper, np.concatenate([-stiffness, -damping], axis=2)], axis=1)
    growth = np.linalg.eigvals(state).real.max(axis=1)
    return float(np.mean(growth > 0.0)), growth


@pytest.mark.parametrize('friction', [0.170, 0.172, 0.174, 0.178])
def test_risk_against_monte_carlo(friction: float) -> None:
    at = inputs(friction)
    found = first_order_risk(TWO, point_of, at, growing(at), SPREAD).probability
    expected, growth = monte_carlo(at)
    assert 0.05 < expected < 0.98
    # 40000 samples: 0.0025; the growth rate bends by (mean - present) / deviation of a deviation
    bend = abs(growth.mean() - growing(at)[0].growth_rate) / growth.std()
    assert bend < 0.05
    assert found == pytest.approx(expected, abs=0.0075 + 0.4 * bend)


@pytest.mark.parametrize('name', ['friction', 'pressure', 'rotor_speed', 'contact_stiffness'])
def test_risk_of_one_uncertain_input(name: str) -> None:
    """The deviation of the growth rate is its change over one deviation of the input."""
    none = InputUncertainty(friction=0.0, pressure=0.0, rotor_speed=0.0, contact_stiffness=0.0)
    at, spread = inputs(0.1725), 1e-3
    mode = growing(at)[0]
    step = spread if name == 'friction' else spread * getattr(at, name)
    high, low = (growing(at.moved(name, sign * step))[0].growth_rate for sign in (0.5, -0.5))
    found = first_order_risk(TWO, point_of, at, (mode,), replace(none, **{name: spread}))
    deviation = abs(high - low)
    expected = normal_cdf(mode.growth_rate / deviation)
    # third derivatives over half a step of 1e-3
    assert found.probability == pytest.approx(expected, abs=1e-4)
    certain = first_order_risk(TWO, point_of, at, (mode,), none)
    assert certain.probability == float(mode.growth_rate > 0.0)


def normal_cdf(x: float) -> float:
    """By summing the density, not by erf."""
    grid = np.linspace(-12.0, x, 20001)
    return float(trapezoid(np.exp(-0.5 * grid**2), grid) / np.sqrt(2.0 * np.pi))


def test_the_greatest_probability_counts() -> None:
    at = inputs(0.172)
    modes = complex_modes(TWO, point_of(at)).modes
    single = [first_order_risk(TWO, point_of, at, (m,), SPREAD).probability for m in modes]
    both = first_order_risk(TWO, point_of, at, modes, SPREAD)
    assert both.probability == max(single) > 0.1
    assert min(single) < 1e-6
    assert first_order_risk(TWO, point_of, at, (), SPREAD).probability == 0.0


@pytest.mark.parametrize('start', [0.170, 0.175])
def test_margin_is_the_way_to_critical_friction(start: float) -> None:
    low, high = 0.16, 0.19
    for _ in range(40):  # bisection on the growth rate itself
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growing(inputs(middle))[0].growth_rate < 0 else (low, middle)
    margin = first_order_risk(TWO, point_of, inputs(start), growing(inputs(start)),
                              SPREAD).friction_margin
    # the growth rate bends by some per cent over 0.003 of friction
    assert start + margin == pytest.approx(low, abs=0.1 * abs(low - start))
    assert np.sign(margin) == np.sign(low - start)


def test_no_margin_without_a_way() -> None:
    """A mode that friction only damps has none; neither has one beyond mu + 1."""
    model = BrakeModel(angular_frequencies=[1e4, 2e4], damping_ratios=0.01,
                       radial_dissipation=[[1e-3, 1e-5], [1e-5, 1e-3]])
    at = inputs(0.4)
    modes = complex_modes(model, point_of(at)).modes
    found = first_order_risk(model, point_of, at, modes, SPREAD)
    assert np.isnan(found.friction_margin)
    assert found.probability == 0.0
