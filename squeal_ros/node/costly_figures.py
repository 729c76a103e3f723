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

"""Figures of brakes that take a large fraction of a tick: a few of them at each tick."""

from collections.abc import Sequence, Set
import math

from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.vehicle_monitor import Assessment
from squeal_ros.node import messages


class CostlyFigures:
    """
    The figures `messages.COSTLY` of brakes, each from the assessment of the tick that computes it.

    Parameters
    ----------
    settings : MonitorSettings
        A brake's figures take at most its share of the period of diagnostics.

    """

    def __init__(self, settings: MonitorSettings) -> None:
        self.forget()
        self.update_settings(settings)

    def update_settings(self, settings: MonitorSettings) -> None:
        """Apply other settings from the next tick on."""
        statuses = len(settings.brakes) + 1
        ticks = max(settings.rate / settings.diagnostics_rate, 1.0)
        self._at_once = math.ceil(len(messages.COSTLY) * statuses / ticks)

    def forget(self) -> None:
        """Discard incomplete figures."""
        self._waiting: dict[int, list[str]] = {}
        self._found: dict[int, dict[str, object]] = {}

    def begin(self, places: Set[int]) -> None:
        """Start to compute the figures of brakes from this tick on, unless that is under way."""
        for place in sorted(places - self._waiting.keys()):
            self._waiting[place], self._found[place] = list(messages.COSTLY), {}

    def compute(self, assessments: Sequence[Assessment]) -> dict[int, dict[str, object]]:
        """Compute a few figures at a tick; return those of brakes that have them all."""
        done = {}
        for _ in range(self._at_once):
            if not self._waiting:
                break
            place, names = next(iter(self._waiting.items()))
            self._found[place] |= messages.costly_figure(assessments[place], names.pop(0))
            if not names:
                del self._waiting[place]
                done[place] = self._found.pop(place)
        return done
