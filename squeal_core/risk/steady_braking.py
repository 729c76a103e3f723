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

"""Squeal risk of a steady braking: the ensemble at one operating point, and changes of it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
import math
from typing import TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.build_up import grown, nepers, noise_decay, saturation_energy
from squeal_core.risk.ensemble import Ensemble
from squeal_core.risk.scatter import along_scatter, at_nodes, exceedance
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND
from squeal_core.stability.sensitivity import parameter_sensitivity

_LEAST_FRICTION = 0.02  # of a member, as in growth emulators
_CANDIDATES = 8  # least stable modes of a member; a more stable one is not heard first

Slopes: TypeAlias = Callable[[int, Sequence[complex]], FloatArray]
"""Derivatives of growth rates over a parameter, by member and eigenvalues."""


@dataclass(frozen=True)
class _Member:
    """One brake of the ensemble, solved: eigenvalues, scatter, decay and limits of build-up."""

    place: int
    eigenvalues: ComplexArray
    scatter: float
    decay: FloatArray
    cap: float
    audible: float

    def margin(self, duration: float, change: FloatArray | float = 0.0) -> FloatArray:
        """Return the largest build-up less N* at the nodes (7,) with changed growth rates."""
        rates = at_nodes(self.eigenvalues.real + change, np.array(self.scatter))
        energy = grown(np.ones(self.eigenvalues.size), rates, duration, self.decay,
                       np.array(self.cap))
        return np.asarray(nepers(energy).max(axis=1, initial=0.0) - self.audible)


@dataclass(frozen=True)
class SteadyBraking:
    """
    A brake application at one operating point, from the noise floor on.

    Parameters
    ----------
    model : BrakeModel
    point : OperatingPoint
        Of the brake as modelled; members of the ensemble differ from it.
    ensemble : Ensemble
    duration : float
        Of the braking [s].
    band_hz : (2,) floats
        Squeal band.

    """

    model: BrakeModel
    point: OperatingPoint
    ensemble: Ensemble
    duration: float
    band_hz: tuple[float, float] = SQUEAL_BAND

    @cached_property
    def risk(self) -> float:
        """Probability that some mode of the band is heard by the end."""
        return self._risk([member.margin(self.duration) for member in self._solved])

    def member_point(self, point: OperatingPoint, place: int) -> OperatingPoint:
        """Return the operating point of a member; the friction slope goes with friction."""
        members = self.ensemble
        measured = abs(point.friction) or _LEAST_FRICTION
        friction = max(measured + float(members.friction_bias[place]), _LEAST_FRICTION)
        return replace(
            point, friction=math.copysign(friction, point.friction or point.rotor_speed),
            friction_slope=float(members.slope_scale[place]) * point.friction_slope
            * friction / measured,
            contact_stiffness=math.exp(members.ln_contact_stiffness[place])
            * point.contact_stiffness,
            damping_scale=math.exp(members.ln_damping[place]) * point.damping_scale)

    def risk_change(self, slopes: Slopes, amount: float) -> float:
        """
        Return half the change of the risk from minus to plus an amount of a parameter.

        Parameters
        ----------
        slopes : callable
            Derivatives of growth rates over the parameter (n,) [1/s], by the place of a member and
            eigenvalues (n,): to first order they change by the amount times these.
        amount : float
            Change of the parameter.

        """
        changes = [amount * slopes(member.place, member.eigenvalues.tolist())
                   for member in self._solved]
        pairs = list(zip(self._solved, changes, strict=True))
        minus, plus = (self._risk([member.margin(self.duration, side * change)
                                   for member, change in pairs]) for side in (-1.0, 1.0))
        return 0.5 * (plus - minus)

    def _risk(self, margins: Sequence[FloatArray]) -> float:
        return float(self.ensemble.weights @ exceedance(np.stack(margins, axis=1)))

    @cached_property
    def _solved(self) -> tuple[_Member, ...]:
        return tuple(self._member(place) for place in range(self.ensemble.count))

    @cached_property
    def _without_friction(self) -> ComplexArray:
        return complex_modes(self.model, replace(
            self.point, friction=0.0, friction_slope=0.0)).oscillatory

    def _member(self, place: int) -> _Member:
        point = self.member_point(self.point, place)
        result = complex_modes(self.model, point).least_stable(*self.band_hz, _CANDIDATES)
        eigenvalues = np.array([mode.eigenvalue for mode in result], complex)
        still = self._without_friction
        nearest = np.abs(np.subtract.outer(eigenvalues.imag, still.imag)).argmin(axis=1)
        own = math.exp(self.ensemble.ln_damping[place]) * -still.real[nearest]
        return _Member(
            place, eigenvalues, self._scatter(point, eigenvalues[:1]),
            noise_decay(own, eigenvalues.imag / math.tau),
            float(saturation_energy(point.contact_pressure, point.contact_stiffness)),
            float(self.ensemble.audible_build_up[place]))

    def _scatter(self, point: OperatingPoint, worst: ComplexArray) -> float:
        """Return the change of the worst growth rate over a standard deviation of scatter."""
        for eigenvalue in worst.tolist():
            by = {name: slope.real
                  for name, slope in parameter_sensitivity(self.model, point, eigenvalue).items()}
            by_friction = math.copysign(1.0, point.friction) * (
                by['friction'] + by['friction_slope'] * point.friction_slope / point.friction)
            return float(along_scatter(
                np.array(self.ensemble.friction_scatter * by_friction),
                np.array(self.ensemble.damping_scatter * point.damping_scale
                         * by['damping_scale'])))
        return 0.0
