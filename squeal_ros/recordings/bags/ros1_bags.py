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

"""Bags of ROS 1, read by rosbags, with messages as CDR so that all that follows is one."""

from bz2 import BZ2Decompressor
from collections.abc import Iterator
import io
from pathlib import Path
import struct
from typing import BinaryIO

try:
    from rosbags.interfaces import Connection
    from rosbags.rosbag1 import Reader
    from rosbags.rosbag1 import reader as rosbag1
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

from squeal_ros.recordings.bags.bag_bounds import MAX_CHUNK, unpack_lz4

SUFFIX = '.bag'
_LONGEST_HEADER = 10_000_000  # bytes; that of a connection holds a message definition


def unpack_bz2(data: bytes, size: int = MAX_CHUNK) -> bytes:
    """Return data unpacked from bz2, at most one byte more than `size`."""
    return BZ2Decompressor().decompress(data, max_length=size + 1)


def _bounded(name: str, data: bytes) -> bytes:
    raw = (unpack_bz2 if name == 'bz2' else unpack_lz4)(data)
    if len(raw) > MAX_CHUNK:
        raise ValueError(f'a chunk of more than the {MAX_CHUNK} bytes that are read')
    return raw


rosbag1.decompressors.update(bz2=lambda data: _bounded('bz2', data),
                             lz4=lambda data: _bounded('lz4', data))


def read_header(file: BinaryIO) -> rosbag1.Header:
    """Return the header of a record of ROS 1, of a size that one has."""
    size = struct.unpack('<I', file.read(4))[0]
    if size > _LONGEST_HEADER:
        raise ValueError(f'a header of {size} bytes')
    file.seek(-4, io.SEEK_CUR)
    return rosbag1.Header.read(file)


class Ros1Storage(Reader):  # type: ignore[misc]
    """A bag of ROS 1 as rosbags opens it, in the manner of a storage file of rosbag2."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)

    def messages(self, connections: list[Connection]) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, time of recording [ns] and bytes of messages, by that time."""
        yield from super().messages(connections)
