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

"""Uncertainty of the inputs of a sliding brake, and what a risk is the probability of."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class InputUncertainty:
    """
    Standard deviations of the inputs of a sliding brake; the inputs are independent.

    Parameters
    ----------
    friction : float
        Of the friction coefficient, Gaussian [-]; at most half its value counts.
    pressure, rotor_speed : float
        Relative to the value, Gaussian [-].
    contact_stiffness : float
        Of the logarithm of the contact stiffness, Gaussian around that of the nominal one [-].

    """

    friction: float
    pressure: float
    rotor_speed: float
    contact_stiffness: float

    @property
    def is_none(self) -> bool:
        """Whether all inputs are certain."""
        return not any((self.friction, self.pressure, self.rotor_speed, self.contact_stiffness))


@dataclass(frozen=True, kw_only=True)
class RiskParameters:
    """
    Definition of a risk: the probability that a mode in a band grows faster than a threshold.

    Parameters
    ----------
    band_hz : (2,) floats
        Squeal band [Hz].
    growth_threshold : float
        Growth rate above which a mode is unstable [1/s].
    uncertainty : InputUncertainty
        Standard deviations of the inputs.

    """

    band_hz: tuple[float, float]
    growth_threshold: float
    uncertainty: InputUncertainty
