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

"""Recorded bags, MCAP and sqlite3, read lazily; with notes on missing parts."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

try:
    from rosbags.interfaces import Connection
    from rosbags.typesys.store import Typestore
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error

from squeal_core.common.errors import in_one_line
from squeal_ros.recordings.bags.bag_bounds import bound_decompression, check_storage
from squeal_ros.recordings.bags.bag_files import BagError, BagFiles, GIVE_BAG
from squeal_ros.recordings.bags.bag_recovery import RECOVERABLE, RecoveredStorage
from squeal_ros.recordings.bags.mcap_chunks import BagStorage
from squeal_ros.recordings.bags.message_definitions import DefinitionError, MessageDefinitions
from squeal_ros.recordings.bags.ros1_bags import Ros1Storage
from squeal_ros.recordings.bags.ros1_bags import SUFFIX as ROS1
from squeal_ros.recordings.findings import full_type_name, same_type_name

bound_decompression()

Storage = BagStorage | Ros1Storage | RecoveredStorage


class Record(NamedTuple):
    """A message as it was recorded."""

    topic: str
    time: int  # of recording [ns]
    data: bytes
    publisher: int
    type_name: str
    store: Typestore


class Bag:
    """
    A recorded bag: its topics, and their messages in order of recording.

    The storage files are read themselves: where metadata.yaml does not fit them, the messages are
    there all the same, and the difference is noted.

    Parameters
    ----------
    path : path
        A rosbag2 folder, or an .mcap, .db3 or .bag file.
    definitions : MessageDefinitions, optional
        For messages whose definition the bag does not hold.

    Attributes
    ----------
    types : dict
        Message types of each topic, with their counts.
    notes : list of str
        What a user should know of the bag.
    undecodable : dict
        Of each topic with messages that are none of their type, or are damaged: how many, and
        why the first is not.

    """

    def __init__(self, path: str | Path, definitions: MessageDefinitions | None = None) -> None:
        self.path = Path(path)
        self.types: dict[str, Counter[str]] = defaultdict(Counter)
        self.undecodable: dict[str, tuple[int, str]] = {}
        self._definitions = definitions or MessageDefinitions()
        self._stores: dict[tuple[str, str], Typestore] = {}
        self._files = BagFiles(self.path)
        self.notes = self._files.notes
        self.kind = 'rosbag1' if self.path.suffix == ROS1 else 'rosbag2'
        self._recovered: dict[Path, RecoveredStorage] = {}
        self._connections: list[Connection] = []
        self._counts: Counter[str] = Counter()  # by the storage files
        for file in self._files.files:
            with self._opened(file) as reader:
                self._connections += reader.connections
                for connection in reader.connections:
                    self.types[connection.topic][connection.msgtype] += connection.msgcount
                    self._counts[connection.topic] += connection.msgcount
        self.types = dict(self.types)

    def undefined_topics(self) -> dict[str, str]:
        """Return the topics whose messages nothing defines, each with the reason."""
        result: dict[str, str] = {}
        for connection in self._connections:
            try:
                self._kind(connection)
            except DefinitionError as error:
                result[connection.topic] = f'{connection.topic}: {error.what}; {error.remedy}'
        return result

    def messages(self, wanted: Mapping[str, str]) -> Iterator[tuple[str, int, Any, int]]:
        """
        Yield (topic, time of recording [ns], message, publisher) in order of recording.

        Publishers of a topic are told apart where each has a connection of its own; the number is
        0 elsewhere, as in what `ros2 bag record` writes.

        Parameters
        ----------
        wanted : mapping
            Type of each topic; messages of another type on it are passed over.

        Raises
        ------
        BagError
            For what is damaged, or has no message that is wanted.
        DefinitionError
            For a type that no definition is found for.

        """
        for record in self.records(wanted):
            message = self.decode(record)
            if message is not None:
                yield record.topic, record.time, message[0], record.publisher

    def records(self, wanted: Mapping[str, str]) -> Iterator['Record']:
        """
        Yield the messages in order of recording, not decoded; parameters as of `messages`.

        Raises
        ------
        BagError, DefinitionError
            As `messages`.

        """
        count: Counter[str] = Counter()
        for file in self._files.files:
            with self._opened(file) as reader:
                chosen = [c for c in reader.connections
                          if same_type_name(wanted.get(c.topic, ''), c.msgtype)]
                kinds = {c.id: self._kind(c) for c in chosen if c.msgcount}
                self.notes.extend(text for text in self._definitions.notes.values()
                                  if text not in self.notes)
                if not chosen:
                    continue
                publishers = Counter(c.topic for c in chosen)
                for connection, time, data in self._read(reader, chosen, file):
                    number, topic = connection.id, connection.topic
                    if number not in kinds:  # one that the file's own counts leave out
                        kinds[number] = self._kind(connection)
                    count[topic] += 1
                    if self.kind == 'rosbag1':
                        data = self._as_cdr(topic, data, *kinds[number])
                        if not data:
                            continue
                    yield Record(topic, time, data, (publishers[topic] > 1) * (number + 1),
                                 *kinds[number])
        self._compare(wanted, count)

    @contextmanager
    def _opened(self, path: Path) -> Iterator[Storage]:
        """Open a storage file; of a damaged one its undamaged part, with a note."""
        if path in self._recovered:
            yield self._recovered[path]
            return
        check_storage(path, BagError)
        reader: Storage
        try:
            reader = (Ros1Storage if path.suffix == ROS1 else BagStorage)(path)
            reader.open()
        except Exception as error:  # rosbags lets struct, sqlite and assertion errors through
            reader = self._recover(path, error)
        try:
            yield reader
        finally:
            reader.close()

    def _recover(self, path: Path, error: Exception) -> RecoveredStorage:
        """Return the undamaged part of a file; raise BagError where there is none."""
        if path.suffix not in RECOVERABLE:
            raise _unreadable(path, error) from None
        result = RecoveredStorage(path)
        if not result.whole:
            raise _unreadable(path, error) from None
        self._recovered[path] = result
        self.notes.append(
            f'{path}: is damaged ({in_one_line(error, 120)}); {result.whole} messages are whole '
            f'and read, the rest is lost: {result.lost or "its index"}')
        return result

    def _read(self, reader: Storage, chosen: list[Connection], path: Path
              ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield the messages of a file, past damaged parts."""
        done: Counter[str] = Counter()
        try:
            for entry in reader.messages(chosen):
                done[entry[0].topic] += 1
                yield entry
            return
        except GeneratorExit:
            raise
        except Exception as error:
            rest = self._recover(path, error)
        names = {(one.topic, one.msgtype) for one in chosen}
        for entry in rest.messages([one for one in rest.connections
                                    if (one.topic, one.msgtype) in names]):
            done[entry[0].topic] -= 1
            if done[entry[0].topic] < 0:
                yield entry

    def _as_cdr(self, topic: str, data: bytes, kind: str, store: Typestore) -> bytes:
        """Return a message of ROS 1 as CDR; nothing where it is damaged, which is counted."""
        try:
            return bytes(store.ros1_to_cdr(data, kind))
        except Exception as error:
            self._count_undecodable(topic, data, error)
            return b''

    def decode(self, record: 'Record') -> tuple[Any, int, bytes] | None:
        """
        Return a message, its length in bytes, and its bytes.

        None where it cannot be decoded, which is counted.
        """
        try:
            data = self._files.unpack(record.data)
            return *decode(record.store, data, record.type_name), data
        except Exception as error:  # whatever bytes can do to a decoder
            self._count_undecodable(record.topic, record.data, error)
            return None

    def _kind(self, connection: Connection) -> tuple[str, Typestore]:
        """Return the full name of the type of a connection's messages, and their decoder."""
        key = connection.msgtype, connection.msgdef.data
        if key not in self._stores:
            digest = self._files.hashes.get(connection.msgtype, connection.digest)
            self._stores[key] = self._definitions.store_for(connection, digest, self.path)
        return full_type_name(connection.msgtype), self._stores[key]

    def _count_undecodable(self, topic: str, data: bytes, error: Exception) -> None:
        why = f'{type(error).__name__}: {in_one_line(error, 120)}'
        first = self.undecodable.get(topic, (0, why))
        self.undecodable[topic] = first[0] + 1, first[1]

    def _compare(self, wanted: Mapping[str, str], count: Counter[str]) -> None:
        """Compare the messages that were read with those that should be there."""
        for topic in sorted(wanted):
            there = sum(n for name, n in self.types.get(topic, Counter()).items()
                        if same_type_name(name, wanted[topic]))
            by_file = max(there, count[topic])
            if count[topic] < by_file:
                self.notes.append(f'{topic}: {count[topic]} of {by_file} messages are in the '
                                  'storage; the rest is lost')
            if self._files.counts and self._files.counts[topic] != self._counts[topic]:
                self.notes.append(
                    f'{topic}: metadata.yaml counts {self._files.counts[topic]} messages and the '
                    f'storage holds {self._counts[topic]}; those were read')


def _unreadable(path: Path, error: Exception) -> BagError:
    text = in_one_line(error, 200)
    remedy = {'.mcap': 'if it was cut off, `mcap recover` gets back what is whole',
              '.db3': 'if it was cut off, `sqlite3 FILE .recover` gets back what is whole',
              '.bag': 'if it was cut off, `rosbag reindex` gets back what is whole'}.get(
                  path.suffix, GIVE_BAG)
    return BagError(path, f'cannot be read ({type(error).__name__}: {text})', remedy)


def decode(store: Typestore, data: bytes, type_name: str) -> tuple[Any, int]:
    """
    Return a message and its length in bytes.

    rclpy's `serialize_message` leaves a tail of undefined bytes behind some messages, which
    rosbags' own decoder refuses.
    """
    definition = store.get_msgdef(type_name)
    if bytes(data[:2]) not in (b'\0\0', b'\0\1'):
        raise ValueError(f'a message of {type_name} is not plain CDR')
    read = definition.deserialize_cdr_le if data[1] else definition.deserialize_cdr_be
    message, length = read(memoryview(data)[4:], 0, definition.cls, store)
    return message, length + 4


__all__ = ['Bag', 'BagError', 'DefinitionError', 'decode']
