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
Quiet pressures of a brake at its present speed, temperature and friction.

Advice, never a command: no safety function may rest on it. No memory, and no figure without a
reason in words; NaN is not known.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.holding import holding_exceedances, over_members
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.quiet_intervals import (
    full_solutions,
    nearest_quiet,
    quiet_intervals,
    QuietInterval,
)

LeastStableAt: TypeAlias = Callable[[SlidingConditions, FloatArray], ComplexArray]
"""The least stable mode [1/s] at other pressures (n,) [Pa], as of `quiet_intervals`."""


@dataclass(frozen=True, kw_only=True)
class AdviceSettings:
    """
    Settings of the search for advice.

    Parameters
    ----------
    band_hz : (2,) floats
        The squeal band.
    pressure : (2,) floats
        Bounds of each brake's [Pa].
    error : float
        Of the table's growth rates, the largest [1/s].
    hold : float
        For which conditions are held, from the noise floor [s].
    front_share : (2,) floats
        Bounds of the front axle's share of the brake force [-].
    rear_force : float
        Force of a rear brake over that of a front one at equal pressure and friction: ratio of
        the effective radii over wheel radii, and of the piston areas.

    """

    band_hz: tuple[float, float]
    pressure: tuple[float, float]
    error: float
    hold: float = 3.0
    front_share: tuple[float, float] = (0.5, 0.9)
    rear_force: float = 1.0


@dataclass(frozen=True, kw_only=True)
class PressureAdvice:
    """
    Quiet pressures of a brake at its speed, temperature and friction.

    Parameters
    ----------
    present : float
        Present pressure [Pa].
    intervals : tuple of QuietInterval
        Pressures [Pa] at which the nominal brake has no unstable mode in the squeal band.
    below, above : float
        Nearest quiet pressures [Pa] down and up; the present one where it is quiet; NaN: none,
        or not known.
    confidence_below, confidence_above : float
        Probability that holding them does not squeal [-]; NaN: no risk is known.
    confirmed : bool
        Whether there are any, and full solutions at this tick are stable at those that differ
        from the present one, too.
    reason : str
        The result in words.

    """

    present: float
    intervals: tuple[QuietInterval, ...] = ()
    below: float = math.nan
    above: float = math.nan
    confidence_below: float = math.nan
    confidence_above: float = math.nan
    confirmed: bool = False
    reason: str


class PressureAdviser:
    """
    Quiet pressures of brakes of one model.

    A pressure counts as quiet where all growth rates are below the threshold by more than the
    table's error, so that a full solution there is stable, too.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    settings : AdviceSettings
    tolerances : Tolerances
        Of them, `growth` is what counts as unstable.
    look_up : callable, optional
        See `LeastStableAt`: in the table; None: by full solutions, one at a time.
    risk : SquealRisk, optional
        Without one there is no confidence.

    """

    def __init__(self, model: BrakeModel, settings: AdviceSettings, tolerances: Tolerances, *,
                 look_up: LeastStableAt | None = None, risk: SquealRisk | None = None) -> None:
        self.model, self.settings, self.tolerances = model, settings, tolerances
        self._look_up, self._risk = look_up, risk

    def __call__(self, at: SlidingConditions) -> PressureAdvice:
        """Return the advice for a brake that slides at some conditions."""
        look_up = self._look_up or self._in_full
        result = quiet_intervals(
            'pressure', self.settings.pressure, lambda pressures: look_up(at, pressures),
            level=self.tolerances.growth - (self.settings.error if self._look_up else 0.0),
            together=self._look_up is not None)
        below, above = nearest_quiet(result, at.pressure)
        advice = PressureAdvice(present=at.pressure, intervals=result, below=below, above=above,
                                reason=_in_words(result, self.settings.pressure))
        return self._with_confidence(self._confirmed(advice, at), at)

    def _in_full(self, at: SlidingConditions, pressures: FloatArray) -> ComplexArray:
        return full_solutions(self.model, at, pressures, self.settings.band_hz, self.tolerances)

    def _confirmed(self, advice: PressureAdvice, at: SlidingConditions) -> PressureAdvice:
        """Keep the pressures at which full solutions are stable, too."""
        wrong: dict[str, Any] = {}
        reason = advice.reason
        for name in ('below', 'above'):
            pressure = getattr(advice, name)
            if pressure == at.pressure or math.isnan(pressure):
                continue
            rate = float(self._in_full(at, np.array([pressure]))[0].real)
            if not rate <= self.tolerances.growth:
                wrong[name] = math.nan
                reason += (f'; {pressure / 1e5:.2f} bar is not confirmed, as a full solution has '
                           f'a growth rate of {rate:+.3g} 1/s')
        return replace(advice, **wrong, confirmed=bool(advice.intervals) and not wrong,
                       reason=reason)

    def _with_confidence(self, advice: PressureAdvice, at: SlidingConditions) -> PressureAdvice:
        pressures = np.array([advice.below, advice.above])
        known = ~np.isnan(pressures)
        if self._risk is None or not known.any():
            return advice
        pressures[known] = 1.0 - over_members(self._risk, holding_exceedances(
            self._risk, self.model, self.settings.hold, pressures[known], at.rotor_speed,
            at.friction))
        below, above = pressures.tolist()
        return replace(advice, confidence_below=below, confidence_above=above)


def bar(pressure: float, towards: float) -> str:
    """Return a pressure [Pa] in bar, rounded into a quiet interval; `towards`: -inf or inf."""
    rounded = math.floor if towards < 0.0 else math.ceil
    return f'{rounded(1e-3 * pressure) / 100.0:.2f}'


def _in_words(result: Sequence[QuietInterval], bounds: tuple[float, float]) -> str:
    texts = [f'{bar(low.value, math.inf)} to {bar(high.value, -math.inf)} bar'
             for low, high in result]
    unknown = sorted(end.value for one in result for end in one if end.kind == 'unknown')
    words = f'quiet: {", ".join(texts)}' if texts else 'no quiet pressure'
    words += f' within {bounds[0] / 1e5:.2f} to {bounds[1] / 1e5:.2f} bar'
    if unknown:
        words += f'; not known beyond {", ".join(f"{end / 1e5:.2f}" for end in unknown)} bar'
    return words
