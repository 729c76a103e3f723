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

"""Sensitivities, critical values along rays and merging margins: closed forms and solves."""

from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.errors import OperatingPointError
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, eigenvalues, Tolerances
from squeal_core.stability.exceptional_point import nearest_exceptional_point
from squeal_core.stability.parameter_paths import moved, PARAMETERS
from squeal_core.stability.sensitivity import parameter_sensitivity
from support.engine_models import dense_model

POINT = OperatingPoint(rotor_speed=7.0, friction=0.5, friction_slope=-0.1, contact_pressure=5e5,
                       contact_stiffness=1e9)
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])
W1, W2 = 1e4, 1.02e4
EVERY = (0.0, 1e5)  # Hz


def at(model: BrakeModel, speed: float, friction: float = 0.42) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=friction, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


# ---------------------------------------------------------------- sensitivities

def difference(model: BrakeModel, point: OperatingPoint, name: str, root: complex,
               step: float) -> complex:
    """By fourth-order central differences, following the root; all but `name` held."""
    def there(times: float) -> complex:
        roots = eigenvalues(model, replace(point, **{name: getattr(point, name) + times * step}))
        return complex(roots[np.abs(roots - root).argmin()])

    return (8.0 * (there(1.0) - there(-1.0)) - (there(2.0) - there(-2.0))) / (12.0 * step)


@pytest.mark.parametrize('name', PARAMETERS)
@pytest.mark.parametrize('seed', range(3))
def test_sensitivity_of_random_models(seed: int, name: str) -> None:
    model = dense_model(seed)
    for mode in complex_modes(model, POINT).modes:
        found = parameter_sensitivity(model, POINT, mode.eigenvalue)[name]
        step = 1e-3 * abs(getattr(POINT, name))
        expected = difference(model, POINT, name, mode.eigenvalue, step)
        assert found == pytest.approx(expected, rel=1e-6, abs=1e-9 / step)
        assert abs(expected) * step > 1e-6  # so the root does move


@pytest.mark.parametrize('name', PARAMETERS)
@pytest.mark.parametrize('speed', [5.0, 20.0])
def test_sensitivity_of_the_shipped_model(speed: float, name: str, kang: BrakeModel) -> None:
    point = replace(at(kang, speed), friction_slope=-0.02)
    flutter = [m for m in complex_modes(kang, point).unstable if m.kind == 'flutter']
    assert len(flutter) > 1
    for mode in flutter:
        found = parameter_sensitivity(kang, point, mode.eigenvalue)[name]
        step = 1e-4 * abs(getattr(point, name))
        expected = difference(kang, point, name, mode.eigenvalue, step)
        assert found == pytest.approx(expected, rel=1e-5, abs=1e-7 / step)


# ---------------------------------------------------------------- critical values: closed forms

def flutter(couple: float, stiffening: float = 0.0, damping: float = 40.0) -> BrakeModel:
    """
    Two modes of equal damping, K = diag(w1^2 + k_c stiffening, w2^2) + mu k_c couple SKEW.

    With equal damping d a root is i w where (half the split of K)^2 = -d^2 w^2, w^2 its mean:
    gap^2 + d^2 mean = (mu k_c couple)^2.
    """
    return BrakeModel(angular_frequencies=[W1, W2], friction_couple=couple * SKEW,
                      damping_ratios=[0.5 * damping / W1, 0.5 * damping / W2],
                      contact_stiffness=np.diag([stiffening, 0.0]))


def test_critical_friction() -> None:
    model = flutter(couple=1e-3)
    point = replace(POINT, contact_stiffness=1e10, friction=0.1)
    gap, mean = 0.5 * (W2**2 - W1**2), 0.5 * (W1**2 + W2**2)
    expected = math.sqrt(gap**2 + 40.0**2 * mean) / (1e10 * 1e-3)
    found = critical_value(model, point, 'friction', (0.0, 1.0), tolerance=1e-9)
    # the growth rate where growing begins is a little further on
    assert found.above.value == pytest.approx(expected, rel=1e-4)
    assert found.above.value > expected
    assert found.nearest is found.above
    assert found.above.converged
    assert abs(found.above.bracket[1] - found.above.bracket[0]) <= 1e-9
    assert found.above.frequency_hz == pytest.approx(math.sqrt(mean) / 2.0 / math.pi, rel=1e-6)
    assert found.below.reason == (
        'no stability boundary from mu = 0.1 to 0, stable')


def window(couple: float = 4e-4, friction: float = 0.5) -> tuple[float, float]:
    """Contact stiffnesses between which mode 1, stiffened past mode 2, flutters with it."""
    a = 1e-3  # (w1^2 + a k - w2^2)^2 / 4 + d^2 (w1^2 + a k + w2^2) / 2 = (mu k b)^2
    gap, total = W1**2 - W2**2, W1**2 + W2**2
    square = a**2 / 4.0 - (friction * couple)**2
    low, high = sorted(np.roots([square, a * gap / 2.0 + 40.0**2 * a / 2.0,
                                 gap**2 / 4.0 + 40.0**2 * total / 2.0]).real)
    return low, high


