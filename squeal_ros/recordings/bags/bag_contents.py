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

"""Contents of a recorded bag: topics, and the numbers in their messages."""

from collections.abc import Iterator, Sequence
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_ros.recordings.bags.bag_reader import Bag
from squeal_ros.recordings.bags.message_definitions import MessageDefinitions
from squeal_ros.recordings.signals.column_units import unit_of_field
from squeal_ros.recordings.signals.contents import Contents, Entry, Statistics

_MOST_ITEMS = 16  # of a list that are looked at
_MOST_FIELDS = 200  # of a topic
_ALL_DECODED, _OF_THE_REST = 2000, 20  # messages of a topic; of further ones each so many
_LARGE = 100_000  # bytes of a message; of a topic of larger ones only the first is decoded
_RAW_FRAMES = ('can_msgs/msg/Frame', 'ros2_socketcan_msgs/msg/FdFrame')
_WITHOUT_SIGNALS = ('sensor_msgs/msg/Image', 'sensor_msgs/msg/CompressedImage',
                    'sensor_msgs/msg/PointCloud2', 'sensor_msgs/msg/LaserScan',
                    'nav_msgs/msg/OccupancyGrid', 'tf2_msgs/msg/TFMessage',
                    'diagnostic_msgs/msg/DiagnosticArray')


def bag_contents(path: Path, types: str | Path | None = None) -> Contents:
    """
    Return the contents of a bag.

    Parameters
    ----------
    path : path
        Of the bag.
    types : path, optional
        Folder of definitions, as of `open_recording`.

    Raises
    ------
    SquealError
        For what is no bag, or is damaged.

    """
    bag = Bag(path, MessageDefinitions(types))
    kinds = {topic: max(counts, key=lambda name: counts[name])
             for topic, counts in bag.types.items()}
    undefined = bag.undefined_topics()
    wanted = {topic: kind for topic, kind in kinds.items()
              if topic not in undefined and kind not in _WITHOUT_SIGNALS}
    topics = {topic: _Topic(topic, kind) for topic, kind in wanted.items()}
    start = end = math.nan
    for record in bag.records(wanted):
        end = record.time * 1e-9
        start = end if math.isnan(start) else start
        topic = topics[record.topic]
        if topic.is_due(len(record.data)) and (decoded := bag.decode(record)) is not None:
            topic.take(decoded[0])
        topic.statistics.time(end)
        topic.messages += 1
    entries = [entry for topic in topics.values() for entry in topic.entries()]
    entries += [Entry(name=topic, type=kind, count=bag.types[topic].total())
                for topic, kind in kinds.items() if topic not in topics]
    return Contents(path=path, kind=bag.kind, entries=sorted(entries, key=lambda e: e.name),
                    start_s=start, end_s=end, notes=[*bag.notes, *undefined.values(), *(
                        f'{topic}: raw CAN frames; decode them by the DBC file of the bus into '
                        'one topic a signal first' for topic, kind in kinds.items()
                        if kind in _RAW_FRAMES)])


class _Topic:
    """One topic, and the figures of each number in its messages."""

    def __init__(self, name: str, kind: str) -> None:
        self._name, self._kind = name, kind
        self.statistics = Statistics()
        self.messages = 0
        self._fields: dict[str, Statistics] = {}

    def is_due(self, size: int) -> bool:
        """Return whether the next message is to be decoded."""
        if size > _LARGE:
            return not self.messages
        return self.messages < _ALL_DECODED or not self.messages % _OF_THE_REST

    def take(self, message: Any) -> None:
        for path, value in _numbers(message, ''):
            if path not in self._fields and len(self._fields) >= _MOST_FIELDS:
                continue
            field = self._fields.setdefault(path, Statistics())
            if not math.isnan(value):
                field.value(value)

    def entries(self) -> Iterator[Entry]:
        about = self.statistics.as_fields()
        if not self._fields:
            yield Entry(name=self._name, type=self._kind, count=self.messages)
        for path, field in self._fields.items():
            limits = field.as_fields()
            yield Entry(name=self._name, field=path, type=self._kind,
                        unit=unit_of_field(self._kind, path),
                        count=self.messages if field.count else 0, **{
                            **about, 'minimum': limits['minimum'], 'maximum': limits['maximum']})


def _numbers(message: Any, before: str) -> Iterator[tuple[str, float]]:
    """Yield the path and the value of each number in a message."""
    names = getattr(message, 'name', None)
    for field in getattr(message, '__dataclass_fields__', {}):
        if field.startswith('__') or 'covariance' in field or field in ('header', 'stamp') or (
                hasattr(type(message), field)):  # a constant
            continue
        value, path = getattr(message, field), f'{before}{field}'
        if isinstance(value, np.ndarray):
            if value.dtype != np.uint8 and value.dtype.kind in 'fiub':
                yield from _listed(path, value, names if field != 'name' else None)
        elif isinstance(value, list):
            for number, item in enumerate(value[:_MOST_ITEMS]):
                yield from _numbers(item, f'{path}[{number}].')
        elif isinstance(value, bool | int | float):
            yield path, float(value)
        elif hasattr(value, '__dataclass_fields__'):
            yield from _numbers(value, f'{path}.')


def _listed(path: str, values: Any, names: Any) -> Iterator[tuple[str, float]]:
    """Yield the numbers of a list, by the names in the list beside it where there is one."""
    if isinstance(names, Sequence) and len(names) == len(values) and not isinstance(
            names, str) and len(set(names)) == len(names) and all(
            isinstance(name, str) and name and ']' not in name for name in names):
        yield from ((f'{path}[name={name}]', float(value))
                    for name, value in zip(names, values, strict=True))
    else:
        yield from ((f'{path}[{number}]', float(value))
                    for number, value in enumerate(values[:_MOST_ITEMS]))
