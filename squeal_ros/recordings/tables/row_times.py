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

"""Times of rows in order; late, repeated and missing ones and clock steps are counted."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

_LATE = 1_000_000_000  # ns by which a row may come after a later one
_HALF_DAY, _DAY = 43_200_000_000_000, 86_400_000_000_000  # ns
_SECOND = 1_000_000_000


class RowTime(NamedTuple):
    """Time at which a row was recorded, and the time that it states [ns]."""

    recorded: int
    stated: int


@dataclass
class _Count:
    """Number of occurrences, row of the first, and size of the largest."""

    number: int = 0
    first: int = 0
    most: int = 0

    def see(self, row: int, size: int = 0) -> None:
        self.first = self.first or row
        self.number += 1
        self.most = max(self.most, size)


@dataclass
class RowTimes:
    """
    Follows the times of the rows of a table.

    Parameters
    ----------
    offset : int
        Added to all times [ns].
    of_day : bool
        Whether they are times of day, which begin anew at midnight.

    """

    offset: int = 0
    of_day: bool = False
    _last: int | None = None
    _shift: int = 0  # whole seconds, where times begin before zero
    _days: int = 0
    _seen: dict[str, _Count] = field(default_factory=dict)

    def take(self, row: int, time: int | None) -> RowTime | None:
        """
        Return the times of a row; None where it has none.

        Parameters
        ----------
        row : int
            Its line, for notes.
        time : int, optional
            As it states it [ns].

        """
        if time is None:
            self._count('missing', row)
            return None
        time += self.offset + self._days * _DAY
        last = self._last
        if last is None and time < 0:
            self._shift = -(time // _SECOND) * _SECOND
        time = max(time + self._shift, 1)  # zero is no time to ROS
        if last is None or time > last:
            self._last = time
            return RowTime(time, time)
        if time == last:
            self._count('repeated', row)
        elif self.of_day and last - time > _HALF_DAY:
            self._days += 1
            self._count('midnight', row)
            self._last = time = time + _DAY
        elif last - time <= _LATE:
            self._count('late', row, last - time)
            return RowTime(last, time)
        else:
            self._count('back', row, last - time)
            self._last = time
        return RowTime(time, time)

    def _count(self, what: str, row: int, size: int = 0) -> None:
        self._seen.setdefault(what, _Count()).see(row, size)

    def notes(self) -> Iterator[str]:
        """Yield notes on the times, in words."""
        if self._shift:
            yield (f'times begin before zero, which ROS has no time for: '
                   f'{self._shift // _SECOND} s are added to all of them')
        for what, words in _WORDS.items():
            if (count := self._seen.get(what)) is not None:
                yield words.format(n=count.number, row=count.first, s=f'{count.most * 1e-9:.6g}',
                                   rows='row' if count.number == 1 else 'rows',
                                   times='once' if count.number == 1 else f'{count.number} times')


_WORDS = {
    'missing': '{n} {rows} without a time that can be read, the first in line {row}: left out',
    'repeated': '{n} {rows} with the time of the row before, the first in line {row}: the last '
                'value counts',
    'late': '{n} {rows} with a time before that of the row before, by up to {s} s, the first in '
            'line {row}: taken at their times',
    'back': 'the time goes back {times}, by up to {s} s, first in line {row}: what came before '
            'is forgotten there, as when a clock is set back',
    'midnight': 'the time of day begins anew {times}, first in line {row}: taken as the next '
                'day'}
