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

"""Sweeps of a pair of modes that flutters, small enough for tests."""

from typing import Any

import numpy as np
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_record import Sweep

SKEW = np.array([[0.0, 1e-3], [-1e-3, 0.0]])
# K = diag(w^2) + mu k_c SKEW: flutter from mu = 0.202 on at POINT
PAIR = BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=[1e-4, 1e-4 / 1.02],
                  friction_couple=SKEW, nominal_contact_stiffness=1e10,
                  gyroscopic=1e-3 * SKEW, radial_dissipation=1e-4 * np.eye(2))
POINT = OperatingPoint(rotor_speed=5.0, friction=0.1, contact_pressure=1e5, contact_stiffness=1e10)
FRICTIONS = [0.0, 0.1, 0.3, 0.6]


def at(model: BrakeModel, speed: float = 5.0) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=0.42, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


def same(one: Sweep, other: Sweep) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=name[0] != 'k'
                              and name != 'identities')
               for name in ('points', 'eigenvalues', 'kinds', 'identities')) and (
        one.about == other.about and list(one.axes) == list(other.axes)
        and all(np.array_equal(one.axes[k], other.axes[k]) for k in one.axes))


def interrupted(count: int, **options: Any) -> Sweep:
    def progress(done: int, _: int) -> None:
        if done == count:
            raise KeyboardInterrupt

    values = {'friction': np.linspace(0.0, 0.9, 20)}
    return sweep(PAIR, POINT, values, progress=progress, **options)
