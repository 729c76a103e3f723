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
Short-time spectra of a sound, block by block, and levels of lines above their neighbours.

Windows are 4096 points at 48 kHz, 85.3 ms, and as long at any other rate, so that a line is
11.7 Hz wide at all of them; they overlap by 75 %.
"""

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, IndexArray

LENGTH, RATE, OVERLAP = 4096, 48_000, 4  # points, Hz, windows that cover a sample
LOWEST = 150.0  # Hz: fundamentals of horns and of music are tones, too
_BEYOND = 2.0 ** (1.0 / 6.0)  # how far above the band lines are needed for the neighbourhood
_LOBE = 3  # lines on each side that a tone takes up
_SHARE = _BEYOND - 1.0  # width of the neighbourhood on each side, over frequency
_LEAST = 16  # lines of it
_TINY = 1e-20  # mean square of samples, -200 dB
_ROUNDING = -160.0  # dB: what single precision leaves of louder lines is no tone

Spectra = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class SpectralPeaks:
    """
    Lines above their neighbourhood, in windows in the order of time.

    Parameters
    ----------
    frame : (P,) array of int
        Number of the window.
    frequency, level, prominence : (P,) arrays
        [Hz], 10 lg of the mean square of the tone's samples, height over the neighbourhood [dB].

    """

    frame: IndexArray
    frequency: FloatArray
    level: FloatArray
    prominence: FloatArray


class SpectrumAnalyser:
    """
    Spectra of one channel; each line holds the mean square of its samples.

    Parameters
    ----------
    rate : int
        Of the samples [Hz].
    highest : float
        Frequency up to which tones are looked for [Hz]; half the rate limits it.

    """

    def __init__(self, rate: int, highest: float) -> None:
        from scipy.fft import next_fast_len
        from scipy.signal.windows import hann
        quarter = next_fast_len(round(LENGTH * rate / RATE / OVERLAP), real=True)
        self.length, self.hop = OVERLAP * quarter, quarter
        self.line = rate / self.length  # Hz
        self.step = quarter / rate  # s
        self.highest = min(highest, 0.5 * rate - (_LOBE + 1) * self.line)
        count = min(self.length // 2 + 1, math.ceil(self.highest * _BEYOND / self.line) + _LEAST)
        self.frequencies = self.line * np.arange(count)
        window = hann(self.length, sym=False)
        scale = math.sqrt(2.0 / (self.length * np.sum(window ** 2)))
        self._window = (scale * window).astype(np.float32)
        self._rest = np.zeros(0, dtype=np.float32)
        self._neighbours = Neighbourhood(count)

    def spectra(self, samples: NDArray[np.float32]) -> Spectra:
        """Return spectra of shape (F, K), of the windows that end with these samples."""
        from scipy.fft import rfft
        whole = np.concatenate([self._rest, samples])
        frames = max(0, (whole.size - self.length) // self.hop + 1)
        self._rest = whole[frames * self.hop:]
        if not frames:
            return np.zeros((0, self.frequencies.size), dtype=np.float32)
        windows = np.lib.stride_tricks.sliding_window_view(whole, self.length)[::self.hop]
        lines = rfft(windows * self._window, axis=1)[:, :self.frequencies.size]
        return np.asarray(lines.real ** 2 + lines.imag ** 2)

    def peaks(self, spectra: Spectra, least: float) -> tuple[SpectralPeaks, FloatArray]:
        """
        Return lines at least so many dB above their neighbourhood, and the background.

        The background is that of each window (F,): the median of all lines in the band from
        1 kHz on [dB], which tones do not move.
        """
        level = 10.0 * np.log10(spectra + np.float32(_TINY))
        above = level - self._neighbours.levels(level)
        low, high = (round(edge / self.line) for edge in (LOWEST, self.highest))
        middle = level[:, low:high + 1]
        frame, line = np.nonzero((above[:, low:high + 1] >= least) & (middle > _ROUNDING)
                                 & (middle >= level[:, low - 1:high])
                                 & (middle > level[:, low + 1:high + 2]))
        line = line + low
        return self._interpolated(spectra, level, above, frame, line), np.median(
            level[:, round(1000.0 / self.line):high:4], axis=1)

    def _interpolated(self, spectra: Spectra, level: Spectra, above: Spectra, frame: IndexArray,
                      line: IndexArray) -> SpectralPeaks:
        """Put a parabola through the levels of three lines; sum the power of five."""
        left, top, right = (level[frame, line + i].astype(float) for i in (-1, 0, 1))
        bend = np.minimum(left - 2.0 * top + right, -1e-9)
        shift = np.clip(0.5 * (left - right) / bend, -0.5, 0.5)
        power = sum(spectra[frame, line + i].astype(float) for i in range(-2, 3))
        return SpectralPeaks(frame, (line + shift) * self.line, 10.0 * np.log10(power + _TINY),
                             above[frame, line] - 0.25 * (left - right) * shift)


class Neighbourhood:
    """
    Level of the lines beside each line, a sixth of an octave on each side, 16 lines at least.

    It is the median, raised to the mean of noise, so other tones in it do not count; the louder
    side counts, so that the edge of a band of noise is no tone.

    Parameters
    ----------
    count : int
        Number of lines.

    """

    def __init__(self, count: int) -> None:
        lines = np.arange(count)
        half = 0.5 * np.maximum(_LEAST, _SHARE * lines)
        centres = [0.5 * _LEAST + _LOBE]
        while centres[-1] + half[-1] < count:
            centres.append(centres[-1] + max(4.0, 0.25 * _SHARE * centres[-1]))
        reach = [max(0.5 * _LEAST, 0.5 * _SHARE * centre) for centre in centres]
        self._windows = [slice(max(0, round(centre - size)), min(count, round(centre + size)))
                         for centre, size in zip(centres, reach, strict=True)]
        self._sides = [_weights(np.array(centres), lines + sign * (_LOBE + half))
                       for sign in (-1, 1)]

    def levels(self, level: Spectra) -> Spectra:
        """Return the level of the neighbourhood of each line, of shape (F, K) [dB]."""
        median = np.empty((len(level), len(self._windows)), dtype=np.float32)
        for i, window in enumerate(self._windows):
            middle = (window.stop - window.start) // 2
            median[:, i] = np.partition(level[:, window], middle, axis=1)[:, middle]
        median -= np.float32(10.0 * math.log10(math.log(2.0)))
        below, beyond = (median @ weights for weights in self._sides)
        return np.asarray(np.maximum(below, beyond))


def _weights(centres: FloatArray, places: FloatArray) -> NDArray[np.float32]:
    """Return the matrix (C, K) of linear interpolation from centres to places."""
    clipped = np.clip(places, centres[0], centres[-1])
    index = np.clip(np.searchsorted(centres, clipped, side='right') - 1, 0, centres.size - 2)
    share = (clipped - centres[index]) / (centres[index + 1] - centres[index])
    weights = np.zeros((centres.size, places.size), dtype=np.float32)
    weights[index, np.arange(places.size)] = 1.0 - share
    weights[index + 1, np.arange(places.size)] += share
    return weights


def a_weighting(frequency: FloatArray) -> FloatArray:
    """Return the A-weighting at frequencies [Hz] [dB], IEC 61672-1, annex E."""
    square = np.asarray(frequency, dtype=float) ** 2
    gain = (12194.217 ** 2 * square ** 2 / (
        (square + 20.598997 ** 2) * (square + 12194.217 ** 2)
        * np.sqrt((square + 107.65265 ** 2) * (square + 737.86223 ** 2))))
    return np.asarray(20.0 * np.log10(np.maximum(gain, 1e-12)) + 2.0)
