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

"""Probability of squeal of sliding brakes: precomputed where there is a map, else first order."""

from collections.abc import Iterator, Sequence
from functools import partial
import math

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.first_order import first_order_probabilities
from squeal_core.risk.operating_map import OperatingMap
from squeal_core.risk.probability import ModeRisk, Risk
from squeal_core.risk.uncertainty import RiskParameters
from squeal_core.stability.eigensolution import ComplexModes, Mode

_CANDIDATES = 3  # least stable modes; a more stable one hardly changes the maximum
_CERTAIN = 0.9999  # probability from which on no other mode is looked at
_SHOWN = 1e-3  # probability from which on a mode is listed
_REMEDY = 'run `squeal tabulate --config` with the settings of this monitor'


class RiskEvaluator:
    """
    Probability that a mode of the squeal band is unstable, given the uncertainty of the inputs.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    parameters : RiskParameters
        Squeal band, growth threshold and uncertainty.
    operating_map : OperatingMap, optional
        Precomputed risks; used where its parameters are the same.

    Attributes
    ----------
    remedy : str
        Why all risks are of first order and what to do about it; empty where they are not.
    precomputed, first_order : int
        Number of risks from the map, and of those to first order.

    """

    def __init__(self, model: BrakeModel, parameters: RiskParameters,
                 operating_map: OperatingMap | None = None) -> None:
        self._model, self._parameters = model, parameters
        self.remedy = _difference(parameters, operating_map)
        self._map = None if self.remedy else operating_map
        self.precomputed = self.first_order = 0

    def assess(self, conditions: Sequence[SlidingConditions],
               modes: Sequence[ComplexModes]) -> list[Risk]:
        """
        Return the risk at each of several conditions.

        Parameters
        ----------
        conditions : sequence of SlidingConditions
            Expected inputs.
        modes : sequence of ComplexModes
            Complex modes at these conditions.

        """
        if self._parameters.uncertainty.is_none:
            return [self._certain(found) for found in modes]
        risks = self._precomputed(conditions)
        return [self._to_first_order(at, found) if math.isnan(risk)
                else self._from_map(risk, at, found)
                for at, found, risk in zip(conditions, modes, risks, strict=True)]

    def _precomputed(self, conditions: Sequence[SlidingConditions]) -> list[float]:
        """Return the risk of each by the map, NaN where there is none."""
        if self._map is None or not conditions:
            return [math.nan] * len(conditions)
        found = self._map.risk_at(*np.array(
            [(abs(at.rotor_speed), self._model.contact_pressure(at.pressure), at.friction)
             for at in conditions]).T)
        found[[at.contact_stiffness is not None for at in conditions]] = math.nan
        risks: list[float] = found.tolist()
        return risks

    def _from_map(self, risk: float, at: SlidingConditions, modes: ComplexModes) -> Risk:
        assert self._map is not None
        self.precomputed += 1
        return Risk(risk, self._map.error.largest, 'precomputed', partial(self._listed, at, modes))

    def _to_first_order(self, at: SlidingConditions, modes: ComplexModes) -> Risk:
        self.first_order += 1
        largest = 0.0
        for probability in self._probabilities(at, self._candidates(modes)):
            largest = probability if math.isnan(probability) else max(largest, probability)
            if not largest < _CERTAIN:
                break
        return Risk(largest, math.nan, 'first order', partial(self._listed, at, modes))

    def _certain(self, modes: ComplexModes) -> Risk:
        unstable = modes.flutter_in(*self._parameters.band_hz)
        return Risk(float(bool(unstable)), 0.0, 'certain', lambda: tuple(
            _mode_risk(mode, 1.0) for mode in unstable))

    def _listed(self, at: SlidingConditions, modes: ComplexModes) -> tuple[ModeRisk, ...]:
        """Return the modes that may be unstable, to first order, the most probable first."""
        candidates = self._candidates(modes)
        found = zip(self._probabilities(at, candidates), candidates, strict=True)
        return tuple(_mode_risk(mode, probability) for probability, mode in sorted(
            found, key=lambda pair: -pair[0]) if probability >= _SHOWN)

    def _candidates(self, modes: ComplexModes) -> tuple[Mode, ...]:
        return modes.least_stable(*self._parameters.band_hz, _CANDIDATES)

    def _probabilities(self, at: SlidingConditions, modes: Sequence[Mode]) -> Iterator[float]:
        return first_order_probabilities(self._model, at, modes, self._parameters.uncertainty,
                                         self._parameters.growth_threshold)


def _mode_risk(mode: Mode, probability: float) -> ModeRisk:
    return ModeRisk(mode.index, mode.frequency_hz, mode.growth_rate, probability)


def _difference(parameters: RiskParameters, operating_map: OperatingMap | None) -> str:
    """Return why a map cannot be used and the remedy; empty where it can or none is needed."""
    if parameters.uncertainty.is_none:
        return ''
    if operating_map is None:
        return f'risks are of first order, as the table has no operating map; {_REMEDY}'
    theirs = operating_map.parameters
    for name, ours, other in (
            ('squeal band', parameters.band_hz, theirs.band_hz),
            ('growth threshold', parameters.growth_threshold, theirs.growth_threshold),
            *((f'standard deviation of {key}', value, getattr(theirs.uncertainty, key))
              for key, value in vars(parameters.uncertainty).items())):
        if ours != other:
            return (f'risks are of first order, as the {name} is {ours} and {other} in the '
                    f'table; {_REMEDY}')
    return ''
