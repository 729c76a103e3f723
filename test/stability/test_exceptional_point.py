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

"""Where two modes merge, and how far that is: closed forms and K09's third doublet."""

from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.errors import OperatingPointError
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.exceptional_point import nearest_exceptional_point
from support.stability_models import fluttering, kang_point, POINT, SKEW, W1, W2

EVERY = (0.0, 1e5)  # Hz


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
    found = nearest_exceptional_point(fluttering(1e-4, 1e-3, damping=0.0),
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
        modes = complex_modes(model, kang_point(model, 5.0, 0.3)).modes
        found.append(nearest_exceptional_point(model, kang_point(model, 5.0, 0.3),
                                               modes=(modes[12], modes[13])))
    assert all(m.converged for m in found)
    assert found[0].value.real == pytest.approx(0.348, abs=0.01)
    assert abs(found[0].value.imag) < 2e-3
    assert abs(found[1].value.imag) > 0.1
    # the roots are power series of friction up to there: frequencies meet at the value
    close = complex_modes(still, kang_point(still, 5.0, found[0].value.real)).modes
    apart = abs(modes[12].eigenvalue - modes[13].eigenvalue)
    assert abs(close[12].eigenvalue - close[13].eigenvalue) < 0.1 * apart


def test_what_cannot_merge() -> None:
    with pytest.raises(OperatingPointError, match='no two modes'):
        nearest_exceptional_point(coupled((0.0, 0.0)), POINT, band_hz=(1.0, 2.0))
    modes = complex_modes(coupled((0.0, 0.0)), POINT).modes
    with pytest.raises(OperatingPointError, match='the two are one'):
        nearest_exceptional_point(coupled((0.0, 0.0)), POINT, modes=(modes[0], modes[0]))
    with pytest.raises(OperatingPointError, match='give one of friction'):
        nearest_exceptional_point(coupled((0.0, 0.0)), POINT, 'rotor_speed')
