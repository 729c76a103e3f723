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

"""Advice in turn: computed a few milliseconds a tick, published, kept for the diagnostics."""

from collections.abc import Callable, Mapping, Sequence
import math

from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.force_split import SplitAdvice, SplitSteps
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.monitor.tick_turns import is_due
from squeal_core.monitor.vehicle_advice import VehicleAdvice
from squeal_ros.node.messages import ADVICE, FRONT_SHARE

_STEPS = 13  # of a search for the split, of each brake
_SEARCH = 2.0  # s, that it takes


class AdviceReports:
    """
    Computes advice on each brake once in a period of the diagnostics, at ticks of absolute time.

    The split is searched for once in `margin_confirm_interval`, when all brakes slide, over some
    seconds: a step or a few at each tick that evaluates no risks, as those that do take longest.

    Parameters
    ----------
    settings : MonitorSettings
    advice : VehicleAdvice
    publish : callable
        Takes a brake, or '' for the vehicle, the name of a topic and its value.

    """

    def __init__(self, settings: MonitorSettings, advice: VehicleAdvice,
                 publish: Callable[[str, str, float], None]) -> None:
        self._publish = publish
        self.update_settings(settings, advice)

    def update_settings(self, settings: MonitorSettings, advice: VehicleAdvice) -> None:
        """Apply other settings, and discard the advice by earlier ones."""
        self._advice, self._turns = advice, len(settings.brakes) + 1
        self._period, self._interval = settings.period, round(1e9 / settings.diagnostics_rate)
        self._at_once = math.ceil(
            _STEPS * len(settings.brakes) * 1e-9 * settings.period / _SEARCH)
        # 0 where every tick evaluates risks: the search does not wait then
        self._risk_interval = (
            settings.risk_interval if settings.risk_interval > settings.period else 0)
        self._pause = round(1e9 * settings.margin_confirm_interval)
        self._steps: SplitSteps | None = None
        self._began: int | None = None  # the last search [ns]
        self._of_brakes: dict[str, Mapping[str, object]] = {}
        self._of_vehicle: Mapping[str, object] = {}

    def of_brake(self, name: str) -> Mapping[str, object]:
        """Return the newest advice on a brake, as values of its diagnostics."""
        return self._of_brakes.get(name, {})

    def of_vehicle(self) -> Mapping[str, object]:
        """Return the newest advice on the split, as values of the node's diagnostics."""
        return self._of_vehicle

    def take(self, result: Sequence[Assessment]) -> None:
        """Compute and publish the advice that is due at a tick."""
        due = [is_due(result[0].time, self._period, self._interval, place, self._turns)
               for place in range(self._turns)]
        for one, now in zip(result, due, strict=False):
            if now:
                self._advise(one)
        if due[-1] and self._steps is None and self._may_search(result):
            self._steps = self._advice.split(result)
        if not is_due(result[0].time, self._period, self._risk_interval):
            self._search()

    def _search(self) -> None:
        """Continue the search for the split."""
        for _ in range(self._at_once):
            if self._steps is None:
                break
            try:
                next(self._steps)
            except StopIteration as done:
                self._take_split(done.value)

    def _may_search(self, result: Sequence[Assessment]) -> bool:
        """Return whether the split is not known, which costs nothing, or is due."""
        if any(one.state != 'steady' for one in result):
            return True
        now, began = result[0].time, self._began
        if not self._pause or (began is not None and 0 <= now - began < self._pause):
            return False
        self._began = now
        return True

    def forget(self, brakes: Sequence[str]) -> None:
        """Publish that nothing is known."""
        self._of_brakes, self._of_vehicle, self._steps = {}, {}, None
        for name in brakes:
            for topic in ADVICE:
                self._publish(name, topic, math.nan)
        self._publish('', FRONT_SHARE, math.nan)

    def _advise(self, one: Assessment) -> None:
        advice = self._advice.pressures(one)
        for topic, value in zip(ADVICE, (advice.below, advice.above), strict=True):
            self._publish(one.brake, topic, value)
        self._of_brakes[one.brake] = {
            'quiet_pressure_below_bar': 1e-5 * advice.below,
            'quiet_pressure_above_bar': 1e-5 * advice.above,
            'quiet_confidence_below': advice.confidence_below,
            'quiet_confidence_above': advice.confidence_above,
            'quiet_pressure_confirmed': advice.confirmed, 'quiet_pressure_reason': advice.reason}

    def _take_split(self, advice: SplitAdvice) -> None:
        self._steps = None
        self._publish('', FRONT_SHARE, advice.front_share)
        self._of_vehicle = {
            'split_front_share': advice.front_share, 'split_present_share': advice.present,
            'split_basis': advice.basis, 'split_least': advice.least, 'split_gain': advice.gain,
            'split_confidence': advice.confidence, 'split_confirmed': advice.confirmed,
            'split_reason': advice.reason}
