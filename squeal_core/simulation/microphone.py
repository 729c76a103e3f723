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
A microphone beside the disc: sound pressure from the normal velocity of the ring under the pads.

Rayleigh's integral over the ring as in a rigid baffle, p(t) = rho / 2 pi sum A dv/dt(t - R/c) / R.
Each mode has a response in frequency, so a mode's level is known beside the signal. The air does
not act on the disc, and pads, caliper and room do not on the sound: levels hold within some dB.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, repr_with_shapes
from squeal_core.common.errors import ModelError
from squeal_core.model.brake_model import BrakeModel

DENSITY, SOUND_SPEED = 1.2, 343.0  # kg/m^3, m/s, of air at 20 degC
POSITION = (0.28, 0.42, 0.1)  # m: where no doublet of up to 7 nodal diameters has a node
AUDIO_RATE = 48_000
REFERENCE = 20e-6  # Pa
_PASS, _STOP = 20_000.0, 23_000.0  # Hz, between which the response falls to zero: no aliasing
_TAPS = 1024  # of the response in time at twice the audio rate: 10.7 ms, of which 2 ms are delay
_LEAD = 256  # taps before the delay, for the ringing of the fall


@dataclass(frozen=True, eq=False)
class Microphone:
    """
    Sound pressure of a brake's modes at one place.

    Parameters
    ----------
    shapes : (J, N) array
        Normal displacement of the ring at J points by each mode [kg^-1/2].
    area, distance : (J,) arrays
        That each point stands for [m^2], and to the microphone [m].

    Examples
    --------
    >>> from squeal_core import BrakeModel
    >>> from squeal_core.simulation.microphone import Microphone
    >>> microphone = Microphone.of(BrakeModel.load('kang2009'))
    >>> microphone.response([3000.0]).shape
    (1, 92)

    """

    shapes: FloatArray
    area: FloatArray
    distance: FloatArray

    __repr__ = repr_with_shapes

    @classmethod
    def of(cls, model: BrakeModel, position: tuple[float, float, float] = POSITION
           ) -> 'Microphone':
        """
        Return a microphone at x, y, z [m], z along the axis.

        Raises
        ------
        ModelError
            For a model that keeps no surface of its disc.

        """
        surface, first = model.surface, 0
        for patch in surface.patches if surface else ():
            if patch.name == 'disc' and patch.closed and surface:
                here = slice(first, first + patch.size)
                points = surface.points[here]
                radius = np.hypot(points[:, 0], points[:, 1])
                width = (radius.max() - radius.min()) / (patch.rows - 1)
                return cls(surface.shapes[here, 2],
                           2.0 * np.pi * radius * width / patch.columns,
                           np.linalg.norm(points - np.array(position), axis=1))
            first += patch.size
        raise ModelError('surface: this model keeps none of its disc, so no sound is known; build '
                         'it with `squeal build`')

    def response(self, frequency: FloatArray | list[float]) -> ComplexArray:
        """Return pressure over modal velocity [Pa s/m kg^-1/2] at F frequencies [Hz], (F, N)."""
        w = 2.0 * np.pi * np.asarray(frequency)[:, None]
        spread = np.exp(-1j * w / SOUND_SPEED * self.distance) * self.area / self.distance
        return np.asarray(1j * w * DENSITY / (2.0 * np.pi) * (spread @ self.shapes))

    def level(self, frequencies: FloatArray, shapes: FloatArray) -> FloatArray:
        """
        Return the sound pressure of modes over the root mean square rate of each [Pa s/m].

        `shapes` (N, M) has a column of modal coordinates for each of M frequencies [Hz].
        """
        return np.asarray(np.abs(np.einsum('mn,nm->m', self.response(frequencies), shapes)))

    @cached_property
    def _filter(self) -> ComplexArray:
        """Responses in frequency of taps at twice the audio rate, padded for a block."""
        rate = 2.0 * AUDIO_RATE
        f = np.asarray(np.fft.rfftfreq(_TAPS, 1.0 / rate), dtype=float)
        fall = 0.5 + 0.5 * np.cos(np.pi * np.clip((f - _PASS) / (_STOP - _PASS), 0.0, 1.0))
        lead = np.exp(-2j * np.pi * f * _LEAD / rate)
        taps = np.fft.irfft(self.response(f) * (fall * lead)[:, None], axis=0)
        return np.asarray(np.fft.rfft(taps, 4 * _TAPS, axis=0))

    def listen(self) -> 'Recorder':
        """Return a recorder of one brake."""
        return Recorder(self._filter)


class Recorder:
    """Turns modal velocities at twice the audio rate, block by block, into sound (overlap-add)."""

    def __init__(self, responses: ComplexArray) -> None:
        self._responses, self._length = responses, 2 * (len(responses) - 1)
        self._tail = np.zeros(_TAPS)
        self._sound: list[FloatArray] = []

    def add(self, velocity: FloatArray) -> None:
        """Take the next samples (F, N) of modal velocities [m/s kg^1/2]."""
        most = self._length - _TAPS
        for start in range(0, len(velocity), most):
            block = velocity[start:start + most]
            spectrum = (np.fft.rfft(block, self._length, axis=0) * self._responses).sum(axis=1)
            sound = np.fft.irfft(spectrum)
            sound[:_TAPS] += self._tail
            self._sound.append(sound[:len(block)])
            self._tail = sound[len(block):len(block) + _TAPS]

    def sound(self) -> FloatArray:
        """Return the sound pressure [Pa] at the audio rate, on the time of the velocities."""
        whole = np.concatenate([*self._sound, self._tail[:_LEAD]])[_LEAD:]
        return np.asarray(whole[::2])
