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

"""Guards of an input, and what they say of a row of values."""

from collections.abc import Sequence

from squeal_core.monitor.inputs.plausibility import PlausibilityCheck, RpmGuard
from support.brake_monitors import SECOND

BAR, TO_RPM, LEAPS = 'bar', 'rpm', 'leaps'  # in what they say


def speeds(**changes: float) -> RpmGuard:
    return RpmGuard(**{'maximum': 400.0, 'leap': 500.0, 'ramp': 40.0, 'memory': 0.5, **changes})


def judged(guard: PlausibilityCheck, values: Sequence[float], rate: float = 100.0,
           start: float = 0.0) -> list[str]:
    said = [guard.check(round((start + i / rate) * SECOND), float(value))
            for i, value in enumerate(values)]
    return [next((word for word in (BAR, TO_RPM) if f'like {word} given' in text), text)
            for text in said]
