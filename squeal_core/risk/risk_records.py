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

"""Inputs and results of a squeal risk."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, IndexArray, RealArray, repr_with_shapes
from squeal_core.risk.build_up import FLOOR, noise_decay
from squeal_core.risk.emulator_records import EmulatedGrowth, EmulatorError
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.stability.eigensolution import SQUEAL_BAND


class GrowthSource(Protocol):
    """Members of a `GrowthEmulator` that a squeal risk uses."""

    @property
    def families(self) -> tuple[ModeFamily, ...]: ...

    @property
    def error(self) -> EmulatorError: ...

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth: ...


def families_in(band_hz: tuple[float, float], families: Sequence[ModeFamily]
                ) -> tuple[IndexArray, FloatArray, FloatArray]:
    """Return places, frequencies [Hz] and decay rates [1/s] of the families in a band."""
    low, high = band_hz
    frequency = np.array([family.frequency_hz for family in families])
    places = np.flatnonzero((frequency >= low) & (frequency <= high))
    decay = noise_decay([family.decay_rate for family in families], frequency)
    return places, frequency[places], decay[places]


@dataclass(frozen=True, kw_only=True)
class RiskSettings:
    """
    Settings of a squeal risk.

    Parameters
    ----------
    band_hz : (2,) floats
        Squeal band; families outside it do not count.
    instability_damping_ratio : float
        zeta*: a mode counts as unstable below a damping ratio of -zeta*. 0, or 0.0025 to 0.005 as
        in industry, whose "damping" of -0.5 to -1 % is twice that.
    longest_interval : float
        Time between two ticks [s] beyond which nothing is known of what was between them.
    noise_floor : float
        Root mean square relative displacement at the contact to which noise excites a mode [m].

    """

    band_hz: tuple[float, float] = SQUEAL_BAND
    instability_damping_ratio: float = 0.0
    longest_interval: float = 0.5
    noise_floor: float = FLOOR


class MemberGrowth(NamedTuple):
    """
    Growth of F families of M members at a tick, or at many: leading axes are of ticks.

    Attributes
    ----------
    rate, frequency_hz : (..., F, M) arrays
        Growth rate [1/s] and frequency of the least stable mode of each family.
    scatter : (..., F, M) array
        Change of the growth rate over one standard deviation of its scatter [1/s].
    cap : (..., M) array
        Energy at saturation over the floor's; infinite for members that are not known.
    known : (..., M) array of bool
        Whether the emulator covers the member.

    """

    rate: RealArray
    frequency_hz: RealArray
    scatter: RealArray
    cap: RealArray
    known: NDArray[np.bool_]

    def at(self, tick: int) -> 'MemberGrowth':
        """Return that of one of many ticks."""
        return MemberGrowth(*(values[tick] for values in self))


@dataclass(frozen=True, eq=False, kw_only=True)
class RiskResult:
    """
    Squeal risk of one brake at one tick.

    Parameters
    ----------
    squeal_risk : float
        Probability that the build-up of some family in the band exceeds N* now [-].
    error : float
        Standard deviation of its error, by the number of members and the emulator [-].
    peak_risk : float
        Probability that it has since the start of the brake application [-].
    instability_probability : float
        Probability that some family in the band has a damping ratio below -zeta* [-].
    build_up : float
        Largest build-up of a family in the band [nepers]: the median of the members.
    family_build_up : (F,) array
        Of each family in the band [nepers], likewise.
    time_to_squeal : float
        Until N* at the present growth [s], the median of the members; 0: exceeded, inf: never.
    family : int
        Index of the emulator's family that most of the risk is of; -1: none in the band.
    frequency_hz : float
        Its mean frequency [Hz].
    calibrated : bool
        Whether measured squeal has gone into the ensemble.
    incomplete : bool
        Whether a part of this brake application is not known.
    basis : str
        In words: what the level of the risk rests on.

    """

    squeal_risk: float
    error: float
    peak_risk: float
    instability_probability: float
    build_up: float
    family_build_up: RealArray
    time_to_squeal: float
    family: int
    frequency_hz: float
    calibrated: bool
    incomplete: bool
    basis: str

    __repr__ = repr_with_shapes

    def __str__(self) -> str:
        return f'{self.squeal_risk:.2f} +- {self.error:.2f} ({self.basis})'


class ApplicationState(NamedTuple):
    """
    Build-up of all members over a brake application, at the nodes of the scatter, up to a tick.

    Attributes
    ----------
    energy : (7, F, M) array
        Of each family over its floor.
    peak : (7, 1, M) array
        The largest of all families since the start of the application.
    growing : (7, M) array
        Time since then in which some family grew [s].
    growth : MemberGrowth
        Of the tick.
    incomplete : bool
        Whether a part of the application is not known.

    """

    energy: RealArray
    peak: RealArray
    growing: RealArray
    growth: MemberGrowth
    incomplete: bool
