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
Synchronisation of a sound with a recording of the same drive.

The background of the sound rises with the speed, by road and wind, and with friction power, by the
noise of the brakes. It is correlated with both at every offset; at the best offsets a model of the
noise is fitted. Beside it the onsets of the sound are correlated with those of the pressure, as of
strokes of the pedal, or of a clap at the moment of one. An offset counts only where no other one
explains the sound nearly as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.sound.channel_analysis import BACKGROUND, ChannelRecord
from squeal_core.sound.noise_model import VehicleNoise
from squeal_core.sound.recorded_drive import RecordedDrive
from squeal_core.sound.sound_clock import SoundClock

GRID = 0.1  # s
_SLOW = 30.0  # s: what changes more slowly does not count in a correlation
_LEAST_OVERLAP, _LEAST_TIME = 0.5, 5.0  # of the shorter of the two; s
_PEAKS, _LOBE = 6, 2.0  # offsets that are looked at, and how far they are apart at least [s]
_REACH = 10.0  # s that a fit may go from there
_LEAST_EXPLAINED = 0.4  # fraction of the variance
_MOST_SPREAD = 1.0  # s, between offsets of thirds of the sound
_MARGIN = 8.0  # of log-likelihood, to any other offset
_SPEED_FLOOR, _POWER_FLOOR = 0.1, 0.01  # of the mean, and of the largest, below which is silence


class _Candidate(NamedTuple):
    """As of `NoiseFit`, with the offset of the sound [s]."""

    offset: float
    deviation: float
    unexplained: float
    independent: float
    spread: float = 0.0


@dataclass(frozen=True)
class _Match:
    """The best offset of one kind of noise, and the next one."""

    kind: str
    best: _Candidate
    second: _Candidate | None

    @property
    def margin(self) -> float:
        other = 1.0 if self.second is None else self.second.unexplained
        return 0.5 * self.best.independent * math.log(
            max(other, 1e-9) / max(self.best.unexplained, 1e-9))

    @property
    def holds(self) -> bool:
        return (self.best.unexplained <= 1.0 - _LEAST_EXPLAINED and self.margin >= _MARGIN
                and self.best.spread <= _MOST_SPREAD)

    def __str__(self) -> str:
        parts = [f'{one.offset:.1f} s ({1.0 - one.unexplained:.0%} explained)'
                 for one in (self.best, self.second) if one is not None]
        return f'by {self.kind} {" or ".join(parts)}'


def synchronise(records: Sequence[ChannelRecord], drive: RecordedDrive) -> SoundClock:
    """
    Return the clock of a sound, or that it is ambiguous.

    Parameters
    ----------
    records : sequence of ChannelRecord
        Of the channels in which something is heard.
    drive : RecordedDrive
        Of the same time.

    """
    time, level = _background(records)
    grid = np.arange(drive.time[0], drive.time[-1], GRID)
    matches = [match for match in (_by_noise(time, level, drive, grid),
                                   _by_onsets(time, level, drive, grid)) if match is not None]
    good = [match for match in matches if match.holds]
    if not good:
        return SoundClock('sync', note=(
            f'not known: no offset stands out: {"; ".join(map(str, matches))}; give --start'
            if matches else 'not known: sound and recording are too short, or nothing changes in '
            'one of them; give --start'), is_ambiguous=True)
    match = min(good, key=lambda match: match.best.deviation)
    tick = float(np.median(np.diff(drive.time)))
    deviation = math.hypot(match.best.deviation, math.hypot(tick, GRID) / math.sqrt(12.0))
    if any(abs(other.best.offset - match.best.offset)
           > 5.0 * math.hypot(deviation, other.best.deviation) + 0.5 for other in good):
        return SoundClock('sync', note=f'not known: {" but ".join(map(str, good))}; give --start',
                          is_ambiguous=True)
    offset = match.best.offset
    other = '' if match.second is None else \
        f'; the next best, {match.second.offset:.1f} s, {1.0 - match.second.unexplained:.0%}'
    return SoundClock('sync', offset, deviation, (
        f'the sound starts at {offset:.3f} s of the recording, standard deviation {deviation:.3f} '
        f's, by {match.kind}: {1.0 - match.best.unexplained:.0%} of its changes explained{other}'))


def _background(records: Sequence[ChannelRecord]) -> tuple[FloatArray, FloatArray]:
    """Return the background of the sound on a grid, the mean of its channels [dB]."""
    first = records[0]
    level = np.mean([record.background for record in records], axis=0)
    time = first.time(BACKGROUND * np.arange(level.size) + 0.5 * (BACKGROUND - 1))
    if time.size < 2:
        return np.zeros(0), np.zeros(0)
    grid = GRID * np.arange(math.ceil(time[0] / GRID), math.floor(time[-1] / GRID) + 1)
    return grid, np.interp(grid, time, level)


