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

"""The nonlinear contact force on a face of a sliding disc, and its derivatives by differences."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from squeal_core import OperatingPoint
from squeal_core.brake.dimensions import Contact
from squeal_core.common.arrays import FloatArray
from squeal_core.model import operators
from squeal_core.model.operators import ContactFace
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.planar_mesh import sector_quadrature

PATCH = Contact(inner_radius=0.1, outer_radius=0.142, angle=np.deg2rad(62.0), stiffness=0.35e11)
HALF = 0.008
PADS, DISC = 3, 5
ORDER = 2 * PADS + DISC
INSTANT = 1e-30j  # of time [s], for derivatives that are exact to rounding


@dataclass(frozen=True)
class Shapes:
    """Modes c (r / 0.12)^power (1 + tilt z) cos(n theta + phase), numbers each (3, N)."""

    c: FloatArray
    n: FloatArray
    phase: FloatArray
    power: FloatArray
    tilt: FloatArray

    def __call__(self, r: FloatArray, t: FloatArray, z: FloatArray) -> FloatArray:
        """u_r, u_t, u_z of each mode, (3, N, Q); t may be complex."""
        return self._profile(r, z) * np.cos(self._argument(t))

    def dtheta(self, r: FloatArray, t: FloatArray, z: FloatArray) -> FloatArray:
        return -self.n[..., None] * self._profile(r, z) * np.sin(self._argument(t))

    def sampled(self, q: Quadrature) -> SampledShapes:
        at = (q.radius, q.angle, q.height)
        return SampledShapes(*self(*at), *self.dtheta(*at), q)

    def _profile(self, r: FloatArray, z: FloatArray) -> FloatArray:
        c, p, tilt = (x[..., None] for x in (self.c, self.power, self.tilt))
        return c * (r / 0.12) ** p * (1.0 + tilt * z)

    def _argument(self, t: FloatArray) -> FloatArray:
        return self.n[..., None] * t + self.phase[..., None]


def random_shapes(seed: int, count: int) -> Shapes:
    rng, size = np.random.default_rng(seed), (3, count)
    return Shapes(rng.standard_normal(size), rng.integers(0, 6, size).astype(float),
                  rng.uniform(0, 6, size), rng.uniform(-1, 3, size), rng.uniform(-80, 80, size))


@dataclass(frozen=True)
class Sliding:
    """One face under load: its side (+1 top, -1 bottom) and its friction, mu + slope * speed."""

    side: int
    speed: float = 5.0
    friction: float = 0.42
    slope: float = 0.0
    pressure: float = 6e5
    stiffness: float = 0.35e11
    retardation_time: float = 0.0
    displacement_moves_friction: bool = False

    @property
    def point(self) -> OperatingPoint:
        """Return it for the operators: backwards, friction is negative and the slope is not."""
        return OperatingPoint(
            rotor_speed=self.speed, friction=float(np.copysign(self.friction, self.speed)),
            friction_slope=self.slope, contact_pressure=self.pressure,
            contact_stiffness=self.stiffness)

    @cached_property
    def quadrature(self) -> Quadrature:
        return sector_quadrature(PATCH, self.side * HALF, panels=(1, 2), points=4)

    @cached_property
    def shapes(self) -> tuple[Shapes, Shapes]:
        """Of the pad and of the disc."""
        return random_shapes(10 + self.side, PADS), random_shapes(20, DISC)

    @cached_property
    def shape_values(self) -> tuple[FloatArray, FloatArray]:
        """Of the pad and of the disc, at the points that are just there."""
        q, (pad, disc) = self.quadrature, self.shapes
        return pad(q.radius, q.angle, q.height), disc(q.radius, q.angle, q.height)

    @cached_property
    def turned_values(self) -> FloatArray:
        """Of the disc, at the points that are there a complex instant later."""
        q, (_, disc) = self.quadrature, self.shapes
        return disc(q.radius, q.angle + self.speed * INSTANT, q.height)

    @cached_property
    def face(self) -> ContactFace:
        q, (pad, disc) = self.quadrature, self.shapes
        build = operators.top_face if self.side > 0 else operators.bottom_face
        return build(pad.sampled(q), disc.sampled(q), PADS)

    def split(self, a: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coordinates of this face's pad and of the disc."""
        disc = a[PADS:PADS + DISC]
        return (a[:PADS] if self.side > 0 else a[PADS + DISC:]), disc

    def disc_velocity(self, a: FloatArray, rate: FloatArray) -> FloatArray:
        """Velocity (3, Q), polar, of the disc's points that are just at (r, theta)."""
        q = self.quadrature
        angle = q.angle + self.speed * INSTANT  # of the points that are at theta for t = 0
        field = np.tensordot(self.turned_values, a + INSTANT * rate, (1, 0))
        out, along = q.radius + field[0], field[1]
        position = np.array([out * np.cos(angle) - along * np.sin(angle),
                             out * np.sin(angle) + along * np.cos(angle), q.height + field[2]])
        x, y, z = position.imag / INSTANT.imag
        c, s = np.cos(q.angle), np.sin(q.angle)
        return np.array([c * x + s * y, c * y - s * x, z])

    def relative_velocity(self, a: FloatArray, rate: FloatArray) -> FloatArray:
        """Disc minus friction material, which keeps to the pad in plane and to the disc in z."""
        pad, disc = self.shape_values
        (_, _), (pad_rate, disc_rate) = self.split(a), self.split(rate)
        material = np.tensordot(pad, pad_rate, (1, 0))
        material[2] = np.tensordot(disc[2], disc_rate, (0, 0))
        return self.disc_velocity(self.split(a)[1], disc_rate) - material

    def force(self, a: FloatArray, rate: FloatArray) -> FloatArray:
        """Integrate normal and friction forces on disc and pad."""
        q, (pad_shape, disc_shape) = self.quadrature, self.shape_values
        # the layer stays over its point of the pad, so that its rate is that at a fixed place
        strain, strain_rate = (
            self.side * (np.tensordot(disc_shape[2], disc_part, (0, 0))
                         - np.tensordot(pad_shape[2], pad_part, (0, 0)))
            for pad_part, disc_part in (self.split(a), self.split(rate)))
        normal = self.pressure + self.stiffness * (strain + self.retardation_time * strain_rate)
        velocity = self.relative_velocity(a, rate)
        speed = np.linalg.norm(velocity, axis=0)
        usual = np.linalg.norm(self.relative_velocity(a, 0.0 * rate), axis=0)
        if self.displacement_moves_friction:
            usual = abs(self.speed) * q.radius
        friction = (self.friction + self.slope * (speed - usual)) * normal * velocity / speed
        on_disc = np.array([-friction[0], -friction[1], -self.side * normal]) * q.weight
        work = np.zeros(ORDER)
        pad_work, disc_work = self.split(work)
        disc_work += np.einsum('iq,inq->n', on_disc, disc_shape)
        pad_work -= np.einsum('iq,inq->n', on_disc, pad_shape)
        return work

    def stiffness_matrix(self) -> FloatArray:
        """-dQ/da about steady sliding."""
        return -jacobian(lambda a: self.force(a, np.zeros(ORDER)), 1e-5)

    def damping_matrix(self) -> FloatArray:
        """-dQ/d(rate of a) about steady sliding."""
        return -jacobian(lambda rate: self.force(np.zeros(ORDER), rate), 1e-4 * abs(self.speed))


def jacobian(function: Callable[[FloatArray], FloatArray], step: float) -> FloatArray:
    """Fourth-order central differences, a column for each coordinate."""
    def column(unit: FloatArray) -> FloatArray:
        near, far = (function(h * unit) - function(-h * unit) for h in (step, 2.0 * step))
        return (8.0 * near - far) / (12.0 * step)

    return np.column_stack([column(unit) for unit in np.eye(ORDER)])
