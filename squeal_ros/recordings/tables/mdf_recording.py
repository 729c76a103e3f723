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

"""An ASAM MDF measurement as a recording: channels are the inputs, each at its group's times."""

from collections.abc import Iterator
from datetime import datetime
import heapq
from itertools import chain
import math
from operator import itemgetter
from pathlib import Path

from squeal_core.common.errors import did_you_mean, short_repr
from squeal_core.common.wording import listed
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.findings import Finding
from squeal_ros.recordings.positions import Positions
from squeal_ros.recordings.recording import Samples
from squeal_ros.recordings.signals.column_units import contradiction
from squeal_ros.recordings.signals.signals_file import CoordinateSource, Signals, SignalSource
from squeal_ros.recordings.tables.csv_cells import start_time, zone_of
from squeal_ros.recordings.tables.input_column import InputColumn, without_values
from squeal_ros.recordings.tables.mdf_file import Channel, MdfError, MdfFile
from squeal_ros.recordings.tables.row_times import RowTimes

_MOST_NAMES = 30  # of channels, in an error


class MdfRecording:
    """
    A measurement read through a file of signals, block by block; memory does not grow with it.

    Parameters
    ----------
    path : path
    settings : MonitorSettings
        With the inputs of the signals.
    signals : Signals

    Raises
    ------
    SquealError
        For what is no MDF, or has not the channels.

    """

    kind = 'mdf'

    def __init__(self, path: Path, settings: MonitorSettings, signals: Signals) -> None:
        self.path, self._signals = path, signals
        self.positions = Positions()
        self._file: MdfFile | None = None  # that is read
        with MdfFile(path) as file:
            self._channels = [_chosen(source, file) for source in signals.sources]
            self._position = [_chosen(source, file) for source in signals.position]
            start, zone_known = file.start
            first = min(filter(math.isfinite, map(file.first_time, self._all)), default=0.0)
        if len({one.group for one in self._position}) > 1:
            raise MdfError(signals.position[0].where, 'is of another group than the longitude',
                           'give channels of one group, which have the same times')
        self._columns = [InputColumn.of(source, settings) for source in signals.sources]
        self._times = {channel.group: RowTimes() for channel in self._all}
        self._about = [*chain.from_iterable(
            contradiction(source, channel.name, channel.unit) for source, channel in zip(
                signals.sources, self._channels, strict=True))]
        if signals.clock.columns or signals.clock.unit:
            self._about.append(f"the clock's column and unit in {signals.path} are of tables of "
                               'text; channels have times of their own')
        self._start = self._begin(start, zone_known)
        earliest = self._start * 1e-9 + first
        if earliest < 0.0:  # ROS has no time before zero
            self._start += math.ceil(-earliest) * 1_000_000_000
            self._about.append(f'times begin at {earliest:.6g} s, before zero, which ROS has no '
                               f'time for: {math.ceil(-earliest)} s are added to all of them')

    def _begin(self, start: float, zone_known: bool) -> int:
        """Return the time at which that of the channels is zero [ns]."""
        clock, where = self._signals.clock, f'{self._signals.path}, clock'
        zone = zone_of(clock.timezone, where)
        begin = start_time(clock, zone)
        if clock.start is None:
            if not zone_known and not clock.timezone:
                self._about.append('its start is a local time without a zone, taken as UTC; '
                                   'clock.timezone says another')
            elif not zone_known:
                shown = datetime.fromtimestamp(start, zone)
                ahead = shown.replace(tzinfo=None) - datetime.fromtimestamp(
                    start, zone_of('', where)).replace(tzinfo=None)
                start -= ahead.total_seconds()
            begin = round(start * 1e6) * 1000
        return begin + round(clock.offset * 1e9)

    @property
    def messages(self) -> int:
        """Return the number of records of all groups."""
        return sum({channel.group: channel.records for channel in self._all}.values())

    @property
    def _all(self) -> list[Channel]:
        return [*self._channels, *self._position]

    @property
    def notes(self) -> list[str]:
        """Return notes on the measurement, as far as it was read."""
        of_times = (f'group {group}: {note.replace("line", "record")}' for group, times in
                    self._times.items() for note in times.notes())
        return [*self._about, *(self._file.lost_notes if self._file else ()), *of_times,
                *self.positions.missing([one.name for one in self._signals.position]),
                *chain.from_iterable(column.notes() for column in self._columns)]

    @property
    def findings(self) -> list[Finding]:
        """Return findings on inputs without values."""
        return without_values(self._columns, 'check the channel and its conversion')

    def samples(self) -> Iterator[tuple[int, Samples]]:
        """
        Yield the time [ns] and the samples of each record, those of all groups in order.

        Raises
        ------
        MdfError
            For a damaged one, or one without a record.

        """
        groups = sorted({channel.group for channel in self._all})
        taken = False
        with MdfFile(self.path) as file:
            self._file = file
            for entry in heapq.merge(*(self._of_group(file, group) for group in groups),
                                     key=itemgetter(0)):
                taken = True
                yield entry
        if not taken:
            raise file.first_damage or MdfError(self.path, 'has no record of the channels',
                                                'check that it was recorded')

    def _of_group(self, file: MdfFile, group: int) -> Iterator[tuple[int, Samples]]:
        own = [(column, channel) for column, channel in zip(
            self._columns, self._channels, strict=True) if channel.group == group]
        fix = [channel for channel in self._position if channel.group == group]
        scales = [one.scale for one in self._signals.position]
        times, record = self._times[group], 0
        for block in file.blocks([*(channel for _, channel in own), *fix]):
            inputs, places = block.columns[:len(own)], block.columns[len(own):]
            for place, seconds in enumerate(block.times.tolist()):
                record += 1
                stated = round(seconds * 1e9) + self._start if math.isfinite(seconds) else None
                time = times.take(record, stated)
                if time is None:
                    continue
                result = []
                for (column, _), values in zip(own, inputs, strict=True):
                    value = values[place]
                    number = value if isinstance(value, float) else None
                    one = column.sample(number, time.stated, str(value), f'in record {record}')
                    if one is not None:
                        result.append(one)
                if fix:
                    north, east = (column[place] for column in places)
                    if isinstance(north, float) and isinstance(east, float):
                        self.positions.take(time.recorded, scales[0] * north, scales[1] * east)
                yield time.recorded, result


def _chosen(source: SignalSource | CoordinateSource, file: MdfFile) -> Channel:
    """Return the channel that a file of signals names."""
    named = [channel for channel in file.channels if channel.name == source.name]
    if not named:
        names = list(dict.fromkeys(channel.name for channel in file.channels))
        raise MdfError(source.where, f'{file.path} has no channel {short_repr(source.name)}'
                       f'{did_you_mean(source.name, names)}',
                       f'its channels are {listed(map(short_repr, names), _MOST_NAMES)}')
    groups = ', '.join(str(channel.group) for channel in named)
    chosen = [channel for channel in named if source.group in (None, channel.group)]
    if len(chosen) != 1:
        raise MdfError(source.where, f'{short_repr(source.name)} is in the groups {groups} of '
                       f'{file.path}', 'give one: group: NUMBER')
    if not chosen[0].timed:
        raise MdfError(source.where, f'{short_repr(source.name)} has no times in {file.path}',
                       'give a channel of a group with times')
    return chosen[0]
