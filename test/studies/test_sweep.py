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

"""Sweeps against solves at single points: values, options, identities, axes."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, SquealError
from squeal_core.brake.friction import FrictionLaw
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.mode_tracking import identities
from squeal_core.stability.parameter_paths import moved, PARAMETERS
from squeal_core.studies.sweep import sweep
from support.sweeps import at, FRICTIONS, PAIR, POINT, same


def test_one_parameter(kang: BrakeModel) -> None:
    """K09 fig. 10 in small: every mode at every stiffness, those that grow marked."""
    values = np.array([0.2, 1.0, 1.6]) * 0.35e11
    found = sweep(kang, at(kang), {'contact_stiffness': values})
    assert found.complete
    assert found.shape == (3,)
    for i, value in enumerate(values):
        modes = complex_modes(kang, replace(at(kang), contact_stiffness=value)).modes
        assert found.eigenvalues[i].tolist() == [m.eigenvalue for m in modes]
        assert found.kinds[i].tolist() == [m.kind for m in modes]
        assert found.frequencies_hz[i].tolist() == [m.frequency_hz for m in modes]
        assert found.unstable[i].tolist() == [m.unstable for m in modes]
        assert found.identities[i].tolist() == [str(m.index) for m in modes]
    assert np.flatnonzero(found.unstable[1]).tolist() == [12, 25]
    assert found.column('contact_stiffness').tolist() == values.tolist()
    assert found.column('friction').tolist() == [0.42] * 3


def test_two_parameters() -> None:
    """The last one runs fastest."""
    speeds = [2.0, 8.0]
    found = sweep(PAIR, POINT, {'rotor_speed': speeds, 'friction': FRICTIONS})
    assert found.shape == (2, 4)
    growth = found.largest_growth()
    for i, speed in enumerate(speeds):
        for j, friction in enumerate(FRICTIONS):
            there = replace(POINT, rotor_speed=speed, friction=friction)
            assert growth[i, j] == max(m.growth_rate for m in complex_modes(PAIR, there).modes)
            assert found.points[4 * i + j].tolist() == [
                getattr(there, name) for name in PARAMETERS]
    assert (growth > 0.0).tolist() == [[False, False, True, True]] * 2
    assert np.all(np.isneginf(found.largest_growth(1.0, 2.0)))


def test_without_rotation(kang: BrakeModel) -> None:
    """G, R and S off; not so without the option."""
    still = replace(kang, gyroscopic=None, radial_dissipation=None, negative_slope=None)
    point = replace(at(kang), friction_slope=-0.05)
    values = {'friction': [0.3, 0.5]}
    found = sweep(kang, point, values, rotation=False)
    assert same(replace(found, about={}), replace(sweep(still, point, values), about={}))
    assert not np.array_equal(found.eigenvalues, sweep(kang, point, values).eigenvalues)
    assert found.about['rotation'] is False


def test_with_the_friction_law(kang: BrakeModel) -> None:
    """K09 fig. 15: speed sets friction and slope."""
    assert kang.caliper is not None
    found = sweep(kang, at(kang), {'rotor_speed': [2.0, 10.0]}, friction_law=True)
    for i, speed in enumerate((2.0, 10.0)):
        point = kang.operating_point(rotor_speed=speed,
                                     pressure=2000.0 / kang.caliper.piston_area)
        assert found.points[i] == pytest.approx([getattr(point, p) for p in PARAMETERS], rel=1e-12)
    torsion = found.eigenvalues.real[:, 11]
    assert torsion[0] > torsion[1] > 0.0
    assert (found.kinds[:, 0] == 'divergence').all()


def test_friction_takes_its_slope_along() -> None:
    point = replace(POINT, friction_slope=-0.1)
    found = sweep(PAIR, point, {'friction': FRICTIONS})
    assert found.column('friction_slope') == pytest.approx(-np.array(FRICTIONS), abs=1e-15)
    both = sweep(PAIR, point, {'friction_slope': [-0.3], 'friction': FRICTIONS})
    assert both.column('friction_slope').tolist() == [-0.3] * 4
    assert both.column('friction').tolist() == FRICTIONS


def test_tracked_identities(kang: BrakeModel) -> None:
    """K09 fig. 12: from no friction on, and merged without rotation."""
    values = np.linspace(0.0, 0.5, 6)
    found = sweep(kang, at(kang), {'friction': values}, tracked=True)
    assert found.identities[0].tolist() == [str(i) for i in range(1, 93)]
    assert found.identities[-1].tolist() == [
        str(i) for i in identities(kang, moved(kang, at(kang), 'friction', 0.5))]
    roots = found.of(13)
    assert np.abs(np.diff(roots)).max() < 40.0
    assert roots.real[0] < 0.0 < roots.real[-1]
    free = sweep(kang, at(kang), {'friction': values}, tracked=True, rotation=False)
    assert '13/14' in free.identities[-1]
    # of a merged pair the lower number is the one that grows
    assert free.of(13)[-1].real > 0.0 > free.of(14)[-1].real
    assert free.of(13)[-1].imag == pytest.approx(free.of(14)[-1].imag, rel=1e-4)
    assert np.isnan(free.of(93)).all()


def test_each_line_of_a_grid_is_tracked_by_itself() -> None:
    found = sweep(PAIR, POINT, {'contact_stiffness': [1e9, 1e10], 'friction': FRICTIONS},
                  tracked=True)
    assert found.identities.tolist() == [['1', '2']] * 6 + [['1/2', '1/2']] * 2


def test_slope_by_the_law_and_friction_as_given(kang: BrakeModel) -> None:
    """Expect mu' at each speed, scaled to the friction there; forwards and backwards alike."""
    assert isinstance(kang.friction_law, FrictionLaw)
    for way in (1.0, -1.0):
        found = sweep(kang, replace(at(kang), rotor_speed=way, friction=way * 0.42),
                      {'friction': way * np.array([0.2, 0.5]), 'rotor_speed': [way, 9.0 * way]},
                      friction_law='slope')
        assert found.column('friction').tolist() == [0.2 * way, 0.2 * way, 0.5 * way, 0.5 * way]
        for point, slope in zip(found.points, found.column('friction_slope'), strict=True):
            speed = abs(point[0]) * kang.contact_radius
            fall = 0.18 * np.exp(-speed)
            assert slope == pytest.approx(-fall / (0.32 + fall) * abs(point[1]), rel=1e-12)
    with pytest.raises(SquealError, match='it gives friction_slope'):
        sweep(kang, at(kang), {'friction_slope': [-0.1]}, friction_law='slope')


