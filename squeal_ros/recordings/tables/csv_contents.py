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

"""Contents of a table of text: its columns, and which of them is the clock."""

from collections import Counter
from collections.abc import Sequence
from itertools import islice, pairwise
import math
from pathlib import Path
import re
from typing import Any, NamedTuple

from squeal_core.common.measured_units import find_unit
from squeal_ros.recordings.signals.column_units import unit_in_name
from squeal_ros.recordings.signals.contents import Contents, Entry, Statistics
from squeal_ros.recordings.signals.name_words import plain_words
from squeal_ros.recordings.signals.table_spec import ClockSpec, TableSpec, TIME_UNITS
from squeal_ros.recordings.tables.csv_cells import number_reader, time_reader
from squeal_ros.recordings.tables.csv_layout import CsvLayout, lines_of, read_layout
from squeal_ros.recordings.tables.row_times import RowTimes

_HEAD_ROWS = 500  # by which the clock is told
_TIME_WORDS = frozenset((
    'time', 'times', 'zeit', 'zeitstempel', 'timestamp', 'stamp', 't', 'temps', 'horodatage',
    'tempo', 'tiempo', 'hora', 'heure', 'uhrzeit', 'sec', 'seconds', 'sekunden', 'date', 'datum',
    'datetime', 'epoch', 'clock'))
_YEAR_FIRST = re.compile(r'\d{4}[-./]\d{1,2}[-./]\d{1,2}')
_DAY_OR_MONTH = re.compile(r'(\d{1,2})([-./])(\d{1,2})[-./](\d{4}|\d\d)')
_CLOCK = re.compile(r'\d+:\d\d(:\d\d([.,:]\d+)?)?(\s*[apAP]\.?[mM]\.?)?')
# from which a number of a unit is a Unix time: of the year 1973
_UNIX = (('ns', 1e17), ('us', 1e14), ('ms', 1e11), ('s', 1e8))


class _Clock(NamedTuple):
    """A column that may be the clock."""

    score: float
    unit: str
    why: str
    is_date: bool = False  # without a time of day


def csv_contents(path: Path) -> Contents:
    """
    Return the contents of a table; it is read whole, row by row.

    Raises
    ------
    SquealError
        For what is no table.

    """
    layout = read_layout(path, TableSpec())
    survey = _Survey(path, layout)
    survey.read()
    columns = survey.clock.get('column', [])
    clock = {**survey.clock, 'column': columns[0] if len(columns) == 1 else columns}
    return Contents(
        path=path, kind='csv', entries=survey.entries(), clock=clock if columns else {},
        clock_notes=survey.clock_notes, start_s=survey.times[0], end_s=survey.times[1],
        notes=[*_layout_notes(layout), *survey.row_times.notes()])


class _Survey:
    """Reads a table whole, and keeps figures of each column."""

    def __init__(self, path: Path, layout: CsvLayout) -> None:
        self._path, self._layout = path, layout
        self._number = number_reader(layout.decimal, layout.thousands)
        head = islice(lines_of(path, layout.encoding), layout.first_row - 1,
                      layout.first_row + _HEAD_ROWS)
        rows = [layout.split(line) for line in head]
        self.clock, self.clock_notes = _clock_of(layout, [
            _as_clock(layout, place, [row[place].strip() for row in rows if len(row) > place],
                      self._number) for place in range(len(layout.names))])
        self._places = [layout.names.index(name) for name in self.clock.get('column', [])]
        unit = self.clock.get('unit', 's')
        self._time = time_reader(ClockSpec(), unit, self._number, path)
        self.row_times = RowTimes(of_day=unit == 'clock')
        self._columns = [Statistics() for _ in layout.names]
        self._missing, self._texts = Counter[int](), Counter[int]()
        self.times = [math.nan, math.nan]  # s, of the first row and the last

    def read(self) -> None:
        """Read all rows."""
        layout = self._layout
        for line, text in enumerate(lines_of(self._path, layout.encoding), 1):
            if line >= layout.first_row and text.strip():
                self._take(line, layout.split(text))

    def _take(self, line: int, cells: Sequence[str]) -> None:
        seconds = math.nan
        if self._places and max(self._places) < len(cells):
            time = self.row_times.take(line, self._time(
                ' '.join(cells[at].strip() for at in self._places)))
            if time is not None:
                seconds = time.recorded * 1e-9
                self.times = [seconds if math.isnan(self.times[0]) else self.times[0], seconds]
        for place, (statistics, cell) in enumerate(zip(self._columns, cells, strict=False)):
            value = self._number(cell)
            if value is None:
                self._texts[place] += 1
            elif math.isnan(value):
                self._missing[place] += 1
            else:
                statistics.value(value)
                if seconds == seconds:
                    statistics.time(seconds)

    def entries(self) -> list[Entry]:
        """Return an entry of each column."""
        layout, result = self._layout, []
        for place, (name, column) in enumerate(zip(layout.names, self._columns, strict=True)):
            kind = 'time' if place in self._places else (
                'text' if self._texts[place] > column.count else 'number')
            result.append(Entry(
                name=name, type=kind, unit=layout.units[place] or unit_in_name(name),
                count=column.count, missing=self._missing[place], texts=self._texts[place],
                **column.as_fields()))
        return result


