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

"""Damping of a brake: ratios over frequency by component, and layers that a loss factor damps."""

from dataclasses import dataclass
import math

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checks import check_number, check_rising, column


@dataclass(frozen=True)
class DampingTable:
    """
    Damping ratio over frequency, linear between its points, flat beyond.

    Parameters
    ----------
    frequency : tuple of floats
        Rising, above zero [Hz].
    ratio : tuple of floats
        xi at each frequency, zero or more [-].

    Raises
    ------
    SquealError
        For lists that do not match, do not rise, or hold what is no number in range.

    """

    frequency: tuple[float, ...]
    ratio: tuple[float, ...]

    def __post_init__(self) -> None:
        table = 'damping table'
        object.__setattr__(self, 'frequency', column(table, 'frequency', self.frequency))
        object.__setattr__(self, 'ratio', column(table, 'ratio', self.ratio, above=-math.inf,
                                                 least=0.0))
        check_rising(table, ('frequencies', 'damping ratios'), self.frequency, self.ratio)

    def __call__(self, angular_frequencies: FloatArray) -> FloatArray:
        """Return xi [-] at angular frequencies [rad/s]."""
        return np.asarray(np.interp(angular_frequencies / math.tau, self.frequency, self.ratio))


@dataclass(frozen=True)
class ComponentDamping:
    """Structural damping of the disc and of the pads, top (pad 1) and bottom (pad 2)."""

    disc: DampingTable
    pads: tuple[DampingTable, DampingTable]


def retardation_time(loss_factor: float, frequency_hz: float) -> float:
    """
    Return c / k = eta / (2 pi f) [s] of a spring and a dashpot side by side.

    Parameters
    ----------
    loss_factor : float
        eta, lost over stored energy per radian, at the reference frequency [-]. That of the two
        goes in proportion to frequency.
    frequency_hz : float
        Reference frequency [Hz].

    Raises
    ------
    SquealError
        For a loss factor that is negative, a frequency that is not above zero.

    Examples
    --------
    >>> from squeal_core.brake.damping import retardation_time
    >>> print(f'{retardation_time(0.1, 2000.0):.3g} s')
    7.96e-06 s

    """
    check_number('loss_factor', loss_factor, least=0.0)
    check_number('frequency_hz', frequency_hz, above=0.0)
    return loss_factor / (math.tau * frequency_hz)
