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


"""
Contact forces without linearisation: contact that opens, friction along the sliding velocity.

At each contact point the normal stress is p = max(0, p0 + k_c (g + tau dg/dt)), g = n a being the
approach of the surfaces and tau k_c a dashpot beside the springs; friction on the disc is
-mu(|V|) p V / |V| with the sliding velocity V = (Omega r + t a', r a' [+ Omega e a]), K09 eqs
(5)-(15). Forces are those on top of steady sliding, at which a = 0 rests.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.common.errors import SquealError
from squeal_core.model.operators import ContactFace

SLOWEST_SLIDING = 0.02  # m/s, below which friction is viscous, so that its direction stays smooth


@dataclass(frozen=True, kw_only=True, eq=False)
class SlidingState:
    """
    Where each of B brakes operates at one time.

    Parameters
    ----------
    rotor_speed : (B,) array
        Omega [rad/s], negative backwards.
    contact_pressure : (B,) array
        p0 [Pa].
    friction, friction_slope : (B,) arrays
        mu [-], positive, and d mu / d v [s/m] at steady sliding.
    contact_stiffness : (B,) array
        k_c [N/m^3].

    """

    rotor_speed: FloatArray
    contact_pressure: FloatArray
    friction: FloatArray
    friction_slope: FloatArray
    contact_stiffness: FloatArray

    __repr__ = repr_with_shapes

    @classmethod
    def of(cls, points: Sequence[OperatingPoint]) -> 'SlidingState':
        """Return the state of brakes at operating points."""
        values = {item.name: np.array([getattr(point, item.name) for point in points])
                  for item in fields(cls)}
        return cls(**{**values, 'friction': np.abs(values['friction'])})


class ContactForces(NamedTuple):
    """
    Generalised forces [m/s^2 kg^1/2], (N, B) each.

    `normal` is what is missing to the springs' pull of a closed contact, `friction` the whole.
    """

    normal: FloatArray
    friction: FloatArray


class NonlinearContact:
    """
    Contact of both pads at its quadrature points, for B brakes at once.

    Parameters
    ----------
    faces : sequence of ContactFace
        `contact_points` of a model.
    decay : float
        alpha [s/m] of the friction law: how mu bends away from its slope.
    retardation_time : float
        tau [s]: dashpots of tau k_c beside the contact springs.
    follower : bool
        Whether the disc's turning tilts the sliding direction (e a), as in F0.

    Examples
    --------
    One point, 1 m^2 at r = 0.1 m; a pad (first mode) that lifts off by 1 mm bears nothing:

    >>> import numpy as np
    >>> from squeal_core.model.operators import ContactFace
    >>> face = ContactFace(normal=np.array([[-1.0], [1.0]]), tangential=np.zeros((2, 1)),
    ...                    radial=np.zeros((2, 1)), spin=np.zeros((2, 1)),
    ...                    radius=np.array([0.1]), weight=np.array([1.0]))
    >>> contact = NonlinearContact([face])
    >>> state = SlidingState.of([OperatingPoint(rotor_speed=5.0, friction=0.4,
    ...                                         contact_pressure=1e6, contact_stiffness=1e10)])
    >>> contact.normal_stress(np.array([[1e-3], [0.0]]), np.zeros((2, 1)), state)
    array([[0.]])
    >>> contact.normal_stress(np.array([[0.0], [1e-5]]), np.zeros((2, 1)), state)
    array([[1100000.]])

    """

    def __init__(self, faces: Sequence[ContactFace], *, decay: float = 1.0,
                 retardation_time: float = 0.0, follower: bool = False) -> None:
        def rows(name: str) -> FloatArray:
            return np.vstack([getattr(face, name).T for face in faces])

        self.normal, self.in_plane = rows('normal'), np.vstack([rows('tangential'),
                                                                rows('radial')])
        self.spin = rows('spin') if follower else None
        self.radius = np.concatenate([face.radius for face in faces])[:, None]
        self.weight = np.concatenate([face.weight for face in faces])[:, None]
        self.retardation_time, self.decay = retardation_time, decay
        self._pull = np.ascontiguousarray(-(self.weight * self.normal).T)
        self._drag = np.ascontiguousarray(-(np.vstack([self.weight] * 2) * self.in_plane).T)

    @property
    def stiffness(self) -> FloatArray:
        """A0 of the points [m^2/kg], (N, N)."""
        return np.asarray(-self._pull @ self.normal)

    def normal_stress(self, a: FloatArray, rate: FloatArray, state: SlidingState) -> FloatArray:
        """Return p [Pa], (Q, B), of coordinates and their rates (N, B); zero where it is open."""
        return np.maximum(state.contact_pressure + self._spring(a, rate, state), 0.0)

    def _spring(self, a: FloatArray, rate: FloatArray, state: SlidingState) -> FloatArray:
        approach = a + self.retardation_time * rate if self.retardation_time else a
        return np.asarray(state.contact_stiffness * (self.normal @ approach))

    def forces(self, a: FloatArray, rate: FloatArray, state: SlidingState, *,
               closed_stiffness: float) -> ContactForces:
        """
        Return the contact forces on top of steady sliding.

        Parameters
        ----------
        a, rate : (N, B) arrays
            Modal coordinates and their rates.
        state : SlidingState
        closed_stiffness : float
            k_c [N/m^3] of the closed contact whose springs and dashpots the caller has already.

        """
        spring = self._spring(a, rate, state)
        stress = state.contact_pressure + spring
        least = stress.min()
        if least < 0.0:
            stress = np.maximum(stress, 0.0)
        if least < 0.0 or np.any(state.contact_stiffness != closed_stiffness):
            closed = spring * (closed_stiffness / state.contact_stiffness)
            normal = self._pull @ (stress - state.contact_pressure - closed)
        else:
            normal = np.zeros_like(a)
        return ContactForces(normal, self._friction(a, rate, stress, state))

    def _friction(self, a: FloatArray, rate: FloatArray, stress: FloatArray,
                  state: SlidingState) -> FloatArray:
        velocity = self.in_plane @ rate
        along, across = velocity[:self.radius.size], velocity[self.radius.size:]
        along += state.rotor_speed * self.radius
        if self.spin is not None:
            across += state.rotor_speed * (self.spin @ a)
        speed = np.sqrt(along * along + across * across)
        drag = self._coefficient(speed, state) * stress / np.maximum(speed, SLOWEST_SLIDING)
        along *= drag
        along -= np.sign(state.rotor_speed) * state.friction * state.contact_pressure
        across *= drag
        return np.asarray(self._drag @ velocity)

    def _coefficient(self, speed: FloatArray, state: SlidingState) -> FloatArray:
        """Return mu(|V|) [-]: the exponential law through mu and its slope at steady sliding."""
        if not np.any(state.friction_slope):
            return state.friction
        faster = speed - np.abs(state.rotor_speed) * self.radius
        if self.decay == 0.0:
            return np.asarray(state.friction + state.friction_slope * faster)
        return np.asarray(state.friction - state.friction_slope / self.decay
                          * np.expm1(-self.decay * faster))

    def spring_energy(self, a: FloatArray, state: SlidingState, *,
                      closed_stiffness: float) -> FloatArray:
        """
        Return what the springs hold beyond those of a closed contact [J], (B,).

        The work of the preload is in it: p^2 / 2 k_c - p0 g - p0^2 / 2 k_c less k g^2 / 2.
        """
        k, p0, g = state.contact_stiffness, state.contact_pressure, self.normal @ a
        p = np.maximum(p0 + k * g, 0.0)
        density = (p**2 - p0**2) / (2.0 * k) - p0 * g - 0.5 * closed_stiffness * g**2
        return np.asarray((self.weight * density).sum(axis=0))

    def check_step(self, step: float, state: SlidingState) -> None:
        """
        Refuse a step that friction across the slowest sliding would make unstable.

        Raises
        ------
        SquealError
            With the speed and the step that are needed.

        """
        mobility = np.linalg.norm(self._drag @ self.in_plane, 2)
        slowest = np.maximum(np.abs(state.rotor_speed) * self.radius.min(), SLOWEST_SLIDING)
        ratio = float(np.max(step * state.friction * state.contact_pressure * mobility / slowest))
        if ratio > 1.0:
            raise SquealError(f'step: {step:.3g} s is {ratio:.2g} times what friction allows at '
                              f'{slowest.min():.3g} m/s of sliding; give a shorter step')
