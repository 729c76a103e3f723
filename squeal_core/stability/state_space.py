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

"""First-order form of the equation of motion, and its largest frequency."""

import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel


def frequency_scale(model: BrakeModel, point: OperatingPoint | None = None) -> float:
    """
    Return the largest angular frequency without contact [rad/s], the unit of tolerances.

    Of a model that has stiffness by contact alone: that at the point, or with nominal contact
    stiffness; without any stiffness, the norm of the damping.
    """
    if model.largest_frequency > 0.0:
        return model.largest_frequency
    if point is not None:
        stiffness = float(np.linalg.norm(model.stiffness(point), 2))
        return math.sqrt(stiffness) or float(np.linalg.norm(model.damping(point), 2))
    if model.contact_stiffness is None:
        return 0.0
    return math.sqrt(model.nominal_contact_stiffness
                     * float(np.linalg.norm(model.contact_stiffness, 2)))


def state_matrix(model: BrakeModel, damping: FloatArray, stiffness: FloatArray) -> FloatArray:
    """
    Return the first-order form without the coordinates that have no stiffness.

    Its states are the coordinates with stiffness, then the velocities of all.
    """
    moving = np.logical_not(model.free_coordinates)
    held = int(np.count_nonzero(moving))
    state = np.zeros((held + model.size, held + model.size))
    state[:held, held:] = np.eye(model.size)[moving]
    state[held:, :held] = -stiffness[:, moving]
    state[held:, held:] = -damping
    return state
