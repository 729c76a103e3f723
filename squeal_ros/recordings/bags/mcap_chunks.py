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


"""Messages of MCAP files, chunk by chunk; one by one rosbags takes five times as long."""

from binascii import crc32
from collections.abc import Iterator, Mapping
from itertools import pairwise
from operator import itemgetter
import struct
from typing import Any, BinaryIO, TypeAlias

try:
    from rosbags.interfaces import Connection
    from rosbags.rosbag2 import Reader
    from rosbags.rosbag2.errors import ReaderError
    from rosbags.rosbag2.storage_mcap import ChunkInfo, DECOMPRESSORS, McapReader
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

StoredMessage: TypeAlias = tuple[Connection, int, bytes]

# MCAP 1.0: opcode and length of a record; of a message, channel, sequence and two times besides
_RECORD, _MESSAGE = struct.Struct('<BQ'), struct.Struct('<BQHIQQ')
_MESSAGE_OPCODE = 5
_CRC_AT, _PACKED_AT = 9 + 24, 9 + 40  # bytes after the start of a chunk; of the latter, and a name

_time = itemgetter(1)


class ChunkReader(McapReader):  # type: ignore[misc]
    """Reads the chunks of an index one after the other, where none overlaps the next."""

    def messages(self, connections: Any, start: int | None = None, stop: int | None = None
                 ) -> Iterator[StoredMessage]:
        """Yield connection, time of recording [ns] and bytes of messages, by that time."""
        bounds = [(chunk.message_start_time, chunk.message_end_time) for chunk in self.chunks]
        apart = all(one[1] <= other[0] for one, other in pairwise(bounds))
        if not bounds or not apart or start is not None or stop is not None:
            yield from super().messages(connections, start, stop)
            return
        channels = {connection.id: connection for connection in connections}
        for chunk in self.chunks:
            if any(chunk.channel_count.get(number) for number in channels):
                yield from _messages(_unpacked(chunk, self.bio), chunk, channels)


class BagStorage(Reader):  # type: ignore[misc]
    """A folder or storage file as rosbags opens it, with `ChunkReader` for MCAP files."""

    STORAGE_PLUGINS = {**Reader.STORAGE_PLUGINS, '.mcap': ChunkReader}


def _unpacked(chunk: ChunkInfo, file: BinaryIO) -> bytes:
    """Return the records of a chunk, with the size and the checksum that it states."""
    file.seek(chunk.chunk_start_offset + _CRC_AT)
    crc = int.from_bytes(file.read(4), 'little')
    file.seek(chunk.chunk_start_offset + _PACKED_AT + len(chunk.compression))
    packed = file.read(chunk.compressed_size)
    if len(packed) != chunk.compressed_size:
        raise ReaderError(f'a chunk of {chunk.compressed_size} bytes is cut off')
    if chunk.compression not in DECOMPRESSORS:
        raise ReaderError(f'a chunk is compressed by {chunk.compression!r}')
    data = bytes(DECOMPRESSORS[chunk.compression](packed, chunk.uncompressed_size))
    if len(data) != chunk.uncompressed_size or crc and crc32(data) != crc:
        raise ReaderError('a chunk has not the size or the checksum that it states')
    return data


def _messages(data: bytes, chunk: ChunkInfo, channels: Mapping[int, Connection]
              ) -> list[StoredMessage]:
    """Return the messages of a chunk, by time; those of one time in the order of the file."""
    result: list[StoredMessage] = []
    first, last = chunk.message_start_time, chunk.message_end_time
    at, end, in_order = 0, len(data), True
    while at < end:
        if at + _RECORD.size > end:
            raise ReaderError('a record is cut off')
        opcode, size = _RECORD.unpack_from(data, at)
        behind = at + _RECORD.size + size
        if opcode == _MESSAGE_OPCODE:
            if behind > end or at + _MESSAGE.size > behind:
                raise ReaderError(f'a message of {size} bytes is cut off')
            _, _, number, _, time, _ = _MESSAGE.unpack_from(data, at)
            if number in channels and first <= time <= last:
                in_order = in_order and (not result or time >= result[-1][1])
                result.append((channels[number], time, data[at + _MESSAGE.size:behind]))
        at = behind
    if at > end:
        raise ReaderError('a record is cut off')
    return result if in_order else sorted(result, key=_time)