@pytest.mark.parametrize('part', [-0.5, 0.3, 0.7, 1.5])
def test_the_nearest_of_two_crossings(part: float) -> None:
    """From below, within and above a window of flutter."""
    low, high = window()
    assert 2e9 < low < high < 8e9
    start = low + part * (high - low)
    found = critical_value(flutter(4e-4, 1e-3), replace(POINT, contact_stiffness=start),
                           'contact_stiffness', (5e8, 1.5e10))
    sides = {'below': low if 0.0 < part < 1.0 else high if part > 1.0 else None,
             'above': high if 0.0 < part < 1.0 else low if part < 0.0 else None}
    for side, expected in sides.items():
        crossing = getattr(found, side)
        if expected is None:
            assert math.isnan(crossing.value)
            assert not crossing.converged
        else:
            assert crossing.value == pytest.approx(expected, rel=1e-4)
            assert crossing.converged
    values = [v for v in sides.values() if v is not None]
    assert found.nearest.value == pytest.approx(
        min(values, key=lambda v: abs(v - start)), rel=1e-4)
    assert (found.growth_rate > 0.0) == (0.0 < part < 1.0)


def single() -> BrakeModel:
    return BrakeModel(angular_frequencies=[1e4], damping_ratios=0.002, contact_radius=0.12,
                      negative_slope=[[1e-3]], friction_law=FrictionLaw(0.5, 0.3, 1.0))


def test_critical_pressure() -> None:
    """2 xi w = p0 |mu_v| S."""
    found = critical_value(single(), replace(POINT, contact_pressure=1e5), 'contact_pressure',
                           (0.0, 1e6), tolerance=1e-9)
    growth = Tolerances.of(single()).growth
    expected = (40.0 + 2.0 * growth) / (0.1 * 1e-3)
    assert found.above.value == pytest.approx(expected, rel=1e-8)


def test_critical_speed_along_the_law() -> None:
    """2 xi w = p0 alpha (mu_s - mu_k) exp(-alpha r Omega) S."""
    def ray(speed: float) -> OperatingPoint:
        return moved(single(), POINT, 'rotor_speed', speed, friction_law=True)

    found = critical_value(single(), ray(10.0), 'rotor_speed', (0.5, 30.0), ray=ray,
                           tolerance=1e-9)
    expected = math.log(POINT.contact_pressure * 0.2 * 1e-3 / (
        40.0 + 2.0 * Tolerances.of(single()).growth)) / 0.12
    assert found.growth_rate < 0.0 or expected > 10.0
    crossing = found.above if expected > 10.0 else found.below
    assert crossing.value == pytest.approx(expected, rel=1e-8)


# ---------------------------------------------------------------- critical values: words, limits

def test_brackets_hold_by_independent_solves(kang: BrakeModel) -> None:
    found = critical_value(kang, at(kang, 5.0), 'friction', (0.0, 1.0), numbers=(13, 14))
    crossing = found.below
    assert crossing.bracket[1] < crossing.value < crossing.bracket[0] < 0.42
    for value, growth in zip(crossing.bracket, crossing.growth_rates, strict=True):
        roots = eigenvalues(kang, at(kang, 5.0, value))
        nearest = roots[np.abs(roots.imag / 2.0 / math.pi - crossing.frequency_hz).argmin()]
        assert nearest.real == pytest.approx(growth, abs=1e-8)
    assert crossing.growth_rates[0] > Tolerances.of(kang).growth >= crossing.growth_rates[1]
    assert crossing.reason == 'stability boundary mu = 0.3749 (1660 Hz), stable below'
    assert crossing.solves < 12  # 2 steps, and 15 by bisection


def test_a_mode_that_enters_the_band_is_no_crossing() -> None:
    """Flutter whose frequency rises into the band as it grows: the rate jumps there."""
    model = flutter(couple=1e-3, stiffening=1e-3)
    model = replace(model, contact_stiffness=np.diag([1e-3, 1e-3]))
    point = replace(POINT, contact_stiffness=1e10)
    mean = 0.5 * (W1**2 + W2**2)
    edge = math.sqrt(mean + 1.3e10 * 1e-3) / 2.0 / math.pi
    found = critical_value(model, point, 'contact_stiffness', (0.5e10, 2e10),
                           band_hz=(edge, 1e5))
    assert found.growth_rate == -math.inf
    # growth lifts the frequency a little
    assert found.above.value == pytest.approx(1.3e10, rel=0.02)
    assert not found.above.converged
    assert 'jump' in found.above.reason
    assert found.above.growth_rates[1] > 10.0


