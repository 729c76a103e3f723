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


"""Modes of the closed contact at mu = 0, and noise that keeps each of them at its floor."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.simulation.contact import NonlinearContact

_LEAST_RATIO = 0.001  # damping ratio at which modes without damping of their own get noise


@dataclass(frozen=True, eq=False)
class ClosedContactModes:
    """
    Undamped modes of the brake at standstill under load, without friction.

    Their order of frequency is that of the mode numbers at mu = 0.

    Parameters
    ----------
    angular_frequencies : (N,) array
        [rad/s].
    shapes : (N, N) array
        A column of modal coordinates for each, orthonormal.
    decay : (N,) array
        Damping of each [1/s], 2 zeta w.
    contact_motion : (N,) array
        Root mean square of the relative displacement over the contact points [kg^-1/2].

    """

    angular_frequencies: FloatArray
    shapes: FloatArray
    decay: FloatArray
    contact_motion: FloatArray

    __repr__ = repr_with_shapes

    @classmethod
    def of(cls, stiffness: FloatArray, damping: FloatArray, contact: NonlinearContact
           ) -> 'ClosedContactModes':
        """Return the modes of stiffness and damping matrices of the closed contact."""
        squares, shapes = np.linalg.eigh(stiffness)
        frequencies = np.sqrt(np.maximum(squares, 0.0))
        weight = contact.weight / contact.weight.sum()
        motion = (weight * (contact.normal @ shapes)**2).sum(axis=0) + (
            np.vstack([weight, weight]) * (contact.in_plane @ shapes)**2).sum(axis=0)
        return cls(frequencies, shapes, ((damping @ shapes) * shapes).sum(axis=0),
                   np.sqrt(motion))

    @property
    def vibrating(self) -> NDArray[np.bool_]:
        """Mask (N,) of those that have stiffness."""
        return np.asarray(self.angular_frequencies > 1e-4 * self.angular_frequencies.max())


def noise_intensity(modes: ClosedContactModes, floor: float) -> FloatArray:
    """
    Return the intensity of the stationary random modal forces, (N, N) [m kg^1/2 s^-3/2].

    White noise s w(t) on an oscillator holds its displacement at a variance of s^2 / (2 c w^2).

    Parameters
    ----------
    modes : ClosedContactModes
        To which the forces act.
    floor : float
        Root mean square displacement at the contact at which each mode is held [m].

    """
    w, there = modes.angular_frequencies, modes.vibrating & (modes.contact_motion > 0.0)
    decay = np.maximum(modes.decay, 2.0 * _LEAST_RATIO * w)
    amplitude = floor / np.where(there, modes.contact_motion, np.inf)
    return np.asarray(modes.shapes * (amplitude * w * np.sqrt(2.0 * decay)))
