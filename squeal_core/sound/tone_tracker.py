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

"""Tones followed from window to window through glides."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray, repr_with_shapes
from squeal_core.sound.prominence import Prominence, prominence_of
from squeal_core.sound.spectra import Spectra, SpectralPeaks

_MISSING = 2  # windows in a row in which a tone may not be seen
_REACH = (2.0, 0.006)  # lines, and fraction of the frequency, that a tone may be off its course
_COURSE = 5  # windows over which its course is the mean glide
_SHORTEST = 3  # windows
_CLEAR = 3.0  # dB below the least prominence of an event that a piece of one reaches somewhere
_AVERAGED = 24  # windows, half a second, over which a spectrum is averaged for ECMA-418-1
LOWEST_RATED = 500.0  # Hz: of tones below this, prominence is of no interest here


@dataclass(frozen=True, eq=False)
class Tone:
    """
    A tone of one channel, or a piece of one.

    Parameters
    ----------
    frame : (F,) array of int
        Numbers of the windows in which it is seen, rising.
    frequency, level, prominence : (F,) arrays
        [Hz], 10 lg of the mean square [dB], height over the neighbourhood [dB].
    rated : Prominence
        After ECMA-418-1, of its loudest half second.

    """

    frame: IndexArray
    frequency: FloatArray
    level: FloatArray
    prominence: FloatArray
    rated: Prominence = Prominence(math.nan, math.nan)

    __repr__ = repr_with_shapes

    @property
    def first(self) -> int:
        """First window."""
        return int(self.frame[0])

    @property
    def last(self) -> int:
        """Last window."""
        return int(self.frame[-1])

    @property
    def mean_frequency(self) -> float:
        """Frequency, weighted by power [Hz]."""
        return float(np.average(self.frequency, weights=10.0 ** (0.1 * self.level)))

    @property
    def peak_level(self) -> float:
        """Level at its loudest [dB]."""
        return float(self.level.max())

    @property
    def mean_prominence(self) -> float:
        """Mean height over the neighbourhood, of power [dB]."""
        return 10.0 * math.log10(float(np.mean(10.0 ** (0.1 * self.prominence))))


@dataclass(eq=False)
class _Track:
    """A tone that is being followed."""

    frames: list[int] = field(default_factory=list)
    rows: list[tuple[float, float, float]] = field(default_factory=list)
    total: Spectra | None = None
    count: int = 0
    power: float = 0.0
    best: tuple[float, float, Spectra | None] = (0.0, 0.0, None)  # power, frequency, spectrum

    def expected(self, frame: int) -> float:
        """Return the frequency that its course leads to [Hz]."""
        frames, rows = self.frames[-_COURSE:], self.rows[-_COURSE:]
        now = rows[-1][0]
        if len(frames) < _COURSE:
            return now
        return now + (now - rows[0][0]) / (frames[-1] - frames[0]) * (frame - frames[-1])

    def add(self, frame: int, row: tuple[float, float, float], spectrum: Spectra) -> None:
        self.frames.append(frame)
        self.rows.append(row)
        if row[0] < LOWEST_RATED:
            return
        self.total = spectrum.copy() if self.total is None else self.total + spectrum
        self.count, self.power = self.count + 1, self.power + 10.0 ** (0.1 * row[1])
        if self.count == _AVERAGED:
            self._keep_louder()

    def _keep_louder(self) -> None:
        if self.total is not None and self.power / self.count > self.best[0]:
            middle = self.rows[-(self.count + 1) // 2][0]
            self.best = (self.power / self.count, middle, self.total)
        self.total, self.count, self.power = None, 0, 0.0

    def tone(self, line: float) -> Tone:
        if self.count > _AVERAGED // 4 or self.best[2] is None:
            self._keep_louder()
        _, frequency, spectrum = self.best
        hertz, level, above = np.array(self.rows).T
        return Tone(np.array(self.frames), hertz, level, above,
                    Prominence(math.nan, math.nan) if spectrum is None
                    else prominence_of(spectrum, line, frequency))


class ToneTracker:
    """
    Joins spectral peaks to tones.

    A tone goes on with the peak nearest to where its course leads, the loudest peaks first. Two
    windows without it, 43 ms, it outlives.

    Parameters
    ----------
    line : float
        Width of a line [Hz].
    prominence : float
        That a tone has somewhere [dB], less a tolerance.

    """

    def __init__(self, line: float, prominence: float) -> None:
        self._line, self._least = line, prominence - _CLEAR
        self._tracks: list[_Track] = []

    def add(self, first: int, peaks: SpectralPeaks, spectra: Spectra) -> list[Tone]:
        """Take the peaks of the windows from `first` on; return the tones that have ended."""
        ended: list[Tone] = []
        edges = np.searchsorted(peaks.frame, np.arange(len(spectra) + 1))
        rows = list(zip(peaks.frequency.tolist(), peaks.level.tolist(),
                        peaks.prominence.tolist(), strict=True))
        for i, spectrum in enumerate(spectra):
            here = rows[edges[i]:edges[i + 1]]
            if here:
                self._join(first + i, here, spectrum)
            ended += self._close(first + i)
        return ended

    def finish(self) -> list[Tone]:
        """Return the tones that go on to the end."""
        return self._close(None)

    def _join(self, frame: int, rows: Sequence[tuple[float, float, float]],
              spectrum: Spectra) -> None:
        free = dict(enumerate(self._tracks))
        course = np.array([track.expected(frame) for track in self._tracks])
        for row in sorted(rows, key=lambda row: -row[1]):
            nearest = -1
            if free:
                places = np.fromiter(free, dtype=int)
                away = np.abs(course[places] - row[0])
                if away.min() <= _REACH[0] * self._line + _REACH[1] * row[0]:
                    nearest = int(places[away.argmin()])
            track = free.pop(nearest) if nearest >= 0 else _Track()
            if nearest < 0:
                self._tracks.append(track)
            track.add(frame, row, spectrum)

    def _close(self, frame: int | None) -> list[Tone]:
        """Return the tones not seen for too long, without those that are hardly one."""
        over = [track for track in self._tracks
                if frame is None or frame - track.frames[-1] > _MISSING]
        if over:
            self._tracks = [track for track in self._tracks if track not in over]
        return [track.tone(self._line) for track in over
                if len(track.frames) >= _SHORTEST
                and max(row[2] for row in track.rows) >= self._least]
