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

"""An emulator of growth that is linear by design, so that risks are known in closed form."""

from collections.abc import Sequence

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.emulator_records import EmulatedGrowth, EmulatorError
from squeal_core.risk.ensemble import Ensemble
from squeal_core.risk.mode_families import ModeFamily


class LinearGrowth:
    """
    Growth rates gain (mu - 0.3) - decay e^(ln damping) of independent families.

    Known up to e^2 times the nominal damping, as an emulator is inside its domain.
    """

    def __init__(self, frequency_hz: Sequence[float], decay: Sequence[float],
                 gain: Sequence[float], error: float = 0.0) -> None:
        self.families = tuple(ModeFamily((i + 1,), *one) for i, one in enumerate(
            zip(frequency_hz, decay, strict=True)))
        self.error = EmulatorError(error, 3.0 * error)
        self._frequency, self._decay, self._gain = map(np.array, (frequency_hz, decay, gain))

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
        friction, damping = inputs[..., 2:3], np.exp(inputs[..., 4:5])
        damping = np.where(damping < np.exp(2.0), damping, np.nan)
        driven = self._gain * (friction - 0.3)
        damped = self._decay * damping
        every = np.ones_like(driven - damped)
        return EmulatedGrowth(driven - damped, self._frequency * every, self._gain * every,
                              -damped * every)


def one_brake(audible: float = 5.5) -> Ensemble:
    """Return an ensemble of the nominal brake alone, without scatter."""
    return members(np.zeros((5, 1)) + [[0.0], [0.0], [0.0], [1.0], [audible]])


def members(values: FloatArray, friction_scatter: float = 0.0,
            damping_scatter: float = 0.0) -> Ensemble:
    """Return an ensemble of the rows ln damping, ln k_c, friction bias, slope scale, N*."""
    damping, stiffness, friction, slope, audible = values
    return Ensemble(damping, stiffness, friction, slope, audible, np.ones_like(audible),
                    friction_scatter, damping_scatter)
