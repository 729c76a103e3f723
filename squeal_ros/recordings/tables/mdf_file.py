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

"""ASAM MDF measurements: opened, and read group by group in blocks of records."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from datetime import UTC
import logging
import math
from pathlib import Path
from typing import Any, NamedTuple

try:
    from asammdf import MDF
    from asammdf.blocks.mdf_v4 import MDF4
except ImportError as error:
    raise ImportError("MDF files need asammdf: pip install -e '.[mdf]' in the checkout") from error
import numpy as np
from squeal_core.common.bounded_reader import check_readable
from squeal_core.common.errors import in_one_line, LocatedError, short_repr

MAX_FILE = 1_000_000_000_000  # bytes: it is read record by record
_BLOCK, _LEAST = 50_000, 1_000  # records that are read at once, and where some are damaged
_MASTERS = (2, 3)  # types of channels that hold times: of records, and virtual ones
_TIME = 1  # kind of a master, besides angle, distance and index
_FIRST_TIME = 1e8  # s, of 1973; an earlier start is none


def _close_quietly(file: Any) -> None:
    with suppress(Exception):  # one that could not be opened would print a traceback
        file.close()


MDF4.__del__ = _close_quietly
logging.getLogger('asammdf').setLevel(logging.CRITICAL)  # errors are ours, in one line


class MdfError(LocatedError):
    """A measurement that cannot be read."""


class Channel(NamedTuple):
    """A channel that is no time."""

    name: str
    group: int
    place: int
    unit: str
    records: int
    timed: bool  # whether its group has times


class Block(NamedTuple):
    """Records of a group: times (n,) [s], and values of each channel, numbers or texts."""

    times: Any
    columns: list[Sequence[Any]]


class MdfFile:
    """
    A measurement that is open; a context manager.

    Parameters
    ----------
    path : path

    Attributes
    ----------
    lost : dict of Channel to int
        Records that cannot be read, by the first channel that was asked for.
    first_damage : MdfError or None
        Why the first of them cannot.

    Raises
    ------
    MdfError
        For what is no MDF, or is damaged.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lost: dict[Channel, int] = {}
        self.first_damage: MdfError | None = None
        check_readable(path, MAX_FILE, MdfError)
        try:
            self._mdf = MDF(path, raise_on_multiple_occurrences=False)
            self.channels = list(self._channels())
        except Exception as error:  # asammdf lets struct, index, key and memory errors through
            raise self._damaged(error) from None

    def __enter__(self) -> 'MdfFile':
        return self

    def __exit__(self, *_: object) -> None:
        self._mdf.close()

    def _damaged(self, error: Exception) -> MdfError:
        return MdfError(self.path, 'cannot be read as MDF '
                        f'({type(error).__name__}: {in_one_line(error, 120)})',
                        'check that it is whole and of version 3 or 4; where its end is missing '
                        'let the software of the logger repair it, or export it as CSV')

    def _channels(self) -> Iterator[Channel]:
        for number, group in enumerate(self._mdf.groups):
            masters = [channel for channel in group.channels
                       if getattr(channel, 'channel_type', 0) in _MASTERS]
            timed = any(getattr(channel, 'sync_type', _TIME) == _TIME for channel in masters) or (
                self._mdf.version < '4' and number in self._mdf.masters_db)
            for index, channel in enumerate(group.channels):
                if channel not in masters and index != self._mdf.masters_db.get(number):
                    unit = channel.unit or getattr(channel.conversion, 'unit', '') or ''
                    yield Channel(channel.name, number, index, unit,
                                  group.channel_group.cycles_nr, timed)

    @property
    def start(self) -> tuple[float, bool]:
        """Return when time is zero [s since 1970], and whether its zone is known; 0: no time."""
        start = self._mdf.start_time
        seconds = (start if start.tzinfo else start.replace(tzinfo=UTC)).timestamp()
        return (seconds, start.tzinfo is not None) if seconds > _FIRST_TIME else (0.0, True)

    def first_time(self, channel: Channel) -> float:
        """Return the first time of a channel [s]; NaN without a record that can be read."""
        try:
            times = self._mdf.get(group=channel.group, index=channel.place, record_offset=0,
                                  record_count=1).timestamps
        except Exception:
            return math.nan
        return float(times[0]) if len(times) else math.nan

    def blocks(self, channels: Sequence[Channel]) -> Iterator[Block]:
        """Yield the records of channels of a group, block by block; `lost` counts the others."""
        waiting = [(offset, _BLOCK) for offset in range(0, channels[0].records, _BLOCK)][::-1]
        intact = True
        while waiting:
            offset, count = waiting.pop()
            try:
                signals = [self._mdf.get(
                    group=one.group, index=one.place, record_offset=offset, record_count=count,
                    ignore_invalidation_bits=True)
                    for one in channels]
            except Exception as error:
                if intact and count > _LEAST:  # read what is before the damage
                    waiting += [(offset + count // 2, count - count // 2), (offset, count // 2)]
                    continue
                intact = False
                self._lose(channels[0], offset, count, error)
                continue
            intact = True
            if not signals or not len(signals[0].timestamps):
                return
            yield Block(signals[0].timestamps, [_values(signal) for signal in signals])

    @property
    def lost_notes(self) -> list[str]:
        """Return notes on records that could not be read."""
        return [f'group {channel.group} is damaged: {count} of its {channel.records} records '
                f'cannot be read (channel {short_repr(channel.name)}) and are left out'
                for channel, count in self.lost.items()]

    def _lose(self, channel: Channel, offset: int, count: int, error: Exception) -> None:
        """Count records that cannot be read."""
        self.first_damage = self.first_damage or self._damaged(error)
        rest = max(0, channel.records - offset)
        self.lost[channel] = self.lost.get(channel, 0) + min(count, rest)


def _values(signal: Any) -> Sequence[Any]:
    """Return numbers, NaN where they are marked as invalid, and texts where there are any."""
    values = signal.samples
    if values.ndim != 1 or values.dtype.names:
        return [None] * len(values)
    numbers = values.dtype.kind in 'fiub'
    result: list[Any] = (values.astype(float) if numbers else values).tolist()
    if not numbers:
        result = [_number_or_text(value) for value in result]
    if signal.invalidation_bits is not None:
        for place in np.flatnonzero(np.asarray(signal.invalidation_bits)).tolist():
            result[place] = np.nan
    return result


def _number_or_text(value: Any) -> float | str:
    """Return a value of a conversion that gives texts for some numbers."""
    if isinstance(value, bytes):
        value = value.decode('utf-8', 'replace')
    try:
        return float(value)
    except (TypeError, ValueError):
        return str(value).strip('\0 ') or math.nan
