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
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.simulation.microphone import Microphone, REFERENCE
from squeal_core.simulation.modal_noise import ClosedContactModes
from squeal_core.simulation.transient import SAMPLE_RATE
from squeal_core.simulation.transient_block import TransientBlock

THRESHOLD = 70.0  # dB, of an event's start
_FALL = 6.0  # dB below the threshold at which it ends
_GAP = 0.1  # s it may be below that for
_PITCH = 0.05  # relative difference of frequency at which two modes are one tone
_HIDDEN = 15.0  # dB below the loudest mode at which others are no events
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
        q, rate = (np.einsum('nm,fnb->fmb', self._modes.shapes, part[:, :, block.sliding],
                             optimize=True) for part in (block.displacement, block.velocity))
        q *= np.where(np.isfinite(w), w, 0.0)
        speed, angle = np.zeros((2, *block.velocity.shape[1:]))
        speed[:, block.sliding] = np.sqrt(0.5 * (_sum(rate, rate) + _sum(q, q)) / len(q))
        # the turn from sample to sample of rate + i w q
        angle[:, block.sliding] = np.arctan2(
            _sum(q[1:], rate[:-1]) - _sum(rate[1:], q[:-1]),
            _sum(rate[1:], rate[:-1]) + _sum(q[1:], q[:-1]))
        level = 20.0 * np.log10(np.maximum(self._gain[:, None] * speed, 1e-9) / REFERENCE)
        self._rows.append((float(block.time.mean()),
                           speed / w * self._modes.contact_motion[:, None],
                           np.abs(angle) * SAMPLE_RATE / (2.0 * np.pi), level))

    def levels(self) -> ModalLevels:
        """Return what was collected."""
        time, *others = zip(*self._rows, strict=True)
        return ModalLevels(np.array(time), *(np.array(item) for item in others))


def _sum(one: FloatArray, other: FloatArray) -> FloatArray:
    return np.asarray(np.einsum('fmb,fmb->mb', one, other))


def squeal_events(levels: ModalLevels, brakes: tuple[str, ...], *,
                  threshold: float = THRESHOLD) -> list[SimulatedEvent]:
    """
    Return the events of all brakes in the order of their starts.

    An event is a time in which a mode is louder than the threshold and no louder mode of that
    pitch, nor one 15 dB louder, hides it. Shorter than 50 ms is none.

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
    level, pitch = _means(levels, brake)
    heard = np.array([_heard(*row, threshold - _FALL) for row in zip(level, pitch, strict=True)])
    half = 0.5 * (levels.time[1] - levels.time[0]) if len(level) > 1 else 0.0
    for mode in np.flatnonzero(heard.any(axis=0)):
        blocks = np.flatnonzero(heard[:, mode])
        for run in np.split(blocks, np.flatnonzero(np.diff(levels.time[blocks]) > _GAP) + 1):
            peak = run[level[run, mode].argmax()]
            start, end = levels.time[run[0]] - half, levels.time[run[-1]] + half
            if level[peak, mode] >= threshold and end - start >= _LEAST:
                yield SimulatedEvent(float(start), float(end), name, int(mode) + 1,
                                     float(pitch[peak, mode]), float(level[peak, mode]))


def _heard(level: FloatArray, pitch: FloatArray, least: float) -> NDArray[np.bool_]:
    """Return a mask of the modes that none hides, of one block."""
    heard = np.zeros(level.size, dtype=bool)
    for mode in np.argsort(-level):
        if level[mode] < max(least, level.max() - _HIDDEN):
            break
        heard[mode] = not np.any(np.abs(pitch[heard] / pitch[mode] - 1.0) < _PITCH)
    return heard


def _means(levels: ModalLevels, brake: int) -> tuple[FloatArray, FloatArray]:
    """Return levels and pitches (T, N) as means over some blocks."""
    from scipy.ndimage import uniform_filter1d

    def mean(values: FloatArray) -> FloatArray:
        return np.asarray(uniform_filter1d(values, _MEAN, axis=0, mode='nearest'))

    power = 10.0 ** (0.1 * levels.level[:, :, brake])
    smooth = mean(power)
    return (10.0 * np.log10(smooth), np.maximum(
        mean(power * levels.frequency[:, :, brake]) / smooth, 1e-3))
