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

"""Friction slope and contact stiffness by a model's laws, at arrays of operating points."""

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel


def sliding_laws(model: BrakeModel, rotor_speed: FloatArray, contact_pressure: FloatArray,
                 friction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """
    Return friction slope [s/m] and contact stiffness [N/m^3], as `BrakeModel.operating_point`.

    Parameters
    ----------
    model : BrakeModel
        Its friction law, scaled to the friction, and its stiffness table; without them the slope
        is zero and the stiffness nominal.
    rotor_speed, contact_pressure, friction : arrays of one shape
        [rad/s], [Pa], [-].

    """
    law, table = model.friction_law, model.stiffness_table
    slope = np.zeros_like(friction) if law is None else (
        friction * law.relative_slope(model.contact_radius * rotor_speed))
    stiffness = (np.full_like(contact_pressure, model.nominal_contact_stiffness)
                 if table is None else np.asarray(table(contact_pressure)))
    return slope, stiffness
