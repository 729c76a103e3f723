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

"""Compares a growth emulator with full solutions: its error when built, its audits when used."""

import math

import numpy as np
from scipy.optimize import linear_sum_assignment
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.growth_emulator import GrowthEmulator, points_at
from squeal_core.stability.eigensolution import eigenvalues, SQUEAL_BAND

MATTERS = -30.0  # 1/s; modes of smaller growth rates do not build up
LARGE = 100.0  # 1/s; modes that grow faster saturate within a tenth of a second


def growth_differences(emulator: GrowthEmulator, inputs: FloatArray) -> FloatArray:
    """
    Return emulated growth rates minus those of a full solution at one row of inputs (6,) [1/s].

    One for each mode of the squeal band between -30 and 100 1/s, each compared with another one.
    """
    truth = eigenvalues(emulator.model, points_at(emulator.model, inputs[None])[0])
    low, high = (2.0 * np.pi * end for end in SQUEAL_BAND)
    truth = truth[(truth.imag >= low) & (truth.imag <= high) & (truth.real > MATTERS)]
    ours = emulator.eigenvalues(inputs[None])[0]
    i, j = linear_sum_assignment(np.abs(truth[:, None] - ours))
    off: FloatArray = (ours[j] - truth[i]).real[truth[i].real < LARGE]
    return off


def audit(emulator: GrowthEmulator, inputs: FloatArray) -> float:
    """
    Return by how much the emulator is off at one row of inputs (6,), from a full solution [1/s].

    NaN outside the domain; 0 where no mode of the band comes near to growing.
    """
    if not emulator.domain.covers(inputs):
        return math.nan
    return float(np.abs(growth_differences(emulator, inputs)).max(initial=0.0))
