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
from functools import cached_property
from typing import NamedTuple

import numpy as np
from squeal_core.brake.operating_point import OperatingPoints
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model.operators import ContactFace

SLOWEST_SLIDING = 0.02  # m/s, below which friction is viscous, so that its direction stays smooth


class ContactForces(NamedTuple):
    """
    Generalised forces [m/s^2 kg^1/2], (N, B) each.

    `normal` is what is missing to the springs' pull of a closed contact, `friction` the whole.
    """

    normal: FloatArray
    friction: FloatArray


class NonlinearContact:
    """
    Contact of both pads at its Q quadrature points.

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
    >>> from squeal_core.brake.operating_point import OperatingPoints
    >>> from squeal_core.model.operators import ContactFace
    >>> from squeal_core.simulation.contact import NonlinearContact
    >>> face = ContactFace(normal=np.array([[-1.0], [1.0]]), tangential=np.zeros((2, 1)),
    ...                    radial=np.zeros((2, 1)), spin=np.zeros((2, 1)),
    ...                    radius=np.array([0.1]), weight=np.array([1.0]))
    >>> points = OperatingPoints.of(rotor_speed=5.0, friction=0.4, contact_pressure=1e6,
    ...                             contact_stiffness=1e10)
    >>> contact = NonlinearContact([face]).at(points, closed_stiffness=1e10)
    >>> contact.normal_stress(np.array([[1e-3], [0.0]]), np.zeros((2, 1)))
    array([[0.]])
    >>> contact.normal_stress(np.array([[0.0], [1e-5]]), np.zeros((2, 1)))
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
        self.pull = np.ascontiguousarray(-(self.weight * self.normal).T)
        self.drag = np.ascontiguousarray(-(np.vstack([self.weight] * 2) * self.in_plane).T)

    @property
    def stiffness(self) -> FloatArray:
        """A0 of the points [m^2/kg], (N, N)."""
        return np.asarray(-self.pull @ self.normal)

    @cached_property
    def mobility(self) -> float:
        """Largest eigenvalue of the points' in-plane sums int t^T t + r^T r dA [m^2/kg]."""
        return float(np.linalg.norm(self.drag @ self.in_plane, 2))

    def at(self, points: OperatingPoints, *, closed_stiffness: float,
           damping_ratio: FloatArray | float = 1.0) -> 'LoadedContact':
        """
        Return the contact of B brakes.

        Parameters
        ----------
        points : OperatingPoints
            One for each brake; damping scales do not count.
        closed_stiffness : float
            k_c [N/m^3] of the closed contact whose springs and dashpots the caller has already.
        damping_ratio : float or (B,) array
            Factor on the dashpots, on those that the caller has, too.

        """
        return LoadedContact(self, points, closed_stiffness, damping_ratio)


class LoadedContact:
    """Contact of B brakes at one operating point each; `NonlinearContact.at` returns it."""

    def __init__(self, contact: NonlinearContact, points: OperatingPoints,
                 closed_stiffness: float, damping_ratio: FloatArray | float = 1.0) -> None:
        self._c, self._points, self._closed = contact, points, closed_stiffness
        self._retardation = damping_ratio * contact.retardation_time
        self._preload = points.contact_pressure
        self._slip = points.rotor_speed * contact.radius
        self._friction_size = np.abs(points.friction)
        self._steady = points.friction * points.contact_pressure
        self._sloped = bool(np.any(points.friction_slope))
        self._as_closed = bool(np.all(points.contact_stiffness == closed_stiffness))
        self._none = np.zeros((len(contact.pull), len(points)))

    def normal_stress(self, a: FloatArray, rate: FloatArray) -> FloatArray:
        """Return p [Pa], (Q, B), of coordinates and their rates (N, B); zero where it is open."""
        return np.maximum(self._spring(a, rate) + self._preload, 0.0)

    def _spring(self, a: FloatArray, rate: FloatArray) -> FloatArray:
        spring = self._c.normal @ (
            a + self._retardation * rate if self._c.retardation_time else a)
        spring *= self._points.contact_stiffness
        return np.asarray(spring)

    def forces(self, a: FloatArray, rate: FloatArray) -> ContactForces:
        """Return the forces on top of steady sliding at coordinates and their rates (N, B)."""
        stress = self._spring(a, rate)
        stress += self._preload
        normal = self._none
        if not self._as_closed or stress.min() < 0.0:
            closed = (stress - self._preload) * (self._closed / self._points.contact_stiffness)
            np.maximum(stress, 0.0, out=stress)
            normal = self._c.pull @ (stress - self._preload - closed)
        return ContactForces(normal, self._friction(a, rate, stress))

    def _friction(self, a: FloatArray, rate: FloatArray, stress: FloatArray) -> FloatArray:
        """Return the force of friction; `stress` is overwritten."""
        velocity = self._c.in_plane @ rate
        along, across = velocity[:len(stress)], velocity[len(stress):]
        along += self._slip
        if self._c.spin is not None:
            across += self._points.rotor_speed * (self._c.spin @ a)
        speed = along * along
        speed += across * across
        np.sqrt(speed, out=speed)
        stress *= self._coefficient(speed) if self._sloped else self._friction_size
        np.maximum(speed, SLOWEST_SLIDING, out=speed)
        stress /= speed
        along *= stress
        along -= self._steady
        across *= stress
        return np.asarray(self._c.drag @ velocity)

    def _coefficient(self, speed: FloatArray) -> FloatArray:
        """Return mu(|V|) [-]: the exponential law through mu and its slope at steady sliding."""
        decay = self._c.decay
        faster = speed - np.abs(self._slip)
        bent = np.expm1(-decay * faster) / -decay if decay else faster
        return np.asarray(self._friction_size + self._points.friction_slope * bent)

    def spring_energy(self, a: FloatArray) -> FloatArray:
        """
        Return what the springs hold beyond those of the closed contact [J], (B,).

        The work of the preload is in it: p^2 / 2 k_c - p0 g - p0^2 / 2 k_c less k g^2 / 2.
        """
        k, p0, g = self._points.contact_stiffness, self._preload, self._c.normal @ a
        p = np.maximum(p0 + k * g, 0.0)
        density = (p**2 - p0**2) / (2.0 * k) - p0 * g - 0.5 * self._closed * g**2
        return np.asarray((self._c.weight * density).sum(axis=0))

    def check_step(self, step: float) -> None:
        """
        Refuse a step in which friction across the slowest sliding would not be stable.

        Raises
        ------
        SquealError
            With the step and the speed.

        """
        slowest = np.maximum(np.abs(self._slip).min(axis=0), SLOWEST_SLIDING)
        ratio = float(np.max(step * np.abs(self._steady) * self._c.mobility / slowest))
        if ratio > 1.0:
            raise SquealError(f'step: {step:.3g} s is {ratio:.2g} times what friction allows at '
                              f'{slowest.min():.3g} m/s of sliding; give a shorter step')
