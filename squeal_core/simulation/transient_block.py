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

"""What a transient yields of some ms, and what it keeps from step to step."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, IndexArray, repr_with_shapes


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """
    Energy [J] at the end of a block and the work [J] of each part since its start, (B,) each.

    At constant inputs the change of energy is the sum of the works: `friction` + `abutment` +
    `noise` - `dissipation`.
    """

    energy: FloatArray
    friction: FloatArray
    abutment: FloatArray
    noise: FloatArray
    dissipation: FloatArray


@dataclass(frozen=True, eq=False)
class TransientBlock:
    """
    Some ms of a transient.

    Parameters
    ----------
    time : (F,) array
        Of the samples [s].
    displacement, velocity : (F, N, B) arrays
        Modal coordinates [m kg^1/2] and their rates [m/s kg^1/2].
    sliding : (B,) array
        Whether each brake slid under load; the others are at rest, or ended.
    balance : EnergyBalance
        NaN unless asked for.

    """

    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    sliding: NDArray[np.bool_]
    balance: EnergyBalance

    __repr__ = repr_with_shapes


@dataclass
class Motion:
    """Of some brakes: state (2N, b), last two kicks by forces alone, rates of the abutment."""

    state: FloatArray
    kick: FloatArray
    relaxed: FloatArray

    def of(self, brakes: IndexArray) -> 'Motion':
        """Return a copy of that of some of the brakes."""
        return Motion(*(np.ascontiguousarray(part[..., brakes]) for part in (
            self.state, self.kick, self.relaxed)))

    def put(self, brakes: IndexArray, part: 'Motion') -> None:
        """Set that of some of the brakes."""
        self.state[:, brakes], self.kick[..., brakes] = part.state, part.kick
        self.relaxed[:, brakes] = part.relaxed
