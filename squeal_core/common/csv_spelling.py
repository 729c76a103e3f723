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

"""Encoding of a text, and the decimal and thousands marks of its numbers."""

import codecs
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
import re

from squeal_core.common.errors import LocatedError

_BOMS = ((codecs.BOM_UTF8, 'utf-8-sig'), (codecs.BOM_UTF16_LE, 'utf-16'),
         (codecs.BOM_UTF16_BE, 'utf-16'))
_NUMBER = re.compile(r"[+-]?(\d[\d.,'’ \u00a0\u202f]*|[.,]\d+)([eE][+-]?\d+)?")
_DATE_TIME = re.compile(
    r'\d{1,4}[-./]\d{1,2}[-./]\d{1,4}([T ,]\s*\d.*)?|'
    r'\d+:\d\d(:\d\d)?([.,]\d+)?(\s*[apAP]\.?[mM]\.?)?')
_GROUPED = re.compile(r"\d{1,3}(([.,'’ \u00a0\u202f])\d{3})(\2\d{3})*(?!\d)")
_MARKS = '.,'
# marks of missing values by instruments and spreadsheets, in lower case
MISSING_WORDS = frozenset((
    'nan', 'n/a', '#n/a', '#nv', 'na', 'n.a.', 'null', 'nil', '#null!', 'err', 'error', 'fehler',
    '#value!', '#wert!', '#div/0!', '#ref!', '#num!', '#bezug!', '#zahl!', '--', '---', '----',
    '?', '???', 'inf', '-inf', '+inf', 'invalid', 'missing', 'overflow', 'ovl', 'ovr'))


class CsvError(LocatedError):
    """A table of text that cannot be read."""


def encoding_of(path: Path, head: bytes) -> str:
    """Return the encoding of a text by its first bytes; refuse other files."""
    for mark, name in _BOMS:
        if head.startswith(mark):
            return name
    even, odd = head[:200:2], head[1:200:2]
    for name, high, low in (('utf-16-le', odd, even), ('utf-16-be', even, odd)):
        if high.count(0) > 0.7 * len(high) and low.count(0) < 0.1 * len(low):
            return name
    first = head.partition(b'\n')[0]
    strange = sum(byte < 32 and byte not in b'\t\r\n\f\x1b' for byte in first[:2000])
    if b'\0' in first or strange > 0.02 * len(first[:2000]):
        raise CsvError(path, 'is no text', 'give a table of text, or end the name as its format '
                       'does (.mcap, .db3, .bag, .mf4)')
    try:
        codecs.getincrementaldecoder('utf-8')().decode(head)
    except UnicodeDecodeError:
        return 'cp1252'
    return 'utf-8'


def likeness(cell: str) -> float:
    """Return the likeness of a cell to a number, a date or a time, 0 to 1."""
    cell = cell.strip()
    if _NUMBER.fullmatch(cell):
        return 0.5 if ' ' in cell else 1.0  # rather two numbers than one with thousands
    return float(bool(_DATE_TIME.fullmatch(cell)))


def is_missing(cell: str) -> bool:
    """Return whether a cell says that a value is missing."""
    return cell.strip().casefold() in MISSING_WORDS


def marks_of(rows: Sequence[Sequence[str]], decimal: str = '',
             thousands: str | None = None) -> tuple[str, str]:
    """Return the marks of decimals and of thousands, by how numbers are written if not given."""
    cells = [cell.strip() for row in rows for cell in row]
    numbers = [cell for cell in cells if _NUMBER.fullmatch(cell)]
    both = Counter(mark for cell in numbers if all(mark in cell for mark in _MARKS)
                   for mark in _MARKS if cell.rfind(mark) == max(map(cell.rfind, _MARKS)))
    twice = {mark for cell in numbers for mark in _MARKS if cell.count(mark) > 1}
    once = Counter(mark for cell in numbers for mark in _MARKS if cell.count(mark) == 1)
    if not decimal:
        if both:
            decimal = both.most_common(1)[0][0]
        elif len(twice) == 1:
            decimal = _MARKS.replace(next(iter(twice)), '')
        else:
            decimal = ',' if once[','] > once['.'] else '.'
    if thousands is None:
        grouped = Counter(match[2] for cell in numbers if (match := _GROUPED.match(cell.lstrip(
            '+-'))) and match[2] != decimal)
        other = _MARKS.replace(decimal, '')
        if not (both or twice):
            grouped.pop(other, None)  # 1.234 beside 1,5 may be either
        thousands = grouped.most_common(1)[0][0] if grouped else ''
    return decimal, thousands
