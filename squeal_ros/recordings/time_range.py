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

"""A range of time of recordings, as `--from` and `--to` give it."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, time, timedelta, UTC
import math
from pathlib import Path

from squeal_core.common.errors import short_repr, SquealError
from squeal_core.monitor.results.squeal_events import clock_time
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.positions import Positions
from squeal_ros.recordings.recording import Recording, RecordingError, Samples

_SECOND = 1_000_000_000
_HALF_DAY = timedelta(hours=12)


class OutOfRangeError(RecordingError):
    """A recording with nothing in the range of time."""


@dataclass(frozen=True)
class Moment:
    """
    A moment: seconds from the start of a recording, a time of the day, or a date and time.

    Parameters
    ----------
    option, text : str
        The option and what was given.
    value : float, time or datetime
        [s]; time of the day and date are UTC, or have a zone.

    """

    option: str
    text: str
    value: float | time | datetime

    @classmethod
    def read(cls, option: str, text: str) -> 'Moment':
        """
        Return the moment in a text.

        Raises
        ------
        SquealError
            For a text that is none.

        """
        for read in (_seconds, time.fromisoformat, datetime.fromisoformat):
            try:
                value = read(text)
            except (ValueError, OverflowError):
                continue
            if isinstance(value, datetime) and value.tzinfo is None:
                value = value.replace(tzinfo=UTC)
            return cls(option, text, value)
        raise SquealError(f'{option}: is {short_repr(text)}; give seconds from the start of a '
                          'recording, a time of the day as 14:05:30, or a date and time as '
                          '2026-05-31T14:05:30, in UTC if it has no zone')

    def at(self, start: int, path: Path) -> int:
        """
        Return the moment in a recording that starts at a time, both [ns].

        Raises
        ------
        RecordingError
            For a time of the day, or a date, where the clock of the recording has none.

        """
        if isinstance(self.value, float):
            return start + round(self.value * _SECOND)
        if not clock_time(start / _SECOND):
            raise RecordingError(
                path, f'starts at {start / _SECOND:.1f} s on a clock that has no date, and '
                f'{self.option} is {self.text}', 'give seconds from its start')
        if isinstance(self.value, datetime):
            return round(self.value.timestamp() * _SECOND)
        begun = datetime.fromtimestamp(start / _SECOND, self.value.tzinfo or UTC)
        moment = datetime.combine(begun.date(), self.value, self.value.tzinfo or UTC)
        if abs(moment - begun) > _HALF_DAY:  # a recording over midnight
            moment += timedelta(days=1 if moment < begun else -1)
        return round(moment.timestamp() * _SECOND)


def _seconds(text: str) -> float:
    value = float(text)
    if not 0.0 <= value < math.inf:
        raise ValueError
    return value


@dataclass(frozen=True)
class TimeRange:
    """A range of time; None: from the start, to the end."""

    begin: Moment | None = None
    end: Moment | None = None

    @classmethod
    def read(cls, begin: str | None, end: str | None) -> 'TimeRange | None':
        """
        Return the range of `--from` and `--to`; None where neither is given.

        Raises
        ------
        SquealError
            For a text that is no moment, and for an end that is not after the begin.

        """
        first = None if begin is None else Moment.read('--from', begin)
        last = None if end is None else Moment.read('--to', end)
        if first and last and type(first.value) is type(last.value) and not isinstance(
                first.value, time) and not first.value < last.value:  # type: ignore[operator]
            raise SquealError(f'--to: {end} is not after --from {begin}; give a later time')
        return cls(first, last) if first or last else None

    def __str__(self) -> str:
        return ' '.join(f'{one.option} {one.text}' for one in (self.begin, self.end) if one)


class RecordingInRange:
    """
    The part of a recording in a range of time; a `Recording` itself.

    Parameters
    ----------
    recording : Recording
    span : TimeRange

    """

    def __init__(self, recording: Recording, span: TimeRange) -> None:
        self._whole, self._span = recording, span
        self._notes: list[str] = []

    @property
    def path(self) -> Path:
        """Return the file or folder."""
        return self._whole.path

    @property
    def kind(self) -> str:
        """Return that of the whole recording."""
        return self._whole.kind

    @property
    def notes(self) -> list[str]:
        """Return notes on the recording and on the range in it."""
        return [*self._whole.notes, *self._notes]

    @property
    def findings(self) -> list[Finding]:
        """Return the findings on the recording and the settings, as far as it was read."""
        return self._whole.findings

    @property
    def messages(self) -> int:
        """Return the number of messages or rows of the whole recording, or an estimate."""
        return self._whole.messages

    @property
    def positions(self) -> Positions:
        """Return the positions of the vehicle, as far as the recording was read."""
        return self._whole.positions

    def samples(self) -> Iterator[tuple[int, Samples]]:
        """
        Yield the samples of the recording in the range, up to the first time beyond it.

        Raises
        ------
        OutOfRangeError
            Where nothing is in the range.
        SquealError
            As those of the whole recording, and for a time that it cannot have.

        """
        start = time = low = 0
        high, some = None, False
        for time, samples in self._whole.samples():
            if not start:
                start, low = time, self._begin(time)
                high = self._span.end.at(time, self.path) if self._span.end else None
            if high is not None and time > high:
                break
            if time >= low:
                some = True
                yield time, samples
        else:
            self._note(time, high)
        if not some:
            raise OutOfRangeError(self.path, f'has nothing in {self._span}: it is {_words(start)} '
                                  f'to {_words(time)}, {(time - start) / _SECOND:.1f} s at least',
                                  'give another range')

    def _begin(self, start: int) -> int:
        low = self._span.begin.at(start, self.path) if self._span.begin else start
        if low < start:
            self._notes.append(f'{self._span}: the recording starts '
                               f'{(start - low) / _SECOND:.1f} s later')
        return low

    def _note(self, last: int, high: int | None) -> None:
        if high is not None and last < high:
            self._notes.append(f'{self._span}: the recording ends '
                               f'{(high - last) / _SECOND:.1f} s earlier')


def _words(moment: int) -> str:
    return clock_time(moment / _SECOND) or f'{moment / _SECOND:.1f} s'
