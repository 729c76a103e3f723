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

"""Margins of a sliding brake: how far its friction, speed and pressure are from critical ones."""

from collections.abc import Callable
from dataclasses import dataclass
import math
from typing import Literal, TypeAlias

import numpy as np
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.boundaries import NO_MODE
from squeal_core.stability.eigensolution import Tolerances

Parameter: TypeAlias = Literal['friction', 'rotor_speed', 'pressure']
Kind: TypeAlias = Literal['squeal', 'groan', 'divergence']
OtherMargin: TypeAlias = Literal['rotor_speed', 'pressure', 'groan', 'divergence']
OTHERS: tuple[OtherMargin, ...] = ('rotor_speed', 'pressure', 'groan', 'divergence')


@dataclass(frozen=True, kw_only=True)
class MarginSettings:
    """
    Settings of the search for critical values and of their confirmation.

    Parameters
    ----------
    band_hz : (2,) floats
        The squeal band.
    friction, rotor_speed, pressure : (2,) floats
        Bounds [-], [rad/s], [Pa].
    error : float
        Of the table's growth rates, the largest [1/s]: a full solution that differs by more does
        not confirm a margin.

    """

    band_hz: tuple[float, float]
    friction: tuple[float, float]
    rotor_speed: tuple[float, float]
    pressure: tuple[float, float]
    error: float


@dataclass(frozen=True, kw_only=True)
class Margin:
    """
    Distance of one parameter from a stability boundary.

    Parameters
    ----------
    parameter : str
        'friction', 'rotor_speed' or 'pressure'.
    kind : str
        'squeal': modes in the squeal band; 'groan': below it; 'divergence': modes that do not
        oscillate.
    present : float
        Present value of the parameter.
    critical : float
        Value at the boundary; NaN where there is none, or none is known.
    growth_rate : float
        At the critical value [1/s]; where a mode jumps into the band, of that mode there.
    frequency_hz : float
        Of the mode that is unstable on one side of the boundary.
    confirmed : bool
        Whether a full solution at the critical value, at this tick, has this growth rate, too.
    reason : str
        The result in words.

    """

    parameter: Parameter
    kind: Kind
    present: float
    critical: float = math.nan
    growth_rate: float = math.nan
    frequency_hz: float = math.nan
    confirmed: bool = False
    reason: str

    @property
    def value(self) -> float:
        """Critical minus present value; NaN where there is none."""
        return self.critical - self.present


@dataclass
class MarginStatistics:
    """Counts of full solutions at critical values since the start."""

    confirmed: int = 0
    not_confirmed: int = 0


@dataclass(frozen=True, eq=False)
class Margins:
    """
    Margins of a brake: that of friction, and the others on request.

    Parameters
    ----------
    friction : Margin
    compute_other : callable, optional
        Returns the margin of a name of `OTHERS`; None: there is no table.

    """

    friction: Margin
    compute_other: Callable[[OtherMargin], Margin] | None = None


def least_stable(eigenvalues: ComplexArray, kind: Kind, band_hz: tuple[float, float],
                 tolerances: Tolerances) -> ComplexArray:
    """
    Return the least stable eigenvalue of a kind in each row (P,) [1/s].

    Parameters
    ----------
    eigenvalues : (P, n) array
        One eigenvalue of each mode, Im >= 0; NaN: none.
    kind : str
        See `Margin`.
    band_hz : (2,) floats
        The squeal band.
    tolerances : Tolerances
        What counts as oscillation.

    """
    low, high = (2.0 * math.pi * end for end in band_hz)
    frequency = eigenvalues.imag
    meant = frequency > tolerances.oscillation
    if kind == 'squeal':
        meant &= (frequency >= low) & (frequency <= high)
    elif kind == 'groan':
        meant &= frequency < low
    else:
        meant = frequency <= tolerances.oscillation
    growth = np.where(meant, eigenvalues.real, -np.inf)
    result = eigenvalues[np.arange(len(eigenvalues)), growth.argmax(axis=1)]
    return np.where(meant.any(axis=1), result, NO_MODE)
