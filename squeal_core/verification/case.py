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

"""A model at K09's operating points, and the modes and pairs that the paper discusses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Mode
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mode_tracking import identify
from squeal_core.stability.parameter_paths import moved
from squeal_core.verification.paper import (
    ADDED,
    FAST,
    FRICTION,
    Pair,
    PRELOAD,
    SLOW,
    TORSION,
)


@dataclass(frozen=True)
class Case:
    """A model at K09's operating points."""

    model: BrakeModel

    def at(self, speed: float, *, friction: float = FRICTION,
           stiffness: float = 1.0) -> OperatingPoint:
        """Return a point with constant friction; speed in rad/s, stiffness over nominal."""
        return OperatingPoint(
            rotor_speed=speed, friction=friction,
            contact_pressure=PRELOAD / self.model.contact_area,
            contact_stiffness=stiffness * self.model.nominal_contact_stiffness)

    def by_law(self, speed: float) -> OperatingPoint:
        """Return a point with friction and slope by K09's law (fig. 9)."""
        return moved(self.model, self.at(speed), 'rotor_speed', speed, friction_law=True)

    @property
    def rigid(self) -> NDArray[np.bool_]:
        """Return whether each component mode (N,) is a motion of a pad as a rigid body."""
        return np.asarray(self.model.angular_frequencies == 0.0)

    def energy(self, point: OperatingPoint, mode: Mode) -> FloatArray:
        """Return the parts (N,) of the kinetic energy that component modes have."""
        right = np.abs(mode_vectors(self.model, point, mode.eigenvalue).right)**2
        return np.asarray(right / right.sum())

    def of_torsion(self, modes: ComplexModes, point: OperatingPoint) -> Mode:
        """Return the mode with the most in-plane torsion of the disc."""
        place = self.model.names.index(TORSION)
        near = self.model.angular_frequencies[place]
        return max((mode for mode in modes.modes if abs(mode.eigenvalue.imag / near - 1.0) < 0.05),
                   key=lambda mode: self.energy(point, mode)[place])

    def pair(self, numbers: Pair, point: OperatingPoint) -> tuple[Mode, Mode]:
        """Return the modes that carry two numbers, worst first."""
        result = identify(self.model, point).of(numbers)
        return result[0], result[-1]

    def critical_friction(self, numbers: Sequence[int], *, stiffness: float = 1.0) -> float:
        """Return mu at which the modes of these numbers start to grow, at 5 rad/s."""
        return critical_value(self.model, self.at(SLOW, friction=0.3, stiffness=stiffness),
                              'friction', (0.0, 0.8), numbers=numbers,
                              samples=16, tolerance=1e-4).nearest.value

    def critical_speed(self, numbers: Sequence[int], start: float) -> float:
        """Return the speed at which these modes start or cease to grow, friction by its law."""
        return critical_value(self.model, self.by_law(start), 'rotor_speed', (0.25, 25.0),
                              numbers=numbers, ray=self.by_law, samples=25,
                              tolerance=1e-4).nearest.value

    def soft_pair(self, stiffness: float) -> tuple[Mode, Mode]:
        """Return the fastest growing mode of pads that move as rigid bodies, and its neighbour."""
        point = self.at(SLOW, stiffness=stiffness)
        modes = complex_modes(self.model, point)
        worst = next((mode for mode in modes.unstable if mode.kind == 'flutter'
                      and self.energy(point, mode)[self.rigid].sum() > 0.25), modes.modes[-1])
        return worst, min((mode for mode in modes.modes if mode != worst),
                          key=lambda mode: gap(worst, mode))


def pairs(modes: ComplexModes) -> dict[Pair, Mode]:
    """Return the flutter modes by the numbers of each and of its neighbour in frequency."""
    result = {}
    for mode in modes.unstable:
        if mode.kind == 'flutter':
            near = min((other for other in modes.modes if other != mode),
                       key=lambda other: gap(mode, other))
            result[min(mode.index, near.index), max(mode.index, near.index)] = mode
    return dict(sorted(result.items()))


def added_pairs(case: Case) -> tuple[dict[Pair, Mode], dict[Pair, Pair], dict[Pair, Mode]]:
    """Return the pairs at 5 rad/s, what K09's two further ones are here, and all added at 20."""
    before, after = (pairs(complex_modes(case.model, case.at(speed))) for speed in (SLOW, FAST))
    added = {pair: mode for pair, mode in after.items() if pair not in before}
    meant = {pair: min(added, key=lambda own: abs(own[0] - pair[0]), default=(0, 0))
             for pair in ADDED}
    return before, meant, added


def gap(first: Mode, second: Mode) -> float:
    """Return the distance of two frequencies [Hz]."""
    return abs(first.frequency_hz - second.frequency_hz)


def merged(first: Mode, second: Mode) -> bool:
    """Return whether two eigenvalues differ more in growth than in frequency: past merging."""
    return ((first.eigenvalue - second.eigenvalue)**2).real > 0.0