def _layout_notes(layout: CsvLayout) -> list[str]:
    mark = {'\t': 'tab', ' ': 'blanks'}.get(layout.delimiter, layout.delimiter)
    thousands = f', thousands {layout.thousands!r}' if layout.thousands else ''
    return [f'{layout.encoding}, columns apart by {mark}, decimals {layout.decimal!r}{thousands}, '
            f'values from line {layout.first_row}']


def _clock_of(layout: CsvLayout, candidates: Sequence[_Clock | None]
              ) -> tuple[dict[str, Any], dict[str, str]]:
    """Return keys of the clock and the grounds of the guess; none where nothing is one."""
    scored = {place: one for place, one in enumerate(candidates) if one is not None}
    if not scored:
        return {}, {}
    best = max(scored, key=lambda place: (scored[place].score, -place))
    dates = [place for place, one in scored.items() if one.is_date]
    clocks = [place for place, one in scored.items() if one.unit == 'clock']
    if dates and clocks and not (scored[best].unit in TIME_UNITS and scored[best].score > 4.0):
        date, of_day = dates[0], clocks[0]
        return ({'column': [layout.names[date], layout.names[of_day]],
                 'unit': scored[date].unit},
                {'column': 'a column of dates and one of times', 'unit': scored[date].why})
    if scored[best].is_date or scored[best].score < 1.0:
        return {}, {}
    chosen = scored[best]
    by_name = _is_time_name(layout.names[best])
    return ({'column': [layout.names[best]], 'unit': chosen.unit},
            {'column': '' if by_name else 'the first column that rises', 'unit': chosen.why})


def _is_time_name(name: str) -> bool:
    return bool(_TIME_WORDS & set(plain_words(name)))


def _as_clock(layout: CsvLayout, place: int, cells: Sequence[str], number: Any) -> _Clock | None:
    """Return a column as the clock, if it may be it."""
    filled = [cell for cell in cells if cell]
    if not filled:
        return None
    score = 3.0 * _is_time_name(layout.names[place]) + (place == 0)
    text = _text_clock(layout, filled)
    if text is not None:
        return text._replace(score=score + 3.0)
    values = [value for cell in filled if (value := number(cell)) is not None
              and not math.isnan(value)]
    if len(values) < 0.9 * len(filled):
        return None
    rising = sum(b >= a for a, b in pairwise(values))
    if len(values) > 1 and (rising < 0.95 * (len(values) - 1) or values[-1] <= values[0]):
        return None
    of_other = find_unit(layout.units[place] or unit_in_name(layout.names[place]) or '?')
    if of_other is not None and of_other.quantity != 'time':
        return None
    unit, why = _time_unit(layout, place, values)
    stated = not why
    return _Clock(score + 1.0 + 3.0 * stated, unit, why) if score or stated or not place else None


def _text_clock(layout: CsvLayout, cells: Sequence[str]) -> _Clock | None:
    """Return texts as dates or times, if they are any."""
    least = 0.9 * len(cells)
    if sum(bool(_YEAR_FIRST.match(cell)) for cell in cells) >= least:
        return _Clock(0.0, 'iso' if '-' in cells[0][:6] else 'ymd', '', ':' not in cells[0])
    if sum(bool(_CLOCK.fullmatch(cell)) for cell in cells) >= least:
        return _Clock(0.0, 'clock', '')
    dates = [match for cell in cells if (match := _DAY_OR_MONTH.match(cell))]
    if len(dates) < least:
        return None
    alone = ':' not in cells[0]
    if any(int(match[1]) > 12 for match in dates) or dates[0][2] == '.':
        return _Clock(0.0, 'dmy', '', alone)
    if any(int(match[3]) > 12 for match in dates):
        return _Clock(0.0, 'mdy', '', alone)
    unit = 'mdy' if layout.decimal == '.' and layout.delimiter == ',' else 'dmy'
    return _Clock(0.0, unit, 'day and month may be the other way round', alone)


def _time_unit(layout: CsvLayout, place: int, values: Sequence[float]) -> tuple[str, str]:
    """Return the unit of numbers of time, and the ground of the guess; '' where it is stated."""
    name = layout.names[place]
    stated = find_unit(layout.units[place] or unit_in_name(name) or '?')
    if stated is not None and stated.name in TIME_UNITS:
        return stated.name, ''
    largest = max(map(abs, values))
    for unit, least in _UNIX:
        if largest > least:
            return unit, 'by the size of the numbers, a Unix time'
    if 20_000.0 < largest < 80_000.0 and {'date', 'datum', 'datetime', 'zeit', 'time'} & set(
            plain_words(name)) and values[-1] - values[0] < 100.0:
        return 'excel', 'by the size of the numbers, days of a spreadsheet'
    steps = sorted(b - a for a, b in pairwise(values))
    usual = steps[len(steps) // 2] if steps else 0.0
    if usual >= 5.0 and all(value % 1.0 == 0.0 for value in values):
        return 'ms', f'by its steps of {usual:g}'
    return 's', f'by its steps of {usual:g}'
