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

"""With which mode another one couples by friction."""

import numpy as np
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.stability.coupling import FrictionCoupling
from support.stability_models import kang_point


def test_the_partner_is_coupled_by_friction_and_not_only_near() -> None:
    couple = np.zeros((3, 3))
    couple[0, 2], couple[2, 0] = 2e-3, -2e-3
    model = BrakeModel(angular_frequencies=[1e4, 1.001e4, 1.03e4], damping_ratios=0.002,
                       friction_couple=couple)
    point = OperatingPoint(rotor_speed=7.0, friction=0.1, contact_pressure=5e5,
                           contact_stiffness=1e10)
    modes = complex_modes(model, point).modes
    _, one, other = modes  # friction has drawn the two of the pair together
    coupling = FrictionCoupling(model, point, modes)
    assert coupling.partner(one) is other
    assert coupling.partner(other) is one
    assert FrictionCoupling(model, point, [one]).partner(one) is None


def test_the_pair_of_the_paper_is_found_from_either_side(kang: BrakeModel) -> None:
    """K09 fig. 12: modes 13 and 14 merge."""
    point = kang_point(kang, 20.0)
    modes = complex_modes(kang, point).modes
    one, other = modes[12], modes[13]
    coupling = FrictionCoupling(kang, point, modes)
    assert coupling.partner(one) is other
    assert coupling.partner(other) is one
