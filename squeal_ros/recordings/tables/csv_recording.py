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

"""A table of text, CSV or TSV, as a recording: columns are the inputs, rows the messages."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from itertools import chain
import math
from pathlib import Path

from squeal_core.common.csv_spelling import CsvError
from squeal_core.common.errors import did_you_mean, short_repr
from squeal_core.common.measured_units import find_unit
from squeal_core.common.wording import listed
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.positions import Positions
from squeal_ros.recordings.recording import Samples
from squeal_ros.recordings.signals.column_units import contradiction, unit_in_name
from squeal_ros.recordings.signals.signals_file import Signals
from squeal_ros.recordings.signals.table_spec import TIME_UNITS
from squeal_ros.recordings.tables.csv_cells import has_zone, number_reader, time_reader
from squeal_ros.recordings.tables.csv_layout import CsvLayout, lines_of, read_layout
from squeal_ros.recordings.tables.input_column import InputColumn, without_values
from squeal_ros.recordings.tables.row_times import RowTimes

_MOST_NAMES = 30  # of columns, in an error


class CsvRecording:
    """
    A table read through a file of signals, row by row; memory does not grow with it.

    Parameters
    ----------
    path : path
    settings : MonitorSettings
        With the inputs of the signals.
    signals : Signals

    Raises
    ------
    SquealError
        For what is no table, or has not the columns.

    """

    kind = 'csv'

    def __init__(self, path: Path, settings: MonitorSettings, signals: Signals) -> None:
        self.path, self._signals = path, signals
        self.layout = read_layout(path, signals.table)
        self.positions = Positions()
        self._number = number_reader(self.layout.decimal, self.layout.thousands)
        self._columns = [InputColumn.of(source, settings) for source in signals.sources]
        self._places = [self._place(source.name, source.where) for source in signals.sources]
        self._position = [self._place(one.name, one.where) for one in signals.position]
        self._clock = [self._place(name, f'{signals.path}, clock') for name in
                       signals.clock.columns]
        if not self._clock:
            raise CsvError(signals.path, 'names no clock', 'write clock: {column: ...}, the '
                           f'column of time; {_columns_in_words(self.layout)}')
        unit = signals.clock.unit or self._stated_time_unit()
        self._time = time_reader(signals.clock, unit, self._number, f'{signals.path}, clock')
        self._times = RowTimes(round(signals.clock.offset * 1e9), unit == 'clock')
        self._odd_rows = {'short': [0, 0], 'long': [0, 0]}  # how many, and the first line
        self._may_be_local, self._local = self._takes_local_times(unit), False
        self._about = [*self._contradictions(unit)]

    def _place(self, name: str, where: str) -> int:
        place = self.layout.place(name)
        if place is None:
            raise CsvError(where, f'{self.path} has no column {short_repr(name)}'
                           f'{did_you_mean(name, self.layout.names)}',
                           _columns_in_words(self.layout))
        return place

    def _stated_time_unit(self) -> str:
        """Return the unit of time that the column of the clock states."""
        for place in self._clock:
            if unit := self._time_unit_of(place):
                return unit
        raise CsvError(f'{self._signals.path}, clock', 'has no unit, and the column states none',
                       f'write unit: one of {", ".join(TIME_UNITS)} for numbers, iso, clock, dmy, '
                       'mdy or ymd for texts, excel for its days')

    def _time_unit_of(self, place: int) -> str:
        text = self.layout.units[place] or unit_in_name(self.layout.names[place])
        unit = find_unit(text) if text else None
        return unit.name if unit and unit.name in TIME_UNITS else ''

    def _contradictions(self, unit: str) -> Iterator[str]:
        layout = self.layout
        for source, place in zip(self._signals.sources, self._places, strict=True):
            text = layout.units[place] or unit_in_name(layout.names[place])
            yield from contradiction(source, layout.names[place], text)
        for place in self._clock:
            stated = self._time_unit_of(place)
            if stated and unit in TIME_UNITS and stated != unit:
                yield (f'clock: the column {short_repr(layout.names[place])} states {stated}, '
                       f'and {self._signals.path} {unit}, which is taken')

    def _takes_local_times(self, unit: str) -> bool:
        """Return whether times without a zone would be taken as UTC."""
        clock = self._signals.clock
        own_start = isinstance(clock.start, datetime) and not clock.start.tzinfo
        return unit not in TIME_UNITS and not clock.timezone and (unit != 'clock' or own_start)

    @property
    def messages(self) -> int:
        """Return about how many rows there are."""
        sample = [len(line) for line, _ in zip(
            lines_of(self.path, self.layout.encoding), range(200), strict=False)]
        wide = 2 if self.layout.encoding.startswith('utf-16') else 1
        return round(self.path.stat().st_size / max(wide * sum(sample) / len(sample), 1.0))

    @property
    def notes(self) -> list[str]:
        """Return notes on the table, as far as it was read."""
        local = ['times without a zone are taken as UTC; clock.timezone says another']
        return [*self._about, *(local if self._local else []), *self._times.notes(),
                *self._row_notes(),
                *self.positions.missing([one.name for one in self._signals.position]),
                *chain.from_iterable(column.notes() for column in self._columns)]

    def _row_notes(self) -> Iterator[str]:
        for what, (count, first) in self._odd_rows.items():
            if count:
                rows = 'row has' if count == 1 else 'rows have'
                yield (f'{count} {rows} {"fewer" if what == "short" else "more"} cells than '
                       f'the {len(self.layout.names)} columns, the first in line {first}: '
                       'left out')

    @property
    def findings(self) -> list[Finding]:
        """Return findings on inputs without values."""
        marks = f'decimals are read with {self.layout.decimal!r}'
        if self.layout.thousands:
            marks += f', thousands with {self.layout.thousands!r}'
        return without_values(self._columns, f'check the column; {marks}, see table.decimal and '
                              'table.thousands')

    def samples(self) -> Iterator[tuple[int, Samples]]:
        """
        Yield the time [ns] and the samples of each row.

        Raises
        ------
        CsvError
            For a table of which no row can be read.

        """
        taken = False
        for line, cells in self._rows():
            text = ' '.join(cells[place].strip() for place in self._clock)
            time = self._times.take(line, self._time(text))
            if time is None:
                continue
            if self._may_be_local and not self._local:
                self._local = not has_zone(text)
            taken = True
            result = []
            for column, place in zip(self._columns, self._places, strict=True):
                cell = cells[place] if place < len(cells) else ''
                one = column.sample(self._number(cell), time.stated, cell, f'in line {line}')
                if one is not None:
                    result.append(one)
            if self._position:
                self._take_position(time.recorded, cells)
            yield time.recorded, result
        if not taken:
            said = [*self._times.notes(), *self._row_notes()]
            raise CsvError(self.path, f'has no row to read{": " * bool(said)}{"; ".join(said)}',
                           'check clock and table in the file of --signals')

    def _take_position(self, time: int, cells: Sequence[str]) -> None:
        numbers = [self._number(cells[place]) if place < len(cells) else None
                   for place in self._position]
        latitude, longitude = (math.nan if number is None else one.scale * number for one, number
                               in zip(self._signals.position, numbers, strict=True))
        self.positions.take(time, latitude, longitude)

    def _rows(self) -> Iterator[tuple[int, Sequence[str]]]:
        """Yield line number and cells of the rows that have as many as there are columns."""
        layout, width = self.layout, len(self.layout.names)
        least = max(self._clock) + 1 if layout.short_rows else width
        for line, text in enumerate(lines_of(self.path, layout.encoding), 1):
            if line < layout.first_row or not text.strip():
                continue
            cells = layout.split(text)
            too_long = len(cells) > width and any(map(str.strip, cells[width:]))
            if len(cells) >= least and not too_long:
                yield line, cells
                continue
            odd = self._odd_rows['long' if too_long else 'short']
            odd[0] += 1
            odd[1] = odd[1] or line


def _columns_in_words(layout: CsvLayout) -> str:
    return f'its columns are {listed(map(short_repr, layout.names), _MOST_NAMES)}'
