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

"""ROS 2 bags written whole, and the message classes of rosbags."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from io import BytesIO
from itertools import chain
from pathlib import Path
import struct
from types import TracebackType
from typing import Any, TypeAlias

try:
    from rosbags.interfaces import (
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.rosbag2.storage_mcap import McapWriter, PendingChunk
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error
from squeal_core.common.output import OutputFiles
from squeal_ros.recordings.bags.bag_reader import decode
from squeal_ros.recordings.bags.typestore import BagMessages, JAZZY

__all__ = ['BagMessages', 'BagWriter', 'Messages']

Messages: TypeAlias = tuple[tuple[str, ...], str, bytes]
"""Topics of one type, and the CDR bytes of a message for each, which are of one length."""

# MCAP 1.0: opcode and length of a record; of a message, channel, sequence and two times besides
_RECORD, _MESSAGE = struct.Struct('<BQ'), struct.Struct('<BQHIQQ')
_MESSAGE_OPCODE, _CHUNK_OPCODE, _INDEX_OPCODE = 5, 6, 7
_MESSAGE_FIELDS = 22  # bytes
_CHUNK = 2**20  # bytes
_INFINITE = QosTime(9_223_372_036, 854_775_807)


class _Storage(McapWriter):  # type: ignore[misc]
    """Takes messages of one time at once; one by one rosbags needs 10 us for each."""

    chunk: PendingChunk

    def close_chunk(self) -> None:
        """Write the pending chunk; rosbags packs its index by two calls a number."""
        chunk = self.chunk
        times = chunk.message_start_time, chunk.message_end_time
        data = self.compressor(chunk.bio.getvalue())
        name = self.compression.encode()
        stored = struct.pack(f'<I{len(name)}sQ', len(name), name, len(data))
        start = self.bio.tell()
        self._write_record(_CHUNK_OPCODE, struct.pack('<QQQI', *times, chunk.bio.tell(), 0),
                           stored, data)
        end = self.bio.tell()
        offsets = b''
        for number, messages in chunk.msgs.items():
            offsets += struct.pack('<HQ', number, self.bio.tell())
            self._write_record(_INDEX_OPCODE, struct.pack(
                f'<HI{2 * len(messages)}Q', number, 16 * len(messages), *chain(*messages)))
        summary = BytesIO()
        summary.write(b''.join((
            struct.pack('<QQQQI', *times, start, end - start, len(offsets)), offsets,
            struct.pack('<Q', self.bio.tell() - end), stored,
            struct.pack('<Q', chunk.bio.tell()))))
        self.chunks.append(summary)
        self.chunk = PendingChunk(2**63 - 1, 0, BytesIO(), defaultdict(list))

    def _write_record(self, opcode: int, *parts: bytes) -> None:
        self.bio.write(_RECORD.pack(opcode, sum(map(len, parts))))
        self.bio.writelines(parts)

    def write_together(self, time: int, messages: Iterable[tuple[Sequence[int], bytes]]) -> None:
        """Write messages, as many equal parts of bytes as the numbers of connections before."""
        chunk, pack, counts = self.chunk, _MESSAGE.pack, self.channel_stats
        places = chunk.msgs
        parts: list[bytes] = []
        position = chunk.bio.tell()
        for numbers, data in messages:
            size, start = len(data) // len(numbers), 0
            fields = _MESSAGE_FIELDS + size
            for number in numbers:
                parts += (pack(_MESSAGE_OPCODE, fields, number, 0, time, time),
                          data[start:start + size])
                places[number].append((time, position))
                counts[number] += 1
                start += size
                position += _RECORD.size + fields
        chunk.bio.write(b''.join(parts))
        for span in (self, chunk):
            span.message_start_time = min(time, span.message_start_time)
            span.message_end_time = max(time, span.message_end_time)
        if position > _CHUNK:
            self.close_chunk()


class _Writer(Writer):  # type: ignore[misc]
    STORAGE_PLUGINS = {StoragePlugin.MCAP: _Storage}

    def close(self) -> None:
        """Close, with the counts of the storage."""
        self.counts.update(self.storage.channel_stats)
        self.min_timestamp = self.storage.message_start_time
        self.max_timestamp = self.storage.message_end_time
        super().close()


def _qos(latched: int) -> Qos:
    """Return the quality of service of a publisher of rclpy, as rosbag2 records it."""
    return Qos(QosHistory.KEEP_LAST, latched or 10, QosReliability.RELIABLE,
               QosDurability.TRANSIENT_LOCAL if latched else QosDurability.VOLATILE,
               _INFINITE, _INFINITE, QosLiveliness.AUTOMATIC, _INFINITE, False)


class BagWriter:
    """
    Writes a bag: `NAME.mcap` as one file, any other name as a folder. A context manager.

    Nothing stands under the name until the bag is whole.

    Parameters
    ----------
    path : path
    files : OutputFiles, optional
        Commits the bag together with other outputs, when its context ends; without one the bag
        is committed when its own context ends, and an existing one is not overwritten.
    latched : mapping, optional
        By the last part of a topic's name: how many messages its publisher kept for late
        subscribers. The others kept none; all were reliable, with a queue of ten.

    """

    def __init__(self, path: str | Path, files: OutputFiles | None = None, *,
                 latched: Mapping[str, int] | None = None) -> None:
        self.path = Path(path)
        self._files = files or OutputFiles()
        self._alone, self._latched = files is None, latched or {}
        self._numbers: dict[str, int] = {}  # of each topic, from 1
        self._connections: dict[tuple[str, ...], tuple[int, ...]] = {}

    def __enter__(self) -> 'BagWriter':
        with ExitStack() as stack:
            if self._alone:
                stack.enter_context(self._files)
            self._output = self._files.add(self.path, folder=self.path.suffix != '.mcap')
            target = self._output.target
            scratch = OutputFiles()  # rosbags makes the folder that it writes to itself
            stack.callback(scratch.discard)
            folder = scratch.add(target.with_name(f'{target.name}.bag'), folder=True).partial
            self._folder = folder / target.stem
            self._writer = _Writer(self._folder, version=9, storage_plugin=StoragePlugin.MCAP)
            self._writer.open()
            stack.push(self._finish)
            self._stack = stack.pop_all()
        return self

    def write(self, topic: str, type_name: str, time: int, message: Any) -> None:
        """Write a message of rosbags' classes, or its CDR bytes."""
        if isinstance(message, bytes):
            data = message[:decode(JAZZY, message, type_name)[1]]
        else:
            data = bytes(JAZZY.serialize_cdr(message, type_name))
        self.write_serialised(time, [((topic,), type_name, data)])

    def write_serialised(self, time: int, entries: Iterable[Messages]) -> None:
        """Write messages of one time [ns]."""
        self._writer.storage.write_together(time, [
            (self._connections.get(topics) or self._connect(topics, type_name), data)
            for topics, type_name, data in entries])

    def _connect(self, topics: tuple[str, ...], type_name: str) -> tuple[int, ...]:
        """Return the numbers of topics, which are told to the bag where they are new."""
        for topic in topics:
            if topic not in self._numbers:
                self._numbers[topic] = self._writer.add_connection(
                    topic, type_name, typestore=JAZZY, offered_qos_profiles=[
                        _qos(self._latched.get(topic.rpartition('/')[2], 0))]).id
        self._connections[topics] = tuple(self._numbers[topic] for topic in topics)
        return self._connections[topics]

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        self._stack.__exit__(kind, error, trace)

    def _finish(self, kind: type[BaseException] | None, *_: object) -> None:
        """Move the written bag to the place it is committed from, if it is whole."""
        if kind is not None:
            with suppress(Exception):  # the first error counts
                self._writer.close()
            return
        self._writer.close()
        if self._output.partial.is_dir():
            for file in self._folder.iterdir():
                file.rename(self._output.partial / file.name)
        else:
            next(self._folder.glob('*.mcap')).replace(self._output.partial)
