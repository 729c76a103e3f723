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

"""Expansions of spectra in closed form: merging, veering and exceptional points."""

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.surrogate.expansion_builder import expand_spectrum
from support.eigenvalues import companion_roots, distance
from support.engine_models import point
from support.expansions import off, series_at


def flutter_pair(couple: float = 1e-3) -> BrakeModel:
    """Two undamped modes, w^2 = 1e8 and 1.1e8, coupled as friction does."""
    return BrakeModel(angular_frequencies=np.sqrt([1e8, 1.1e8]), damping_ratios=0.0,
                      friction_couple=[[0.0, couple], [-couple, 0.0]])


@pytest.mark.parametrize('friction', [0.2, 0.49, 0.4999, 0.5001, 0.52, 0.7])
def test_flutter_of_two_modes(friction: float) -> None:
    """lambda^2 = -(mean +- sqrt(half^2 - (mu k b)^2)); they merge at mu k b = half = 5e6."""
    def at(mu: float) -> OperatingPoint:
        return point(friction=mu, contact_stiffness=1e10)

    expansion = expand_spectrum(flutter_pair(), at(0.48))
    assert expansion.sizes.tolist() == [2]
    roots = series_at(expansion, at(friction))
    split = np.emath.sqrt(5e6**2 - (friction * 1e7) ** 2)
    truth = np.emath.sqrt(-(1.05e8 + np.array([split, -split])))
    away, _ = off(expansion, roots, np.concatenate([truth, -truth]))
    # the two are 490 rad/s apart at most: the other half of the spectrum, 20,000 away, is all
    # that the series has to follow
    assert away.max() < 0.01
    assert (roots.real.max() > 1.0) == (friction > 0.5)


EXCEPTIONAL = BrakeModel(  # D = r diag(1, -1) + g [[0, 1], [-1, 0]], K = 0
    angular_frequencies=[0.0, 0.0], damping_ratios=0.0, gyroscopic=[[0.0, 1.0], [-1.0, 0.0]],
    radial_dissipation=np.diag([1.0, -1.0]))


def damped(turning: float, dissipation: float) -> OperatingPoint:
    return point(rotor_speed=turning, friction=0.5, friction_slope=0.0,
                 contact_pressure=2.0 * dissipation * turning)


@pytest.mark.parametrize('dissipation', [0.0, 8.0, 9.999, 9.999999, 10.001, 12.0, 500.0])
def test_an_exceptional_point_inside_a_block_is_exact(dissipation: float) -> None:
    """+-sqrt(r^2 - g^2): all modes are in the block, so there is nothing that it leaves out."""
    expansion = expand_spectrum(EXCEPTIONAL, damped(10.0, 8.0))
    assert expansion.sizes.tolist() == [2]
    roots = series_at(expansion, damped(10.0, dissipation))
    exact = np.emath.sqrt(dissipation**2 - 100.0) * np.array([1.0, -1.0])
    # a root of r^2 - g^2: rounding of it, 1e-15 of both squares, over the distance of the roots
    assert distance(roots, exact) <= 1e-14 * (dissipation**2 + 100.0) / max(abs(exact[0]), 1e-6)


def test_there_is_no_expansion_about_an_exceptional_point() -> None:
    """Its vectors do not span the space."""
    with pytest.raises(np.linalg.LinAlgError, match='span the space'):
        expand_spectrum(EXCEPTIONAL, damped(10.0, 10.0))


@pytest.mark.parametrize('stiffness', [1.6e10, 1.88e10, 1.95e10, 2e10, 2.05e10, 2.4e10])
@pytest.mark.parametrize(('couple', 'sizes'), [(2e-5, [2]), (2e-6, [1, 1])])
def test_veering(stiffness: float, couple: float, sizes: list[int]) -> None:
    """
    Two modes of which one stiffens: they veer at k = 2e10, and change places beyond.

    In one block they are followed through it; two blocks serve on their own side of it.
    """
    model = BrakeModel(angular_frequencies=np.sqrt([0.9e8, 1.1e8]), damping_ratios=0.0,
                       contact_stiffness=[[1e-3, couple], [couple, 0.0]])
    expansion = expand_spectrum(model, point(contact_stiffness=1.9e10))
    assert expansion.sizes.tolist() == sizes
    roots = series_at(expansion, point(contact_stiffness=stiffness))
    k = np.array([[0.9e8 + 1e-3 * stiffness, couple * stiffness], [couple * stiffness, 1.1e8]])
    exact = 1j * np.sqrt(np.linalg.eigvalsh(k))
    away, _ = off(expansion, roots, np.concatenate([exact, exact.conj()]))
    if sizes == [2]:
        assert away.max() < 0.05
        assert np.abs(roots.real).max() < 0.05
    else:
        assert (away.max() < 0.1) == (stiffness in (1.88e10, 1.95e10))


def test_two_equal_modes_that_have_nothing_to_do_with_each_other() -> None:
    model = BrakeModel(angular_frequencies=[1e4, 1e4, 3e4],
                       contact_stiffness=np.diag([0.0, 0.0, 1e-3]))
    expansion = expand_spectrum(model, point(contact_stiffness=1e10))
    at = point(contact_stiffness=1.2e10)
    away, _ = off(expansion, series_at(expansion, at), companion_roots(model, at))
    assert np.all(away < 1e-6)
