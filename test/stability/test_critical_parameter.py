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

"""Critical values along rays of parameters: closed forms, independent solves and K09's figures."""

from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.errors import OperatingPointError
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import eigenvalues, Tolerances
from squeal_core.stability.parameter_paths import moved
from support.stability_models import fluttering, kang_point, POINT, W1, W2


def test_critical_friction() -> None:
    model = fluttering(couple=1e-3)
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
    found = critical_value(fluttering(4e-4, 1e-3), replace(POINT, contact_stiffness=start),
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


def test_brackets_hold_by_independent_solves(kang: BrakeModel) -> None:
    found = critical_value(kang, kang_point(kang, 5.0), 'friction', (0.0, 1.0), numbers=(13, 14))
    crossing = found.below
    assert crossing.bracket[1] < crossing.value < crossing.bracket[0] < 0.42
    for value, growth in zip(crossing.bracket, crossing.growth_rates, strict=True):
        roots = eigenvalues(kang, kang_point(kang, 5.0, value))
        nearest = roots[np.abs(roots.imag / 2.0 / math.pi - crossing.frequency_hz).argmin()]
        assert nearest.real == pytest.approx(growth, abs=1e-8)
    assert crossing.growth_rates[0] > Tolerances.of(kang).growth >= crossing.growth_rates[1]
    assert crossing.reason == 'stability boundary mu = 0.3749 (1660 Hz), stable below'
    assert crossing.solves < 12  # 2 steps, and 15 by bisection


def test_a_mode_that_enters_the_band_is_no_crossing() -> None:
    """Flutter whose frequency rises into the band as it grows: the rate jumps there."""
    model = fluttering(couple=1e-3, stiffening=1e-3)
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
    found = critical_value(kang, kang_point(kang, 5.0), 'friction', (0.1, 0.9), numbers=(12,),
                           samples=8)
    for crossing in (found.below, found.above):
        assert math.isnan(crossing.value)
        assert math.isnan(crossing.frequency_hz)
        assert not crossing.converged
        assert crossing.reason.startswith('no stability boundary from mu = 0.42 to 0.')
        assert max(crossing.growth_rates) < 0.0
    assert found.nearest is found.above


def test_a_start_at_a_bound() -> None:
    point = replace(POINT, contact_stiffness=1e10, friction=0.0)
    found = critical_value(fluttering(couple=1e-3), point, 'friction', (0.0, 1.0))
    assert found.above.converged
    assert found.below.bracket == (0.0, 0.0)
    assert math.isnan(found.below.value)


@pytest.mark.parametrize('bounds', [(0.6, 1.0), (0.0, 0.4), (0.5, 0.5)])
def test_bounds_that_leave_the_point_out(bounds: tuple[float, float]) -> None:
    with pytest.raises(OperatingPointError, match=r'friction is 0\.5'):
        critical_value(fluttering(1e-3), POINT, 'friction', bounds)


def test_parameters_there_are_not() -> None:
    with pytest.raises(OperatingPointError, match='parameter is mu'):
        critical_value(fluttering(1e-3), POINT, 'mu', (0.0, 1.0))
    with pytest.raises(OperatingPointError, match='1 to 2'):
        critical_value(fluttering(1e-3), POINT, 'friction', (0.0, 1.0), numbers=(2, 3))


@pytest.mark.parametrize(('numbers', 'rotating', 'free'), [
    ((13, 14), 0.375, 0.360), ((25, 26), 0.0405, 0.1056), ((18, 19), 0.460, 0.1465)])
def test_critical_friction_of_k09(numbers: tuple[int, int], rotating: float, free: float,
                                  kang: BrakeModel) -> None:
    """Figs 11 and 12 at 5 rad/s: rotation stabilises doublets, and destabilises the pads' pair."""
    still = replace(kang, gyroscopic=None, radial_dissipation=None, negative_slope=None)
    for model, expected in ((kang, rotating), (still, free)):
        found = critical_value(model, kang_point(model, 5.0), 'friction', (0.0, 1.0),
                               numbers=numbers, tolerance=1e-4)
        # growth rates are good to 0.5 1/s, the pads' pair's to 2 (the data's note)
        assert found.nearest.value == pytest.approx(expected, abs=0.01)
        assert found.nearest.converged


@pytest.mark.parametrize(('numbers', 'speed'), [((13, 14), 3.16), ((18, 19), 5.09), ((12,), 10.8)])
def test_critical_speed_of_k09(numbers: tuple[int, ...], speed: float, kang: BrakeModel) -> None:
    """Fig. 15: doublets are stable below a speed, torsion above one."""
    def ray(value: float) -> OperatingPoint:
        return moved(kang, kang_point(kang, 5.0), 'rotor_speed', value, friction_law=True)

    found = critical_value(kang, ray(8.0), 'rotor_speed', (1.0, 20.0), numbers=numbers, ray=ray,
                           tolerance=1e-4)
    assert found.growth_rate > 0.0
    assert found.nearest.value == pytest.approx(speed, rel=0.05)
    assert found.nearest is (found.above if numbers == (12,) else found.below)
