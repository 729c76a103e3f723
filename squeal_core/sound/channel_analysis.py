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

"""One channel of a sound, block by block: tones, background, and times when nothing is heard."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.sound.listening_settings import ListeningSettings
from squeal_core.sound.spectra import a_weighting, OVERLAP, SpectrumAnalyser
from squeal_core.sound.tone_tracker import Tone, ToneTracker

HYSTERESIS = 6.0  # dB below prominence and threshold to which a tone is followed
BACKGROUND = 4  # windows over which the background is averaged
_LOUD = 47  # windows, a second, over which the level is averaged that tells a live microphone
_ALIVE = 1.5  # steps of a sample, root mean square, that a microphone moves at least
_FULL = 1e-4  # below full scale from which on two equal samples are clipped
_PLATEAUS = 8  # of three equal samples, in a hop
_HEIGHT = 0.3  # of full scale, from which on they count


@dataclass(frozen=True, eq=False)
class ChannelRecord:
    """
    Result of the analysis of a channel; times count from its first sample.

    Parameters
    ----------
    step, lead : float
        Between windows, and from the first sample to the middle of the first window [s].
    tones : list of Tone
        Pieces of tones, levels on the scale of the settings, in the order of their ends.
    background : (B,) array
        Level of every fourth window, the median of its lines [dB]; NaN: not heard.
    heard, clipped : (F,) arrays of bool
        Of each window: whether the microphone was alive, and whether it was overdriven.
    loudest : float
        Largest level of a second [dB].
    is_moving : bool
        Whether samples move by more than their steps.
    unusable : int
        Samples that are no numbers, infinite or as good as that.

    """

    step: float
    lead: float
    tones: list[Tone]
    background: FloatArray
    heard: NDArray[np.bool_]
    clipped: NDArray[np.bool_]
    loudest: float
    is_moving: bool
    unusable: int = 0

    __repr__ = repr_with_shapes

    @property
    def heard_time(self) -> float:
        """Return the time for which the microphone was alive [s]."""
        return float(self.heard.sum() * self.step)

    def time(self, frame: ArrayLike) -> FloatArray:
        """Return the time of the middle of windows [s]."""
        return np.asarray(self.lead + self.step * np.asarray(frame, dtype=float))

    def why_unknown(self, settings: ListeningSettings) -> str:
        """Return the reason why nothing is known of the channel; '' where something is."""
        if not self.heard.size:
            return 'it is shorter than one window'
        if not self.heard.any():
            return 'all samples are equal or no numbers: the microphone was off'
        if not self.is_moving:
            return f'samples move by less than {_ALIVE:g} steps: the microphone was off'
        least = settings.scale.least_background
        if self.loudest < least:
            return (f'the loudest second has {self.loudest:.0f} {settings.scale.unit}, below '
                    f'{least:g}: too quiet for a microphone that was on')
        return ''


class ChannelAnalysis:
    """
    Takes the samples of one channel in blocks of whole hops, the last one of any length.

    Parameters
    ----------
    rate : int
        Of the samples [Hz].
    step : float
        Between values of samples, of full scale; 0 for floats.
    settings : ListeningSettings
        What counts as squeal.

    """

    def __init__(self, rate: int, step: float, settings: ListeningSettings) -> None:
        self.spectra = SpectrumAnalyser(rate, settings.band[1])
        self._settings, self._step = settings, step
        self._tracker = ToneTracker(self.spectra.line, settings.prominence)
        scale = settings.scale
        gain = (a_weighting(self.spectra.frequencies) if scale.is_weighted
                else np.zeros(self.spectra.frequencies.size))
        gain[self.spectra.frequencies < 50.0] = -200.0
        self._gain, self._offset = (10.0 ** (0.1 * gain)).astype(np.float32), scale.offset_db
        self._frames, self._moving, self._loudest = 0, 0.0, -np.inf
        self._unusable = 0
        self._tones: list[Tone] = []
        self._background: list[FloatArray] = []
        self._bad: list[NDArray[np.bool_]] = []
        self._flat: list[NDArray[np.bool_]] = []
        self._clipped: list[NDArray[np.bool_]] = []

    def add(self, samples: NDArray[np.float32]) -> None:
        """Take the next samples."""
        samples = self._condition(samples)
        spectra = self.spectra.spectra(samples)
        if not len(spectra):
            return
        peaks, background = self.spectra.peaks(spectra, self._settings.prominence - HYSTERESIS)
        weight = a_weighting(peaks.frequency) if self._settings.scale.is_weighted else 0.0
        peaks = replace(peaks, level=peaks.level + weight + self._offset)
        self._tones += self._tracker.add(self._frames, peaks, spectra)
        self._background.append(background + self._offset)
        self._frames += len(spectra)
        power = spectra @ self._gain
        mean = np.add.reduceat(power, np.arange(0, power.size, _LOUD)) / np.minimum(
            _LOUD, power.size - np.arange(0, power.size, _LOUD))
        self._loudest = max(self._loudest, 10.0 * np.log10(mean.max() + 1e-20) + self._offset)

    def _condition(self, samples: NDArray[np.float32]) -> NDArray[np.float32]:
        """Record faults of each hop, and return finite samples."""
        hop = self.spectra.hop
        usable = np.abs(samples) < 1e15  # squares of larger ones overflow; NaN is not either
        size = samples.size // hop * hop
        bad = np.asarray(~usable[:size].reshape(-1, hop).all(axis=1))
        if not usable.all():
            self._unusable += int((~usable).sum())
            samples = np.where(usable, samples, np.float32(0.0))
        whole = samples[:size].reshape(-1, hop)
        if len(whole):
            self._moving = max(self._moving, float(whole.std(axis=1).max()))
        self._bad.append(bad)
        self._flat.append(np.asarray(np.ptp(whole, axis=1) == 0.0))
        self._clipped.append(_clipped(whole, max(_FULL, 1.5 * self._step)))
        return samples

    def finish(self) -> ChannelRecord:
        """Return the record of the channel."""
        bad, flat, clipped = (np.concatenate([*parts, np.zeros(0, dtype=bool)])
                              for parts in (self._bad, self._flat, self._clipped))
        heard = ~(_windows(bad, self._frames) | _windows(flat, self._frames, every=True))
        background = np.concatenate([*self._background, np.zeros(0)])
        background[~heard] = np.nan
        background = background[:background.size // BACKGROUND * BACKGROUND].reshape(
            -1, BACKGROUND).mean(axis=1)
        step = self.spectra.step
        return ChannelRecord(
            step, 0.5 * OVERLAP * step, self._tones + self._tracker.finish(), background, heard,
            _windows(clipped, self._frames), self._loudest,
            self._moving >= _ALIVE * self._step, self._unusable)


def _windows(hops: NDArray[np.bool_], count: int, *, every: bool = False) -> NDArray[np.bool_]:
    """Return for each window whether any, or each, of its hops is marked."""
    if hops.size < OVERLAP:
        return np.zeros(count, dtype=bool)
    views = np.lib.stride_tricks.sliding_window_view(hops, OVERLAP)[:count]
    return np.asarray(views.all(axis=1) if every else views.any(axis=1))


def _clipped(hops: NDArray[np.float32], near: float) -> NDArray[np.bool_]:
    """
    Return a mask of the hops that are clipped.

    Two equal samples at full scale, or many plateaus of three at the extremes of a loud hop.
    """
    size = np.abs(hops)
    most = size.max(axis=1, initial=0.0)
    loud = np.flatnonzero(most >= _HEIGHT)
    result = np.zeros(len(hops), dtype=bool)
    if loud.size:
        equal = hops[loud, 1:] == hops[loud, :-1]
        full = np.abs(size[loud, 1:] - 1.0) <= near
        plateau = equal[:, 1:] & equal[:, :-1] & (size[loud, 2:] >= 0.98 * most[loud, None])
        result[loud] = (equal & full).any(axis=1) | (plateau.sum(axis=1) >= _PLATEAUS)
    return result
