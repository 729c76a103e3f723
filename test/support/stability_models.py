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

"""Models and points that tests of stability share: random ones, two modes that merge, K09's."""

import numpy as np
from squeal_core import BrakeModel, OperatingPoint

POINT = OperatingPoint(rotor_speed=7.0, friction=0.5, friction_slope=-0.1, contact_pressure=5e5,
                       contact_stiffness=1e9)
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])
W1, W2 = 1e4, 1.02e4
MERGING = (W2**2 - W1**2) / 2.0  # of mu k_c b, for K = diag(w^2) + mu k_c b SKEW
LOAD = 0.5 * 1e9  # mu k_c at POINT


def supported_model(seed: int, size: int = 4) -> BrakeModel:
    """Return a model of all arrays, none of them small, at POINT."""
    rng = np.random.default_rng(seed)
    skew, *square = rng.standard_normal((6, size, size))
    a, r, s = (x @ x.T for x in square[:3])
    k, d = (x @ x.T for x in rng.standard_normal((2, size, size)))
    return BrakeModel(
        angular_frequencies=np.sort(rng.uniform(1e3, 1e4, size)), damping_ratios=0.01,
        gyroscopic=skew - skew.T, contact_stiffness=1e-3 * a, friction_couple=1e-3 * square[3],
        radial_dissipation=1e-4 * r, negative_slope=1e-4 * s, follower=square[4],
        support_stiffness=1e6 * k, support_damping=10.0 * d, contact_retardation_time=2e-5)


def fluttering(couple: float, stiffening: float = 0.0, damping: float = 40.0) -> BrakeModel:
    """
    Two modes of equal damping, K = diag(w1^2 + k_c stiffening, w2^2) + mu k_c couple SKEW.

    With equal damping d a root is i w where (half the split of K)^2 = -d^2 w^2, w^2 its mean:
    gap^2 + d^2 mean = (mu k_c couple)^2.
    """
    return BrakeModel(angular_frequencies=[W1, W2], friction_couple=couple * SKEW,
                      damping_ratios=[0.5 * damping / W1, 0.5 * damping / W2],
                      contact_stiffness=np.diag([stiffening, 0.0]))


def kang_point(model: BrakeModel, speed: float, friction: float = 0.42) -> OperatingPoint:
    """Return a point of K09's figures, at constant friction."""
    return OperatingPoint(rotor_speed=speed, friction=friction, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


def kang_point_by_law(model: BrakeModel, speed: float) -> OperatingPoint:
    """Return a point of K09's figures, friction and its slope being those of the law."""
    assert model.caliper is not None
    return model.operating_point(rotor_speed=speed, pressure=2000.0 / model.caliper.piston_area)