def test_solves_that_find_nothing(kang: BrakeModel) -> None:
    """In-plane torsion grows at no friction."""
    found = critical_value(kang, at(kang, 5.0), 'friction', (0.1, 0.9), numbers=(12,), samples=8)
    for crossing in (found.below, found.above):
        assert math.isnan(crossing.value)
        assert math.isnan(crossing.frequency_hz)
        assert not crossing.converged
        assert crossing.reason.startswith('no stability boundary from mu = 0.42 to 0.')
        assert max(crossing.growth_rates) < 0.0
    assert found.nearest is found.above


def test_a_start_at_a_bound() -> None:
    point = replace(POINT, contact_stiffness=1e10, friction=0.0)
    found = critical_value(flutter(couple=1e-3), point, 'friction', (0.0, 1.0))
    assert found.above.converged
    assert found.below.bracket == (0.0, 0.0)
    assert math.isnan(found.below.value)


@pytest.mark.parametrize('bounds', [(0.6, 1.0), (0.0, 0.4), (0.5, 0.5)])
def test_bounds_that_leave_the_point_out(bounds: tuple[float, float]) -> None:
    with pytest.raises(OperatingPointError, match=r'friction is 0\.5'):
        critical_value(flutter(1e-3), POINT, 'friction', bounds)


def test_parameters_there_are_not() -> None:
    with pytest.raises(OperatingPointError, match='parameter is mu'):
        critical_value(flutter(1e-3), POINT, 'mu', (0.0, 1.0))
    with pytest.raises(OperatingPointError, match='1 to 2'):
        critical_value(flutter(1e-3), POINT, 'friction', (0.0, 1.0), numbers=(2, 3))
    with pytest.raises(OperatingPointError, match='give one of friction'):
        nearest_exceptional_point(flutter(1e-3), POINT, 'rotor_speed')


# ---------------------------------------------------------------- critical values: K09

@pytest.mark.parametrize(('numbers', 'rotating', 'free'), [
    ((13, 14), 0.375, 0.360), ((25, 26), 0.0405, 0.1056), ((18, 19), 0.460, 0.1465)])
def test_critical_friction_of_k09(numbers: tuple[int, int], rotating: float, free: float,
                                  kang: BrakeModel) -> None:
    """Figs 11 and 12 at 5 rad/s: rotation stabilises doublets, and destabilises the pads' pair."""
    still = replace(kang, gyroscopic=None, radial_dissipation=None, negative_slope=None)
    for model, expected in ((kang, rotating), (still, free)):
        found = critical_value(model, at(model, 5.0), 'friction', (0.0, 1.0), numbers=numbers,
                               tolerance=1e-4)
        # growth rates are good to 0.5 1/s, the pads' pair's to 2 (the data's note)
        assert found.nearest.value == pytest.approx(expected, abs=0.01)
        assert found.nearest.converged


@pytest.mark.parametrize(('numbers', 'speed'), [((13, 14), 3.16), ((18, 19), 5.09), ((12,), 10.8)])
def test_critical_speed_of_k09(numbers: tuple[int, ...], speed: float, kang: BrakeModel) -> None:
    """Fig. 15: doublets are stable below a speed, torsion above one."""
    def ray(value: float) -> OperatingPoint:
        return moved(kang, at(kang, 5.0), 'rotor_speed', value, friction_law=True)

    found = critical_value(kang, ray(8.0), 'rotor_speed', (1.0, 20.0), numbers=numbers, ray=ray,
                           tolerance=1e-4)
    assert found.growth_rate > 0.0
    assert found.nearest.value == pytest.approx(speed, rel=0.05)
    assert found.nearest is (found.above if numbers == (12,) else found.below)


# ---------------------------------------------------------------- merging

def coupled(damping: tuple[float, float]) -> BrakeModel:
    return BrakeModel(angular_frequencies=[W1, W2], friction_couple=1e-3 * SKEW,
                      damping_ratios=[0.5 * damping[0] / W1, 0.5 * damping[1] / W2])


@pytest.mark.parametrize('friction', [0.0, 0.05, 0.19, 0.25, 0.8])
def test_merging_of_undamped_modes(friction: float) -> None:
    """At (w2^2 - w1^2) / (2 k_c b), from either side."""
    point = replace(POINT, contact_stiffness=1e10, friction=friction)
    found = (nearest_exceptional_point(coupled((0.0, 0.0)), point, band_hz=EVERY)
             if friction else None)
    expected = (W2**2 - W1**2) / 2e7
    if found is None:  # no way to go: the roots do not move to first order
        assert not nearest_exceptional_point(coupled((0.0, 0.0)), point, band_hz=EVERY).converged
        return
    assert found.converged
    assert found.value.real == pytest.approx(expected, rel=1e-7)
    assert abs(found.value.imag) < 1e-7
    assert found.distance == pytest.approx(abs(expected - friction), rel=1e-6)
    assert found.gap < 1e-2
    assert found.eigenvalue == pytest.approx(1j * math.sqrt(0.5 * (W1**2 + W2**2)), rel=1e-9)
    assert ('above' if expected > friction else 'below') in found.reason


