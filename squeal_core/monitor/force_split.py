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

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.advice import AdviceSettings, LeastStableAt
from squeal_core.risk.holding import holding_exceedances, nominal_least_stable, over_members
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.quiet_intervals import full_solutions

SplitSteps: TypeAlias = Generator[None, None, 'SplitAdvice']

NOTHING_KNOWN = 'neither growth emulator nor table; compute them by `squeal tabulate`'
_SHARES = 7  # compared first, over the limits
_HALVINGS = 2  # of their steps, about the best
_SAME_BUILD_UP = 1.0  # neper; N* scatters by two
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
        Whether full solutions at the advised pressures have the growth rates that it rests on:
        build-ups of the nominal brakes over `hold` are within a neper.
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
        Fractions of the total force on the front axle [-].

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
        """Return the advice as `__call__`, in steps of about a full solution each."""
        if self._risk is None and self._look_up is None:
            return SplitAdvice(reason=NOTHING_KNOWN)
        low, high = self.settings.front_share
        splits = _Splits(brakes, np.array(front), self.settings, self._cost, self._risk)
        yield from splits.add(np.concatenate([[splits.present], np.linspace(low, high, _SHARES)]))
        for halving in range(1, _HALVINGS + 1):
            if (best := splits.best()) is None:
                return SplitAdvice(present=splits.present, reason=f'not known at front shares '
                                   f'{low:g} to {high:g}, {splits.limits}')
            step = (high - low) / (_SHARES - 1) / 2.0**halving
            near = splits.shares[best] + np.array([-step, step])
            yield from splits.add(near[(near >= low) & (near <= high)])
        best = splits.best()
        assert best is not None
        for at, pressure in zip(brakes, splits.pressures[best], strict=True):
            told, full = self._growth(at, pressure)
            # by so much their build-ups differ, where they do; NaN does, too
            if not abs(max(told, 0.0) - max(full, 0.0)) * self.settings.hold <= _SAME_BUILD_UP:
                return SplitAdvice(present=splits.present, basis=splits.basis, reason=(
                    f'front share {splits.shares[best]:.3f} is not confirmed: at '
                    f'{pressure / 1e5:.2f} bar a full solution has {full:+.3g} 1/s, not '
                    f'{told:+.3g} 1/s'))
            yield
        return splits.advice(best)

    def _growth(self, at: SlidingConditions, pressure: float) -> tuple[float, float]:
        """Return the growth rate of the nominal brake by look-up and by a full solution [1/s]."""
        place = np.array([pressure])
        told = nominal_least_stable(self._risk, self.model, at, place) if self._risk else (
            self._cost(at, place))
        full = full_solutions(self.model, at, place, self.settings.band_hz, self.tolerances)
        return float(told[0].real), float(full[0].real)

    def _cost(self, at: SlidingConditions, pressures: FloatArray) -> FloatArray:
        """Return growth rates (S,) [1/s] of a brake, or probabilities of squeal (S, M)."""
        if self._risk is not None:
            return holding_exceedances(self._risk, self.model, self.settings.hold, pressures,
                                       at.rotor_speed, at.friction)
        assert self._look_up is not None
        return np.asarray(self._look_up(at, pressures).real)


class _Splits:
    """Splits that were evaluated, the present one first: shares (S,), pressures (S, B), costs."""

    def __init__(self, brakes: Sequence[SlidingConditions], front: Any, settings: AdviceSettings,
                 cost: Callable[[SlidingConditions, FloatArray], FloatArray],
                 risk: SquealRisk | None) -> None:
        self._brakes, self._front, self._settings = brakes, front, settings
        self._cost, self._risk = cost, risk
        self._now = np.array([at.pressure for at in brakes])
        self._factor = np.array([at.friction for at in brakes]) * np.where(
            front, 1.0, settings.rear_force)
        force = self._factor * self._now
        self.present = float(force[front].sum() / force.sum())
        self.shares, self.pressures = np.empty(0), np.empty((0, len(brakes)))
        self._members: list[FloatArray] = []  # of each share: growth rate, or risks of members
        self.basis = 'growth rate' if risk is None else 'squeal risk'

    @property
    def limits(self) -> str:
        low, high = self._settings.pressure
        return f'{low / 1e5:.2f} to {high / 1e5:.2f} bar'

    def add(self, shares: FloatArray) -> Generator[None, None, None]:
        """Evaluate more splits, a share of a brake a step."""
        pressures = split_pressures(self._factor, self._now, self._front, shares)
        for share in pressures:
            costs = []
            for at, pressure in zip(self._brakes, share, strict=True):
                costs.append(self._cost(at, np.array([pressure]))[0])
                yield
            # the brakes are alike: a member is all of them, their scatter is each one's own
            self._members.append(np.max(costs) if self._risk is None else
                                 1.0 - np.prod(1.0 - np.array(costs), axis=0))
        self.shares = np.concatenate([self.shares, shares])
        self.pressures = np.concatenate([self.pressures, pressures])

    @property
    def _values(self) -> FloatArray:
        values = np.array(self._members)
        return values if self._risk is None else over_members(self._risk, values)

    def best(self) -> int | None:
        """Return the split of least cost within the limits, of equal ones the nearest."""
        low, high = self._settings.front_share
        least, most = self._settings.pressure
        values = self._values
        known: Any = ~np.isnan(values) & (self.shares >= low) & (self.shares <= high)
        known &= ((self.pressures >= least) & (self.pressures <= most)).all(axis=1)
        if not known.any() or math.isnan(values[0]):
            return None
        near = known & (values <= values[known].min() + _SAME[self.basis])
        return int(np.where(near, np.abs(self.shares - self.present), np.inf).argmin())

    def advice(self, best: int) -> SplitAdvice:
        """Return a split that full solutions confirm."""
        values, share = self._values, float(self.shares[best])
        confidence = math.nan
        if self._risk is not None:
            now, then = self._members[0], self._members[best]
            confidence = float(over_members(self._risk, np.where(
                np.isnan(now + then), math.nan, then <= now + 1e-9)))
        return SplitAdvice(
            present=self.present, front_share=share, basis=self.basis, confirmed=True,
            pressures=tuple(self.pressures[best].tolist()), least=float(values[best]),
            gain=float(values[0] - values[best]), confidence=confidence, reason=(
                f'{self.basis} {values[best]:.2f} at front share {share:.3f}, '
                f'{values[0]:.2f} at {self.present:.3f} now'))
