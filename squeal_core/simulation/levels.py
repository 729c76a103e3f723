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


"""Levels and pitches of modes over time, and the squeal events among them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray, repr_with_shapes
from squeal_core.simulation.microphone import Microphone, REFERENCE
from squeal_core.simulation.modal_noise import ClosedContactModes
from squeal_core.simulation.transient import SAMPLE_RATE, TransientBlock

THRESHOLD = 70.0  # dB, of an event's start
_FALL = 6.0  # dB below the threshold at which it ends
_GAP = 0.1  # s it may be below that for
_PITCH = 0.05  # relative change of frequency by which another event starts
_MEAN = 5  # blocks of 10 ms over which levels and pitches are means
_LEAST = 0.05  # s, of an event


@dataclass(frozen=True, eq=False)
class ModalLevels:
    """
    Modes of the closed contact over T blocks of a transient.

    Parameters
    ----------
    time : (T,) array
        At the middle of each block [s].
    amplitude : (T, N, B) array
        Root mean square relative displacement at the contact [m].
    frequency : (T, N, B) array
        At which the mode's coordinate turns [Hz].
    level : (T, N, B) array
        Sound pressure level at the microphone [dB re 20 uPa].

    """

    time: FloatArray
    amplitude: FloatArray
    frequency: FloatArray
    level: FloatArray

    __repr__ = repr_with_shapes


@dataclass(frozen=True)
class SimulatedEvent:
    """A tone of a brake: from when to when [s], mode number at mu = 0, pitch [Hz], level [dB]."""

    start: float
    end: float
    brake: str
    mode: int
    frequency_hz: float
    level_db: float


class LevelMeter:
    """Collects the levels of the modes block by block."""

    def __init__(self, modes: ClosedContactModes, microphone: Microphone) -> None:
        there = modes.vibrating
        self._modes = modes
        self._frequency = np.where(there, modes.angular_frequencies, np.inf)
        self._gain = np.where(there, microphone.level(
            modes.angular_frequencies / (2.0 * np.pi), modes.shapes), 0.0)
        self._rows: list[tuple[float, FloatArray, FloatArray, FloatArray]] = []

    def add(self, block: TransientBlock) -> None:
        """Take the next block."""
        w = self._frequency[:, None]
        q, rate = (np.einsum('nm,fnb->fmb', self._modes.shapes, part, optimize=True)
                   for part in (block.displacement, block.velocity))
        turning = rate + 1j * np.where(np.isfinite(w), w, 0.0) * q
        speed = np.sqrt(0.5 * (np.abs(turning)**2).mean(axis=0))
        angle = np.angle((turning[1:] * turning[:-1].conj()).sum(axis=0))
        level = 20.0 * np.log10(np.maximum(self._gain[:, None] * speed, 1e-9) / REFERENCE)
        self._rows.append((float(block.time.mean()),
                           speed / w * self._modes.contact_motion[:, None],
                           np.abs(angle) * SAMPLE_RATE / (2.0 * np.pi), level))

    def levels(self) -> ModalLevels:
        """Return what was collected."""
        time, *others = zip(*self._rows, strict=True)
        return ModalLevels(np.array(time), *(np.array(item) for item in others))


def squeal_events(levels: ModalLevels, brakes: tuple[str, ...], *,
                  threshold: float = THRESHOLD) -> list[SimulatedEvent]:
    """
    Return the events of all brakes in the order of their starts.

    An event is a time in which the loudest mode stays above the threshold, at one pitch.

    Parameters
    ----------
    levels : ModalLevels
        Of all brakes.
    brakes : tuple of str
        Names of the columns.
    threshold : float
        Sound pressure level of its start [dB re 20 uPa]; it ends 6 dB lower.

    """
    events = [event for i, name in enumerate(brakes)
              for event in _events_of(levels, i, name, threshold)]
    return sorted(events, key=lambda event: (event.start, event.brake))


def _events_of(levels: ModalLevels, brake: int, name: str,
               threshold: float) -> Iterator[SimulatedEvent]:
    level, pitch, loudest = _heard(levels, brake)
    half = 0.5 * (levels.time[1] - levels.time[0]) if level.size > 1 else 0.0
    heard: list[int] = []  # blocks of the event that goes on
    for i in range(level.size + 1):
        over = i < level.size and level[i] >= (threshold - _FALL if heard else threshold)
        ends = heard and (i == level.size or levels.time[i] - levels.time[heard[-1]] > _GAP
                          or (over and abs(pitch[i] / pitch[heard[-1]] - 1.0) > _PITCH))
        if ends:
            peak = heard[int(np.argmax(level[heard]))]
            start, end = levels.time[heard[0]] - half, levels.time[heard[-1]] + half
            if end - start >= _LEAST:
                yield SimulatedEvent(float(start), float(end), name, int(loudest[peak]) + 1,
                                     float(pitch[peak]), float(level[peak]))
            heard, over = [], i < level.size and level[i] >= threshold
        if over:
            heard.append(i)


def _heard(levels: ModalLevels, brake: int) -> tuple[FloatArray, FloatArray, IndexArray]:
    """Return level, pitch and number of the loudest mode over time, means over some blocks."""
    from scipy.ndimage import uniform_filter1d

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(uniform_filter1d(values, _MEAN, axis=0, mode='nearest'))

    power = 10.0 ** (0.1 * levels.level[:, :, brake])
    smooth = mean(power)
    loudest = smooth.argmax(axis=1)
    rows = np.arange(loudest.size)
    pitch = mean(power * levels.frequency[:, :, brake])[rows, loudest] / smooth[rows, loudest]
    return 10.0 * np.log10(smooth[rows, loudest]), pitch, loudest
