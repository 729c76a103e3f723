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
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.operators import ContactFace
from squeal_core.simulation.abutment import Abutment
from squeal_core.simulation.contact import LoadedContact, NonlinearContact, SlidingState
from squeal_core.simulation.history import OperatingHistory
from squeal_core.simulation.modal_noise import ClosedContactModes, noise_intensity

SAMPLE_RATE = 96_000  # recorded samples a second: modes of kang2009 end at 32 kHz
STEPS = 2  # steps a sample: 5.2 us
_BLOCK = 960  # samples: 10 ms
_HELD = 48  # samples in which the operating point is constant: 0.5 ms


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """
    Energy [J] at the end of a block and the work [J] of each part since its start, (B,) each.

    At constant inputs the change of energy is the sum of the works: `friction` + `abutment` +
    `noise` - `dissipation`.
    """

    energy: FloatArray
    friction: FloatArray
    abutment: FloatArray
    noise: FloatArray
    dissipation: FloatArray


@dataclass(frozen=True, eq=False)
class TransientBlock:
    """
    Some ms of a transient.

    Parameters
    ----------
    time : (F,) array
        Of the samples [s].
    displacement, velocity : (F, N, B) arrays
        Modal coordinates [m kg^1/2] and their rates [m/s kg^1/2].
    sliding : (B,) array
        Whether each brake slid under load; the others are at rest.
    balance : EnergyBalance

    """

    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    sliding: NDArray[np.bool_]
    balance: EnergyBalance

    __repr__ = repr_with_shapes


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
    seed : int
        Of the noise.
    abutment : bool
        Whether the caliper's abutment carries what drives the pads away in plane; without it the
        linear part is exactly the model's.
    steps : int
        Steps of integration in a sample of 10.4 us.
    damping_scale : float
        Factor on the damping of components, supports and contact layer.

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
                 *, floor: float = 1e-9, seed: int = 0, abutment: bool = True,
                 steps: int = STEPS, damping_scale: float = 1.0) -> None:
        law = model.friction_law
        self.history, self.steps, self.step = history, steps, 1.0 / (SAMPLE_RATE * steps)
        self.contact = NonlinearContact(
            faces, decay=1.0 if law is None else law.decay, follower=model.follower is not None,
            retardation_time=damping_scale * model.contact_retardation_time)
        self.closed_stiffness = history.mean_stiffness
        self.stiffness, self.damping = self._closed(model, damping_scale)
        self.modes = ClosedContactModes.of(self.stiffness, self.damping, self.contact)
        self.gyroscopic = np.zeros_like(self.damping) if model.gyroscopic is None \
            else model.gyroscopic
        self._noise = noise_intensity(self.modes, floor) * np.sqrt(self.step)
        self._random = np.random.default_rng(seed)
        self.abutment = Abutment.of(model) if abutment else None

    def _closed(self, model: BrakeModel, scale: float) -> tuple[FloatArray, FloatArray]:
        """Return stiffness and damping of the linear system of the closed contact."""
        stiffness = np.diag(model.angular_frequencies**2)
        damping = scale * model.material_damping
        if model.support_stiffness is not None:
            stiffness += model.support_stiffness
        contact = self.closed_stiffness * self.contact.stiffness
        return stiffness + contact, damping + self.contact.retardation_time * contact

    def acceleration(self, a: FloatArray, rate: FloatArray, state: SlidingState) -> FloatArray:
        """Return the whole acceleration of modal coordinates (N, B), noise and abutment aside."""
        force = self.loaded(state).forces(a, rate)
        return np.asarray(force.normal + force.friction
                          - state.rotor_speed * (self.gyroscopic @ rate)
                          - self.stiffness @ a - self.damping @ rate)

    def energy(self, a: FloatArray, rate: FloatArray, state: SlidingState) -> FloatArray:
        """Return kinetic energy and that of bodies and contact springs [J], (B,)."""
        linear = 0.5 * (rate**2).sum(axis=0) + 0.5 * (a * (self.stiffness @ a)).sum(axis=0)
        return np.asarray(linear + self.loaded(state).spring_energy(a))

    def loaded(self, state: SlidingState) -> LoadedContact:
        """Return the contact at a state, on top of the springs of the linear system."""
        return self.contact.at(state, closed_stiffness=self.closed_stiffness)

    def run(self, start: FloatArray | None = None, *,
            progress: Callable[[float], None] = lambda _: None) -> Iterator[TransientBlock]:
        """
        Integrate the history and yield it in blocks of 10 ms.

        Parameters
        ----------
        start : (2N, B) array, optional
            Modal coordinates and their rates at the start; None: at rest.
        progress : callable
            Told the time [s] that is reached.

        Raises
        ------
        SquealError
            For a step too long for the friction, and for motion that does not stay finite.

        """
        run = _Run(self, start, self._random)
        samples = round((self.history.time[-1] - self.history.time[0]) * SAMPLE_RATE)
        total = max(samples, 2) * self.steps
        size = _BLOCK * self.steps
        for first in range(0, total, size):
            block = run.block(first, min(size, total - first))
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

    def noise(self, steps: int) -> FloatArray:
        """Return the change of the rates by noise in each step, (steps, N, B)."""
        size = len(self.stiffness)
        white = self._random.standard_normal((steps, len(self.history.brakes), size))
        return np.ascontiguousarray((white @ self._noise.T).transpose(0, 2, 1))


