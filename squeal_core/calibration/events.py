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
from itertools import chain, islice
import math
from pathlib import Path
from typing import NamedTuple

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.csv_spelling import CsvError, encoding_of, marks_of
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
_KNOWN = (*REQUIRED, *OPTIONAL, *_PASSED_OVER)
_DELIMITERS = (',', ';', '\t', '|')
_HEAD = 200_000  # bytes by which the encoding is told
_RANGES = {'time_s': (-math.inf, math.inf), 'frequency_hz': (20.0, 20_000.0),
           'level_db': (-20.0, 200.0), 'end_s': (-math.inf, math.inf)}
AFTER = 0.5  # s after the end of a brake application in which an event is of it: clocks, echoes


class EventFileError(LocatedError):
    """A table of events that cannot be used."""


class _Row(NamedTuple):
    """A row of the table, and its line."""

    line: int
    cells: list[str]


@dataclass(frozen=True)
class MeasuredEvent:
    """
    One event of measured squeal.

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
    Read a table of events, with a first line of column names.

    Delimiter, decimal mark and encoding are told by the text, as a spreadsheet of any language
    writes it.

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
        return list(_events(path, _rows(path), places))
    except (UnicodeDecodeError, CsvError):
        raise EventFileError(path, 'is no text', 'save it as CSV, in UTF-8') from None
    except csv.Error as error:
        raise EventFileError(path, f'cannot be read as CSV ({error})', 'mend it') from None


def _rows(path: Path) -> Iterator[_Row]:
    """Yield the rows that are not blank, the header first."""
    def too_long(line: int) -> EventFileError:
        return EventFileError(f'{path}, line {line}', f'has more than {MAX_LINE} characters',
                              'give a table of lines')

    with open_bounded(path, MAX_BYTES, EventFileError) as file:
        encoding = encoding_of(path, file.read(_HEAD))
        file.seek(0)
        lines = bounded_lines(file, MAX_LINE, too_long, encoding=encoding)
        first = next(lines, '')
        rows = csv.reader(chain([first], lines), delimiter=_delimiter(first), strict=True)
        for row in rows:
            if any(cell.strip() for cell in row):
                yield _Row(rows.line_num, [cell.strip() for cell in row])


def _delimiter(header: str) -> str:
    """Return the delimiter of the names of columns."""
    return max(_DELIMITERS, key=lambda mark: sum(
        name.strip(' \t\r\n"') in _KNOWN for name in header.split(mark)))


def _events(path: Path, rows: Iterator[_Row],
            places: Collection[str]) -> Iterator[MeasuredEvent]:
    columns = _columns(path, next(rows, _Row(1, [])).cells)
    whole = [(line, dict(zip(columns, _whole(path, line, cells, columns), strict=True)))
             for line, cells in islice(rows, MAX_EVENTS + 1)]
    if len(whole) > MAX_EVENTS:
        raise EventFileError(f'{path}, line {whole[-1][0]}', f'is event {len(whole)}',
                             f'give at most {MAX_EVENTS}')
    marks = marks_of([[cells.get(name, '') for name in _RANGES] for _, cells in whole])
    for line, cells in whole:
        where = f'{path}, line {line}'
        time, frequency, level, end = (
            _number(where, name, cells.get(name, ''), *marks) for name in _RANGES)
        if end < time:
            raise EventFileError(where, f'end_s is {end:g}, before time_s {time:g}',
                                 'give the later one, or nothing')
        yield MeasuredEvent(time, _place(where, cells.get('brake', ''), places), frequency, level,
                            cells.get('recording', ''), line, end)


def _whole(path: Path, line: int, cells: Sequence[str], columns: Sequence[str]) -> Sequence[str]:
    if len(cells) != len(columns):
        raise EventFileError(f'{path}, line {line}',
                             f'has {len(cells)} cells for {len(columns)} columns',
                             'give one cell a column, empty where it is not known')
    return cells


def _columns(path: Path, header: Sequence[str]) -> list[str]:
    where, names = f'{path}, line 1', list(header)
    for name in REQUIRED:
        if name not in names:
            raise EventFileError(where, f'has no column {name} in {short_repr(names)}',
                                 f'name the columns in the first line, {",".join(REQUIRED)} and '
                                 f'what is known of {",".join(OPTIONAL)}')
    for name in names:
        if name not in _KNOWN or names.count(name) > 1:
            what = 'twice the column' if name in _KNOWN else 'an unknown column'
            raise EventFileError(where, f'has {what} {short_repr(name)}',
                                 f'remove it, or use {", ".join(_KNOWN)}'
                                 f'{did_you_mean(name, _KNOWN)}')
    return names


def _number(where: str, name: str, text: str, decimal: str, thousands: str) -> float:
    if not text and name != 'time_s':
        return math.nan
    low, high = _RANGES[name]
    try:
        plain = text.replace(thousands, '') if thousands else text
        value = float(plain.replace(decimal, '.'))
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
