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

"""Probability of squeal under uncertain inputs, and its estimate of first order."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
import math
from typing import Literal

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.sensitivity import growth_change, root_sensitivity


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """What an operating point is made from: SI units, friction and pressure positive."""

    rotor_speed: float
    pressure: float
    friction: float
    contact_stiffness: float

    def moved(self, name: str, step: float) -> 'Inputs':
        values = {**self.__dict__, name: getattr(self, name) + step}
        return Inputs(**values)


@dataclass(frozen=True, kw_only=True)
class InputUncertainty:
    """
    Standard deviations: of friction absolute [-], of the others relative to their value.

    Friction, pressure and rotor speed are Gaussian. Contact stiffness is lognormal: its logarithm
    is Gaussian, of the given deviation around that of the nominal value.
    """

    friction: float
    pressure: float
    rotor_speed: float
    contact_stiffness: float

    def steps(self, at: Inputs) -> dict[str, float]:
        """Return one standard deviation of each input, in its own unit."""
        return {
            'friction': min(self.friction, 0.5 * at.friction),
            'pressure': self.pressure * at.pressure,
            'rotor_speed': self.rotor_speed * at.rotor_speed,
            'contact_stiffness': self.contact_stiffness * at.contact_stiffness}

    @property
    def none(self) -> bool:
        """Whether all inputs are certain."""
        return not any((self.friction, self.pressure, self.rotor_speed, self.contact_stiffness))


@dataclass(frozen=True)
class ModeRisk:
    """
    Probability that one mode grows within the band.

    Parameters
    ----------
    index : int
        As of `stability.Mode` at the operating point: that of the nearest root. Where two modes
        merge along the contact stiffness, which of them grows is a matter of convention.
    frequency_hz, growth_rate : float
        Of that root.
    probability : float

    """

    index: int
    frequency_hz: float
    growth_rate: float
    probability: float


@dataclass(frozen=True, eq=False, repr=False)
class Risk:
    """
    How probable squeal is.

    Parameters
    ----------
    probability : float
        That at least one mode in the band grows [-].
    error : float
        What the errors of the growth rates make of it [-]; NaN where it is not known.
    basis : str
        'summed': over the inputs' spread; 'first order': by the tangent at the point, as no cell
        is made yet; 'certain': no input is uncertain.
    named : callable
        Returns `modes`. They cost more than all the rest and are asked for now and then, so they
        are found when they are.

    """

    probability: float
    error: float
    basis: Literal['precomputed', 'summed', 'first order', 'certain']
    named: Callable[[], tuple[ModeRisk, ...]] = tuple

    @cached_property
    def modes(self) -> tuple[ModeRisk, ...]:
        """Modes that may grow, the most probable first."""
        return self.named()

    def _values(self) -> tuple[object, ...]:
        return self.probability, self.error, self.basis, self.modes

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Risk) and self._values() == other._values()

    def __hash__(self) -> int:
        return hash(self._values())

    def __repr__(self) -> str:
        return f'Risk{self._values()!r}'


@dataclass(frozen=True)
class RiskEstimate:
    """Probability [-] that a mode grows, and critical minus present friction [-] (NaN: none)."""

    probability: float
    friction_margin: float
    each: tuple[float, ...] = ()


def first_order_risk(model: BrakeModel, point_of: Callable[[Inputs], OperatingPoint], at: Inputs,
                     modes: Sequence[Mode], deviations: InputUncertainty, *,
                     level: float = 0.0) -> RiskEstimate:
    """
    Return the probability that one of the given modes grows, from the tangent at one point.

    It is exact for growth rates that are linear over the inputs' spread, and blunt next to a
    merging of two modes.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point_of : callable
        Operating point of inputs.
    at : Inputs
        Expected inputs.
    modes : sequence of Mode
        Candidates, at the operating point of `at`; the greatest of their probabilities is taken.
    deviations : InputUncertainty
        Standard deviations of the inputs.
    level : float
        Growth rate that counts as unstable [1/s].

    Notes
    -----
    The growth rate of a mode is Gaussian with its present value as mean and, for independent
    inputs, the root sum square of its changes over one deviation of each as deviation.

    """
    each, margin = [], math.nan
    steps = deviations.steps(at)
    point = point_of(at)
    for mode in modes:
        sensitivity = root_sensitivity(model, point, mode.eigenvalue)

        def change(name: str, step: float, sensitivity: dict[str, complex] = sensitivity) -> float:
            low, high = (point_of(at.moved(name, sign * step)) for sign in (-0.5, 0.5))
            return growth_change(sensitivity, low.coefficients(), high.coefficients())

        deviation = math.hypot(*(change(name, step) for name, step in steps.items()))
        each.append(_exceeds_zero(mode.growth_rate - level, deviation))
        if math.isnan(each[-1]):  # max() would lose it
            return RiskEstimate(math.nan, math.nan, tuple(each))
        slope = change('friction', 1e-3 * at.friction) / (1e-3 * at.friction)
        if slope > 0.0:
            margin = min((level - mode.growth_rate) / slope,
                         math.inf if math.isnan(margin) else margin)
    return RiskEstimate(max(each, default=0.0), margin if margin <= 1.0 else math.nan,
                        tuple(each))


def _exceeds_zero(mean: float, deviation: float) -> float:
    """P(X > 0) of a Gaussian; a step where the deviation is zero."""
    if deviation == 0.0:
        return float(mean > 0.0)
    return 0.5 * math.erfc(-mean / deviation / math.sqrt(2.0))
