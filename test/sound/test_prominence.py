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

"""Prominence after ECMA-418-1: against closed forms, and another implementation of it."""

import numpy as np
import pytest
from scipy.signal import get_window
from squeal_core.sound.prominence import critical_bandwidth, prominence_of
from support.rows import each

RATE, LENGTH = 48_000, 8192
LINE = RATE / LENGTH


def spectrum_of(frequency: float, tone: float, density: float, seed: int) -> np.ndarray:
    """Return the mean spectrum of a tone of a mean square in white noise of a density [1/Hz]."""
    rng = np.random.default_rng(seed)
    time = np.arange(60 * LENGTH) / RATE
    sound = np.sqrt(2.0 * tone) * np.sin(2.0 * np.pi * frequency * time)
    sound += np.sqrt(0.5 * density * RATE) * rng.standard_normal(time.size)
    window = get_window('hann', LENGTH)
    lines = np.fft.rfft(sound.reshape(-1, LENGTH) * window, axis=1)
    return np.asarray(2.0 * (np.abs(lines) ** 2).mean(axis=0) / (LENGTH * (window ** 2).sum()))


@each('frequency', [1300.0, 2503.7, 5000.0, 9100.0])
@each('excess', [8.0, 15.0, 25.0])
def test_a_tone_in_white_noise(frequency: float, excess: float) -> None:
    """Tone over noise in its critical band, exactly; neighbour bands have the noise alone."""
    width = critical_bandwidth(frequency)
    tone = 1e-4
    density = tone * 10.0 ** (-0.1 * excess) / width
    found = prominence_of(spectrum_of(frequency, tone, density, 1), LINE, frequency)
    assert found.tone_to_noise == pytest.approx(excess, abs=0.4)
    # the two neighbours are not as wide as the band: their mean width counts
    ratio = 10.0 * np.log10(1.0 + 10.0 ** (0.1 * excess))
    assert found.ratio == pytest.approx(ratio, abs=0.6)


@each('line', [222, 427, 853, 1100])  # 1.3 to 6.4 kHz: their bands end at 11.2 kHz
def test_another_implementation_of_the_standard(line: int) -> None:
    """
    The same spectrum in both, an even one: theirs takes peaks of noise for tones of their own.

    Of the tone-to-noise ratio they take a tone's lines by other rules.
    """
    tonality = pytest.importorskip('mosqito.sq_metrics')
    spectrum = np.full(LENGTH // 2, 1e-4 * 10.0 ** -1.8 / critical_bandwidth(LINE * line) * LINE)
    spectrum[line - 1:line + 2] += 1e-4 * np.array([1.0, 4.0, 1.0]) / 6.0
    own = prominence_of(spectrum, LINE, LINE * line)
    for theirs, mine in ((tonality.tnr_ecma_freq, own.tone_to_noise),
                         (tonality.pr_ecma_freq, own.ratio)):
        _, values, _, tones = theirs(np.sqrt(spectrum), LINE * np.arange(spectrum.size),
                                     prominence=False)
        assert abs(float(tones[0]) / LINE - line) < 1.5
        assert mine == pytest.approx(float(values[0]), abs=0.3)


def test_neighbours_above_the_highest_line_are_not_known() -> None:
    spectrum = np.ones(100)
    assert np.isnan(prominence_of(spectrum, LINE, 95.0 * LINE).ratio)
