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

"""Contents of an ASAM MDF measurement: its channels."""

import math
from pathlib import Path

from squeal_ros.recordings.signals.contents import Contents, Entry, Statistics
from squeal_ros.recordings.tables.mdf_file import Channel, MdfFile


def mdf_contents(path: Path) -> Contents:
    """
    Return the contents of a measurement; it is read whole, channel by channel.

    Raises
    ------
    MdfError
        For what is no MDF, or is damaged.

    """
    with MdfFile(path) as file:
        names = [channel.name for channel in file.channels]
        start, zone_known = file.start
        entries, ends = [], []
        for channel in file.channels:
            entry, first, last = _entry(file, channel, names.count(channel.name) > 1)
            entries.append(entry)
            ends += [first, last]
        if file.first_damage and not any(entry.count for entry in entries):
            raise file.first_damage
    known = [start + end for end in ends if not math.isnan(end)]
    return Contents(
        path=path, kind='mdf', entries=entries, start_s=min(known, default=math.nan),
        end_s=max(known, default=math.nan),
        notes=[*file.lost_notes, *([] if zone_known else [
            'its start is a local time without a zone'])])


def _entry(file: MdfFile, channel: Channel, ambiguous: bool) -> tuple[Entry, float, float]:
    statistics, missing, texts = Statistics(), 0, 0
    for block in file.blocks([channel]):
        for time, value in zip(block.times.tolist(), block.columns[0], strict=True):
            if not isinstance(value, float):
                texts += 1
            elif math.isnan(value):
                missing += 1
            else:
                statistics.value(value)
                if channel.timed:
                    statistics.time(time)
    kind = 'text' if texts > statistics.count else 'number'
    return Entry(
        name=channel.name, type=kind, unit=channel.unit, missing=missing, texts=texts,
        count=statistics.count if channel.timed else 0, group=channel.group if ambiguous else None,
        **statistics.as_fields()), statistics.first, statistics.last
