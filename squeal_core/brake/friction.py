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

"""Friction laws: the coefficient, its slope over sliding speed, and its table over temperature."""

from dataclasses import dataclass

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checks import check_number, check_rising, column


@dataclass(frozen=True)
class FrictionLaw:
    r"""
    Coefficient falling with sliding speed: mu_k + (mu_s - mu_k) exp(-alpha v).

    Parameters
    ----------
    static, kinetic : float
        mu_s and mu_k [-].
    decay : float
        alpha [s/m].

    Raises
    ------
    SquealError
        For what is not a finite number, a coefficient not above zero, a negative decay.

    Notes
    -----
    Source: K09 eqs (15), (A.8), (A.9).

    """

    static: float = 0.5
    kinetic: float = 0.32
    decay: float = 1.0

    def __post_init__(self) -> None:
        check_number('friction_law.static', self.static, above=0.0)
        check_number('friction_law.kinetic', self.kinetic, above=0.0)
        check_number('friction_law.decay', self.decay, least=0.0)

    def coefficient(self, sliding_speed: float) -> float:
        """Return mu at a sliding speed [m/s]."""
        fall = np.exp(-self.decay * abs(sliding_speed))
        return float(self.kinetic + (self.static - self.kinetic) * fall)

    def slope(self, sliding_speed: float) -> float:
        """Return d mu / d v [s/m] at a sliding speed [m/s]; negative for mu_s > mu_k."""
        fall = np.exp(-self.decay * abs(sliding_speed))
        return float(-self.decay * (self.static - self.kinetic) * fall)

    def slope_at(self, sliding_speed: float, measured: float) -> float:
        """Return the slope [s/m] when a measured mu replaces the law's: scaled in proportion."""
        fall = float(np.exp(-self.decay * abs(sliding_speed)))
        excess = self.static - self.kinetic
        return -self.decay * excess * fall * measured / (self.kinetic + excess * fall)

    def relative_slope(self, sliding_speed: FloatArray | float) -> FloatArray:
        """Return the slope over the coefficient [s/m] at sliding speeds [m/s]."""
        excess = (self.static - self.kinetic) * np.exp(-self.decay * np.abs(sliding_speed))
        return np.asarray(-self.decay * excess / (self.kinetic + excess))


@dataclass(frozen=True)
class FrictionTable:
    """
    Friction coefficient over disc temperature, linear between its points, flat beyond.

    Parameters
    ----------
    temperature : tuple of floats
        Rising [K].
    friction : tuple of floats
        mu at each temperature [-].

    Raises
    ------
    SquealError
        For lists that do not match, do not rise, or hold what is no positive number.

    """

    temperature: tuple[float, ...]
    friction: tuple[float, ...]

    def __post_init__(self) -> None:
        for name in ('temperature', 'friction'):
            object.__setattr__(self, name, column('friction table', name, getattr(self, name)))
        check_rising('friction table', ('temperatures', 'friction coefficients'),
                     self.temperature, self.friction)

    def __call__(self, temperature: FloatArray | float) -> FloatArray:
        """Return mu [-] at temperatures [K]."""
        return np.asarray(np.interp(temperature, self.temperature, self.friction))
