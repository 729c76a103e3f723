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

"""The clock of a sound: from seconds since its first sample to the clock of recordings."""

from dataclasses import dataclass
import datetime
import math
import re

from squeal_core.common.errors import short_repr, SquealError
from squeal_core.sound.sound_source import SoundFile

_LATEST = 1e11  # s since 1970


@dataclass(frozen=True)
class SoundClock:
    """
    Offset of a sound's clock from that of recordings.

    Parameters
    ----------
    source : str
        `start`, `bext`, `sync`, or `none`: times count from the first sample.
    offset : float
        To add to times of the sound [s]; NaN: not known.
    uncertainty : float
        Standard deviation of it [s]; NaN: not known.
    note : str
        What to know about it.
    is_ambiguous : bool
        Whether it was looked for, and not found.

    """

    source: str = 'none'
    offset: float = math.nan
    uncertainty: float = math.nan
    note: str = 'times count from the start of the sound'
    is_ambiguous: bool = False

    @property
    def shift(self) -> float:
        """Return the time to add to times of the sound [s]: 0 where the offset is not known."""
        return 0.0 if math.isnan(self.offset) else self.offset


def clock_of_stamp(text: str) -> SoundClock:
    """
    Return the clock of a sound that starts at a stamp.

    Parameters
    ----------
    text : str
        ISO 8601 with a zone, or seconds since 1970, UTC.

    Raises
    ------
    SquealError
        For a stamp that is neither, or has no zone.

    """
    if re.fullmatch(r'[-+]?\d+(\.\d*)?([eE][-+]?\d+)?', text.strip()):
        seconds = float(text)
        if abs(seconds) > _LATEST:
            raise SquealError(f'--start: is {text}; give seconds, not milli- or nanoseconds')
        return SoundClock('start', seconds, math.nan, 'the start as given')
    try:
        time = datetime.datetime.fromisoformat(text.strip())
    except ValueError:
        raise SquealError(f'--start: is {short_repr(text)}; give a time as '
                          '2026-05-04T09:30:00.250+02:00, or seconds since 1970') from None
    if time.tzinfo is None:
        raise SquealError(f'--start: {text} has no zone; add Z for UTC, or an offset as +02:00')
    return SoundClock('start', time.timestamp(), math.nan, 'the start as given')


def clock_of_file(sound: SoundFile) -> SoundClock:
    """Return the clock in a file itself; times from its start where there is none."""
    if sound.started is None:
        return SoundClock()
    time = sound.started.time.replace(tzinfo=datetime.UTC)
    return SoundClock('bext', time.timestamp(), sound.started.resolution / math.sqrt(12.0),
                      f'the file says that it starts at {sound.started.time.isoformat(" ")}, '
                      'without a zone: taken as UTC; give --start where it is another')
