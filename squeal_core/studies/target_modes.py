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

"""Modes that are to be made stable: at one operating point, and at their critical friction."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
import math

from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.mode_tracking import identify, Identity, Tracked
from squeal_core.stability.parameter_paths import moved

OTHERS = 12  # least stable modes of the band that side effects are looked for in


@dataclass(frozen=True)
class TargetMode:
    """
    A mode that is to be made stable, at an operating point.

    Parameters
    ----------
    identity : Identity
    point : OperatingPoint
    eigenvalue : complex
        [1/s].
    critical_friction : float
        Where its growth rate crosses zero along friction, nearest; NaN: nowhere from 0 to 1.
    critical_eigenvalue : complex
        There [1/s].
    others : tuple of (Identity, complex)
        Further modes of the band, least stable first.

    """

    identity: Identity
    point: OperatingPoint
    eigenvalue: complex
    critical_friction: float
    critical_eigenvalue: complex
    others: tuple[tuple[Identity, complex], ...]

    @property
    def frequency_hz(self) -> float:
        return self.eigenvalue.imag / math.tau

    @property
    def growth_rate(self) -> float:
        """Re(lambda) [1/s]."""
        return self.eigenvalue.real


def target_modes(model: BrakeModel, point: OperatingPoint, tracked: Tracked,
                 chosen: Collection[int], count: int,
                 band_hz: tuple[float, float]) -> list[TargetMode]:
    """
    Return chosen modes at a point, or the `count` least stable ones of a band.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Where the modes are looked at.
    tracked : Tracked
        All modes there.
    chosen : collection of int
        Numbers of modes; empty: the least stable ones.
    count : int
        How many, where none is chosen.
    band_hz : (2,) floats
        Squeal band.

    """
    def named(modes: Iterable[Mode]) -> list[tuple[Identity, complex]]:
        return [(tracked.identity(mode), mode.eigenvalue) for mode in modes]

    every = named(sorted(
        (mode for mode in tracked.modes if mode.eigenvalue.imag > 0.0
         and band_hz[0] <= mode.frequency_hz <= band_hz[1]), key=lambda mode: -mode.growth_rate))
    wanted = named(mode for number in chosen for mode in tracked.of([number])[:1]
                   ) if chosen else every[:count]
    result = []
    for identity, eigenvalue in dict.fromkeys(wanted):
        others = tuple(other for other in every
                       if set(other[0].numbers).isdisjoint(identity.numbers))[:OTHERS]
        critical, there = _critical_friction(model, point, tracked, identity, band_hz)
        result.append(TargetMode(identity, point, eigenvalue, critical, there, others))
    return result


def _critical_friction(model: BrakeModel, point: OperatingPoint, tracked: Tracked,
                       identity: Identity, band_hz: tuple[float, float]) -> tuple[float, complex]:
    """Return the nearest critical friction of a mode and its eigenvalue there, NaN without."""
    start, end = point.friction, math.copysign(1.0, point.friction)
    if tracked.of(identity.numbers)[0].unstable:
        end = 0.0
    bounds = min(start, end), max(start, end)
    if bounds[0] == bounds[1]:
        return math.nan, complex(math.nan, math.nan)
    crossing = critical_value(model, point, 'friction', bounds, numbers=identity.numbers,
                              band_hz=band_hz).nearest
    if math.isnan(crossing.value):
        return math.nan, complex(math.nan, math.nan)
    there = identify(model, moved(model, point, 'friction', crossing.value)).of(identity.numbers)
    return crossing.value, there[0].eigenvalue
