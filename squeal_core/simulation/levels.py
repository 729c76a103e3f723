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
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.simulation.microphone import Microphone, REFERENCE
from squeal_core.simulation.modal_noise import ClosedContactModes
from squeal_core.simulation.transient import TransientBlock

THRESHOLD = 70.0  # dB, of an event's start
_FALL = 6.0  # dB below the threshold at which it ends
_GAP = 0.1  # s it may be below that for
_PITCH = 0.05  # relative change of frequency by which another event starts


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
        w, step = self._frequency[:, None], block.time[1] - block.time[0]
        q, rate = (np.einsum('nm,fnb->fmb', self._modes.shapes, part, optimize=True)
                   for part in (block.displacement, block.velocity))
        turning = rate + 1j * np.where(np.isfinite(w), w, 0.0) * q
        speed = np.sqrt(0.5 * (np.abs(turning)**2).mean(axis=0))
        angle = np.angle((turning[1:] * turning[:-1].conj()).sum(axis=0))
        level = 20.0 * np.log10(np.maximum(self._gain[:, None] * speed, 1e-9) / REFERENCE)
        self._rows.append((float(block.time.mean()),
                           speed / w * self._modes.contact_motion[:, None],
                           np.abs(angle) / (2.0 * np.pi * step), level))

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
    loudest = levels.level[:, :, brake].argmax(axis=1)
    rows = np.arange(loudest.size)
    level, pitch = levels.level[rows, loudest, brake], levels.frequency[rows, loudest, brake]
    half = 0.5 * (levels.time[1] - levels.time[0]) if rows.size > 1 else 0.0
    heard: list[int] = []  # blocks of the event that goes on
    for i in rows:
        over = level[i] >= (threshold - _FALL if heard else threshold)
        other = heard and abs(pitch[i] / pitch[heard[0]] - 1.0) > _PITCH
        silent = heard and levels.time[i] - levels.time[heard[-1]] > _GAP
        if heard and ((over and other) or silent):
            yield _event(levels, heard, level, pitch, loudest, half, name)
            heard = []
            over = level[i] >= threshold
        if over:
            heard.append(int(i))
    if heard:
        yield _event(levels, heard, level, pitch, loudest, half, name)


def _event(levels: ModalLevels, heard: list[int], level: FloatArray, pitch: FloatArray,
           loudest: FloatArray, half: float, name: str) -> SimulatedEvent:
    peak = heard[int(np.argmax(level[heard]))]
    return SimulatedEvent(
        start=float(levels.time[heard[0]] - half), end=float(levels.time[heard[-1]] + half),
        brake=name, mode=int(loudest[peak]) + 1, frequency_hz=float(pitch[peak]),
        level_db=float(level[peak]))
