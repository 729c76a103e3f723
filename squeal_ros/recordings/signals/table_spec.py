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

"""Format of a table of text and the place of its times, by a file of signals."""

from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime

from squeal_core.common.errors import did_you_mean, short_repr
from squeal_core.common.measured_units import find_unit, UNITS
from squeal_core.common.yaml_sections import YamlSection

TIME_UNITS = tuple(unit.name for unit in UNITS.values() if unit.quantity == 'time')
TIME_FORMATS = ('iso', 'clock', 'dmy', 'mdy', 'ymd', 'excel')
_DELIMITERS = {'tab': '\t', 'space': ' ', 'comma': ',', 'semicolon': ';'}
_MOST_ROWS = 100_000  # before the first row of values


@dataclass(frozen=True, kw_only=True)
class ClockSpec:
    """
    Columns of a table's times, and their meaning.

    Parameters
    ----------
    columns : tuple of str
        One, or two of which one holds the date; empty: a measurement's own times.
    unit : str
        One of TIME_UNITS or TIME_FORMATS; empty: as it is found.
    start : datetime or float, optional
        Instant at which the column reads zero, or day of clock times; a float is a Unix time [s].
    timezone : str
        Of local times.
    offset : float
        Added to all times [s].

    """

    columns: tuple[str, ...] = ()
    unit: str = ''
    start: datetime | float | None = None
    timezone: str = ''
    offset: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TableSpec:
    """Format of a table of text; None or empty: as it is found."""

    delimiter: str = ''
    decimal: str = ''
    thousands: str | None = None
    encoding: str = ''
    header_row: int | None = None
    unit_row: int | None = None
    first_row: int | None = None


def read_clock(section: YamlSection) -> ClockSpec:
    """
    Read the section `clock` of a file of signals.

    Raises
    ------
    SignalsError
        With file, line, key, value and remedy.

    """
    columns = section.take('column') or section.take('channel') or []
    if isinstance(columns, str | int):
        columns = [columns]
    if not (isinstance(columns, list) and len(columns) <= 2 and all(
            isinstance(name, str | int) for name in columns)):
        raise section.error('column', f'is {short_repr(columns)}',
                            'name a column, or two: [date, time]')
    units = (*TIME_UNITS, *TIME_FORMATS)
    unit = section.text('unit')
    if unit not in (*units, ''):
        known = find_unit(unit)
        if known is None or known.quantity != 'time':
            raise section.error('unit', f'is {short_repr(unit)}', f'write one of '
                                f'{", ".join(units)}{did_you_mean(unit, units)}')
        unit = known.name
    result = ClockSpec(
        columns=tuple(map(str, columns)), unit=unit, start=_start(section),
        timezone=section.text('timezone'), offset=section.number('offset', 0.0))
    section.finish(('channel',))
    return result


def _start(section: YamlSection) -> datetime | float | None:
    value = section.take('start')
    if isinstance(value, str):
        with suppress(ValueError):
            return datetime.fromisoformat(value)
    elif isinstance(value, datetime) or value is None:
        return value
    elif isinstance(value, date):
        return datetime(value.year, value.month, value.day)
    elif isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < 1e11:
        return float(value)
    raise section.error('start', f'is {short_repr(value)}',
                        'write a date and time, as 2026-11-26T10:00:00+01:00, or Unix seconds')


def read_table(section: YamlSection) -> TableSpec:
    """
    Read the section `table` of a file of signals.

    Raises
    ------
    SignalsError
        With file, line, key, value and remedy.

    """
    delimiter = section.text('delimiter')
    delimiter = _DELIMITERS.get(delimiter.strip().casefold(), delimiter)
    if len(delimiter) > 1 or delimiter in '"\r\n' and delimiter:
        raise section.error('delimiter', f'is {short_repr(delimiter)}',
                            'write one character, tab or space')
    encoding = section.text('encoding')
    try:
        ''.encode(encoding or 'utf-8')
    except (LookupError, ValueError):
        raise section.error('encoding', f'is {short_repr(encoding)}',
                            'write utf-8, latin-1, cp1252 or utf-16') from None
    thousands = section.text('thousands') if 'thousands' in section.content else None
    result = TableSpec(
        delimiter=delimiter, decimal=section.text('decimal', '', ('.', ',')), thousands=thousands,
        encoding=encoding, header_row=section.count('header_row', _MOST_ROWS),
        unit_row=section.count('unit_row', _MOST_ROWS),
        first_row=section.count('first_row', _MOST_ROWS))
    if thousands and (len(thousands) > 1 or thousands in (result.decimal, delimiter)
                      or thousands.isdecimal()):
        raise section.error('thousands', f'is {short_repr(thousands)}',
                            'write another mark than those of decimals and columns')
    section.finish()
    return result
