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

"""Cells of a table of text -> numbers and times."""

from collections.abc import Callable
from datetime import datetime, timedelta, timezone, tzinfo, UTC
import math
import re
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

from squeal_core.common.errors import short_repr
from squeal_core.common.measured_units import UNITS
from squeal_ros.recordings.signals.signals_file import SignalsError
from squeal_ros.recordings.signals.table_spec import ClockSpec

MISSING = frozenset(('', 'nan', '-nan', '+nan'))  # in lower case: cells without a value
_SPACES, _APOSTROPHES = '\u00a0\u202f\u2009 ', "'’"
_TIME = r'(?P<hour>\d{1,6}):(?P<minute>\d\d)(?::(?P<second>\d\d)(?:[.,:](?P<fraction>\d{1,12}))?)?'
_HALF, _ZONE = r'(?:\s*(?P<half>[apAP])\.?[mM]\.?)?', r'\s*(?P<zone>Z|UTC|[+-]\d\d:?\d\d)?'
_DATES = {
    'ymd': r'(?P<year>\d{4})[-./](?P<month>\d{1,2})[-./](?P<day>\d{1,2})',
    'dmy': r'(?P<day>\d{1,2})[-./](?P<month>\d{1,2})[-./](?P<year>\d{4}|\d\d)',
    'mdy': r'(?P<month>\d{1,2})[-./](?P<day>\d{1,2})[-./](?P<year>\d{4}|\d\d)'}
_DATES['iso'] = _DATES['ymd']
_ZONED = re.compile(r':\d\d.*(?:Z|UTC|[+-]\d\d:?\d\d)')  # a time of day and its zone
_EXCEL_DAY = 25569  # of 1970-01-01

TimeReader = Callable[[str], int | None]
"""Returns the time that a cell states [ns], or None."""


def number_reader(decimal: str, thousands: str) -> Callable[[str], float | None]:
    """
    Return a function that reads a number as written; NaN: missing, None: a text.

    Parameters
    ----------
    decimal, thousands : str
        Marks; no other one is taken for either.

    """
    same = next((marks for marks in (_SPACES, _APOSTROPHES) if thousands in marks), thousands)
    group = ''.join(map(re.escape, same or ','))
    grouped = re.compile(rf'[+-]?\d{{1,3}}(?:[{group}]\d{{3}})+(?:{re.escape(decimal)}\d*)?')
    ungrouped = str.maketrans('', '', same)

    def read(cell: str) -> float | None:
        text = cell.strip()
        if decimal != '.':
            if '.' in text and thousands != '.':
                return None
            text = text.replace('.', '\0').replace(decimal, '.')
        try:
            value = float(text)
        except ValueError:
            if thousands and grouped.fullmatch(cell.strip()):
                return float(cell.strip().translate(ungrouped).replace(decimal, '.'))
            return math.nan if text.lower() in MISSING else None
        return None if '_' in text or math.isinf(value) else value

    return read


def time_reader(clock: ClockSpec, unit: str, number: Callable[[str], float | None],
                where: object) -> TimeReader:
    """
    Return a function that reads the times of a table.

    Parameters
    ----------
    clock : ClockSpec
        Its zone and start are those of the times.
    unit : str
        One of TIME_UNITS or TIME_FORMATS.
    number : callable
        Reads a number.
    where : object
        For errors.

    """
    zone = zone_of(clock.timezone, where)
    origin = start_time(clock, zone)
    if unit in UNITS or unit == 'excel':
        factor = 86400e9 if unit == 'excel' else UNITS[unit].scale * 1e9
        before = _EXCEL_DAY if unit == 'excel' else 0

        def read_number(cell: str) -> int | None:
            value = number(cell)
            if value is None or not abs(value * factor) < 9e18:
                return None
            whole = math.floor(value)  # apart, so that a Unix time keeps its microseconds
            time = round((whole - before) * factor) + round((value - whole) * factor) + origin
            return time - _offset_at(time, zone) if unit == 'excel' else time

        return read_number
    if unit == 'clock':
        return _clock_reader(origin)
    return _date_reader(unit, zone)


