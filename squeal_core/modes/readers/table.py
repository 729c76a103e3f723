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

"""
Modes as a table, one line a node, as a script or a spreadsheet can write it.

    # comment
    frequency_hz, 0, 3442.5
    modal_mass, 1, 1            (may be left out)
    node, x, y, z, ux, uy, uz, ux, uy, uz
    1, 0.1, 0, 0, 0.2, 0, 0, 0, 0.1, 3.0

Columns stand between commas, semicolons or blanks, whichever the line of frequencies has.
"""

from pathlib import Path
import re

import numpy as np
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers import listing
from squeal_core.modes.readers.raw import assemble, NodeField, RawModes
from squeal_core.modes.readers.text import Text

FIRST_WORD = 'frequency_hz'
_REMEDY = 'see docs/howto/modal_results.md for the layout'


def begins_table(text: Text) -> bool:
    """Return whether the first line that says something is one of frequencies."""
    return any(line.decode('latin-1').strip('\ufeff\xef\xbb\xbf \t').startswith(FIRST_WORD)
               for line in _first(text))


def _first(text: Text) -> list[bytes]:
    said = (line for line in text.lines if line.strip() and line.strip()[:1] != b'#')
    return [line for _, line in zip(range(1), said, strict=False)]


def read_text(text: Text) -> RawModes:
    """Read a table of modes."""
    rows = _rows(text)
    if not rows or rows[0][1][0] != FIRST_WORD:
        raise text.error(rows[0][0] if rows else 0, f'does not begin with {FIRST_WORD}', _REMEDY)
    frequencies = _numbers(text, *rows[0], 1)
    masses = _numbers(text, *rows[1], 1) if rows[1:] and rows[1][1][0] == 'modal_mass' else None
    head = 1 if masses is None else 2
    if masses is not None and len(masses) != len(frequencies):
        raise text.error(rows[1][0], f'gives {len(masses)} modal masses of {len(frequencies)} '
                         'modes', 'give one each mode')
    if len(rows) < head + 2:
        raise text.error(rows[-1][0], 'is the last line: there are no nodes', _REMEDY)
    _check_names(text, *rows[head], len(frequencies))
    values = np.array([_numbers(text, *row, 0, 4 + 3 * len(frequencies))
                       for row in rows[head + 1:]])
    ids = _ids(text, rows[head + 1:], values[:, 0])
    where = f'lines from {rows[head][0] + 2}'
    fields = [NodeField(ids, values[:, k:k + 3], where) for k in range(4, values.shape[1], 3)]
    return assemble(text.path, NodeField(ids, values[:, 1:4], where), fields, frequencies, {},
                    modal_masses=masses)


def _rows(text: Text) -> list[tuple[int, list[str]]]:
    """Return line numbers and columns of the lines that are not comments."""
    rows: list[tuple[int, list[str]]] = []
    separator: str | None = None
    for i, line in enumerate(text.lines):
        try:
            content = line.decode('utf-8-sig').partition('#')[0].strip()
        except UnicodeDecodeError:
            raise text.error(i, 'is no UTF-8 text', 'save the table as UTF-8') from None
        if not content:
            continue
        if not rows:
            separator = next((mark for mark in ';,' if mark in content), None)
        rows.append((i, [cell.strip() for cell in content.split(separator)]))
    return rows


def _numbers(text: Text, i: int, cells: list[str], start: int,
             count: int | None = None) -> list[float]:
    if count is not None and len(cells) != count:
        raise text.error(i, f'has {len(cells)} columns, not {count}', 'give a line each node: '
                         'its number, x, y, z and ux, uy, uz of each mode')
    try:
        return [float(cell) for cell in cells[start:]]
    except ValueError:
        bad = next(cell for cell in cells[start:] if not _is_number(cell))
        raise text.error(i, f'has {short_repr(bad)}, not a number', 'write decimals with a point'
                         if re.fullmatch(r'[-+\d]+,\d+', bad) else _REMEDY) from None


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _check_names(text: Text, i: int, cells: list[str], modes: int) -> None:
    """Refuse other names of columns; they may carry the number of the mode: ux, ux1, ux_1."""
    names = [re.sub(r'[ _]?\d+$', '', cell.lower()) for cell in cells]
    wanted = ['node', 'x', 'y', 'z', *['ux', 'uy', 'uz'] * modes]
    if names != wanted:
        place = next((k for k, pair in enumerate(zip(names, wanted, strict=False))
                      if pair[0] != pair[1]), min(len(names), len(wanted)))
        result = short_repr(cells[place]) if place < len(cells) else 'nothing'
        raise text.error(i, f'has {result} in column {place + 1}, where {modes} modes have '
                         f'{wanted[place] if place < len(wanted) else "nothing"}', _REMEDY)


def _ids(text: Text, rows: list[tuple[int, list[str]]], numbers: np.ndarray) -> np.ndarray:
    bad = np.flatnonzero(~((numbers == np.round(numbers)) & (np.abs(numbers) < 1e15)))
    if bad.size:
        raise text.error(rows[bad[0]][0], f'has node number {numbers[bad[0]]}',
                         'number nodes by whole numbers')
    return np.asarray(numbers.astype(np.int64))


def read(path: Path) -> RawModes:
    """Read a table of modes, or the listing of a package if it does not begin as a table."""
    text = Text.read(path)
    return read_text(text) if begins_table(text) else listing.read_text(text)
