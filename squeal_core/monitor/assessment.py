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

"""Result of assessing one brake at one tick."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
import math
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint, SlidingConditions
from squeal_core.common.frozen_records import frozen_record
from squeal_core.common.wording import risk_in_words
from squeal_core.monitor.brake_risk import BrakeRisk
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.setting_specs import Signal
from squeal_core.stability.eigensolution import Mode

State: TypeAlias = Literal['steady', 'released', 'not sliding', 'stale', 'invalid',
                           'outside validated range']

VALID: tuple[State, ...] = ('steady', 'released')


@dataclass(frozen=True, kw_only=True)
class Assessment:
    """
    Result of assessing one brake at one tick.

    Parameters
    ----------
    brake : str
    time : int
        The tick [ns].
    state : str
        'steady': sliding under load, the numbers hold; 'released': no load, risk 0;
        'not sliding', 'stale', 'invalid', 'outside validated range': not known, numbers NaN.
    reason : str
        The state in words; inputs named with their value and age.
    inputs : mapping
        `Reading` of each input.
    friction : float
        mu [-], measured, by the temperature table or constant.
    friction_source : str
        'measured', 'temperature' or 'constant'; empty where friction is not known.
    point : OperatingPoint or None
    modes : tuple of Mode
        All unstable modes, worst first: flutter in and below the squeal band, divergence.
    risk : float
        Squeal risk: probability that a mode has built up until it is audible [-].
    application_risk : float
        At the tick of a release that of the application, with the time to its end [-]; else NaN.
    instability_probability : float
        That a mode in the squeal band is unstable, over the ensemble of brakes [-].
    build_up : float
        Of the mode that has built up most, above its noise floor [nepers].
    time_to_squeal : float
        Until it is audible at its present growth rate [s]; inf: it decays, 0: it is.
    growth_rate : float
        Largest Re(lambda) of the oscillating modes in the squeal band [1/s].
    damping_ratio : float
        zeta = -Re/|lambda| of that mode [-]; negative: unstable.
    worst_frequency_hz : float
        Frequency of that mode.
    friction_margin : float
        Critical minus present friction [-]; NaN where there is none, or none is known.
    stability : BrakeStability or None
        Modes with their errors and margins with reasons, of a brake that slides.
    risk_result : BrakeRisk or None
        Risk with its error and basis, of such a brake.

    """

    brake: str
    time: int
    state: State
    reason: str
    inputs: Mapping[Signal, Reading] = field(default_factory=dict)
    friction: float = math.nan
    friction_source: str = ''
    point: OperatingPoint | None = None
    modes: tuple[Mode, ...] = ()
    risk: float = math.nan
    application_risk: float = math.nan
    instability_probability: float = math.nan
    build_up: float = math.nan
    time_to_squeal: float = math.nan
    growth_rate: float = math.nan
    damping_ratio: float = math.nan
    worst_frequency_hz: float = math.nan
    friction_margin: float = math.nan
    stability: BrakeStability | None = field(default=None, repr=False, compare=False)
    risk_result: BrakeRisk | None = field(default=None, repr=False, compare=False)

    @property
    def is_valid(self) -> bool:
        """Return whether the brake was assessed."""
        return self.state in VALID

    @property
    def build_ups(self) -> tuple[float, ...]:
        """Build-up of the family of each flutter mode [nepers], NaN where it is not known."""
        if self.risk_result is None:
            return (math.nan,) * len(self.flutter)
        return self.risk_result.build_ups(self.flutter)

    @cached_property
    def unstable_frequencies_hz(self) -> tuple[float, ...]:
        """Frequencies of the flutter modes, worst first."""
        return tuple([mode.frequency_hz for mode in self.flutter])

    @cached_property
    def unstable_growth_rates(self) -> tuple[float, ...]:
        """Growth rates of the flutter modes [1/s], worst first."""
        return tuple([mode.growth_rate for mode in self.flutter])

    @cached_property
    def mode_numbers(self) -> tuple[int, ...]:
        """Numbers of the flutter modes, worst first."""
        return tuple([mode.index for mode in self.flutter])

    @property
    def worst_mode_number(self) -> int:
        """Return the number of the least stable flutter mode in the band; 0: not known."""
        worst = self.stability.worst if self.stability else None
        return worst.index if worst else 0

    @cached_property
    def flutter(self) -> tuple[Mode, ...]:
        """Oscillating unstable modes, worst first."""
        return tuple([mode for mode in self.modes if mode.kind == 'flutter'])


class AssessmentContext(NamedTuple):
    """
    Brake, tick and inputs of an assessment to be made.

    Parameters
    ----------
    brake, time, inputs, friction, friction_source
        As of `Assessment`.
    confirm : bool
        Whether the friction margin is to be confirmed at this tick.

    """

    brake: str
    time: int
    inputs: Mapping[Signal, Reading]
    friction: float = math.nan
    friction_source: str = ''
    confirm: bool = False

    @property
    def conditions(self) -> SlidingConditions:
        """Return the conditions under which the brake slides."""
        return frozen_record(
            SlidingConditions, rotor_speed=self.inputs['rotor_speed'].value,
            pressure=self.inputs['pressure'].value, friction=self.friction)

    def result(self, state: State, reason: str, **values: Any) -> Assessment:
        """Return the assessment in this context."""
        return frozen_record(
            Assessment, brake=self.brake, time=self.time, inputs=self.inputs,
            friction=self.friction, friction_source=self.friction_source, state=state,
            reason=reason, **values)


def from_stability(context: AssessmentContext, result: BrakeStability | np.linalg.LinAlgError,
                   risk: BrakeRisk | None) -> Assessment:
    """Return the assessment of a brake that slides, given its stability and risk if known."""
    if isinstance(result, np.linalg.LinAlgError) or risk is None:
        return context.result('invalid', f'no eigensolution ({result})')
    worst, known = result.worst, risk.result
    return context.result(
        'steady', _in_words(worst, risk), point=result.point, modes=result.modes.unstable,
        risk=known.squeal_risk, instability_probability=known.instability_probability,
        build_up=known.build_up, time_to_squeal=known.time_to_squeal,
        growth_rate=worst.growth_rate if worst else math.nan,
        damping_ratio=worst.damping_ratio if worst else math.nan,
        worst_frequency_hz=worst.frequency_hz if worst else math.nan,
        friction_margin=result.margins.friction.value, stability=result, risk_result=risk)


def explained(result: Assessment) -> Assessment:
    """Return an assessment with the reason why its friction is by temperature, if it is."""
    if result.friction_source == 'temperature' and 'friction' in result.inputs:
        instead = result.inputs['friction'].described('friction')
        return replace(result, reason=f'{result.reason}; friction by temperature, as {instead}')
    return result


def _in_words(worst: Mode | None, risk: BrakeRisk) -> str:
    known = risk.result
    said = f'squeal risk not known: {risk.unknown}' if risk.unknown else (
        f'squeal risk {risk_in_words(known.squeal_risk)}, build-up {known.build_up:.1f} nepers')
    since = '; a part of this brake application is not known' if known.incomplete else ''
    if worst is None:
        return f'{said}: no mode in the squeal band{since}'
    verdict = 'grows' if worst.unstable else 'decays'
    return (f'{said}: mode at {worst.frequency_hz:.0f} Hz {verdict} with '
            f'{worst.growth_rate:+.1f} 1/s{since}')


# of each brake: its assessment, or the context of the one to be made from its stability
PreparedTick: TypeAlias = tuple[Assessment | AssessmentContext, ...]
