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

"""Evaluations of a growth emulator in a run, and its comparison with full solutions."""

from dataclasses import dataclass
import math

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.risk.emulator_audit import audit
from squeal_core.risk.growth_emulator import GrowthEmulator
from squeal_core.risk.squeal_risk import SquealRisk

_ALLOWED = 2.0  # largest published errors, as they are the largest of some hundred points


@dataclass
class EmulatorStatistics:
    """Counts since the start; `worst_audit` over the largest published error."""

    evaluations: int = 0
    audits: int = 0
    mismatches: int = 0
    worst_audit: float = 0.0

    def count(self, risk: SquealRisk, point: OperatingPoint, every: int) -> None:
        """Count an evaluation; compare the emulator with a full solution at every so many."""
        self.evaluations += 1
        if not every or self.evaluations % every:
            return
        assert isinstance(risk.emulator, GrowthEmulator)
        members = risk.ensemble.inputs(point.rotor_speed, point.contact_pressure,
                                       abs(point.friction))
        off = audit(risk.emulator, members[self.audits % len(members)])
        self.audits += 1
        if not math.isnan(off):
            self.mismatches += off > _ALLOWED * risk.emulator.error.largest
            self.worst_audit = max(self.worst_audit, off / risk.emulator.error.largest)
