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

"""Sounds whose events are known: squeal, noise of road and wind, and what resembles squeal."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
import struct

import numpy as np
from squeal_core.common.arrays import FloatArray

BAND = (1250.0, 16000.0)  # Hz


@dataclass(frozen=True)
class Squeal:
    """
    A tone that is there from start to end [s].

    Parameters
    ----------
    start, end : float
    frequency : float
        At the start [Hz].
    level : float
        Of the tone over the noise in 1.25 to 16 kHz [dB].
    glide : float
        Change of frequency from start to end [Hz].
    beat : float
        Frequency difference of a second tone of 0.7 of the amplitude [Hz]; 0: none.
    harmonics : tuple of float
        Amplitudes of the second, third ... partial, of the first one's.
    rise : float
        Time in which it grows exponentially by 40 dB, and falls [s].

    """

    start: float
    end: float
    frequency: float
    level: float
    glide: float = 0.0
    beat: float = 0.0
    harmonics: tuple[float, ...] = ()
    rise: float = 0.02

    def sound(self, time: FloatArray, most: float) -> FloatArray:
        """Return it with a root mean square of 1, without partials above a frequency [Hz]."""
        there = np.flatnonzero((time >= self.start) & (time < self.end))
        t = time[there] - self.start
        length = self.end - self.start
        phase = 2.0 * np.pi * (self.frequency * t + 0.5 * self.glide * t ** 2 / length)
        wave = np.sin(phase)
        if self.beat:
            wave += 0.7 * np.sin(phase + 2.0 * np.pi * self.beat * t)
        for i, amplitude in enumerate(self.harmonics):
            if (i + 2) * max(self.frequency, self.frequency + self.glide) < most:
                wave += amplitude * np.sin((i + 2) * phase + i)
        edge = np.minimum(t, length - t) / max(self.rise, 1e-9)
        whole = np.zeros(time.size)
        whole[there] = np.sqrt(2.0) * wave * 10.0 ** (2.0 * (np.minimum(edge, 1.0) - 1.0))
        return whole


def road_noise(rng: np.random.Generator, time: FloatArray, speed: FloatArray) -> FloatArray:
    """
    Return noise of road and wind at a speed [m/s].

    The road falls by 6 dB an octave and rises with the second power of the speed, the wind by 3 dB
    and with the third; each as a coloured Gaussian noise, 1 in root mean square in the squeal band
    at 20 m/s together.
    """
    parts = []
    for exponent, power in ((1.0, 1.0), (0.5, 1.5)):
        spectrum = np.fft.rfft(rng.standard_normal(time.size))
        hertz = np.fft.rfftfreq(time.size, time[1] - time[0])
        shape = np.maximum(hertz, 60.0) ** -exponent
        band = (hertz >= BAND[0]) & (hertz <= BAND[1])
        noise = np.fft.irfft(spectrum * shape, time.size)
        in_band = np.fft.irfft(spectrum * shape * band, time.size).std()
        parts.append(noise / in_band * (speed / 20.0) ** power)
    return np.asarray((parts[0] + parts[1]) / np.sqrt(2.0))


def sound_of(rng: np.random.Generator, rate: int, duration: float, squeals: Sequence[Squeal], *,
             noise: float = 0.01, speed: Callable[[FloatArray], FloatArray] | None = None
             ) -> FloatArray:
    """
    Return a sound: squeal in noise whose root mean square in the squeal band is given.

    Parameters
    ----------
    rng : Generator
        Of the noise.
    rate : int
        [Hz]
    duration : float
        [s]
    squeals : sequence of Squeal
        In it.
    noise : float
        Root mean square at 20 m/s, of full scale.
    speed : callable, optional
        Of the vehicle over time [m/s]; None: 20.

    """
    time = np.arange(round(rate * duration)) / rate
    whole = road_noise(rng, time, np.full(time.size, 20.0) if speed is None else speed(time))
    for squeal in squeals:
        whole = whole + 10.0 ** (0.05 * squeal.level) * squeal.sound(time, 0.49 * rate)
    return np.asarray(noise * whole)


def write_wav(path: Path, rate: int, samples: FloatArray, kind: str = 'i2', *,
              extensible: bool = False, bext: bytes = b'', magic: bytes = b'RIFF',
              data_size: int | None = None) -> Path:
    """
    Write samples (n,) or (n, channels) by the letter of the format, not by the reader's code.

    Parameters
    ----------
    path : path
        Of the file.
    rate : int
        [Hz]
    samples : array
        Of full scale 1.
    kind : str
        `u1`, `i2`, `i3`, `i4`, `f4` or `f8`.
    extensible : bool
        As WAVE_FORMAT_EXTENSIBLE.
    bext : bytes
        Content of a bext chunk.
    magic : bytes
        `RIFF`, `RIFX` or `RF64`.
    data_size : int, optional
        That the header is to state.

    """
    order = '>' if magic == b'RIFX' else '<'
    columns = samples.reshape(len(samples), -1)
    width = int(kind[1])
    if kind[0] == 'f':
        data = columns.astype(f'{order}{kind}').tobytes()
    elif kind == 'u1':
        data = np.clip(np.round(columns * 128.0) + 128.0, 0, 255).astype('u1').tobytes()
    else:
        most = 2 ** (8 * width - 1)
        whole = np.clip(np.round(columns * most), -most, most - 1).astype(f'{order}i8')
        octets = whole.reshape(-1, 1).view(np.uint8)
        data = (octets[:, :width] if order == '<' else octets[:, 8 - width:]).tobytes()
    tag = 3 if kind[0] == 'f' else 1
    form = struct.pack(f'{order}HHIIHH', 0xFFFE if extensible else tag, columns.shape[1], rate,
                       rate * width * columns.shape[1], width * columns.shape[1], 8 * width)
    if extensible:
        form += struct.pack(f'{order}HHIH', 22, 8 * width, 0, tag) + bytes.fromhex(
            '000000001000800000aa00389b71')
    chunks = _chunk(b'fmt ', form, order) + (_chunk(b'bext', bext, order) if bext else b'')
    stated = len(data) if data_size is None else data_size
    if magic == b'RF64':
        chunks = _chunk(b'ds64', struct.pack('<QQQI', 0, stated, 0, 0), order) + chunks
        stated = 0xFFFFFFFF
    body = chunks + b'data' + struct.pack(f'{order}I', stated) + data
    size = 0xFFFFFFFF if magic == b'RF64' else 4 + len(body) if data_size is None else 0
    path.write_bytes(magic + struct.pack(f'{order}I', size) + b'WAVE' + body)
    return path


def _chunk(name: bytes, content: bytes, order: str) -> bytes:
    return name + struct.pack(f'{order}I', len(content)) + content + b'\0' * (len(content) % 2)


def whine(time: FloatArray, speed: FloatArray, order: float, amplitude: float) -> FloatArray:
    """Return a tone of so many Hz for each m/s of speed, with a second partial."""
    phase = 2.0 * np.pi * np.cumsum(order * speed) * (time[1] - time[0])
    return np.asarray(amplitude * (np.sin(phase) + 0.3 * np.sin(2.0 * phase)))


def horn(time: FloatArray, start: float, end: float, amplitude: float) -> FloatArray:
    """Return a car's horn of two notes, 420 and 512 Hz, with partials up to 8 kHz."""
    whole = np.zeros(time.size)
    for base in (420.0, 512.0):
        for n in range(1, int(min(8000.0, 0.4 / (time[1] - time[0])) / base)):
            whole += np.sin(2.0 * np.pi * n * base * time + n * n) / (1.0 + 0.15 * abs(n - 5))
    return np.asarray(amplitude * whole * ((time >= start) & (time < end)))


