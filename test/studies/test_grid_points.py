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

"""Points of a grid are those that are set one by one."""

from itertools import product

import pytest
from squeal_core import BrakeModel
from squeal_core.stability.parameter_paths import Law
from squeal_core.studies.point_options import grid_points, point_with, PointOptions


@pytest.mark.parametrize('law', [False, True, 'slope'])
def test_each_is_the_point_with_its_values(kang: BrakeModel, law: Law) -> None:
    """The last axis runs fastest; a slope that is swept is not carried along by the friction."""
    base = PointOptions(rotor_speed=5.0, friction=0.4, friction_slope=-0.1).at(kang)
    axes = {'contact_stiffness': [2e10, 3e10], 'friction_slope': [-0.2, 0.0, 0.1],
            'rotor_speed': [2.0, 4.0], 'friction': [0.3, 0.5], 'preload': [500.0, 900.0]}
    points, reason = grid_points(kang, base, axes, law)
    assert (len(points), reason) == (48, '')
    assert points == [point_with(kang, base, dict(zip(axes, values, strict=True)), law)
                      for values in product(*axes.values())]


def test_impossible_points_keep_their_places(kang: BrakeModel) -> None:
    base = PointOptions(rotor_speed=5.0, friction=0.4).at(kang)
    points, reason = grid_points(kang, base, {'friction': [0.3, 0.4], 'rotor_speed': [0.0, 2.0]},
                                 False)
    assert [point is None for point in points] == [True, False, True, False]
    assert 'rotor_speed is 0 rad/s' in reason


def test_without_an_axis_there_is_one_point(kang: BrakeModel) -> None:
    base = PointOptions(rotor_speed=5.0, friction=0.4).at(kang)
    assert grid_points(kang, base, {}, False) == ([base], '')
