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

"""Events of measured squeal: the table that a test engineer, or `squeal simulate`, writes."""

from collections.abc import Collection, Iterator, Sequence
import csv
from dataclasses import dataclass
import math
from pathlib import Path

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import did_you_mean, LocatedError, short_repr

MAX_BYTES = 50_000_000
MAX_EVENTS = 200_000
MAX_LINE = 10_000  # characters
UNKNOWN = 'unknown'
REQUIRED = ('time_s', 'frequency_hz')
OPTIONAL = ('brake', 'level_db', 'recording', 'end_s')
# of `squeal simulate` and `squeal listen`
_PASSED_OVER = ('mode', 'frequency_end_hz', 'prominence_db', 'tone_to_noise_db',
                'prominence_ratio_db', 'harmonics', 'channel', 'comment')
_RANGES = {'time_s': (-math.inf, math.inf), 'frequency_hz': (20.0, 20_000.0),
           'level_db': (-20.0, 200.0), 'end_s': (-math.inf, math.inf)}
AFTER = 0.5  # s after the end of a brake application in which an event is of it: clocks, echoes


class EventFileError(LocatedError):
    """A table of events that cannot be used."""


@dataclass(frozen=True)
class MeasuredEvent:
    """
    Squeal that was heard.

    Parameters
    ----------
    time : float
        Of its start, as the table has it [s].
    place : str
        Name of a brake or an axle; empty: not known.
    frequency_hz : float
        Pitch; NaN: not known.
    level_db : float
        Sound pressure level [dB re 20 uPa]; NaN: not known.
    recording : str
        Name of the recording it is of; empty: the one that covers its time.
    line : int
        Of the table, for errors.
    end : float
        Of the squeal, as the table has it [s]; NaN: not known.

    """

    time: float
    place: str = ''
    frequency_hz: float = math.nan
    level_db: float = math.nan
    recording: str = ''
    line: int = 0
    end: float = math.nan


def read_events(path: str | Path, places: Collection[str]) -> list[MeasuredEvent]:
    """
    Read a table of events, CSV with a first line of column names.

    Parameters
    ----------
    path : path
        Columns `time_s` and `frequency_hz`, and `brake`, `level_db`, `recording`, `end_s` where
        they are known; a cell may be empty but for the time. Further columns that `squeal
        simulate` and `squeal listen` write are passed over.
    places : collection of str
        Names of brakes and axles that `brake` may hold, besides `unknown`.

    Raises
    ------
    EventFileError
        With file, line, value and remedy.

    """
    path = Path(path)
    try:
        with open_bounded(path, MAX_BYTES, EventFileError) as file:
            rows = csv.reader(bounded_lines(file, MAX_LINE, lambda line: EventFileError(
                f'{path}, line {line}', f'has more than {MAX_LINE} characters',
                'give a table of lines')), strict=True)
            return list(_events(path, rows, places))
    except UnicodeDecodeError:
        raise EventFileError(path, 'is no UTF-8 text', 'save it as UTF-8') from None
    except csv.Error as error:
        raise EventFileError(path, f'cannot be read as CSV ({error})', 'mend it') from None


def _events(path: Path, rows: Iterator[list[str]],
            places: Collection[str]) -> Iterator[MeasuredEvent]:
    columns = _columns(path, next(rows, []))
    count = 0
    for row in rows:
        if not any(cell.strip() for cell in row):
            continue
        line, count = rows.line_num, count + 1  # type: ignore[attr-defined]
        where = f'{path}, line {line}'
        if len(row) != len(columns):
            raise EventFileError(where, f'has {len(row)} cells for {len(columns)} columns',
                                 'give one cell a column, empty where it is not known')
        if count > MAX_EVENTS:
            raise EventFileError(where, f'is event {count}', f'give at most {MAX_EVENTS}')
        cells = dict(zip(columns, map(str.strip, row), strict=True))
        time, frequency, level, end = (
            _number(where, name, cells.get(name, '')) for name in _RANGES)
        if end < time:
            raise EventFileError(where, f'end_s is {end:g}, before time_s {time:g}',
                                 'give the later one, or nothing')
        yield MeasuredEvent(time, _place(where, cells.get('brake', ''), places), frequency, level,
                            cells.get('recording', ''), line, end)


def _columns(path: Path, header: Sequence[str]) -> list[str]:
    where, names = f'{path}, line 1', [cell.strip() for cell in header]
    if any(';' in name for name in names):
        raise EventFileError(where, f'is separated by ; in {short_repr(names)}', 'give commas '
                             'between the cells, and points in decimal numbers')
    for name in REQUIRED:
        if name not in names:
            raise EventFileError(where, f'has no column {name} in {short_repr(names)}',
                                 f'name the columns in the first line, {",".join(REQUIRED)} and '
                                 f'what is known of {",".join(OPTIONAL)}')
    known = (*REQUIRED, *OPTIONAL, *_PASSED_OVER)
    for name in names:
        if name not in known or names.count(name) > 1:
            what = 'twice the column' if name in known else 'an unknown column'
            raise EventFileError(where, f'has {what} {short_repr(name)}',
                                 f'remove it, or use {", ".join(known)}'
                                 f'{did_you_mean(name, known)}')
    return names


def _number(where: str, name: str, text: str) -> float:
    if not text and name != 'time_s':
        return math.nan
    low, high = _RANGES[name]
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise EventFileError(where, f'{name} is {short_repr(text)}', 'write a number'
                             + (', or nothing' if name != 'time_s' else ' of seconds'))
    if not low <= value <= high:
        khz = f' ({value:g} kHz would be {1e3 * value:g})' if name == 'frequency_hz' \
            and low <= 1e3 * value <= high else ''
        raise EventFileError(where, f'{name} is {value:g}', f'give {low:g} to {high:g}{khz}')
    return value


def _place(where: str, text: str, places: Collection[str]) -> str:
    if text in ('', UNKNOWN):
        return ''
    if text not in places:
        raise EventFileError(where, f'brake is {short_repr(text)}',
                             f'give one of {", ".join(places)}, or {UNKNOWN}'
                             f'{did_you_mean(text, places)}')
    return text
