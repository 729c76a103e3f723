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

"""Squeal risk of one brake over its brake applications, tick by tick."""

import numpy as np
from squeal_core.common.arrays import RealArray
from squeal_core.risk.build_up import after, gain_and_noise, halves
from squeal_core.risk.risk_records import ApplicationState, MemberGrowth, RiskResult
from squeal_core.risk.scatter import at_nodes, NODES
from squeal_core.risk.squeal_risk import SquealRisk

_SECOND = 1_000_000_000
_NO_CAP = np.array(np.inf, np.float32)


class ApplicationRisk:
    """
    Build-up and squeal risk of one brake; methods take the data of a tick.

    `update`: it slides under load. `hold`: it does, and is not evaluated. `rest`: it is pressed
    and does not slide, so modes decay to their floors; the application goes on. `skip`: nothing is
    known, and nothing is added. `release`: the application ends, and all modes are at their
    floors. More than `RiskSettings.longest_interval` after the last evaluated tick, or before it
    (a clock set back), the time between is unknown.

    Parameters
    ----------
    risk : SquealRisk
        Shared by all brakes of a model.

    Attributes
    ----------
    energy, peak, growing, incomplete
        As of `ApplicationState`.

    """

    def __init__(self, risk: SquealRisk) -> None:
        self._risk = risk
        self._shape = (NODES.size, risk.families.size, risk.ensemble.weights.size)
        self._time, self._slid_at, self._fresh = 0, 0, False
        self._still: RealArray = np.broadcast_to(-risk.decay, self._shape)
        self._rates: RealArray | None = None  # (7, F, M) at the last tick; None: not known
        self._growth: MemberGrowth | None = None  # there, where the brake slid
        self._reset()
        self.incomplete = True  # nothing is known of what was before the first tick

    def _reset(self) -> None:
        self.energy: RealArray = np.ones(self._shape, np.float32)
        self.peak: RealArray = np.ones((NODES.size, 1, self._shape[-1]), np.float32)
        self.growing: RealArray = np.zeros((NODES.size, self._shape[-1]))
        self.incomplete = False

    def update(self, time_ns: int, growth: MemberGrowth) -> RiskResult | None:
        """
        Return the risk at a tick at which the brake slides under load.

        Parameters
        ----------
        time_ns : int
            The tick.
        growth : MemberGrowth
            `SquealRisk.growth` of the tick.

        Returns
        -------
        RiskResult or None
            None where most members are outside the emulator's domain.

        """
        state = self.advance(time_ns, growth)
        return state and self._risk.assess([state])[0]

    def advance(self, time_ns: int, growth: MemberGrowth) -> ApplicationState | None:
        """Take a tick as `update` does; return the state to assess."""
        if not growth.known.any():
            self.skip(time_ns)
            return None
        rates = at_nodes(growth.rate, growth.scatter)
        self._step(self._elapsed(time_ns), rates, growth)
        self._rates, self._growth, self._fresh = rates, growth, False
        self._slid_at = time_ns
        return self._state()

    def hold(self, time_ns: int) -> None:
        """Take a tick at which the brake slides on, between two that are evaluated."""
        self._slid_at = time_ns

    def rest(self, time_ns: int) -> None:
        """Take a tick at which the brake is pressed and does not slide."""
        duration = self._elapsed(time_ns)
        if self._growth is not None and self._rates is not None:
            sliding = duration - self._after_sliding(time_ns)
            self._grow(self._rates[None], sliding, self._growth)
            duration -= sliding
        self._grow(self._still[None], duration, None)
        self._rates, self._growth = self._still, None

    def skip(self, time_ns: int) -> None:
        """Take a tick of which nothing is known."""
        self._time, self.incomplete, self._fresh = time_ns, True, False
        self._rates = self._growth = None

    def release(self, time_ns: int) -> RiskResult | None:
        """
        End the application at a tick at which the brake is released.

        Returns
        -------
        RiskResult or None
            The last of the application: sliding is taken to have ended in the middle between the
            last tick that saw it and this one. None where the brake did not slide before it.

        """
        state = self.end(time_ns)
        return state and self._risk.assess([state])[0]

    def end(self, time_ns: int) -> ApplicationState | None:
        """Take a tick as `release` does; return the state to assess."""
        self.finish(time_ns)
        last = self._state()
        if not self._fresh:
            self._reset()
        self._rates, self._growth, self._fresh = self._still, None, True
        return last

    def finish(self, time_ns: int) -> None:
        """Take the time to the end of sliding, before a tick at which the brake is released."""
        duration = self._elapsed(time_ns)
        if self._rates is not None and self._growth is not None:
            self._grow(self._rates[None], duration - self._after_sliding(time_ns), self._growth)

    def _after_sliding(self, time_ns: int) -> float:
        """Return half of the time since the brake was last seen sliding [s]."""
        return 0.5 * (time_ns - self._slid_at) / _SECOND

    def _elapsed(self, time_ns: int) -> float:
        """Return the time since the last tick [s]; 0 where nothing is known of it."""
        duration = (time_ns - self._time) / _SECOND
        if self._rates is None or not 0.0 <= duration <= self._risk.settings.longest_interval:
            self.skip(time_ns)
        self._time = time_ns
        return 0.0 if self._rates is None else duration

    def _state(self) -> ApplicationState | None:
        """Return the state if the brake slid at the last tick and most members are known."""
        if self._growth is None or not self._risk.knows(self._growth):
            return None
        return ApplicationState(self.energy, self.peak, self.growing, self._growth,
                                self.incomplete)

    def _step(self, duration: float, rates: RealArray, growth: MemberGrowth) -> None:
        """Go on to a tick at which the brake slides with these growth rates."""
        if self._rates is None or duration == 0.0:
            return
        edge = self._growth is None
        self._grow(halves(self._rates, rates, edge=edge), 0.5 * duration,
                   None if edge else growth, growth)

    def _grow(self, rates: RealArray, duration: float, *growths: MemberGrowth | None) -> None:
        """Take times of a duration, each at its rates; without sliding all modes decay."""
        gains, noises = gain_and_noise(rates, duration, self._risk.decay)
        grows = np.any(rates > 0.0, axis=2)
        for part, growth in enumerate(growths):
            self.energy = after(self.energy, gains[part], noises[part],
                                _NO_CAP if growth is None else growth.cap)
            if growth is not None:
                self.peak = np.maximum(
                    self.peak, self.energy.max(axis=1, keepdims=True, initial=1.0))
                self.growing = self.growing + duration * grows[part]