class _Run:
    """The state of one integration."""

    def __init__(self, transient: Transient, start: FloatArray | None,
                 random: np.random.Generator) -> None:
        self._t, self._propagator = transient, transient.propagator()
        self._size, self._brakes = len(transient.stiffness), len(transient.history.brakes)
        self._y = np.zeros((2 * self._size, self._brakes)) if start is None \
            else np.array(start, dtype=float)
        self._kick = np.zeros((2, self._size, self._brakes))  # the last two, by forces alone
        self._relaxed = np.zeros((
            transient.abutment.coordinates.size if transient.abutment else 0, self._brakes))
        self._energy = np.zeros(self._brakes)

    def block(self, first: int, steps: int) -> TransientBlock:
        """Integrate some steps."""
        t, n, b = self._t, self._size, self._brakes
        begin = t.history.time[0] + first * t.step
        middle = begin + 0.5 * steps * t.step
        sliding = t.history.sliding(middle)
        time = begin + t.step * np.arange(t.steps, steps + 1, t.steps)
        self._rest(~sliding)
        if not sliding.any():
            still = np.zeros((time.size, n, b))
            return TransientBlock(time, still, still, sliding,
                                  EnergyBalance(*np.zeros((5, b))))
        record = np.empty((steps, 3, n, b))  # displacement, velocity at mid kick, friction
        noise, abutment = t.noise(steps) * sliding, np.zeros(b)
        for i in range(0, steps, _HELD * t.steps):
            upto = min(i + _HELD * t.steps, steps)
            state = self._state(begin + 0.5 * (i + upto) * t.step, sliding)
            abutment += self._held(state, noise[i:upto], record[i:upto])
        self._rest(~sliding)
        balance = self._balance(record, noise, abutment, state)
        samples = record[t.steps - 1::t.steps]
        return TransientBlock(time, samples[:, 0].copy(), samples[:, 1].copy(), sliding, balance)

    def _state(self, time: float, sliding: NDArray[np.bool_]) -> SlidingState:
        """Return the state at a time; brakes that do not slide are calm somewhere."""
        state = self._t.history.at(time)
        return SlidingState(
            rotor_speed=np.where(sliding, state.rotor_speed, 10.0),
            contact_pressure=np.where(sliding, state.contact_pressure, 0.0),
            friction=np.where(sliding, state.friction, 0.0),
            friction_slope=np.where(sliding, state.friction_slope, 0.0),
            contact_stiffness=state.contact_stiffness)

    def _rest(self, still: NDArray[np.bool_]) -> None:
        self._y[:, still] = 0.0
        self._kick[:, :, still] = 0.0
        self._relaxed[:, still] = 0.0

    def _held(self, state: SlidingState, noise: FloatArray, record: FloatArray) -> FloatArray:
        """Integrate steps of one operating point; returns the work of the abutment."""
        t, n, h, hold = self._t, self._size, self._t.step, self._t.abutment
        contact, work = t.loaded(state), np.zeros(self._brakes)
        contact.check_step(h)
        held = hold.damping(state) if hold else 0.0
        for i in range(len(noise)):
            self._y = self._propagator @ self._y
            a, rate = self._y[:n], self._y[n:]
            mid = rate + self._kick[1] - 0.5 * self._kick[0]  # half of 2 last - last but one
            normal, friction = contact.forces(a, mid)
            total = normal + friction
            total -= state.rotor_speed * (t.gyroscopic @ mid)
            if hold:
                at = hold.coordinates
                there = mid.take(at, axis=0)
                force = hold.force(a.take(at, axis=0), there, self._relaxed, held, h)
                work += h * (force * there).sum(axis=0)
                total[at] += force
            self._kick[0], self._kick[1] = self._kick[1], h * total
            change = self._kick[1] + noise[i]
            record[i, 0], record[i, 2] = a, friction
            np.multiply(change, 0.5, out=record[i, 1])
            record[i, 1] += rate
            rate += change
        return work

    def _balance(self, record: FloatArray, noise: FloatArray, abutment: FloatArray,
                 state: SlidingState) -> EnergyBalance:
        velocity, h = record[:, 1], self._t.step
        damped = np.einsum('nm,smb->snb', self._t.damping, velocity, optimize=True)
        energy = self._t.energy(self._y[:self._size], self._y[self._size:], state)
        return EnergyBalance(
            energy, h * (record[:, 2] * velocity).sum(axis=(0, 1)), abutment,
            (noise * velocity).sum(axis=(0, 1)), h * (damped * velocity).sum(axis=(0, 1)))
