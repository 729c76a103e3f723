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

"""Squeal risk of a brake at a tick, by the model's modes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
import math

import numpy as np
from squeal_core.risk.risk_records import RiskResult
from squeal_core.stability.eigensolution import Mode


@dataclass(frozen=True, eq=False, kw_only=True)
class BrakeRisk:
    """
    Squeal risk of a brake that slides under load.

    Parameters
    ----------
    result : RiskResult
        Numbers that are not known are NaN.
    places : mapping
        Place in `result.family_build_up` of each mode number.
    modes : tuple of int
        Numbers of the modes that most probably squeal.
    unknown : str
        Why the squeal risk is not known; empty where it is.

    """

    result: RiskResult
    places: Mapping[int, int] = field(default_factory=dict)
    modes: tuple[int, ...] = ()
    unknown: str = ''

    def build_ups(self, modes: Iterable[Mode]) -> tuple[float, ...]:
        """Return the build-up of the family of each mode [nepers], NaN where it is in none."""
        known = self.result.family_build_up.tolist()
        return tuple([known[self.places[mode.index]] if mode.index in self.places else math.nan
                      for mode in modes])


def unknown_risk(instability_probability: float, basis: str, unknown: str) -> BrakeRisk:
    """Return the risk of a brake without growth rates of an ensemble."""
    return BrakeRisk(unknown=unknown, result=RiskResult(
        squeal_risk=math.nan, error=math.nan, peak_risk=math.nan,
        instability_probability=instability_probability, build_up=math.nan,
        family_build_up=np.empty(0), time_to_squeal=math.nan, family=-1, frequency_hz=math.nan,
        calibrated=False, incomplete=False, basis=basis))
