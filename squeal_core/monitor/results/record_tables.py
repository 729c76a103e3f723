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


"""Tables of records as CSV: the fields of named tuples as columns, one or several in a row."""

from collections.abc import Iterable, Iterator, Sequence
import csv
from itertools import islice
import math
from pathlib import Path
from typing import Any, get_type_hints, Self, TypeVar

from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import LocatedError

MAX_BYTES = 200_000_000  # of the table of one recording
REMEDY = 'give a result that `squeal replay` wrote, or write it again'
_MAX_LINE = 10_000  # characters

Record = TypeVar('Record')


class ResultError(LocatedError):
    """Files of replayed recordings that cannot be read."""


def columns_of(kinds: Sequence[Any]) -> tuple[str, ...]:
    """Return the fields of named tuples, which are the columns of a table that joins them."""
    return tuple(name for kind in kinds for name in kind._fields)


def write_records(path: Path, kind: type[Record], records: Iterable[Record]) -> None:
    """Write records as CSV, the fields as columns; a cell is empty where nothing is known."""
    with JoinedWriter(path, [kind]) as table:
        for record in records:
            table.write(record)


class JoinedWriter:
    """
    Writes rows as CSV, each of one record of each kind. A context manager.

    Parameters
    ----------
    path : Path
        Of the table.
    kinds : sequence of types
        Named tuples without a common field.

    """

    def __init__(self, path: Path, kinds: Sequence[Any]) -> None:
        self._columns = columns_of(kinds)
        self._file = path.open('w', encoding='utf-8', newline='')
        self._writer = csv.writer(self._file, lineterminator='\n')
        self._writer.writerow(self._columns)

    def __enter__(self) -> Self:
        return self

    def write(self, *records: Any) -> None:
        """Write a row."""
        values = (value for record in records for value in record)
        self._writer.writerow([_cell(*one) for one in zip(values, self._columns, strict=True)])

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _cell(value: object, name: str) -> object:
    if value is None or value != value or (name == 'mode_number' and not value):
        return ''
    return int(value) if isinstance(value, bool) else value


_PARSERS: dict[object, Any] = {
    str: str, int: lambda text: int(text or 0), float: lambda text: float(text or math.nan),
    bool: lambda text: bool(int(text)),
    bool | None: lambda text: bool(int(text)) if text else None}


def read_records(path: str | Path, kind: type[Record]) -> Iterator[Record]:
    """
    Yield the records of a CSV file.

    Raises
    ------
    ResultError
        Naming file, line and what is wrong.

    """
    return (record for (record,) in read_joined(path, [kind]))


def read_joined(path: str | Path, kinds: Sequence[Any], *,
                most_bytes: int = MAX_BYTES) -> Iterator[Any]:
    """
    Yield the rows of a CSV file of `JoinedWriter`: a record of each kind.

    Raises
    ------
    ResultError
        Naming file, line and what is wrong.

    """
    names = columns_of(kinds)
    parsers = [_PARSERS[get_type_hints(kind)[name]] for kind in kinds for name in kind._fields]
    try:
        with open_bounded(path, most_bytes, ResultError) as file:
            reader = csv.reader(bounded_lines(file, _MAX_LINE, lambda line: ResultError(
                f'{path}, line {line}', f'has more than {_MAX_LINE} characters', REMEDY)))
            if tuple(columns := next(reader, [])) != names:
                raise ResultError(path, f'has the columns {columns}', REMEDY)
            for cells in reader:
                try:
                    values = iter([parse(cell) for parse, cell in zip(
                        parsers, cells, strict=True)])
                except ValueError as error:
                    raise ResultError(f'{path}, line {reader.line_num}', str(error),
                                      REMEDY) from None
                yield tuple(kind._make(islice(values, len(kind._fields))) for kind in kinds)
    except (UnicodeDecodeError, csv.Error) as error:
        raise ResultError(path, f'cannot be read ({error})', REMEDY) from None
