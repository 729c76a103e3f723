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

"""Cartesian components of modes -> polar ones, theta derivatives included."""

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.modal_basis import Quadrature, SampledShapes


def polar(field: FloatArray, turned: FloatArray, points: Quadrature) -> SampledShapes:
    """Return polar components of Cartesian ones (3, N, P), and of (x d/dy - y d/dx) of them."""
    c, s = np.cos(points.angle), np.sin(points.angle)
    radial, tangential = c * field[0] + s * field[1], c * field[1] - s * field[0]
    return SampledShapes(
        radial, tangential, field[2], radial_dtheta=c * turned[0] + s * turned[1] + tangential,
        tangential_dtheta=c * turned[1] - s * turned[0] - radial, normal_dtheta=turned[2],
        points=points)