def beeper(time: FloatArray, start: float, end: float, amplitude: float, *,
           frequency: float = 2800.0, period: float = 0.9, on: float = 0.5) -> FloatArray:
    """Return a reversing alarm."""
    ringing = (time >= start) & (time < end) & ((time - start) % period < on * period)
    return np.asarray(amplitude * np.sin(2.0 * np.pi * frequency * time) * ringing)


def tune(rng: np.random.Generator, time: FloatArray, start: float, end: float,
         amplitude: float) -> FloatArray:
    """Return chords of three voices and a melody above them, by notes of 0.15 to 0.5 s."""
    whole = np.zeros(time.size)
    for low, high, partials in ((48, 60, 8), (60, 72, 8), (67, 79, 6), (84, 103, 3)):
        now = start
        while now < end:
            length = rng.uniform(0.15, 0.5)
            base = 440.0 * 2.0 ** ((rng.integers(low, high) - 69) / 12.0)
            there = np.flatnonzero((time >= now) & (time < min(now + length, end)))
            t = time[there] - now
            for n in range(1, partials + 1):
                if n * base < 0.45 / (time[1] - time[0]):
                    whole[there] += np.sin(2.0 * np.pi * n * base * t) / n * np.minimum(
                        1.0, t / 0.01) * np.exp(-2.0 * t / length)
            now += length
    return np.asarray(amplitude * whole)
