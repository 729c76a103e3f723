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

"""Detection of squeal in tones: edges, joined pieces, grouped harmonics, rejected sources."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.sound.channel_analysis import ChannelRecord, HYSTERESIS
from squeal_core.sound.listening_settings import ListeningSettings
from squeal_core.sound.tone_joining import GAP, joined, TimeIndex, unsteady_joined
from squeal_core.sound.tone_sources import (
    alarms,
    BrakingAt,
    follows_speed,
    glides,
    is_constant,
    is_in_music,
    is_of_clipping,
    is_of_comb,
    is_of_lower_tones,
    is_without_braking,
    multiple_of,
    SpeedAt,
    Timing,
)
from squeal_core.sound.tone_tracker import Tone

_EDGE = 6.0  # dB: an abrupt start is in the middle of the window that has a quarter of its power
_WINDOWS = 4  # over which a step of level rises
_FAST = 6  # windows, 128 ms, over which a level is averaged, as by a sound level meter on "fast"
_LEAD = 6.0  # dB by which a channel is louder than the others, so that the brake is its own
_OVERLAP = 0.5  # of the shorter of two tones that are one in two channels


@dataclass(frozen=True)
class HeardTone:
    """
    A tone in the squeal band.

    Parameters
    ----------
    start, end : float
        From the first sample on [s].
    frequency_hz, frequency_start_hz, frequency_end_hz : float
        Weighted by power; at start and end.
    level_db : float
        At its loudest, over 128 ms, on the scale of the settings.
    prominence_db : float
        Over its spectral neighbourhood.
    tone_to_noise_db, prominence_ratio_db : float
        After ECMA-418-1; NaN: not known.
    harmonics : tuple of int
        Numbers of the multiples that are heard, too.
    channel : int
        From 0 on.
    is_clipped : bool
        Whether the channel was overdriven meanwhile.
    brake : str
        Empty: not known.
    rule : str
        By which it is no event; empty: it is one.

    """

    start: float
    end: float
    frequency_hz: float
    frequency_start_hz: float
    frequency_end_hz: float
    level_db: float
    prominence_db: float
    tone_to_noise_db: float
    prominence_ratio_db: float
    harmonics: tuple[int, ...] = ()
    channel: int = 0
    is_clipped: bool = False
    brake: str = ''
    rule: str = ''


def heard_tones(record: ChannelRecord, settings: ListeningSettings, *, channel: int = 0,
                speed: SpeedAt | None = None, braking: BrakingAt | None = None
                ) -> list[HeardTone]:
    """
    Return the tones of a channel in the squeal band, events and rejected ones, by time.

    Parameters
    ----------
    record : ChannelRecord
        Of the channel.
    settings : ListeningSettings
        What counts as squeal.
    channel : int
        Its number.
    speed : callable, optional
        Speed of the wheels at times from the first sample on.
    braking : callable, optional
        Whether brakes slide under pressure then.

    """
    timing = Timing(record.step)
    gap = round(GAP / record.step)
    notes = [trimmed for tone in record.tones if (trimmed := _trimmed(tone)) is not None]
    pieces = unsteady_joined(notes)
    ringing = alarms(pieces, timing)
    tones = [*joined([piece for i, piece in enumerate(pieces) if i not in ringing],
                     gap), *(pieces[i] for i in ringing)]
    bursts = {id(pieces[i]) for i in ringing}
    index = TimeIndex([tone for tone in tones if tone.mean_prominence >= settings.prominence
                       or id(tone) in bursts])
    melody = TimeIndex([note for note in joined(notes, gap)
                        if note.mean_prominence >= settings.prominence])
    rules: dict[int, str] = {}
    multiples: dict[int, list[int]] = {}
    for tone in sorted(index.tones, key=lambda tone: tone.mean_frequency):
        if not settings.band[0] <= tone.mean_frequency <= settings.band[1]:
            continue
        parent, number = _parent(tone, index, rules)
        if parent is not None:
            multiples.setdefault(id(parent), []).append(number)
            continue
        rules[id(tone)] = 'alarm' if id(tone) in bursts else _rule(
            tone, index, melody, record, settings, timing, speed, braking)
    result = [_heard(tone, record, settings, timing, tuple(sorted(multiples.get(id(tone), []))),
                     channel, rules[id(tone)])
              for tone in index.tones if id(tone) in rules]
    return sorted(result, key=lambda tone: tone.start)


def _rule(tone: Tone, index: TimeIndex, melody: TimeIndex, record: ChannelRecord,
          settings: ListeningSettings, timing: Timing, speed: SpeedAt | None,
          braking: BrakingAt | None) -> str:
    """Return the first rule that rejects a tone."""
    reach = round(3.0 / record.step)
    others = [other for other in index.near(tone, reach) if other is not tone]
    if level_of(tone) < settings.threshold:
        return 'level'
    if timing.duration(_loud_part(tone, settings)) < settings.shortest - 0.5 * timing.step:
        return 'duration'
    if record.clipped[tone.frame].mean() > 0.5 and is_of_clipping(tone, others):
        return 'clipping'
    if is_of_lower_tones(tone, [other for other in others
                                if other.mean_frequency < settings.band[0]]):
        return 'below the band'
    times = record.time(tone.frame)
    if speed is not None and follows_speed(tone, times, speed):
        return 'wheel speed'
    if braking is not None and is_without_braking(times, braking, timing):
        return 'no braking'
    if is_constant(tone, timing) and (braking is None or np.isnan(braking(times)).all()):
        return 'constant'
    if glides(tone):
        return 'glide'
    if is_of_comb(tone, others):
        return 'horn'
    return 'music' if is_in_music(
        tone, list(melody.near(tone, reach)), timing, settings.band[0]) else ''


def _parent(tone: Tone, index: TimeIndex, rules: dict[int, str]) -> tuple[Tone | None, int]:
    """Return the louder tone in the band that a tone is a multiple of, and of which number."""
    for other in index.near(tone, 0):
        if id(other) in rules and other.peak_level >= tone.peak_level:
            number = multiple_of(tone, other)
            if number:
                return other, number
    return None, 0


def _trimmed(tone: Tone) -> Tone | None:
    """Return a tone without the windows that only reach into it; they begin before an onset."""
    keep = np.ones(tone.level.size, dtype=bool)
    for order in (slice(None), slice(None, None, -1)):
        level = tone.level[order]
        ahead = np.array([level[i:i + _WINDOWS + 1].max() for i in range(level.size)])
        first = int(np.argmax(level >= ahead - _EDGE))
        keep[order][:first] = False
    return _part(tone, keep) if keep.any() else None


def _loud_part(tone: Tone, settings: ListeningSettings) -> Tone:
    """Return a tone from the first to the last window within 6 dB of the threshold."""
    loud = np.flatnonzero(tone.level >= settings.threshold - HYSTERESIS)
    keep = np.zeros(tone.level.size, dtype=bool)
    keep[loud[0] if loud.size else 0:loud[-1] + 1 if loud.size else 1] = True
    return _part(tone, keep)


def _part(tone: Tone, keep: NDArray[np.bool_]) -> Tone:
    return replace(tone, frame=tone.frame[keep], frequency=tone.frequency[keep],
                   level=tone.level[keep], prominence=tone.prominence[keep])


def level_of(tone: Tone) -> float:
    """Return the level of a tone at its loudest, averaged over 128 ms [dB]."""
    power = 10.0 ** (0.1 * tone.level)
    width = min(_FAST, power.size)
    return 10.0 * math.log10(float(np.convolve(power, np.full(width, 1.0 / width), 'valid').max()))


def _heard(tone: Tone, record: ChannelRecord, settings: ListeningSettings, timing: Timing,
           harmonics: tuple[int, ...], channel: int, rule: str) -> HeardTone:
    loud = _loud_part(tone, settings)
    few = slice(0, 3), slice(-3, None)
    start, end = (float(np.median(loud.frequency[part])) for part in few)
    middle: FloatArray = record.time(np.array([loud.first, loud.last]))
    return HeardTone(
        float(middle[0]) - 0.5 * timing.step, float(middle[1]) + 0.5 * timing.step,
        loud.mean_frequency, start, end, level_of(loud), tone.mean_prominence,
        tone.rated.tone_to_noise, tone.rated.ratio, harmonics, channel,
        bool(record.clipped[loud.first:loud.last + 1].any()), '', rule)


def one_of_channels(tones: Sequence[HeardTone], brakes: Sequence[str]) -> list[HeardTone]:
    """
    Return each tone once, as its loudest channel has it, with the brake where that is told.

    Parameters
    ----------
    tones : sequence of HeardTone
        Of all channels.
    brakes : sequence of str
        Names of the brakes that the channels are at; none: not known.

    """
    left = sorted(tones, key=lambda tone: -tone.level_db)
    result = []
    while left:
        loudest, *rest = left
        same = [tone for tone in rest if tone.channel != loudest.channel and _alike(tone, loudest)]
        lead = loudest.level_db - max((tone.level_db for tone in same), default=-math.inf)
        result.append(replace(loudest, brake=brakes[loudest.channel]
                              if brakes and lead >= _LEAD else ''))
        left = [tone for tone in rest if tone not in same] if same else rest
    return sorted(result, key=lambda tone: (tone.start, tone.frequency_hz))


def _alike(one: HeardTone, other: HeardTone) -> bool:
    shared = min(one.end, other.end) - max(one.start, other.start)
    return (shared >= _OVERLAP * min(one.end - one.start, other.end - other.start)
            and abs(one.frequency_hz / other.frequency_hz - 1.0) < 0.01)
