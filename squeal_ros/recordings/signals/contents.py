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

"""Contents of a recording of any format: fields or columns with rates, gaps and ranges."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from pathlib import Path
from typing import Any

_FIRST_STEPS = 1000  # by whose median a gap is told
_GAP = 5.0  # times the usual step


@dataclass(frozen=True, kw_only=True)
class Entry:
    """
    A column, a channel, or a field of a topic.

    Parameters
    ----------
    name : str
        Of the column, channel or topic.
    field : str
        Where in the messages of a topic; empty: a column, or a topic without numbers.
    type : str
        Of messages; of a column 'number', 'text' or 'time'.
    group : int, optional
        Of channels.
    unit : str
        As it is stated; empty: not at all.
    count, missing, texts : int
        Values; cells without one; cells of another kind.
    rate_hz : float
        By the usual step; NaN: not known.
    gaps : int
        Steps of more than five times the usual one.
    longest_gap_s : float
    minimum, maximum : float
        NaN without values.

    """

    name: str
    field: str = ''
    type: str = 'number'  # noqa: A003
    group: int | None = None
    unit: str = ''
    count: int = 0
    missing: int = 0
    texts: int = 0
    rate_hz: float = math.nan
    gaps: int = 0
    longest_gap_s: float = 0.0
    minimum: float = math.nan
    maximum: float = math.nan

    @property
    def label(self) -> str:
        """Return the name as a reader looks for it."""
        return f'{self.name} {self.field}'.strip()


@dataclass(frozen=True, kw_only=True)
class Contents:
    """
    Contents of a recording.

    Parameters
    ----------
    path : Path
    kind : str
        As of `Recording`.
    entries : sequence of Entry
    clock, clock_notes : mapping
        Keys of `clock:` in a file of signals, and what each was guessed by.
    table : mapping
        Keys of `table:` that are stated, not found.
    start_s, end_s : float
        Times of the first and last value, as the recording has them [s]; NaN: not known.
    notes : sequence of str

    """

    path: Path
    kind: str
    entries: Sequence[Entry]
    clock: Mapping[str, Any] = field(default_factory=dict)
    clock_notes: Mapping[str, str] = field(default_factory=dict)
    table: Mapping[str, Any] = field(default_factory=dict)
    start_s: float = math.nan
    end_s: float = math.nan
    notes: Sequence[str] = ()


class Statistics:
    """Rate, gaps and range of one field; takes values as they come, and keeps none."""

    def __init__(self) -> None:
        self.count = 0
        self.minimum, self.maximum = math.inf, -math.inf
        self.first = self.last = math.nan  # s
        self._steps: list[float] = []
        self._usual = math.nan
        self._gaps, self._longest = 0, 0.0

    def time(self, seconds: float) -> None:
        """Take the time of a value [s]."""
        step = seconds - self.last
        if math.isnan(self.first):
            self.first = seconds
        elif step > 0.0 and len(self._steps) < _FIRST_STEPS:
            self._steps.append(step)
            self._longest = max(self._longest, step)
        elif step > 0.0:
            if math.isnan(self._usual):
                self._usual = _median(self._steps)
            self._gaps += step > _GAP * self._usual
            self._longest = max(self._longest, step)
        self.last = seconds

    def value(self, value: float) -> None:
        """Take a value that is no NaN."""
        self.count += 1
        self.minimum, self.maximum = min(self.minimum, value), max(self.maximum, value)

    def as_fields(self) -> dict[str, Any]:
        """Return the fields of an `Entry`."""
        usual = _median(self._steps) if self._steps else math.nan
        gaps = self._gaps + sum(step > _GAP * usual for step in self._steps)
        known = self.count > 0
        return {'rate_hz': 1.0 / usual, 'gaps': gaps,
                'longest_gap_s': self._longest if gaps else 0.0,
                'minimum': self.minimum if known else math.nan,
                'maximum': self.maximum if known else math.nan}


def _median(steps: Sequence[float]) -> float:
    return sorted(steps)[len(steps) // 2]
