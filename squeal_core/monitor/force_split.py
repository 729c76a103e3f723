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

"""
Split of the brake force over two axles with the least risk, at unchanged total force.

Advice, never a command: no safety function may rest on it. What stability of the vehicle, laws and
brake-by-wire allow is not known here, but for the limits of the settings.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.advice import AdviceSettings, LeastStableAt
from squeal_core.risk.holding import holding_exceedances, over_members
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.quiet_intervals import full_solutions

SplitSteps: TypeAlias = Generator[None, None, 'SplitAdvice']

NOTHING_KNOWN = 'neither growth emulator nor table; compute them by `squeal tabulate`'
_SHARES = 17  # compared, over the limits
_SAME = {'squeal risk': 0.005, 'growth rate': 0.1}  # of two splits so close the nearer is advised


@dataclass(frozen=True, kw_only=True)
class SplitAdvice:
    """
    The front share of the brake force with the least risk.

    Parameters
    ----------
    present, front_share : float
        Present and advised share of the front axle [-]; NaN: not known.
    pressures : tuple of float
        Of the brakes at the advised share [Pa].
    basis : str
        What is least: 'squeal risk', of any brake, where the conditions are held; or without an
        emulator the largest 'growth rate' [1/s].
    least, gain : float
        It at the advised share, and how much less that is than at the present one.
    confidence : float
        Weight of the ensemble's brakes that squeal no more than with the present split [-].
    confirmed : bool
        Whether by full solutions the nominal brakes are stable, or no less so than now.
    reason : str
        The result in words.

    """

    present: float = math.nan
    front_share: float = math.nan
    pressures: tuple[float, ...] = ()
    basis: str = ''
    least: float = math.nan
    gain: float = math.nan
    confidence: float = math.nan
    confirmed: bool = False
    reason: str


def split_pressures(force_per_pressure: FloatArray, pressures: FloatArray, front: Any,
                    shares: FloatArray) -> FloatArray:
    """
    Return the pressures (S, B) at which the front axle has shares (S,) of the same total force.

    Parameters
    ----------
    force_per_pressure : (B,) array
        Of each brake, in any unit.
    pressures : (B,) array
        Present ones, which keep their ratio on an axle [Pa].
    front : (B,) array of bool
        Which brakes are on the front axle.
    shares : (S,) array

    """
    force = force_per_pressure * pressures
    total, ahead = force.sum(), force[front].sum()
    share = shares[:, None]
    scale = np.where(front, share / ahead, (1.0 - share) / (total - ahead))
    return np.asarray(pressures * total * scale)


class SplitAdviser:
    """
    Compares splits of the brake force of a vehicle whose brakes are of one model.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : AdviceSettings
    tolerances : Tolerances
        Of them, `growth` is what counts as unstable.
    look_up : callable, optional
        See `LeastStableAt`; what counts where there is no emulator.
    risk : SquealRisk, optional
        What counts where there is an emulator.

    """

    def __init__(self, model: BrakeModel, settings: AdviceSettings, tolerances: Tolerances, *,
                 look_up: LeastStableAt | None = None, risk: SquealRisk | None = None) -> None:
        self.model, self.settings, self.tolerances = model, settings, tolerances
        self._look_up, self._risk = look_up, risk

    def __call__(self, brakes: Sequence[SlidingConditions], front: Sequence[bool]) -> SplitAdvice:
        """Return the advice for brakes that all slide, given which are on the front axle."""
        steps = self.steps(brakes, front)
        while True:
            try:
                next(steps)
            except StopIteration as done:
                return done.value  # type: ignore[no-any-return]

    def steps(self, brakes: Sequence[SlidingConditions], front: Sequence[bool]) -> SplitSteps:
        """Return the advice as `__call__`, in two steps a brake of some milliseconds each."""
        if self._risk is None and self._look_up is None:
            return SplitAdvice(reason=NOTHING_KNOWN)
        ahead, present = np.array(front), np.array([at.pressure for at in brakes])
        factor = np.array([at.friction for at in brakes]) * np.where(
            ahead, 1.0, self.settings.rear_force)
        share = float((factor * present)[ahead].sum() / (factor * present).sum())
        low, high = self.settings.front_share
        shares = np.concatenate([[share], np.linspace(low, high, _SHARES)])
        pressures = split_pressures(factor, present, ahead, shares)
        least, most = self.settings.pressure
        allowed: Any = ((pressures >= least) & (pressures <= most)).all(axis=1)
        allowed[0] &= low <= share <= high
        columns = []
        for at, column in zip(brakes, pressures.T, strict=True):
            columns.append(self._cost(at, column))
            yield
        values, members = self._together(np.array(columns))
        allowed &= ~np.isnan(values)
        if not allowed.any() or math.isnan(values[0]):
            return SplitAdvice(present=share, reason=f'not known at front shares {low:g} to '
                               f'{high:g}, {least / 1e5:.2f} to {most / 1e5:.2f} bar')
        near = allowed & (values <= values[allowed].min() + _SAME[self.basis])
        best = int(np.where(near, np.abs(shares - share), np.inf).argmin())
        before = after = self.tolerances.growth
        for at, now, then in zip(brakes, present, pressures[best], strict=True):
            rates = full_solutions(self.model, at, np.array([now, then]), self.settings.band_hz,
                                   self.tolerances).real
            before, after = max(before, float(rates[0])), max(after, float(rates[1]))
            yield
        if not after <= before:  # NaN is not
            return SplitAdvice(present=share, basis=self.basis, reason=(
                f'front share {shares[best]:.3f} is not confirmed: by full solutions a mode has '
                f'{after:+.3g} 1/s there, {before:+.3g} 1/s now'))
        return SplitAdvice(
            present=share, front_share=float(shares[best]), basis=self.basis, confirmed=True,
            pressures=tuple(pressures[best].tolist()), least=float(values[best]),
            gain=float(values[0] - values[best]),
            confidence=self._confidence(members, best), reason=(
                f'{self.basis} {values[best]:.2f} at front share {shares[best]:.3f}, '
                f'{values[0]:.2f} at {share:.3f} now'))

    @property
    def basis(self) -> str:
        """What is least."""
        return 'growth rate' if self._risk is None else 'squeal risk'

    def _cost(self, at: SlidingConditions, pressures: FloatArray) -> FloatArray:
        """Return growth rates (S,) [1/s] of a brake, or probabilities of squeal (S, M)."""
        if self._risk is not None:
            return holding_exceedances(self._risk, self.model, self.settings.hold, pressures,
                                       at.rotor_speed, at.friction)
        assert self._look_up is not None
        return np.asarray(self._look_up(at, pressures).real)

    def _together(self, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what is least of all brakes (S,), and risks by member (S, M)."""
        if self._risk is None:
            return columns.max(axis=0), columns
        # the brakes are alike: a member is all of them, their scatter is each one's own
        members = 1.0 - np.prod(1.0 - columns, axis=0)
        return over_members(self._risk, members), members

    def _confidence(self, members: FloatArray, best: int) -> float:
        if self._risk is None:
            return math.nan
        no_more = np.where(np.isnan(members[best] + members[0]), math.nan,
                           members[best] <= members[0] + 1e-9)
        return float(over_members(self._risk, no_more))
