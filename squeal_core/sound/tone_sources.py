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
Rules by which a tone is no squeal: whine, siren, horn, alarm, music.

A squeal is a mode of the brake: its frequency hardly follows the speed, its partials are multiples
of a tone in the band, and it neither keeps time nor a tune.
"""

from collections.abc import Callable, Sequence
import math
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.sound.tone_tracker import Tone

SpeedAt = Callable[[FloatArray], FloatArray]
"""Speed of wheel or vehicle at times of the sound, in any unit; NaN where not known."""
BrakingAt = Callable[[FloatArray], FloatArray]
"""Sliding of brakes under pressure at times of the sound: 1, 0, or NaN where not known."""

RULES = {
    'wheel speed': 'frequency proportional to wheel speed: ln f over ln v has a slope of 0.7 to '
                   '1.3 and a correlation of 0.9, over 5 % of speed or more',
    'no braking': 'for half of it or 2 s no brake slides under pressure, by the recording',
    'constant': '30 s or more without a break, 90 % of the time within 1 % of frequency, where '
                'no recording tells brakings',
    'glide': 'frequency spans a ratio of more than 1.25 (90 % of the time): whine, siren',
    'below the band': 'multiple of a tone below the band that is not 10 dB weaker',
    'clipping': '10 dB or more weaker than another tone while the channel is overdriven',
    'horn': 'one of five or more partials of a steady fundamental below the band',
    'alarm': 'one of four or more bursts alike in frequency (0.4 %), duration (8 %), period '
             '(5 %, at most 2.5 s) and level (3 dB), steady, silent for a quarter of the time; or '
             'what is left of one beside them',
    'music': 'within 2 s of other notes, 1.5 a second or more of five or more pitches, half of '
             'them below the band or 85 % on one equal-tempered scale; or 3 a second, a tenth '
             'below the band; and not 10 dB louder than they',
}
_SLOPE, _CORRELATION, _LEAST_CHANGE = (0.7, 1.3), 0.9, 0.05
_GLIDE = 1.25
_OUTSIDE = 2.0  # s of a tone while no brake slides
_ENDLESS, _UNCHANGED = 30.0, 1.01  # s, longer than a brake is applied; ratio of frequencies
_MULTIPLE, _MOST_MULTIPLE = 0.005, 12  # tolerance; of a fundamental
_NOTE = 0.2  # of the windows of a partial, in which one of its fundamentals is there
_SHARED = 0.7  # of the windows of a partial in which its fundamental is there
_PARTIALS, _COMB, _FUNDAMENTALS = 5, 0.03, (100.0, 1250.0)
_WEAKER = 10.0  # dB
_BURSTS, _ALIKE, _LENGTHS, _PERIODS, _LONGEST = 4, 0.004, 0.08, 0.05, 2.5
_STEADY, _LEVELS, _SILENT, _CLEAR = 0.0015, 3.0, 0.25, 20.0
_NEAR, _NOTES, _PITCHES = 2.0, 1.5, 5  # s, notes a second, pitches
_CENTS, _TUNED = 12.0, 0.85  # from the scale, and the fraction of notes within


class Timing(NamedTuple):
    """Seconds from one window to the next."""

    step: float

    def duration(self, tone: Tone) -> float:
        """Return the duration of a tone [s]."""
        return (tone.last - tone.first + 1) * self.step


def common(one: Tone, other: Tone) -> tuple[IndexArray, IndexArray] | None:
    """Return the rows of both in windows that they share; None where those are few of one's."""
    if other.first > one.last or other.last < one.first:
        return None
    _, mine, its = np.intersect1d(one.frame, other.frame, assume_unique=True,
                                  return_indices=True)
    return (mine, its) if mine.size >= _SHARED * one.frame.size else None


def multiple_of(tone: Tone, other: Tone) -> int:
    """Return of which number a tone is the multiple of a lower one, throughout; 0: of none."""
    number, windows = _as_multiple(tone, other)
    return number if windows.size >= _SHARED * tone.frame.size else 0


