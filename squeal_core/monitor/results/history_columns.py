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

"""Tables of assessments as arrays, block by block: memory does not grow with the table."""

from collections.abc import Iterator, Sequence
import csv
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.monitor.results.history import HistoryError, MAX_BYTES, MAX_LINE

ROWS = 5_000  # of a block
_NEEDED = ('time_s', 'brake', 'state')
_MODES = ('unstable_frequencies_hz', 'unstable_growth_rates_1_s')


class HistoryBlock(NamedTuple):
    """
    Successive rows of a table.

    Parameters
    ----------
    brakes, states : sequence of str
        One a row.
    numbers : dict
        Array of each column that was asked for, NaN where not known or where the table lacks it.
    frequencies_hz, growth_rates : sequence of str
        Of the unstable modes of each row [Hz], [1/s], as written.

    """

    brakes: Sequence[str]
    states: Sequence[str]
    numbers: dict[str, FloatArray]
    frequencies_hz: Sequence[str]
    growth_rates: Sequence[str]


def read_blocks(path: str | Path, columns: Sequence[str],
                rows: int = ROWS) -> Iterator[HistoryBlock]:
    """
    Yield the rows of a table, some thousand at once.

    Parameters
    ----------
    path : path
        CSV file of `squeal replay`.
    columns : sequence of str
        Columns of numbers to return, besides `time_s`.
    rows : int
        Of a block.

    Raises
    ------
    HistoryError
        Naming file, line and what is wrong.

    """
    def too_long(line: int) -> HistoryError:
        return _error(f'{path}, line {line}', f'has more than {MAX_LINE} characters',
                      'give a table that `squeal replay` wrote')

    try:
        with open_bounded(path, MAX_BYTES, _error) as file:
            lines = bounded_lines(file, MAX_LINE, too_long, encoding='utf-8')
            names = next(csv.reader([next(lines, '')]), [])
            missing = [name for name in _NEEDED if name not in names]
            if missing:
                raise _error(path, f'has no column {", ".join(missing)}',
                             'give a table that `squeal replay` wrote')
            places = {name: place for place, name in enumerate(names)}
            end = 1
            while block := list(islice(lines, rows)):
                first, end = end + 1, end + len(block)
                if not any(map(str.strip, block)):
                    continue
                try:
                    yield _block(block, places, ('time_s', *columns))
                except (ValueError, IndexError, csv.Error) as error:
                    raise _error(f'{path}, lines {first} to {end}', str(error),
                                 'mend or leave out the line') from None
    except (OSError, UnicodeDecodeError) as error:
        raise _error(path, f'cannot be read ({error})', 'check the path') from None


def _error(where: object, what: str, remedy: str) -> HistoryError:
    return HistoryError(f'{where}: {what}; {remedy}')


def _block(lines: list[str], places: dict[str, int], columns: Sequence[str]) -> HistoryBlock:
    there = [name for name in columns if name in places]
    of_numbers = [places[name] for name in there]
    last = max(places['brake'], places['state']) + 1
    rows = [line.split(',', last) for line in lines]
    try:
        read = np.loadtxt(lines, delimiter=',', quotechar='"', ndmin=2, comments=None,
                          usecols=of_numbers)
        quick = len(read) == len(rows) and not any(
            '"' in text for name in _NEEDED[1:] for text in {row[places[name]] for row in rows})
    except ValueError:
        quick = False
    if quick:  # only a brake that slides under load has modes
        last = max(places.get(name, 0) for name in _MODES) + 1
        modes = [line.split(',', last) if row[places['state']] == 'steady' else []
                 for row, line in zip(rows, lines, strict=True)]
    else:  # quotes elsewhere than in the reason, empty cells or lines
        modes = rows = [row for row in csv.reader(lines) if row]
        read = np.array([[float(row[place] or 'nan') for place in of_numbers] for row in rows])
    numbers = dict(zip(there, read.reshape(-1, len(there)).T, strict=True))
    return HistoryBlock(
        [row[places['brake']] for row in rows], [row[places['state']] for row in rows],
        {name: numbers.get(name, np.full(len(rows), np.nan)) for name in columns},
        *([row[places[name]] if row else '' for row in modes] if name in places
          else [''] * len(rows) for name in _MODES))
