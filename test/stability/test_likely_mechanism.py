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

"""The label of a mode from its vectors, beside the one by following the mode."""

import pytest
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND
from squeal_core.stability.likely_mechanism import LikelyMechanism
from squeal_core.stability.mechanism import mechanisms


@pytest.mark.parametrize(('speed', 'pressure', 'friction', 'label'), [
    (26.0, 3.1e6, 0.56, 'gyroscopic'), (6.0, 2.6e6, 0.31, 'negative slope'),
    (20.0, 7.84e5, 0.42, 'mode coupling')])
def test_the_label_of_mechanisms(speed: float, pressure: float, friction: float, label: str,
                                 kang: BrakeModel) -> None:
    point = kang.operating_point(rotor_speed=speed, pressure=pressure, friction=friction)
    worst = complex_modes(kang, point).worst_in(*SQUEAL_BAND)
    assert worst is not None
    likely = LikelyMechanism(kang)
    assert likely.label(point, worst.eigenvalue) == label
    assert mechanisms(kang, point, [worst])[0].label == label
    assert likely.label(point, worst.eigenvalue - 1e3) == 'stable'
