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

"""Domain, error and results of a growth emulator."""

from dataclasses import dataclass
import math
from typing import Any, NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class EmulatorDomain:
    """
    Inputs that an emulator covers: a box without its steepest corner.

    Parameters
    ----------
    low, high : (6,) arrays
        Ends of the inputs, in the order of `INPUTS`.
    steepest : float
        p0 mu / Omega [Pa s] up to which it is covered; beyond, the brake creeps under full load.

    """

    low: FloatArray
    high: FloatArray
    steepest: float = math.inf

    def covers(self, inputs: FloatArray) -> Any:
        """Return whether each row (...) of inputs (..., 6) is covered."""
        inside = ((inputs >= self.low) & (inputs <= self.high)).all(axis=-1)
        with np.errstate(over='ignore', invalid='ignore'):
            load = np.exp(inputs[..., 1] - inputs[..., 0]) * inputs[..., 2]
        return inside & (load <= self.steepest)


@dataclass(frozen=True)
class EmulatorError:
    """
    Error of growth rates above -30 1/s, by full solutions at points that no fit has seen.

    Parameters
    ----------
    rms, largest : float
        [1/s].
    points : int
        Number of full solutions.

    """

    rms: float
    largest: float
    points: int = 0


class EmulatedGrowth(NamedTuple):
    """
    Least stable mode of each family, (..., F); NaN outside the domain.

    Attributes
    ----------
    growth_rate, frequency_hz : arrays
        [1/s], [Hz].
    by_friction : array
        d growth rate / d mu, along the friction law [1/s].
    by_damping : array
        d growth rate / d ln(damping scale) [1/s].

    """

    growth_rate: FloatArray
    frequency_hz: FloatArray
    by_friction: FloatArray
    by_damping: FloatArray
