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

"""Probability of observations given squeal: errors of ears and labels."""

from dataclasses import dataclass, fields

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checks import check_number


@dataclass(frozen=True, kw_only=True)
class HearingModel:
    """
    Probability of observations given squeal.

    Parameters
    ----------
    detection : float
        Probability that a squeal is detected [-].
    false_alarm : float
        Probability that an application without squeal has an event [-].
    label_error : float
        Probability that an application is noted the wrong way round, as of another brake [-].
    frequency_tolerance : float
        Relative standard deviation of a measured from a predicted pitch [-].

    """

    detection: float = 0.95
    false_alarm: float = 0.02
    label_error: float = 0.02
    frequency_tolerance: float = 0.03

    def __post_init__(self) -> None:
        for item in fields(self):
            low, high = {'detection': (0.5, 1.0), 'frequency_tolerance': (0.001, 0.5)}.get(
                item.name, (0.0, 0.49))
            check_number(item.name, getattr(self, item.name), least=low, most=high)

    def heard(self, squeals: FloatArray) -> FloatArray:
        """Return the probability of an event where that of squeal is given."""
        noted = self.detection * squeals + self.false_alarm * (1.0 - squeals)
        return np.asarray(self.label_error + (1.0 - 2.0 * self.label_error) * noted)
