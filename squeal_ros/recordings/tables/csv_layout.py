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

"""Layout of a table of text: encoding, delimiter, decimal mark, rows of names and units."""

from collections import Counter
from collections.abc import Iterator, Sequence
import csv
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.csv_spelling import (
    CsvError,
    encoding_of,
    is_missing,
    likeness,
    marks_of,
)
from squeal_core.common.errors import short_repr
from squeal_core.common.measured_units import find_unit
from squeal_ros.recordings.signals.table_spec import TableSpec

MAX_BYTES = 1_000_000_000_000  # rows are read one by one
MAX_LINE = 1_000_000  # characters
_HEAD = 200_000  # bytes by which the layout is told
_HEAD_LINES = 1000
_WINDOW = 3  # rows, most of which are alike where the values begin
_LINES_OF_HEADING = 60
_USUALLY_SHORT = 0.1  # of the rows
_DELIMITERS = (';', '\t', ',', '|', ' ')  # a space: any run of blanks


@dataclass(frozen=True)
class CsvLayout:
    """
    Layout of a table, and the names of its columns.

    Parameters
    ----------
    encoding, delimiter, decimal, thousands : str
        A delimiter ' ' is any run of blanks; thousands are empty where they have no mark.
    names, units : tuple of str
        Of each column; units as they are written, empty where there are none.
    first_row : int
        Line of the first values, from 1.
    short_rows : bool
        Whether rows often end before the last column, as empty cells are left out.

    """

    encoding: str
    delimiter: str
    decimal: str
    thousands: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    first_row: int
    short_rows: bool = False

    def split(self, line: str) -> list[str]:
        """Return the cells of a line; a line break ends a cell even in quotes."""
        return split(line, self.delimiter)

    def place(self, column: str) -> int | None:
        """Return the place of a column, by its name or its number from 1."""
        if column in self.names:
            return self.names.index(column)
        bare = [name.strip() for name in self.names]
        if column.strip() in bare:
            return bare.index(column.strip())
        number = int(column) if column.isdecimal() and len(column) < 7 else 0
        return number - 1 if 0 < number <= len(self.names) else None


class _Start(NamedTuple):
    """First row of values for a delimiter, and how well the delimiter fits."""

    quality: float
    columns: int
    row: int  # from 0