def _by_noise(time: FloatArray, level: FloatArray, drive: RecordedDrive,
              grid: FloatArray) -> _Match | None:
    """Return the offset at which speed and friction power explain the background best."""
    speed = drive.speed_at(grid)
    power = speed * np.maximum(drive.pressure_at(grid), 0.0)
    known = np.isfinite(speed + power)
    if not known.any() or not level.size:
        return None
    with np.errstate(invalid='ignore'):
        features = np.column_stack([
            np.log(_SPEED_FLOOR + speed / max(speed[known].mean(), 1e-9)),
            np.log(_POWER_FLOOR + power / max(power[known].max(), 1e-9))])
    noise = VehicleNoise(grid, speed, power)
    lags = {*_highest(_explained(_filtered(level), _filtered(features))),
            *_highest(_explained(level, features))}
    result = [_Candidate(*fit) for lag in sorted(lags)
              if (fit := noise.fit(time, level, _offset(lag, time, grid), _REACH)) is not None]
    return _match('noise of rolling and braking', result)


def _by_onsets(time: FloatArray, level: FloatArray, drive: RecordedDrive,
               grid: FloatArray) -> _Match | None:
    """Return the offset at which the sound rises when the pressure does."""
    if not level.size:
        return None
    y, x = _filtered(_rises(level)), _filtered(_rises(drive.pressure_at(grid))[:, None])
    square = _explained(y, x)
    result = []
    for lag in _highest(square):
        left, top, right = (square.get(lag + i, 0.0) for i in (-1, 0, 1))
        bend = max(2.0 * top - left - right, 1e-9)
        independent = 0.5 * min(np.isfinite(y).sum(), np.isfinite(x).sum())
        deviation = GRID * math.sqrt((1.0 - top) / max(independent * bend, 1e-9))
        result.append(_Candidate(_offset(lag + 0.5 * (right - left) / bend, time, grid), deviation,
                                 1.0 - top, independent))
    return _match('onsets of pressure', result)


def _match(kind: str, result: Sequence[_Candidate]) -> _Match | None:
    """Return the best candidate and the next one that is not the same."""
    if not result:
        return None
    best, *rest = sorted(result, key=lambda one: one.unexplained)
    return _Match(kind, best, next(
        (one for one in rest if abs(one.offset - best.offset) > 0.5 * _LOBE), None))


def _offset(lag: float, time: FloatArray, grid: FloatArray) -> float:
    return float(grid[0] + GRID * lag - time[0])


def _rises(values: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.maximum(np.diff(values, prepend=values[:1]), 0.0)))


def _filtered(values: FloatArray) -> FloatArray:
    """Return values (T,) or (T, C) without their slow changes; NaN stays."""
    from scipy.ndimage import uniform_filter1d
    known = np.isfinite(values)
    width = round(_SLOW / GRID)
    total, weight = (uniform_filter1d(of, width, axis=0, mode='constant')
                     for of in (np.where(known, values, 0.0), known.astype(float)))
    return np.asarray(values - total / np.maximum(weight, 1e-9))


def _highest(square: dict[int, float]) -> list[int]:
    """Return the lags with the largest values, not too near each other."""
    lags: IndexArray = np.fromiter(square, dtype=int)
    values = np.fromiter(square.values(), dtype=float)
    result: list[int] = []
    while len(result) < _PEAKS and values.size and values.max() > 0.0:
        result.append(int(lags[values.argmax()]))
        values[np.abs(lags - result[-1]) <= _LOBE / GRID] = 0.0
    return result


def _explained(y: FloatArray, x: FloatArray) -> dict[int, float]:
    """
    Return R^2 of a regression of y (T,) on x (S, 1 or 2), with positive slopes, at each lag.

    Lags at which too little is known of both have none. Sums over what is known of both come from
    correlations by FFT.
    """
    from scipy.signal import correlate

    def total(a: FloatArray, b: FloatArray) -> FloatArray:
        return np.asarray(correlate(b, a, mode='full', method='fft'))

    known = np.asarray(np.isfinite(x).all(axis=1))
    here, there = np.isfinite(y).astype(float), known.astype(float)
    y, x = np.nan_to_num(y), np.where(known[:, None], x, 0.0)
    count = np.maximum(np.round(total(here, there)), 1.0)
    mean = total(y, there) / count
    spread = np.maximum(total(y * y, there) / count - mean ** 2, 1e-9)
    means = [total(here, column) / count for column in x.T]
    spreads = [np.maximum(total(here, column ** 2) / count - one ** 2, 1e-9)
               for column, one in zip(x.T, means, strict=True)]
    r = [(total(y, column) / count - one * mean) / np.sqrt(spread * own)
         for column, one, own in zip(x.T, means, spreads, strict=True)]
    square = np.maximum.reduce([np.maximum(one, 0.0) ** 2 for one in r])
    if len(r) == 2:
        both = (total(here, x[:, 0] * x[:, 1]) / count - means[0] * means[1]) / np.sqrt(
            spreads[0] * spreads[1])
        together = (r[0] ** 2 + r[1] ** 2 - 2.0 * r[0] * r[1] * both) / np.maximum(
            1.0 - both ** 2, 1e-3)
        positive = (r[0] > both * r[1]) & (r[1] > both * r[0])
        square = np.where(positive, np.maximum(together, square), square)
    fewest = max(_LEAST_OVERLAP * min(here.sum(), there.sum()), _LEAST_TIME / GRID)
    usable = np.flatnonzero(count >= fewest)
    return dict(zip((usable - (y.size - 1)).tolist(), np.minimum(square[usable], 1.0).tolist(),
                    strict=True))