def _as_multiple(tone: Tone, other: Tone) -> tuple[int, IndexArray]:
    """Return of which number a tone is the multiple while both are there, and its windows then."""
    none = np.zeros(0, dtype=np.intp)
    if other.first > tone.last or other.last < tone.first or (
            other.mean_frequency >= 0.7 * tone.mean_frequency):
        return 0, none
    _, mine, its = np.intersect1d(tone.frame, other.frame, assume_unique=True,
                                  return_indices=True)
    if not mine.size:
        return 0, none
    ratio = tone.frequency[mine] / other.frequency[its]
    number = round(float(np.median(ratio)))
    near = np.abs(ratio / max(number, 1) - 1.0) < _MULTIPLE
    fits = 2 <= number <= _MOST_MULTIPLE and near.mean() > _SHARED
    return (number, mine) if fits else (0, none)


def is_of_lower_tones(tone: Tone, lower: Sequence[Tone]) -> bool:
    """
    Return whether a tone is a multiple of a lower one, throughout, that is not much weaker.

    They may be a few, one after the other: partials of the notes of a tune that coincide are one
    tone.
    """
    is_multiple = np.zeros(tone.frame.size, dtype=bool)
    for other in lower:
        if other.peak_level > tone.peak_level - _WEAKER:
            _, windows = _as_multiple(tone, other)
            if windows.size >= _NOTE * tone.frame.size:
                is_multiple[windows] = True
    return bool(is_multiple.mean() >= _SHARED)


def follows_speed(tone: Tone, times: FloatArray, speed: SpeedAt) -> bool:
    """Return whether a tone's frequency is proportional to the speed, where that changes."""
    with np.errstate(divide='ignore', invalid='ignore'):
        v = np.log(np.abs(speed(times)))
    known = np.isfinite(v)
    if known.mean() < _SHARED or np.ptp(v[known]) < _LEAST_CHANGE:
        return False
    v, f = v[known] - v[known].mean(), np.log(tone.frequency[known])
    f -= f.mean()
    slope = float(v @ f / (v @ v))
    correlation = float(v @ f) / math.sqrt(max(float((v @ v) * (f @ f)), 1e-30))
    return _SLOPE[0] <= slope <= _SLOPE[1] and correlation >= _CORRELATION


def is_without_braking(times: FloatArray, braking: BrakingAt, timing: Timing) -> bool:
    """Return whether a tone at times is there while no brake slides, where that is known."""
    there = braking(times)
    known = there[np.isfinite(there)]
    return known.size >= _SHARED * times.size and bool(
        known.mean() <= 0.5 or (known == 0.0).sum() * timing.step >= _OUTSIDE)


def is_constant(tone: Tone, timing: Timing) -> bool:
    """Return whether a tone goes on for longer than a brake is applied, and does not change."""
    return timing.duration(tone) >= _ENDLESS and _frequency_ratio(tone) <= _UNCHANGED


def glides(tone: Tone) -> bool:
    """Return whether a tone goes further than a mode of a brake does."""
    return _frequency_ratio(tone) > _GLIDE


def _frequency_ratio(tone: Tone) -> float:
    low, high = np.percentile(tone.frequency, (5.0, 95.0))
    return float(high / low)


def is_of_clipping(tone: Tone, others: Sequence[Tone]) -> bool:
    """Return whether a tone of an overdriven channel is by far not the loudest."""
    return any(other.peak_level >= tone.peak_level + _WEAKER and common(tone, other) is not None
               for other in others)


def is_of_comb(tone: Tone, others: Sequence[Tone]) -> bool:
    """Return whether a tone is a partial of a steady fundamental below the band."""
    there = [tone, *(other for other in others if common(tone, other) is not None)]
    for lowest in sorted(there, key=lambda other: other.mean_frequency)[:4]:
        for part in (1, 2, 3, 4):
            base = lowest.mean_frequency / part
            if not (_FUNDAMENTALS[0] <= base < _FUNDAMENTALS[1] and _is_partial(tone, base)):
                continue
            partials = [other for other in there if _is_partial(other, base)]
            numbers = {round(other.mean_frequency / base) for other in partials}
            if len(numbers) >= _PARTIALS and math.gcd(*numbers) == 1 \
                    and not glides(lowest) and tone.peak_level < _WEAKER + max(
                        other.peak_level for other in partials if other is not tone):
                return True
    return False


