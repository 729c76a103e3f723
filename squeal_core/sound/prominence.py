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
Prominence of a tone after ECMA-418-1: tone-to-noise ratio and prominence ratio.

From a spectrum whose lines hold mean squares. Critical bands are
25 + 75 (1 + 1.4 (f / kHz)^2)^0.69 Hz wide; a tone above 1 kHz is prominent from 8 dB of
tone-to-noise ratio, or 9 dB of prominence ratio on.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_LOBE = 2.5  # lines on each side of a tone that are the tone's, of a Hann window
_ABOVE = 5.0  # times the median of the critical band: further lines are of a tone that drifts
_TONE_MOST = 0.3  # of the critical band that a tone may take up


class Prominence(NamedTuple):
    """Tone-to-noise ratio and prominence ratio [dB]; NaN where lines are missing."""

    tone_to_noise: float
    ratio: float


def critical_bandwidth(frequency: float) -> float:
    """Return the width of the critical band about a frequency [Hz]."""
    return 25.0 + 75.0 * float((1.0 + 1.4 * (1e-3 * frequency) ** 2) ** 0.69)


def critical_band(frequency: float) -> tuple[float, float]:
    """Return the ends of the critical band about a frequency above 500 Hz [Hz]."""
    half = 0.5 * critical_bandwidth(frequency)
    return frequency - half, frequency + half


def prominence_of(spectrum: NDArray[np.floating], line: float, frequency: float) -> Prominence:
    """
    Return the prominence of a tone.

    Parameters
    ----------
    spectrum : (K,) array
        Mean square of each line, from zero on.
    line : float
        Width of a line [Hz].
    frequency : float
        Of the tone, above 500 Hz [Hz].

    """
    low, high = critical_band(frequency)
    middle = _between(spectrum, line, low, high)
    below = _between(spectrum, line, *_band_below(low))
    beyond = _between(spectrum, line, *_band_above(high))
    if not middle > 0.0:
        return Prominence(math.nan, math.nan)
    ratio = 10.0 * math.log10(middle / (0.5 * (below + beyond))) if below + beyond > 0.0 \
        else math.nan
    first, last = _lines_of_tone(spectrum, line, frequency)
    tone, width = float(spectrum[first:last + 1].sum()), (last + 1 - first) * line
    outside = middle - tone
    if not outside > 0.0:
        return Prominence(math.nan, ratio)
    density = outside / (high - low - width)  # of the noise
    tone -= density * width
    return Prominence(10.0 * math.log10(tone / (density * (high - low)))
                      if tone > 0.0 else math.nan, ratio)


def _band_below(high: float) -> tuple[float, float]:
    """Return the critical band that ends at a frequency [Hz]."""
    from scipy.optimize import brentq
    centre = brentq(lambda f: critical_band(f)[1] - high, 1.0, high)
    return critical_band(centre)[0], high


def _band_above(low: float) -> tuple[float, float]:
    """Return the critical band that begins at a frequency [Hz]."""
    from scipy.optimize import brentq
    centre = brentq(lambda f: critical_band(f)[0] - low, low, 2.0 * low + 200.0)
    return low, critical_band(centre)[1]


def _between(spectrum: NDArray[np.floating], line: float, low: float, high: float) -> float:
    """Return the sum of the lines between two frequencies; NaN beyond the last one."""
    if high > line * (spectrum.size - 0.5):
        return math.nan
    edges = np.array([low, high]) / line + 0.5  # of lines, which reach half a line to each side
    whole = np.concatenate([[0.0], np.cumsum(spectrum, dtype=float)])
    ends = np.interp(edges, np.arange(whole.size), whole)
    return float(ends[1] - ends[0])


def _lines_of_tone(spectrum: NDArray[np.floating], line: float,
                   frequency: float) -> tuple[int, int]:
    """Return the first and the last line of a tone: its lobe, and more where it drifts."""
    half = 0.5 * critical_bandwidth(frequency) / line
    place = frequency / line
    band = spectrum[max(0, round(place - half)):round(place + half) + 1]
    least = _ABOVE * float(np.median(band))
    first, last = max(0, round(place - _LOBE)), min(round(place + _LOBE), spectrum.size - 1)
    while first > 0 and place - first < _TONE_MOST * half and spectrum[first - 1] > least:
        first -= 1
    while last + 1 < spectrum.size and last - place < _TONE_MOST * half \
            and spectrum[last + 1] > least:
        last += 1
    return first, last
