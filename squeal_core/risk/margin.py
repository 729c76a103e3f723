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

"""How far the brake is from squeal: what a margin is, and where and how closely it is sought."""

from dataclasses import dataclass, replace
import math
from typing import Literal, TypeAlias

Parameter: TypeAlias = Literal['friction', 'rotor_speed', 'pressure']
Kind: TypeAlias = Literal['squeal', 'groan', 'divergence']


@dataclass(frozen=True, kw_only=True)
class MarginSettings:
    """
    Where margins are looked for, and how closely.

    Parameters
    ----------
    friction, rotor_speed, pressure : (2,) floats
        Bounds [-], [rad/s], [Pa].
    friction_step : float
        Step of the walk [-]. Two crossings within a step pass unseen.
    ratio : float
        Of one speed or pressure to the next.
    friction_tolerance, tolerance : float
        Width of the bracket: of friction [-], of speed and pressure as a part of their value.
    change : float
        Of speed or pressure, as a part of the value, from which on a search is given up.
    rest : float
        Time [s] after which a margin is looked for anew though the inputs are where they were.
    friction_rest, relative_rest : float
        Changes of friction [-], and of speed and pressure as a part of their value, that are none.

    """

    friction: tuple[float, float] = (0.05, 0.9)
    rotor_speed: tuple[float, float] = (0.5, 200.0)
    pressure: tuple[float, float] = (2e4, 1.6e7)
    friction_step: float = 0.02
    ratio: float = 1.2
    friction_tolerance: float = 1e-4
    tolerance: float = 1e-3
    change: float = 0.2
    rest: float = 15.0
    friction_rest: float = 0.005
    relative_rest: float = 0.01

    def bounds(self, parameter: Parameter) -> tuple[float, float]:
        found: tuple[float, float] = getattr(self, parameter)
        return found

    def moved(self, parameter: Parameter, value: float, way: float) -> float:
        """Return the next value of a walk upwards (1) or downwards (-1), within the bounds."""
        low, high = self.bounds(parameter)
        there = (value + way * self.friction_step if parameter == 'friction'
                 else value * self.ratio**way)
        return min(max(there, min(low, value)), max(high, value))

    def width(self, parameter: Parameter, ends: tuple[float, float]) -> float:
        """Return the width of a bracket over what it may be."""
        return abs(ends[1] - ends[0]) / (self.friction_tolerance if parameter == 'friction'
                                         else self.tolerance * max(ends))


@dataclass(frozen=True, kw_only=True)
class SlidingConditions:
    """Speed [rad/s] (its sign does not matter), brake pressure [Pa] and friction [-]."""

    rotor_speed: float
    pressure: float
    friction: float

    def moved(self, parameter: Parameter, value: float) -> 'SlidingConditions':
        return replace(self, **{parameter: value})

    def rests(self, other: 'SlidingConditions', settings: MarginSettings) -> bool:
        """Tell whether the changes from others are none."""
        return (abs(self.friction - other.friction) <= settings.friction_rest
                and self.near(other, settings.relative_rest))

    def near(self, other: 'SlidingConditions', part: float) -> bool:
        """Tell whether speed, either way round, and pressure are within a part of others'."""
        return all(abs(abs(here) - abs(there)) <= part * abs(there) for here, there in (
            (self.rotor_speed, other.rotor_speed), (self.pressure, other.pressure)))


@dataclass(frozen=True, kw_only=True)
class Margin:
    """
    Where one kind of growth begins or ends along one parameter.

    Parameters
    ----------
    parameter, kind : str
        'squeal' is growth of a mode in the band, 'groan' of one below, 'divergence' of one that
        does not oscillate.
    time : int
        When the search began [ns].
    inputs : SlidingConditions
        For which it holds.
    grows : bool
        Whether it grows at these inputs; then the critical value is where it ends.
    critical : float
        The middle of the bracket; NaN where there is none within the bounds.
    bracket : (2,) floats
        The nearer end first; without a crossing what was walked over.
    growth_rates : (2,) floats
        At both ends [1/s], of the full problem where there is a crossing; -inf where no mode is.
    index : int
        Of the mode, at the growing end of the bracket; 0 without a crossing.
    frequency_hz : float
    converged : bool
        Whether the bracket is as narrow as asked for, the full problem has it and the growth rate
        goes through zero in it.
    reason : str
        The result in words.
    solves : int

    """

    parameter: Parameter
    kind: Kind
    time: int
    inputs: SlidingConditions
    grows: bool
    critical: float = math.nan
    bracket: tuple[float, float]
    growth_rates: tuple[float, float]
    index: int = 0
    frequency_hz: float = math.nan
    converged: bool = False
    reason: str
    solves: int

    @property
    def value(self) -> float:
        """Critical minus present value; NaN where there is none."""
        present: float = getattr(self.inputs, self.parameter)
        return self.critical - present


@dataclass(frozen=True)
class Margins:
    """
    The last margins found; None: not yet.

    `friction`, `rotor_speed` and `pressure` are those of squeal; `groan` and `divergence` along
    friction.
    """

    friction: Margin | None = None
    rotor_speed: Margin | None = None
    pressure: Margin | None = None
    groan: Margin | None = None
    divergence: Margin | None = None
