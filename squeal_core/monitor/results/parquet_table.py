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

"""Assessments over time as a Parquet table; the columns are those of the CSV."""

from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import Any, get_type_hints

import numpy as np

try:
    import pyarrow
    from pyarrow import parquet
except ImportError as error:
    raise ImportError("Parquet tables need pyarrow: pip install -e '.[parquet]' in the checkout"
                      ) from error

from squeal_core.common.bounded_reader import check_readable
from squeal_core.monitor.results.history import AssessmentRecord, HistoryError, MAX_BYTES
from squeal_core.monitor.results.history_columns import HistoryBlock, ROWS

_TYPES: dict[object, Any] = {
    float: pyarrow.float64(), str: pyarrow.string(), bool: pyarrow.bool_(), int: pyarrow.int32(),
    tuple[float, ...]: pyarrow.list_(pyarrow.float64()),
    tuple[int, ...]: pyarrow.list_(pyarrow.int32()), bool | None: pyarrow.bool_()}
_GROUP = 20_000  # rows that are written, and read, at once


def _schema(*kinds: Any) -> Any:
    """Return the columns of a table that joins records of these kinds."""
    return pyarrow.schema([(name, _TYPES[kind]) for one in kinds
                           for name, kind in get_type_hints(one).items()])


_SCHEMA = _schema(AssessmentRecord)


class ParquetWriter:
    """
    Writes rows as they come, in groups. A context manager.

    Parameters
    ----------
    path : Path
        Of the table.
    kinds : sequence of types
        Named tuples: a row is a record of each.

    """

    def __init__(self, path: Path, kinds: Sequence[Any] = (AssessmentRecord,)) -> None:
        self._schema = _schema(*kinds)
        self._writer = parquet.ParquetWriter(path, self._schema, compression='zstd')
        self._rows: list[tuple[Any, ...]] = []

    def __enter__(self) -> 'ParquetWriter':
        return self

    def write(self, *records: Any) -> None:
        """Write a row."""
        self._rows.append(records[0] if len(records) == 1 else tuple(chain(*records)))
        if len(self._rows) == _GROUP:
            self._flush()

    def _flush(self) -> None:
        columns = [*zip(*self._rows, strict=True)] or [()] * len(self._schema)
        self._writer.write_table(pyarrow.table([
            pyarrow.array(values, field.type)
            for values, field in zip(columns, self._schema, strict=True)], schema=self._schema))
        self._rows.clear()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if kind is None:
            self._flush()
        self._writer.close()


def read_parquet(path: str | Path) -> Iterator[AssessmentRecord]:
    """
    Yield the rows of a Parquet file.

    Raises
    ------
    HistoryError
        Naming the file and what is wrong.

    """
    for batch in _batches(path, _GROUP):
        columns = [column.to_pylist() for column in batch.columns]
        for values in zip(*columns, strict=True):
            yield AssessmentRecord._make(
                tuple(value) if isinstance(value, list) else value for value in values)


def parquet_blocks(path: str | Path, columns: Sequence[str],
                   rows: int = ROWS) -> Iterator[HistoryBlock]:
    """
    Yield the rows of a Parquet file as `history_columns.read_blocks` does those of a CSV.

    Raises
    ------
    HistoryError
        Naming the file and what is wrong.

    """
    for batch in _batches(path, rows):
        texts = {name: batch.column(name).to_pylist() for name in (
            'brake', 'state', 'unstable_frequencies_hz', 'unstable_growth_rates_1_s')}
        brakes, states, *lists = texts.values()
        frequencies, growth_rates = ([' '.join(map(repr, values)) for values in column]
                                     for column in lists)
        numbers = {name: batch.column(name).to_numpy(zero_copy_only=False).astype(np.float64)
                   for name in ('time_s', *columns)}
        yield HistoryBlock(brakes, states, numbers, frequencies, growth_rates)


def _batches(path: str | Path, rows: int) -> Iterator[Any]:
    """Yield record batches of a Parquet file that `ParquetWriter` wrote."""
    check_readable(path, MAX_BYTES, lambda where, what, remedy: HistoryError(
        f'{where}: {what}; {remedy}'))
    try:
        with parquet.ParquetFile(path) as file:
            if file.schema_arrow.names != _SCHEMA.names:
                raise HistoryError(f'{path}: its columns are {file.schema_arrow.names}; give a '
                                   'table that `squeal replay` wrote')
            yield from file.iter_batches(rows)
    except (OSError, pyarrow.ArrowException) as error:
        raise HistoryError(f'{path}: cannot be read ({error}); give a table that `squeal replay` '
                           'wrote') from None