def has_zone(cell: str) -> bool:
    """Return whether a time states its zone."""
    return _ZONED.search(cell) is not None


def zone_of(name: str, where: object) -> tzinfo:
    """Return a time zone by its name or its offset; UTC where none is named."""
    offset = re.fullmatch(r'(?:UTC)?([+-])(\d\d):?(\d\d)', name)
    if offset:
        minutes = int(offset[2]) * 60 + int(offset[3])
        return timezone(timedelta(minutes=-minutes if offset[1] == '-' else minutes))
    try:
        return ZoneInfo(name) if name not in ('', 'UTC', 'Z') else UTC
    except (ZoneInfoNotFoundError, ValueError, OSError):
        raise SignalsError(where, f'timezone is {short_repr(name)}',
                           'write one as Europe/Berlin, or an offset as +01:00') from None


def start_time(clock: ClockSpec, zone: tzinfo) -> int:
    """Return the instant at which times are zero [ns]; 0 where none is stated."""
    if clock.start is None:
        return 0
    if isinstance(clock.start, float):
        return round(clock.start * 1e9)
    start = clock.start if clock.start.tzinfo else clock.start.replace(tzinfo=zone)
    return round(start.timestamp()) * 1_000_000_000 + (
        start.microsecond * 1000 if start.microsecond < 500_000 else
        (start.microsecond - 1_000_000) * 1000)


def _offset_at(time: int, zone: tzinfo) -> int:
    """Return by how much the clock of a zone is ahead of UTC [ns] when it shows a time."""
    if zone is UTC:
        return 0
    shown = datetime(1970, 1, 1, tzinfo=zone) + timedelta(seconds=time // 1_000_000_000)
    return round((shown.utcoffset() or timedelta()).total_seconds()) * 1_000_000_000


def _clock_reader(origin: int) -> TimeReader:
    pattern = re.compile(rf'{_TIME}{_HALF}')

    def read(cell: str) -> int | None:
        match = pattern.fullmatch(cell.strip())
        return None if match is None else _of_day(match) + origin

    return read


def _date_reader(unit: str, zone: tzinfo) -> TimeReader:
    pattern = re.compile(rf'{_DATES[unit]}(?:[T ,;]+{_TIME}{_HALF}{_ZONE})?')
    days: dict[tuple[str, ...], int] = {}

    def read(cell: str) -> int | None:
        match = pattern.fullmatch(cell.strip())
        if match is None:
            return None
        hour = match['hour'] or '0'
        key = match['year'], match['month'], match['day'], hour, match['zone'] or ''
        if key not in days:
            if len(days) > 10_000:
                days.clear()
            own = zone if not key[-1] else zone_of(key[-1].replace('Z', 'UTC'), cell)
            year = int(key[0]) + 2000 * (len(key[0]) == 2)
            try:
                shown = datetime(year, int(key[1]), int(key[2]), int(hour) % 24, tzinfo=own)
                ahead = shown.utcoffset() or timedelta()
            except (ValueError, OverflowError):
                return None
            day = shown.replace(hour=0, tzinfo=UTC).timestamp()
            days[key] = (round(day) - round(ahead.total_seconds())) * 1_000_000_000
        return days[key] + (_of_day(match) if match['hour'] else 0)

    return read


def _of_day(match: re.Match[str]) -> int:
    """Return the time since midnight [ns]."""
    hour = int(match['hour'])
    if match['half']:
        hour = hour % 12 + 12 * (match['half'] in 'pP')
    seconds = (hour * 60 + int(match['minute'])) * 60 + int(match['second'] or 0)
    return seconds * 1_000_000_000 + int((match['fraction'] or '0').ljust(9, '0')[:9])