@pytest.mark.parametrize('damping', [(10.0, 40.0), (300.0, 20.0)])
def test_merging_of_modes_that_damping_keeps_apart(damping: tuple[float, float]) -> None:
    """Double roots of (l^2 + d1 l + w1^2)(l^2 + d2 l + w2^2) + (mu k_c b)^2, by its derivative."""
    product = np.polymul([1.0, damping[0], W1**2], [1.0, damping[1], W2**2])
    double = np.roots(np.polyder(product))
    double = double[double.imag > 5e3]
    frictions = np.sqrt(-np.polyval(product, double)) / 1e7
    assert double.size == 1
    found = nearest_exceptional_point(coupled(damping),
                                      replace(POINT, contact_stiffness=1e10, friction=0.15))
    assert found.eigenvalue == pytest.approx(complex(double[0]), rel=1e-8)
    assert found.value == pytest.approx(complex(frictions[0]), rel=1e-6)
    assert found.distance == pytest.approx(abs(frictions[0] - 0.15), rel=1e-6)
    assert abs(found.value.imag) > 0.01


def test_merging_by_contact_stiffness() -> None:
    """As mode 1 is stiffened past mode 2: w1^2 + k a - w2^2 = +- 2 mu k b."""
    found = nearest_exceptional_point(flutter(1e-4, 1e-3, damping=0.0),
                                      replace(POINT, contact_stiffness=3.3e9), 'contact_stiffness')
    expected = (W2**2 - W1**2) / (1e-3 + 2.0 * 0.5 * 1e-4)
    assert found.value == pytest.approx(expected, rel=1e-7)


def test_the_closest_of_several_pairs() -> None:
    """Three modes; the upper two are closer, the lower two couple: the latter merge first."""
    couple = np.zeros((3, 3))
    couple[:2, :2], couple[1:, 1:] = 1e-3 * SKEW, couple[1:, 1:] + 1e-6 * SKEW
    couple[0, 1], couple[1, 0] = 1e-3, -1e-3
    model = BrakeModel(angular_frequencies=[W1, W2, 1.025e4], damping_ratios=0.0,
                       friction_couple=couple)
    found = nearest_exceptional_point(model, replace(POINT, contact_stiffness=1e10, friction=0.15))
    assert [m.index for m in found.modes] == [1, 2]
    assert found.value.real == pytest.approx((W2**2 - W1**2) / 2e7, rel=1e-3)
    modes = complex_modes(model, replace(POINT, contact_stiffness=1e10, friction=0.15)).modes
    other = nearest_exceptional_point(model, replace(POINT, contact_stiffness=1e10, friction=0.15),
                                      modes=(modes[1], modes[2]))
    assert other.distance > found.distance


def test_modes_that_nothing_couples_do_not_merge() -> None:
    model = BrakeModel(angular_frequencies=[W1, W2], damping_ratios=0.001)
    found = nearest_exceptional_point(model, POINT)
    assert not found.converged
    assert found.distance == math.inf


def test_merging_without_rotation_in_k09(kang: BrakeModel) -> None:
    """The third doublet, fig. 12: nearly real without rotation, far from it with rotation."""
    still = replace(kang, gyroscopic=None, radial_dissipation=None, negative_slope=None)
    found = []
    for model in (still, kang):
        modes = complex_modes(model, at(model, 5.0, 0.3)).modes
        found.append(nearest_exceptional_point(model, at(model, 5.0, 0.3),
                                               modes=(modes[12], modes[13])))
    assert all(m.converged for m in found)
    assert found[0].value.real == pytest.approx(0.348, abs=0.01)
    assert abs(found[0].value.imag) < 2e-3
    assert abs(found[1].value.imag) > 0.1
    # the roots are power series of friction up to there: frequencies meet at the value
    close = complex_modes(still, at(still, 5.0, found[0].value.real)).modes
    apart = abs(modes[12].eigenvalue - modes[13].eigenvalue)
    assert abs(close[12].eigenvalue - close[13].eigenvalue) < 0.1 * apart


def test_a_band_of_one_mode() -> None:
    with pytest.raises(OperatingPointError, match='no two modes'):
        nearest_exceptional_point(coupled((0.0, 0.0)), POINT, band_hz=(1.0, 2.0))
    modes = complex_modes(coupled((0.0, 0.0)), POINT).modes
    with pytest.raises(OperatingPointError, match='the two are one'):
        nearest_exceptional_point(coupled((0.0, 0.0)), POINT, modes=(modes[0], modes[0]))
