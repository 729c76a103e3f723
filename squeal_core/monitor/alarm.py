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

"""Alarm with hysteresis and a hold over a risk that flickers."""

from squeal_core.monitor.settings import MonitorSettings

_SECOND = 1_000_000_000


class Alarm:
    """
    Raised by a risk at or above a level; ends after a while below a lower one.

    A risk that is not known (NaN) raises no alarm and does not keep one up; what the brake's state
    says of it is another matter. Depends on the risks and times handed in, nothing else.

    Parameters
    ----------
    warning : float
        Risk that raises it [-].
    hysteresis : float
        It ends below `warning - hysteresis` [-].
    hold : float
        And only once the risk has been below for so long [s].

    Attributes
    ----------
    held : bool
        Whether the alarm is up by its hold alone, as the last risk was below its level.

    """

    def __init__(self, warning: float, hysteresis: float, hold: float) -> None:
        self._up = self.held = False
        self._last = 0  # tick at which the risk last kept the alarm up
        self.update_settings(warning, hysteresis, hold)

    @classmethod
    def of(cls, settings: MonitorSettings) -> 'Alarm':
        """Return an alarm by settings."""
        return cls(settings.risk_warning, settings.risk_hysteresis, settings.risk_hold)

    def update_settings(self, warning: float, hysteresis: float, hold: float) -> None:
        """Apply other settings; an alarm that is up stays up by the new ones."""
        self._warning, self._low = warning, warning - hysteresis
        self._hold = round(hold * _SECOND)

    def end(self) -> None:
        """End it whatever the risk, as nothing is known any more."""
        self._up = self.held = False

    def update(self, time_ns: int, risk: float) -> bool:
        """
        Return whether the alarm is up at a tick [ns] with this risk.

        A tick before the last one (a clock set back) ends an alarm that its risk does not raise.
        """
        if risk >= self._warning or (self._up and risk >= self._low and risk > 0.0):
            self._up, self.held, self._last = True, False, time_ns
        else:
            self._up = self.held = self._up and 0 <= time_ns - self._last < self._hold
        return self._up