_NOWHERE = _Start(-1.0, 0, 0)


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line."""
    line = line.rstrip('\r\n')
    if '"' in line:
        blank = delimiter == ' '
        return next(csv.reader([line], delimiter=delimiter, skipinitialspace=blank), [])
    if delimiter == ' ':
        return line.split()
    return line.split(delimiter)


def lines_of(path: Path, encoding: str) -> Iterator[str]:
    """
    Yield the lines of a table; bytes that are none of its encoding stand as U+FFFD.

    Raises
    ------
    CsvError
        For what is no regular file, and for a line that is longer than any row.

    """
    def too_long(number: int) -> CsvError:
        return CsvError(f'{path}, line {number}', f'has more than {MAX_LINE} characters',
                        'give a table of rows, or cut this line')

    with open_bounded(path, MAX_BYTES, CsvError) as file:
        yield from bounded_lines(file, MAX_LINE, too_long, encoding=encoding, errors='replace')


def read_layout(path: Path, spec: TableSpec) -> CsvLayout:
    """
    Return the layout of a table, by its first lines where `spec` does not say.

    Raises
    ------
    CsvError
        For a file that is no table of text.

    """
    with open_bounded(path, MAX_BYTES, CsvError) as file:
        head = file.read(_HEAD)
    encoding = spec.encoding or encoding_of(path, head)
    lines = [line for _, line in zip(range(_HEAD_LINES + (spec.first_row or 0)),
                                     lines_of(path, encoding), strict=False)]
    if not any(line.strip() for line in lines):
        raise CsvError(path, 'is empty', 'check that it was recorded')
    candidates = (spec.delimiter,) if spec.delimiter else _DELIMITERS
    tables = {mark: _rows(lines, mark) for mark in candidates}
    starts = {mark: _start(rows, mark, spec) for mark, rows in tables.items()}
    delimiter = max(starts, key=lambda mark: starts[mark][:2])
    start = starts[delimiter]
    if not start.columns:
        raise _no_table(path, lines, delimiter if spec.delimiter else '')
    rows = tables[delimiter]
    if not spec.first_row:
        start = start._replace(row=_first_values(rows, start, spec))
    names, units = _headings(rows, start, spec)
    values = [row for row in rows[start.row:] if any(cell.strip() for cell in row)]
    decimal, thousands = marks_of(values, spec.decimal, spec.thousands)
    short = sum(len(row) < len(names) for row in values)
    return CsvLayout(encoding, delimiter, decimal, thousands, names, units, start.row + 1,
                     short > _USUALLY_SHORT * len(values))


def _rows(lines: Sequence[str], delimiter: str) -> list[list[str]]:
    """Return the cells of each line; of headings with line breaks in quotes in the last line."""
    rows: list[list[str]] = []
    pending = ''
    for at, line in enumerate(lines):
        pending += line
        closes = '"' in ''.join(lines[at + 1:at + 1 + _LINES_OF_HEADING])
        if pending.count('"') % 2 and closes and at < _LINES_OF_HEADING:
            rows.append([])
            continue
        whole = ' '.join(pending.splitlines()) if pending != line else line
        rows.append(split(whole, delimiter))
        pending = ''
    return rows


def _start(rows: Sequence[list[str]], delimiter: str, spec: TableSpec) -> _Start:
    """Return the first row of values, of one number of cells; 0 columns: none."""
    full = [at for at, row in enumerate(rows) if any(cell.strip() for cell in row)]
    shares = {at: sum(map(likeness, rows[at])) / sum(bool(cell.strip()) for cell in rows[at])
              for at in full}
    after = spec.first_row - 1 if spec.first_row else max(spec.header_row or 0, spec.unit_row or 0)
    values = [at for at in full if at >= after and len(rows[at]) > 1 and shares[at] >= 0.5]
    if not values:
        named = len(rows[full[0]])  # perhaps a table of names alone
        quality = -0.5 if delimiter == ' ' else 0.0  # blanks are in names, too
        return _Start(quality, named, len(rows)) if len(full) <= 2 and named > 1 else _NOWHERE
    counts = Counter(len(rows[at]) for at in values)
    columns = max(counts, key=lambda count: (counts[count], count))
    whole = {at for at in values if len(rows[at]) == columns}

    def begins(at: int) -> bool:
        window = [one for one in full if one >= at][:_WINDOW]
        return 2 * sum(one in whole for one in window) > len(window)

    first = spec.first_row - 1 if spec.first_row else next(
        (at for at in values if at in whole and begins(at)), min(whole))
    after_first = [at for at in full if at >= first]
    quality = sum(shares[at] for at in whole if at >= first) / len(after_first)
    return _Start(round(quality, 2), columns, first)


def _first_values(rows: Sequence[list[str]], start: _Start, spec: TableSpec) -> int:
    """Return the first row of values, from 0: one whose values are mostly missing may be it."""
    first = start.row
    for at in range(start.row - 1, max(spec.header_row or 0, spec.unit_row or 0) - 1, -1):
        row = rows[at]
        filled = sum(bool(cell.strip()) for cell in row)
        values = sum(cell.strip() == '-' or _is_value(cell) for cell in row)
        below_heading = at > 0 and len(rows[at - 1]) == start.columns and not any(
            map(_is_value, rows[at - 1]))
        if len(row) != start.columns or _is_unit_row(row) or 2 * values < filled or (
                values < filled and not below_heading):
            break
        first = at if filled else first
    return first


def _headings(rows: Sequence[list[str]], start: _Start, spec: TableSpec
              ) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names and the units of the columns."""
    above: list[list[str]] = []
    for row in reversed(rows[:start.row]):
        filled = sum(bool(cell.strip()) for cell in row)
        if filled > 1 and filled >= 0.5 * start.columns:
            above.insert(0, row)
        elif filled or above:
            break
    units, names = [], []
    if spec.unit_row:
        units = rows[spec.unit_row - 1] if spec.unit_row <= len(rows) else []
    elif spec.unit_row is None and len(above) > 1:
        units = max(filter(_is_unit_row, above[:0:-1]), key=_unit_share, default=[])
    if spec.header_row:
        names = rows[spec.header_row - 1] if spec.header_row <= len(rows) else []
    elif spec.header_row is None and above:
        named = above[:above.index(units)] if units in above else above
        names = max(reversed(named), key=lambda row: len(set(filter(None, map(str.strip, row)))),
                    default=[])
    width = max([start.columns, *(at + 1 for at, cell in enumerate(names) if cell.strip())])
    return (tuple(_unique(cell.strip() or str(at + 1) for at, cell in enumerate(
        [*names, *[''] * width][:width]))),
            tuple(cell.strip() for cell in [*units, *[''] * width][:width]))


def _unique(names: Iterator[str]) -> Iterator[str]:
    """Yield names, a second one of a name with its number."""
    seen: Counter[str] = Counter()
    for name in names:
        seen[name] += 1
        yield name if seen[name] == 1 else f'{name} ({seen[name]})'


def _unit_share(row: Sequence[str]) -> float:
    cells = [cell.strip() for cell in row if cell.strip()]
    return sum(find_unit(cell) is not None or cell[:1] + cell[-1:] in ('[]', '()')
               for cell in cells) / max(len(cells), 1)


def _is_unit_row(row: Sequence[str]) -> bool:
    """
    Return whether cells are units.

    One at least is no mere dash or 1, which values may be, too; a text for a missing value may be
    among them only where most are units.
    """
    cells = [cell.strip() for cell in row if cell.strip()]
    known = sum(unit is not None and unit.name != '-' for unit in map(find_unit, cells))
    bracketed = any(cell[:1] + cell[-1:] in ('[]', '()') for cell in cells)
    return _unit_share(row) >= 0.5 and bool(known or bracketed) and (
        2 * known > len(cells) or not any(map(_is_value, cells)))


def _is_value(cell: str) -> bool:
    """Return whether a cell is a number, or says that one is missing."""
    return is_missing(cell) or likeness(cell) == 1.0 and find_unit(cell) is None


def _no_table(path: Path, lines: Sequence[str], delimiter: str) -> CsvError:
    first = next(line for line in lines if line.strip())
    apart = f' with {short_repr(delimiter)} between them' if delimiter else ''
    return CsvError(
        path, f'is no table: it has no rows of values{apart} '
        f'(it begins {short_repr(first.strip())})', 'give rows of a time and values, or state '
        'delimiter, header_row and first_row under table: in the file of --signals')