def _is_partial(tone: Tone, base: float) -> bool:
    number = tone.mean_frequency / base
    return abs(number - round(number)) < _COMB


def alarms(pieces: Sequence[Tone], timing: Timing) -> set[int]:
    """Return the places of the pieces that are bursts of an alarm."""
    usable = [i for i, piece in enumerate(pieces)
              if piece.mean_prominence >= _CLEAR and _is_steady(piece)]
    usable.sort(key=lambda i: pieces[i].mean_frequency)
    result: set[int] = set()
    for n, i in enumerate(usable):
        if i in result:
            continue
        group = [i]
        for j in usable[n + 1:]:
            if pieces[j].mean_frequency > (1.0 + _ALIKE) * pieces[i].mean_frequency:
                break
            group.append(j)
        group.sort(key=lambda i: pieces[i].first)
        for at in range(len(group) - _BURSTS + 1):
            bursts = group[at:at + _BURSTS]
            if not result.issuperset(bursts) and _keeps_time([pieces[i] for i in bursts], timing):
                result.update(bursts)
    return result | _rests(pieces, result, timing) if result else result


def _rests(pieces: Sequence[Tone], result: set[int], timing: Timing) -> set[int]:
    """Return pieces that are left of a burst cut short, next to bursts of an alarm."""
    frequency, first, length = np.array([
        (pieces[j].mean_frequency, pieces[j].first, timing.duration(pieces[j])) for j in result]).T
    return {i for i, piece in enumerate(pieces) if np.any(
        (np.abs(piece.mean_frequency / frequency - 1.0) < _ALIKE)
        & (np.abs(piece.first - first) * timing.step <= _LONGEST)
        & (timing.duration(piece) <= length + 2.0 * timing.step))}


def _is_steady(tone: Tone) -> bool:
    inner = tone.frequency[1:-1] if tone.frequency.size > 4 else tone.frequency
    return bool(inner.std() < _STEADY * inner.mean())


def _keeps_time(bursts: Sequence[Tone], timing: Timing) -> bool:
    starts = np.array([burst.first for burst in bursts], dtype=float)
    lengths = np.array([burst.last - burst.first + 1.0 for burst in bursts])
    levels = np.array([burst.peak_level for burst in bursts])
    periods = np.diff(starts)
    period = float(periods.mean())
    return bool(np.ptp(levels) <= _LEVELS and period * timing.step <= _LONGEST
                and np.ptp(periods) <= max(2.0, _PERIODS * period)
                and np.ptp(lengths) <= max(2.0, _LENGTHS * float(lengths.mean()))
                and lengths.mean() <= (1.0 - _SILENT) * period)


def is_in_music(tone: Tone, others: Sequence[Tone], timing: Timing, band_low: float) -> bool:
    """Return whether notes of music surround a tone."""
    reach = round(_NEAR / timing.step)
    notes = [other for other in others if other is not tone and not glides(other)
             and other.last >= tone.first - reach and other.first <= tone.last + reach
             and abs(other.mean_frequency / tone.mean_frequency - 1.0) > 0.02
             and tone.first - reach <= other.first]
    onsets = np.sort([note.first for note in notes])
    count = 1 + int((np.diff(onsets) > 2).sum()) if notes else 0
    span = (tone.last - tone.first + 2 * reach) * timing.step
    if count < _NOTES * span:
        return False
    semitones = 12.0 * np.log2([note.mean_frequency for note in notes])
    below = float(np.mean([note.mean_frequency < band_low for note in notes]))
    offset = np.angle(np.exp(2j * np.pi * semitones).mean()) / (2.0 * np.pi)
    cents = 100.0 * np.abs((semitones - offset + 0.5) % 1.0 - 0.5)
    tuned = (cents < _CENTS).mean() > _TUNED
    busy = count >= 2.0 * _NOTES * span and below >= 0.1
    loudest = max(note.peak_level for note in notes)
    return bool(np.unique(np.round(semitones)).size >= _PITCHES
                and (below >= 0.5 or tuned or busy) and tone.peak_level < loudest + _WEAKER)
