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
Transients of brakes that share one model: exact modal oscillators between kicks of the contact.

A step is symmetric (Strang): half a step of the linear system of the closed contact, exactly, by
its matrix exponential; a kick h f by contact, friction, gyroscopic forces and noise; half a step
again. Two halves between kicks are one product. f depends on the rates at the middle of its kick,
which are extrapolated from the two kicks before: one evaluation a step, error O(h^2).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from squeal_core.brake.operating_point import OperatingPoints
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation.abutment import Abutment
from squeal_core.simulation.contact import LoadedContact, NonlinearContact
from squeal_core.simulation.history import OperatingHistory
from squeal_core.simulation.modal_noise import ClosedContactModes, noise_intensity
from squeal_core.simulation.transient_block import EnergyBalance, Motion, TransientBlock

SAMPLE_RATE = 96_000  # recorded samples a second: modes of kang2009 end at 32 kHz
STEPS = 2  # steps a sample: 5.2 us
_BLOCK = 960  # samples: 10 ms
_HELD = 48  # samples in which the operating point is constant: 0.5 ms


class Transient:
    """
    Nonlinear transient of B brakes of one model.

    Parameters
    ----------
    model : BrakeModel
    faces : sequence of ContactFace
        `contact_points` of the model.
    history : OperatingHistory
        Where the brakes operate.
    floor : float
        Root mean square relative displacement at the contact to which noise excites each mode
        of the closed contact [m]; 0: no noise.
    seed : int or sequence of int
        Of the noise of all brakes, or of each, which then does not depend on the others.
    abutment : bool
        Whether the caliper's abutment carries what drives the pads away in plane; without it the
        linear part is exactly the model's.
    steps : int
        Steps of integration in a sample of 10.4 us.
    damping_scale : float or sequence of float
        Factor on the damping of components, supports and contact layer, of all brakes or of each.

    Examples
    --------
    >>> from squeal_core import BrakeModel, OperatingPoint
    >>> from squeal_core.simulation.contact_points import contact_points
    >>> model = BrakeModel.load('kang2009')
    >>> point = OperatingPoint(rotor_speed=20.0, friction=0.42, contact_pressure=6e5,
    ...                        contact_stiffness=0.35e11)
    >>> history = OperatingHistory.ramps([point], [point], 0.02)
    >>> blocks = Transient(model, contact_points(model), history).run()
    >>> [block.velocity.shape for block in blocks]
    [(960, 92, 1), (960, 92, 1)]

    """

    def __init__(self, model: BrakeModel, faces: Sequence[ContactFace], history: OperatingHistory,
                 *, floor: float = 1e-9, seed: int | Sequence[int] = 0, abutment: bool = True,
                 steps: int = STEPS, damping_scale: float | Sequence[float] = 1.0) -> None:
        law = model.friction_law
        self.history, self.steps, self.step = history, steps, 1.0 / (SAMPLE_RATE * steps)
        scales = np.broadcast_to(np.asarray(damping_scale, float), len(history.brakes))
        mean = float(scales.mean() if np.ptp(scales) else scales[0])
        self.damping_ratio = scales / mean if np.ptp(scales) else np.ones(scales.size)
        self.contact = NonlinearContact(
            faces, decay=1.0 if law is None else law.decay, follower=model.follower is not None,
            retardation_time=mean * model.contact_retardation_time)
        self.closed_stiffness = history.mean_stiffness
        self.stiffness, self.damping = self._closed(model, mean)
        self.modes = ClosedContactModes.of(self.stiffness, self.damping, self.contact)
        self.gyroscopic = np.zeros_like(self.damping) if model.gyroscopic is None \
            else model.gyroscopic
        self._intensity = np.array([
            noise_intensity(replace(self.modes, decay=ratio * self.modes.decay), floor)
            for ratio in self.damping_ratio.tolist()]) * np.sqrt(self.step)
        self._random = np.random.default_rng(seed) if isinstance(seed, int) \
            else [np.random.default_rng(one) for one in seed]
        self.abutment = Abutment.of(model) if abutment else None

    def _closed(self, model: BrakeModel, scale: float) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping of the linear system of the closed contact."""
        stiffness = np.diag(model.angular_frequencies**2)
        damping = scale * model.material_damping
        if model.support_stiffness is not None:
            stiffness += model.support_stiffness
        contact = self.closed_stiffness * self.contact.stiffness
        return stiffness + contact, damping + self.contact.retardation_time * contact

    def acceleration(self, a: FloatArray, rate: FloatArray, points: OperatingPoints) -> FloatArray:
        """Return the whole acceleration of modal coordinates (N, B), noise and abutment aside."""
        force = self.loaded(points).forces(a, rate)
        return np.asarray(force.normal + force.friction
                          - points.rotor_speed * (self.gyroscopic @ rate)
                          - self.stiffness @ a - self.damping_ratio * (self.damping @ rate))

    def energy(self, a: FloatArray, rate: FloatArray, points: OperatingPoints,
               brakes: IndexArray | None = None) -> FloatArray:
        """Return kinetic energy and that of bodies and contact springs [J], of each brake."""
        linear = 0.5 * (rate**2).sum(axis=0) + 0.5 * (a * (self.stiffness @ a)).sum(axis=0)
        return np.asarray(linear + self.loaded(points, brakes).spring_energy(a))

    def loaded(self, points: OperatingPoints, brakes: IndexArray | None = None) -> LoadedContact:
        """
        Return the contact at points, on top of the springs and dashpots of the linear system.

        `points` are of all brakes, or of those that are given.
        """
        ratio = self.damping_ratio if brakes is None else self.damping_ratio[brakes]
        return self.contact.at(points, closed_stiffness=self.closed_stiffness, damping_ratio=ratio)

    def run(self, start: FloatArray | None = None, *, balance: bool = True,
            ended: Callable[[float], NDArray[np.bool_]] | None = None,
            progress: Callable[[float], None] = lambda _: None) -> Iterator[TransientBlock]:
        """
        Integrate the history and yield it in blocks of 10 ms.

        Brakes that are at rest or ended take no time, so many are integrated best side by side:
        a step is products of matrices with a column a brake.

        Parameters
        ----------
        start : (2N, B) array, optional
            Modal coordinates and their rates at the start; None: at rest.
        balance : bool
            Whether to compute the balance of energy.
        ended : callable, optional
            Called with the time [s] before each block, returns a mask (B,) of the brakes that
            are integrated no further.
        progress : callable
            Told the time [s] that is reached.

        Raises
        ------
        SquealError
            For a step too long for the friction, and for motion that does not stay finite.

        """
        run, left = _Run(self, start, balance), np.ones(len(self.history.brakes), bool)
        samples = round((self.history.time[-1] - self.history.time[0]) * SAMPLE_RATE)
        total = max(samples, 2) * self.steps
        size = _BLOCK * self.steps
        for first in range(0, total, size):
            if ended is not None:
                left &= ~ended(float(self.history.time[0]) + first * self.step)
                if not left.any():
                    return
            block = run.block(first, min(size, total - first), left)
            if not np.isfinite(block.velocity).all():
                raise SquealError(f'the motion did not stay finite at {block.time[-1]:.4g} s; '
                                  'give a shorter step, or brakes with supports')
            progress(float(block.time[-1]))
            yield block

    def propagator(self) -> FloatArray:
        """Return exp(h L) of the linear system of the closed contact, (2N, 2N)."""
        from scipy.linalg import expm
        n = len(self.stiffness)
        return np.asarray(expm(self.step * np.block([
            [np.zeros((n, n)), np.eye(n)], [-self.stiffness, -self.damping]])))

    def noise(self, steps: int, brakes: IndexArray) -> FloatArray:
        """Return the change of the rates of some brakes by noise in each step, (steps, N, b)."""
        size = len(self.stiffness)
        if isinstance(self._random, np.random.Generator):
            white = self._random.standard_normal((steps, len(self.history.brakes), size))
            white = white[:, brakes].swapaxes(0, 1)
        else:
            white = np.array([self._random[i].standard_normal((steps, size)) for i in brakes])
        result = white @ self._intensity[brakes].swapaxes(1, 2)
        return np.ascontiguousarray(result.transpose(1, 2, 0))


class _Run:
    """The state of one integration."""

    def __init__(self, transient: Transient, start: FloatArray | None, balance: bool) -> None:
        self._t, self._propagator, self._balanced = transient, transient.propagator(), balance
        self._size, self._brakes = len(transient.stiffness), len(transient.history.brakes)
        self._motion = Motion(
            np.zeros((2 * self._size, self._brakes)) if start is None
            else np.array(start, dtype=float),
            np.zeros((2, self._size, self._brakes)),
            np.zeros((transient.abutment.coordinates.size if transient.abutment else 0,
                      self._brakes)))

    def block(self, first: int, steps: int, left: NDArray[np.bool_]) -> TransientBlock:
        """Integrate some steps of the brakes that are left."""
        t = self._t
        begin = float(t.history.time[0]) + first * t.step
        sliding = left & t.history.sliding(begin + 0.5 * steps * t.step)
        time = np.asarray(begin + t.step * np.arange(t.steps, steps + 1, t.steps), float)
        resting, brakes = np.flatnonzero(~sliding), np.flatnonzero(sliding)
        self._motion.put(resting, Motion(*np.zeros((3, 1))))
        result = np.zeros((2, time.size, self._size, self._brakes))
        balance = np.full((5, self._brakes), np.nan)
        if self._balanced:
            balance[:, resting] = 0.0
        if brakes.size:
            part = self._motion.of(brakes)
            samples, balance[:, brakes] = self._integrated(begin, steps, brakes, part)
            result[..., brakes] = samples.swapaxes(0, 1)
            self._motion.put(brakes, part)
        return TransientBlock(time, result[0], result[1], sliding, EnergyBalance(*balance))

    def _integrated(self, begin: float, steps: int, brakes: IndexArray, part: Motion
                    ) -> tuple[FloatArray, FloatArray]:
        """Return displacement and velocity (F, 2, N, b) and the balance (5, b)."""
        t = self._t
        # displacement, velocity at mid kick, friction
        record = np.empty((steps, 3 if self._balanced else 2, self._size, brakes.size))
        noise, abutment = t.noise(steps, brakes), np.zeros(brakes.size)
        for i in range(0, steps, _HELD * t.steps):
            upto = min(i + _HELD * t.steps, steps)
            points = t.history.at(begin + 0.5 * (i + upto) * t.step).take(brakes)
            abutment += self._held(points, brakes, part, noise[i:upto], record[i:upto])
        balance = self._balance(record, noise, abutment, points, brakes, part) \
            if self._balanced else np.full((5, brakes.size), np.nan)
        return record[t.steps - 1::t.steps, :2], balance

    def _held(self, points: OperatingPoints, brakes: IndexArray, part: Motion, noise: FloatArray,
              record: FloatArray) -> FloatArray:
        """Integrate steps of one operating point; returns the work of the abutment."""
        t, n, h, hold = self._t, self._size, self._t.step, self._t.abutment
        contact, work = t.loaded(points, brakes), np.zeros(brakes.size)
        contact.check_step(h)
        held = hold.damping(points) if hold else 0.0
        kick, more = part.kick, t.damping_ratio[brakes] - 1.0
        own_damping = bool(more.any())
        for i in range(len(noise)):
            part.state = self._propagator @ part.state
            a, rate = part.state[:n], part.state[n:]
            mid = rate + kick[1] - 0.5 * kick[0]  # half of 2 last - last but one
            normal, friction = contact.forces(a, mid)
            total = normal + friction
            total -= points.rotor_speed * (t.gyroscopic @ mid)
            if own_damping:
                total -= more * (t.damping @ mid)
            if hold:
                at = hold.coordinates
                there = mid.take(at, axis=0)
                force = hold.force(a.take(at, axis=0), there, part.relaxed, held, h)
                work += h * (force * there).sum(axis=0)
                total[at] += force
            kick[0], kick[1] = kick[1], h * total
            change = kick[1] + noise[i]
            record[i, 0], record[i, 2:] = a, friction
            np.multiply(change, 0.5, out=record[i, 1])
            record[i, 1] += rate
            rate += change
        return work

    def _balance(self, record: FloatArray, noise: FloatArray, abutment: FloatArray,
                 points: OperatingPoints, brakes: IndexArray, part: Motion) -> FloatArray:
        velocity, h, n = record[:, 1], self._t.step, self._size
        damped = np.einsum('nm,smb->snb', self._t.damping, velocity, optimize=True)
        energy = self._t.energy(part.state[:n], part.state[n:], points, brakes)
        return np.array([
            energy, h * (record[:, 2] * velocity).sum(axis=(0, 1)), abutment,
            (noise * velocity).sum(axis=(0, 1)),
            h * self._t.damping_ratio[brakes] * (damped * velocity).sum(axis=(0, 1))])