@pytest.mark.parametrize('first', [0.0, 0.3])
def test_a_merging_is_one_wherever_the_path_begins(first: float, kang: BrakeModel) -> None:
    """The third doublet without rotation: apart up to 0.348, one pair from there."""
    found = sweep(kang, at(kang), {'friction': [first, 0.33, 0.4, 0.5]}, tracked=True,
                  rotation=False)
    assert found.names(13).tolist() == ['13', '13', '13/14', '13/14']
    assert found.merged(14).tolist() == [False, False, True, True]
    assert found.names(93).tolist() == [''] * 4


@pytest.mark.parametrize(('axes', 'text'), [
    ({}, 'one or two'), ({'mu': [0.1]}, r"\['mu'\]"), ({'friction': []}, 'lists of values'),
    (dict.fromkeys(PARAMETERS[:3], [1.0]), 'one or two'), ({'friction': [[0.1]]}, 'shapes'),
    ({'rotor_speed': [0.0]}, 'rotor_speed is 0')])
def test_axes_that_cannot_be_meant(axes: dict[str, Any], text: str) -> None:
    with pytest.raises(SquealError, match=text):
        sweep(PAIR, POINT, axes)


def test_a_law_that_is_swept_over(kang: BrakeModel) -> None:
    with pytest.raises(SquealError, match='friction_law'):
        sweep(kang, at(kang), {'friction': [0.1]}, friction_law=True)
    with pytest.raises(SquealError, match='friction_law'):
        sweep(PAIR, POINT, {'rotor_speed': [1.0]}, friction_law=True)
