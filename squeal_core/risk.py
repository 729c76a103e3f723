"""Probability of squeal under uncertain inputs, to first order in the uncertainties.

A first-order estimate answers from the tangent at one point; it is exact for growth rates that
are linear over the inputs' spread, and blunt next to a merging of two modes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math

from squeal_core.brake_model import BrakeModel
from squeal_core.operating_point import OperatingPoint
from squeal_core.sensitivity import growth_change, root_sensitivity
from squeal_core.stability import Mode


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
class Deviations:
    """Standard deviations: of friction absolute [-], of the others relative to their value."""

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


@dataclass(frozen=True)
class RiskEstimate:
    """Probability [-] that a mode grows, and critical minus present friction [-] (NaN: none)."""

    probability: float
    friction_margin: float


def first_order_risk(model: BrakeModel, point_of: Callable[[Inputs], OperatingPoint], at: Inputs,
                     modes: Sequence[Mode], deviations: Deviations) -> RiskEstimate:
    """Return the probability that one of the given modes grows.

    Parameters
    ----------
    model : BrakeModel
    point_of : callable
        Operating point of inputs.
    at : Inputs
        Expected inputs.
    modes : sequence of Mode
        Candidates, at the operating point of `at`; the greatest of their probabilities is taken.
    deviations : Deviations

    Notes
    -----
    The growth rate of a mode is Gaussian with its present value as mean and, for independent
    inputs, the root sum square of its changes over one deviation of each as deviation.
    """
    probability, margin = 0.0, math.nan
    steps = deviations.steps(at)
    point = point_of(at)
    for mode in modes:
        sensitivity = root_sensitivity(model, point, mode.eigenvalue)

        def change(name: str, step: float, sensitivity: dict[str, complex] = sensitivity) -> float:
            low, high = (point_of(at.moved(name, sign * step)) for sign in (-0.5, 0.5))
            return growth_change(sensitivity, low.coefficients(), high.coefficients())

        deviation = math.hypot(*(change(name, step) for name, step in steps.items()))
        own = _exceeds_zero(mode.growth_rate, deviation)
        if math.isnan(own):  # max() would lose it
            return RiskEstimate(own, own)
        probability = max(probability, own)
        slope = change('friction', 1e-3 * at.friction) / (1e-3 * at.friction)
        if slope > 0.0:
            margin = min(-mode.growth_rate / slope, math.inf if math.isnan(margin) else margin)
    return RiskEstimate(probability, margin if margin <= 1.0 else math.nan)


def _exceeds_zero(mean: float, deviation: float) -> float:
    """P(X > 0) of a Gaussian; a step where the deviation is zero."""
    if deviation == 0.0:
        return float(mean > 0.0)
    return 0.5 * math.erfc(-mean / deviation / math.sqrt(2.0))
