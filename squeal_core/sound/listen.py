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

"""Listen to a sound: all channels in one pass, in blocks, and the squeal events in them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from squeal_core.common.ranges import Ends
from squeal_core.sound.channel_analysis import ChannelAnalysis, ChannelRecord
from squeal_core.sound.listening_settings import ListeningSettings
from squeal_core.sound.sound_errors import SoundError
from squeal_core.sound.sound_source import SoundFile
from squeal_core.sound.spectra import LOWEST
from squeal_core.sound.squeal_detection import heard_tones, HeardTone, one_of_channels
from squeal_core.sound.tone_sources import BrakingAt, SpeedAt

_HOPS = 256  # in a block: 5.5 s
_MOST_STRETCHES = 1_000  # that are told apart, of those in which nothing was heard


@dataclass(frozen=True)
class SoundRecord:
    """
    Result of one pass over a sound.

    Parameters
    ----------
    sound : SoundFile
    settings : ListeningSettings
    channels : dict of int to ChannelRecord
        By number, from 0 on.
    unknown : dict of int to str
        Why nothing is known of a channel.

    """

    sound: SoundFile
    settings: ListeningSettings
    channels: dict[int, ChannelRecord]
    unknown: dict[int, str] = field(default_factory=dict)

    @property
    def band(self) -> tuple[float, float]:
        """Frequencies that were listened to [Hz]: half the rate limits them."""
        highest = 0.5 * self.sound.rate - 4.0 * self.sound.rate / round(
            self.sound.rate * 4096 / 48_000)
        return self.settings.band[0], min(self.settings.band[1], highest)

    @property
    def heard(self) -> list[ChannelRecord]:
        """Return the channels with known results."""
        return [record for i, record in self.channels.items() if i not in self.unknown]

    @property
    def heard_share(self) -> float:
        """Fraction of the sound in which a microphone was alive."""
        return max((float(record.heard.mean()) for record in self.heard), default=0.0)

    @property
    def notes(self) -> list[str]:
        """Return the faults of the file and its samples."""
        return [*self.sound.notes, *(
            f'channel {i + 1}: {one.unusable} sample{"s are" if one.unusable > 1 else " is"} no '
            'usable number (NaN, infinite or above 1e15); what is around counts as not heard'
            for i, one in self.channels.items() if one.unusable)]

    @property
    def not_heard(self) -> list[Ends]:
        """
        Return stretches from the first sample on [s] in which no microphone was alive.

        Of more than 1000, the nearest ones are taken together with what is between them.
        """
        if not self.heard:
            return [(0.0, self.sound.duration)]
        one = self.heard[0]
        alive = np.any([record.heard for record in self.heard], axis=0)
        steps = np.diff(np.concatenate([[1], alive.astype(int), [1]]))
        start = one.time(np.flatnonzero(steps == -1) - 0.5)
        end = one.time(np.flatnonzero(steps == 1) - 0.5)
        gaps = np.argsort(end[:-1] - start[1:])[:_MOST_STRETCHES - 1]  # the widest
        parted = np.sort(gaps)
        return list(zip([*start[:1].tolist(), *start[parted + 1].tolist()],
                        [*end[parted].tolist(), *end[-1:].tolist()], strict=True))

    def tones(self, *, brakes: Sequence[str] = (), speed: SpeedAt | None = None,
              braking: BrakingAt | None = None) -> list[HeardTone] | None:
        """Return tones in the squeal band, with events; None where nothing is known."""
        if not self.heard:
            return None
        result = [tone for i, record in self.channels.items() if i not in self.unknown
                  for tone in heard_tones(record, self.settings, channel=i, speed=speed,
                                          braking=braking)]
        return one_of_channels(result, brakes)


def listen(sound: SoundFile, settings: ListeningSettings, *, channels: Sequence[int] = (),
           progress: Callable[[float], None] = lambda _: None) -> SoundRecord:
    """
    Listen to a sound file.

    Parameters
    ----------
    sound : SoundFile
        The file.
    settings : ListeningSettings
        What counts as squeal.
    channels : sequence of int
        From 0 on; none: all.
    progress : callable
        Told the fraction that is done.

    Raises
    ------
    SoundError
        For a rate too low for the band.

    """
    chosen = list(dict.fromkeys(channels)) or list(range(sound.channels))
    analyses = [ChannelAnalysis(sound.rate, sound.step, settings) for _ in chosen]
    spectra = analyses[0].spectra
    if spectra.highest <= max(1.05 * settings.band[0], LOWEST):
        raise SoundError(sound.path, f'has {sound.rate} samples a second, which hold tones up to '
                         f'{spectra.highest:.0f} Hz', f'give a sound of at least '
                         f'{2.5 * settings.band[0]:.0f} samples a second, or another --band')
    done = 0
    for block in sound.blocks(_HOPS * spectra.hop):
        for i, analysis in zip(chosen, analyses, strict=True):
            analysis.add(np.ascontiguousarray(block[:, i]))
        done += len(block)
        progress(done / sound.frames)
    records = {i: analysis.finish() for i, analysis in zip(chosen, analyses, strict=True)}
    unknown = {i: why for i, record in records.items() if (why := record.why_unknown(settings))}
    return SoundRecord(sound, settings, records, unknown)
