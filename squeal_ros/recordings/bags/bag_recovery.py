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
Recovery of storage files that are cut off or damaged: read in order, without their index.

Each reader has the connections and messages of a storage file, as rosbags' readers have, and lists
in `lost` what could not be read.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
import io
from itertools import count
from operator import itemgetter
from pathlib import Path
import shutil
import sqlite3
import struct
from tempfile import TemporaryDirectory
from typing import BinaryIO
from zlib import crc32

try:
    from rosbags.interfaces import Connection, MessageDefinition, MessageDefinitionFormat
    from rosbags.rosbag1.reader import read_uint32, RecordType
    from rosbags.rosbag2.storage_mcap import get_msgdef, Schema
    from rosbags.typesys.msg import normalize_msgtype
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

from squeal_ros.recordings.bags.bag_bounds import MAX_CHUNK, ODD_ENTRIES, unpack_lz4, unpack_zstd
from squeal_ros.recordings.bags.ros1_bags import read_header, unpack_bz2
from squeal_ros.recordings.bags.ros1_bags import SUFFIX as ROS1


def _as_it_is(data: bytes, size: int) -> bytes:
    return data[:size]


_UNPACK: dict[str, Callable[[bytes, int], bytes]] = {
    '': _as_it_is, 'none': _as_it_is, 'zstd': unpack_zstd, 'lz4': unpack_lz4, 'bz2': unpack_bz2}
RECOVERABLE = ('.mcap', '.db3', ROS1)
_MCAP = b'\x89MCAP0\r\n'
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 3, 4, 5, 6, 15
_FEW_ROWS_LOST = 20_000  # after so many in a row that cannot be read, none is looked for
_MOST_TOPICS = 10_000
_STEP, _MOST_STEPS = 100_000, 200  # instructions of sqlite, and so many times them for a row
_time = itemgetter(1)

Stored = tuple[int, int, bytes]
"""Number of a connection, time of recording [ns] and bytes of a message."""


