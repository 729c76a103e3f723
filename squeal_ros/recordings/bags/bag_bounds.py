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

"""
Bounds on what a recorded bag may cost a reader: unpacking, storage and decoding.

The reader of the bags is rosbags; it believes sizes that a file states. What is stated is compared
here with what is there before memory is taken.
"""

from collections.abc import Mapping
from pathlib import Path
import sqlite3
from typing import Any

try:
    from lz4.frame import LZ4FrameDecompressor
    from rosbags.interfaces import Nodetype
    from rosbags.rosbag2 import storage_mcap
    from rosbags.rosbag2.storage_mcap import zstd
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

from squeal_core.common.bounded_reader import check_readable, ErrorOf
from squeal_core.common.errors import in_one_line, SquealError

MAX_FILE = 1_000_000_000_000  # bytes: it is read chunk by chunk
MAX_CHUNK = 200_000_000  # bytes of a chunk or message when unpacked; recorders write a few MB
MAX_RATIO = 1000  # of a packed file to what it unpacks to
MAX_FIELDS = 20_000  # values of a message of fixed size; its decoder has as many lines
MAX_DEPTH = 20  # of types in types
_BLOCK = 1 << 20  # bytes

_SIZES = {'bool': 1, 'byte': 1, 'char': 1, 'int8': 1, 'uint8': 1, 'int16': 2, 'uint16': 2,
          'int32': 4, 'uint32': 4, 'float32': 4, 'int64': 8, 'uint64': 8, 'float64': 8}
ODD_ENTRIES = (  # of a database: views would be computed when they are asked for messages
    "SELECT type, name FROM sqlite_master WHERE type NOT IN ('table', 'index') "
    "OR sql LIKE '%VIRTUAL%' LIMIT 1")
ZSTD_MAGIC = b'\x28\xb5\x2f\xfd'  # plain CDR begins with a zero
_STRING = 5  # bytes at least: a length and a zero


def check_storage(path: Path, error_of: ErrorOf) -> None:
    """Refuse a storage file that is no regular file, or a database with more than tables."""
    check_readable(path, MAX_FILE, error_of)
    if path.suffix != '.db3':
        return
    try:
        database = sqlite3.connect(f'{path.absolute().as_uri()}?mode=ro&immutable=1', uri=True)
        database.text_factory = lambda text: text.decode('utf-8', 'replace')
        try:
            odd = database.execute(ODD_ENTRIES).fetchone()
        finally:
            database.close()
    except sqlite3.Error:
        return  # the reader says what is wrong with it
    if odd:  # one that is asked for messages could be computed, without end
        raise error_of(path, f'holds a {odd[0]} {str(odd[1])[:40]!r}, which no bag has',
                       'give a bag as it was recorded')


def bound_decompression() -> None:
    """Make rosbags unpack no chunk beyond the size that it states, and none without bounds."""
    storage_mcap.DECOMPRESSORS.update(zstd=unpack_zstd, lz4=unpack_lz4)


def unpack_zstd(data: bytes, size: int = MAX_CHUNK) -> bytes:
    """Return data unpacked from zstd, at most one byte more than `size`."""
    _check_size(size)
    return bytes(zstd.ZstdDecompressor().decompress(data, max_length=size + 1))


def unpack_lz4(data: bytes, size: int = MAX_CHUNK) -> bytes:
    """Return data unpacked from lz4, at most one byte more than `size`."""
    _check_size(size)
    return bytes(LZ4FrameDecompressor().decompress(data, max_length=size + 1))


def unpack_message(data: bytes) -> bytes:
    """Return a message as it was sent, of one that may have been packed alone."""
    if bytes(data[:4]) != ZSTD_MAGIC:
        return bytes(data)
    message = unpack_zstd(data)
    if len(message) > MAX_CHUNK:
        raise ValueError(f'a message of more than {MAX_CHUNK} bytes')
    return message


def unpack_file(path: Path, target: Path, error_of: ErrorOf) -> str:
    """
    Unpack a storage file, at most to `MAX_RATIO` times its size.

    Returns
    -------
    str
        What is to be said of one that is cut off or damaged, where the part before is there.

    """
    most = MAX_RATIO * check_readable(path, MAX_FILE, error_of) + MAX_CHUNK
    done, unpacker, data = 0, zstd.ZstdDecompressor(), b''
    try:
        with path.open('rb') as packed, target.open('wb') as file:
            while data or not unpacker.needs_input or (data := packed.read(_BLOCK)):
                block = unpacker.decompress(data, max_length=_BLOCK)
                file.write(block)
                done, data = done + len(block), b''
                if done > most:
                    raise error_of(path, f'unpacks to more than {most} bytes', 'unpack it first')
                if unpacker.eof:  # frames stand one behind the other
                    data = unpacker.unused_data or packed.read(_BLOCK)
                    if not data:
                        return ''
                    unpacker = zstd.ZstdDecompressor()
        why = 'its end is missing'
    except (OSError, EOFError, ValueError, zstd.ZstdError) as error:
        if isinstance(error, SquealError):
            raise
        why = in_one_line(error, 120)
    if not done:
        raise error_of(path, f'cannot be unpacked ({why})', 'copy it again')
    return f'{path}: is cut off or damaged ({why}); the {done} bytes before are unpacked'


def _check_size(size: int) -> None:
    if not 0 <= size <= MAX_CHUNK:
        raise ValueError(f'a chunk of {size} bytes, more than the {MAX_CHUNK} that are read')


def least_size(name: str, types: Mapping[str, Any]) -> int:
    """
    Return the least number of bytes of a message of a type.

    Raises
    ------
    ValueError
        For types that contain themselves, and arrays of fixed length with more values than a
        message has.

    """
    return _measure(name, types, {}, ())[0]


def _measure(name: str, types: Mapping[str, Any], known: dict[str, tuple[int, int]],
             outer: tuple[str, ...]) -> tuple[int, int]:
    """Return bytes and values of a type, where sequences are empty and texts too."""
    if name in known:
        return known[name]
    if name in outer or len(outer) > MAX_DEPTH:
        raise ValueError(f'type {name} contains itself, or types more than {MAX_DEPTH} deep')
    size = values = 0
    for field, (kind, detail) in types[name][1]:
        inner, count = detail, 1
        if kind == Nodetype.ARRAY:
            (kind, inner), count = detail
        elif kind == Nodetype.SEQUENCE:
            if detail[0][0] == Nodetype.NAME:
                _measure(detail[0][1], types, known, (*outer, name))
            kind, inner, count = Nodetype.BASE, ('uint32', 0), 1
        if kind == Nodetype.NAME:
            own = _measure(inner, types, known, (*outer, name))
        elif inner[0] in ('string', 'wstring'):
            own = _STRING, 1
        else:  # an array of numbers is read at once
            own = _SIZES.get(inner[0], 8), 1 if count == 1 else 0
        size, values = size + count * own[0], values + max(count * own[1], 1)
        if values > MAX_FIELDS or size > MAX_CHUNK:
            raise ValueError(f'{name}.{field} is an array of {count} entries: {values} values and '
                             f'{size} bytes in a message')
    known[name] = max(size, 1), max(values, 1)
    return known[name]
