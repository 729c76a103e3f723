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

"""Probability of squeal at an operating point, to first order."""

from collections.abc import Sequence
from functools import partial
import math

from squeal_core.brake.operating_point import OperatingPoint, SlidingConditions
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.probability import first_order_risk, Inputs, InputUncertainty, ModeRisk, Risk
from squeal_core.stability.eigensolution import ComplexModes, Mode, Tolerances

_CANDIDATES = 3  # the least stable modes: a more stable one hardly changes the maximum
_SHOWN = 1e-3  # probability from which on a mode is named


class RiskEvaluator:
    """
    Probability that a mode of the squeal band is unstable, given the inputs' uncertainty.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    band_hz : (2,) floats
        Ends of the squeal band.
    deviations : InputUncertainty
        Standard deviations of the inputs.
    tolerances : Tolerances
        What counts as growth.

    """

    def __init__(self, model: BrakeModel, band_hz: tuple[float, float],
                 deviations: InputUncertainty, tolerances: Tolerances) -> None:
        self._model, self._band = model, band_hz
        self._deviations, self._tolerances = deviations, tolerances

    def assess(self, conditions: Sequence[SlidingConditions],
               modes: Sequence[ComplexModes]) -> list[Risk]:
        """Return the risks at conditions, given the complex modes there."""
        return [self._assessed(at, found) for at, found in zip(conditions, modes, strict=True)]

    def _assessed(self, at: SlidingConditions, modes: ComplexModes) -> Risk:
        if self._deviations.none:
            unstable = modes.flutter_in(*self._band)
            return Risk(float(bool(unstable)), 0.0, 'certain',
                        partial(_named, [1.0] * len(unstable), unstable))
        candidates = modes.least_stable(*self._band, _CANDIDATES)
        found = first_order_risk(self._model, self._point, self._inputs(at), candidates,
                                 self._deviations, level=self._tolerances.growth)
        return Risk(found.probability, math.nan, 'first order',
                    partial(_named, found.each, candidates))

    def _inputs(self, at: SlidingConditions) -> Inputs:
        stiffness = at.contact_stiffness
        if stiffness is None:
            stiffness = self._model.contact_stiffness_at(
                self._model.contact_pressure(at.pressure))
        return Inputs(rotor_speed=at.rotor_speed, pressure=at.pressure, friction=at.friction,
                      contact_stiffness=stiffness)

    def _point(self, inputs: Inputs) -> OperatingPoint:
        return self._model.operating_point(**vars(inputs))


def _named(each: Sequence[float], modes: Sequence[Mode]) -> tuple[ModeRisk, ...]:
    ordered = sorted(zip(each, modes, strict=False), key=lambda pair: -pair[0])
    return tuple(ModeRisk(m.index, m.frequency_hz, m.growth_rate, p)
                 for p, m in ordered if p >= _SHOWN)