class RecoveredStorage:
    """
    The messages of a file that can be read, of any kind of storage.

    Parameters
    ----------
    path : path
        Ends as its kind does.

    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lost = ''
        self._found: dict[int, Connection] = {}
        self._folder: TemporaryDirectory[str] | None = None  # goes with this object
        counts: Counter[int] = Counter()
        for number, _, _ in self._stored():
            counts[number] += 1
        self.connections = [one._replace(msgcount=counts[number])
                            for number, one in self._found.items()]
        self.whole = sum(counts[number] for number in self._found)

    def messages(self, connections: list[Connection]) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield connection, time of recording [ns] and bytes of messages that are whole."""
        wanted = {one.id: one for one in connections}
        for number, time, data in self._stored():
            if number in wanted:
                yield wanted[number], time, data

    def close(self) -> None:
        """Do nothing: the file is closed between the readings."""

    def _stored(self) -> Iterator[Stored]:
        try:
            yield from self._in_order()
        except Exception as error:  # whatever damage does to a reader; what came before is whole
            self.lost = self.lost or f'it is damaged ({type(error).__name__})'

    def _in_order(self) -> Iterator[Stored]:
        if self.path.suffix == '.db3':
            yield from self._rows()
            return
        with self.path.open('rb') as file:
            yield from self._of_ros1(file) if self.path.suffix == ROS1 else self._of_mcap(file)

    def _add(self, number: int, topic: str, kind: str, definition: MessageDefinition) -> None:
        self._found.setdefault(number, Connection(
            number, topic, kind, definition, '', 0, None, self))

    def _of_mcap(self, file: BinaryIO) -> Iterator[Stored]:
        end = file.seek(0, io.SEEK_END)
        file.seek(0)
        if file.read(len(_MCAP)) != _MCAP:
            self.lost = 'it does not begin as MCAP does'
            return
        schemas: dict[int, Schema] = {}
        while head := file.read(9):
            at = file.tell() - len(head)
            opcode, size = struct.unpack('<BQ', head) if len(head) == 9 else (0, 0)
            cut = len(head) < 9 or file.tell() + size > end
            if opcode == _DATA_END:
                return
            if not 0 < opcode < _DATA_END or cut and opcode != _CHUNK:
                break
            if opcode == _CHUNK and size <= MAX_CHUNK:
                yield from self._chunk(file.read(min(size, end - at)), at, schemas, cut=cut)
            elif opcode in (_SCHEMA, _CHANNEL, _MESSAGE) and size <= MAX_CHUNK:
                yield from self._records(head + file.read(size), schemas)
            else:
                file.seek(size, io.SEEK_CUR)
            if cut:
                break
        self.lost = self.lost or f'it ends or is damaged at byte {file.tell()}'

    def _chunk(self, data: bytes, at: int, schemas: dict[int, Schema], *, cut: bool
               ) -> Iterator[Stored]:
        try:
            size, crc, length = struct.unpack_from('<QII', data, 16)
            name = data[32:32 + length].decode()
            raw = bytes(_UNPACK[name](data[40 + length:], min(size, MAX_CHUNK)))
        except Exception as error:  # each library has errors of its own
            self.lost = f'the chunk at byte {at} cannot be unpacked ({type(error).__name__})'
            return
        if not cut and (len(raw) != size or crc and crc32(raw) != crc):
            self.lost = f'the chunk at byte {at} is damaged'
            return
        yield from sorted(self._records(raw, schemas), key=_time)

    def _records(self, data: bytes, schemas: dict[int, Schema]) -> Iterator[Stored]:
        """Yield the messages among records that are whole, and keep schemas and channels."""
        at = 0
        while at + 9 <= len(data):
            opcode, size = struct.unpack_from('<BQ', data, at)
            body, at = data[at + 9:at + 9 + size], at + 9 + size
            if at > len(data):
                self.lost = self.lost or 'a record is cut off or damaged'
                return
            if opcode == _MESSAGE and size >= 22:
                number, _, time, _ = struct.unpack_from('<HIQQ', body)
                yield number, time, body[22:]
            elif opcode in (_SCHEMA, _CHANNEL):
                with suppress(struct.error, KeyError):  # a damaged one defines nothing
                    self._define(opcode, body, schemas)

    def _define(self, opcode: int, body: bytes, schemas: dict[int, Schema]) -> None:
        """Take a schema or a channel."""
        number, schema = struct.unpack_from('<HH', body)
        if opcode == _SCHEMA:
            name, encoding, text = _texts(body[2:], 3)
            schemas[number] = Schema(number, name, encoding, text)
        elif schema in schemas:
            self._add(number, _texts(body[4:], 1)[0], schemas[schema].name,
                      get_msgdef(schemas[schema]))

    def _of_ros1(self, file: BinaryIO) -> Iterator[Stored]:
        end = file.seek(0, io.SEEK_END)
        file.seek(0)
        if not file.readline(100).startswith(b'#ROSBAG V2.0'):
            self.lost = 'it does not begin as a bag of ROS 1 does'
            return
        while (at := file.tell()) < end:
            try:
                header = read_header(file)
                size = read_uint32(file)
                data = file.read(min(size, end - at, MAX_CHUNK))
                if header.get_uint8('op') == RecordType.CHUNK:
                    raw = _UNPACK[header.get_string('compression')](data, MAX_CHUNK)
                    yield from sorted(self._records_of_ros1(bytes(raw)), key=_time)
            except Exception as error:  # whatever bytes do to rosbags' reader
                self.lost = f'it ends or is damaged at byte {at} ({type(error).__name__})'
                return
            if len(data) < size:
                self.lost = f'it ends in the record at byte {at}'

    def _records_of_ros1(self, data: bytes) -> Iterator[Stored]:
        file = io.BytesIO(data)
        while file.tell() < len(data):
            try:
                header = read_header(file)
                body = file.read(size := read_uint32(file))
            except Exception:  # the chunk is cut off here
                return
            if len(body) < size:
                return
            kind = header.get_uint8('op')
            if kind == RecordType.MSGDATA:
                yield header.get_uint32('conn'), header.get_time('time'), body
            elif kind == RecordType.CONNECTION:
                about = read_header(io.BytesIO(struct.pack('<I', size) + body))
                self._add(header.get_uint32('conn'), header.get_string('topic'),
                          normalize_msgtype(about.get_string('type')), MessageDefinition(
                              MessageDefinitionFormat.MSG, about.get_string('message_definition')))

    def _whole_pages(self) -> Path:
        """Return a database of whole pages: sqlite fills the rest of one with zeros."""
        with self.path.open('rb') as file:
            size = int.from_bytes(file.read(18)[16:], 'big') or 1
            page = 65536 if size == 1 else size
            rest = self.path.stat().st_size % page
            if not rest:
                return self.path
            self._folder = self._folder or TemporaryDirectory()
            copy = Path(self._folder.name, self.path.name)
            if not copy.exists():
                file.seek(0)
                with copy.open('wb') as target:
                    shutil.copyfileobj(file, target)
                    target.truncate(self.path.stat().st_size - rest)
        return copy

    def _rows(self) -> Iterator[Stored]:
        uri = f'{self._whole_pages().absolute().as_uri()}?mode=ro&immutable=1'
        database = sqlite3.connect(uri, uri=True)
        database.text_factory = lambda text: text.decode('utf-8', 'replace')
        steps = count()
        # pages that lead in a circle would be followed without end
        database.set_progress_handler(lambda: next(steps) > _MOST_STEPS, _STEP)
        try:
            # without it a database that is shorter than it states is refused
            database.execute('PRAGMA writable_schema=ON')
            if database.execute(ODD_ENTRIES).fetchone():
                self.lost = 'the database holds more than tables'
                return
            definitions = self._definitions(database)
            for number, name, kind in database.execute(
                    f'SELECT id, name, type FROM topics LIMIT {_MOST_TOPICS}').fetchall():
                self._add(number, str(name), str(kind), get_msgdef(Schema(
                    0, kind, *definitions.get(kind, ('', '')))))
            row, missed = 1, 0
            while missed < _FEW_ROWS_LOST:
                steps = count()
                try:
                    result = database.execute('SELECT topic_id, timestamp, data FROM messages '
                                              'WHERE id = ?', (row,)).fetchone()
                except sqlite3.DatabaseError:
                    result, self.lost = None, 'pages of the database are missing or damaged'
                row, missed = row + 1, 0 if result else missed + 1
                if result and isinstance(result[2], bytes):
                    yield result
        except sqlite3.DatabaseError as error:
            self.lost = f'the database cannot be read ({error})'
        finally:
            database.close()

    @staticmethod
    def _definitions(database: sqlite3.Connection) -> dict[str, tuple[str, str]]:
        """Return encoding and text of the definition of each type."""
        try:
            rows = database.execute(
                'SELECT topic_type, encoding, encoded_message_definition FROM '
                f'message_definitions LIMIT {_MOST_TOPICS}').fetchall()
        except sqlite3.DatabaseError:  # of an older version, or damaged
            return {}
        return {kind: (encoding, text) for kind, encoding, text in rows
                if encoding in ('ros2msg', 'ros2idl') and isinstance(text, str)}


def _texts(data: bytes, count: int) -> list[str]:
    """Return texts that each stand behind their length."""
    result, at = [], 0
    for _ in range(count):
        size = struct.unpack_from('<I', data, at)[0]
        result.append(data[at + 4:at + 4 + size].decode('utf-8', 'replace'))
        at += 4 + size
    return result
