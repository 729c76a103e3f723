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

"""The disc's doublet that leads a mode, and how far masses on the disc split that one."""

from dataclasses import replace
import math

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.studies.split_doublet import ModeOverAngle, PAIR, SplitDoublet


def led_doublet(masses: SplitDoublet, point: OperatingPoint,
                mode: ModeOverAngle) -> tuple[int, float] | None:
    """
    Return nodal diameters of the doublet, and by how much the masses split it [Hz].

    Parameters
    ----------
    masses : SplitDoublet
        Of any doublet.
    point : OperatingPoint
        Of the mode.
    mode : ModeOverAngle
        Its eigenvalue without masses is looked at.

    Returns
    -------
    tuple of int and float, or None
        None where a pad leads, or a mode of the disc that has no partner.

    """
    ring, model = masses.ring, masses.model
    eigenvalue = complex(mode.without, math.tau * mode.frequency_hz)
    lead = np.abs(mode_vectors(model, point, eigenvalue).right).argmax()
    if lead not in ring.places:
        return None
    order = ring.diameters
    frequencies = model.angular_frequencies
    own = int(order[ring.places == lead][0])
    pair = np.flatnonzero((order == own) & (
        np.abs(frequencies[ring.places] - frequencies[lead]) < PAIR * frequencies[lead]))
    if pair.size != 2:
        return None
    first, second = replace(masses, doublet=(int(pair[0]), int(pair[1]))).frequencies_hz
    return own, second - first
