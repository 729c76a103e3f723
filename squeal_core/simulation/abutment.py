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


"""The caliper's abutment, which K09 lacks: what keeps pads from drifting away in plane."""

from dataclasses import dataclass

import numpy as np
from squeal_core.brake.operating_point import OperatingPoints
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel

_SPRING = 200.0  # rad/s
_CALM = 500.0  # 1/s of dashpot and relaxation where nothing diverges


@dataclass(frozen=True, eq=False)
class Abutment:
    """
    Spring and Maxwell element on each coordinate without stiffness, a pad's rigid motion in plane.

    Such a pad drifts off by the mean force of a limit cycle, and diverges by a negative slope
    (K09 section 4). Dashpot c and relaxation rate w follow the rate of divergence s: c = w =
    2 s + 500 1/s. In the squeal band the abutment is a spring of c w, far softer than the contact.

    Parameters
    ----------
    coordinates : (M,) array
        Their indices in the model.
    slope : float
        S [m^2/kg] with which they diverge at a rate of -p0 mu_v S.

    """

    coordinates: IndexArray
    slope: float

    @classmethod
    def of(cls, model: BrakeModel) -> 'Abutment | None':
        """Return the abutment of a model; None where every coordinate has stiffness."""
        free = np.flatnonzero(model.free_coordinates)
        if free.size == 0:
            return None
        slope = model.negative_slope
        return cls(free, 0.0 if slope is None else
                   float(np.linalg.norm(slope[np.ix_(free, free)], 2)))

    def damping(self, points: OperatingPoints) -> FloatArray:
        """Return c = w [1/s] at the operating points of B brakes, (B,)."""
        divergence = np.maximum(-points.contact_pressure * points.friction_slope, 0.0) * self.slope
        return np.asarray(2.0 * divergence + _CALM)

    def force(self, a: FloatArray, rate: FloatArray, relaxed: FloatArray,
              damping: FloatArray | float, step: float) -> FloatArray:
        """
        Return the forces (M, B) on the coordinates.

        `relaxed` (M, B), the rates of the relaxing dashpots, is advanced by a step.
        """
        relaxed += (step * damping) * (rate - relaxed)
        return np.asarray(-damping * relaxed - _SPRING**2 * a)
