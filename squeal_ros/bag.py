"""ROS 2 bags, MCAP and sqlite3, read lazily and written whole; the only room of rosbags."""

from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
import shutil
import tempfile
from types import TracebackType
from typing import Any

try:
    from rosbags.interfaces import Connection
    from rosbags.rosbag2 import Reader, StoragePlugin, Writer
    from rosbags.typesys import get_types_from_msg, get_typestore, Stores
    from rosbags.typesys.store import Typestore
except ImportError as error:
    raise ImportError("bags need rosbags: pip install -e '.[bags]' in the checkout") from error
import numpy as np

from squeal_core.errors import SquealError

_JAZZY = get_typestore(Stores.ROS2_JAZZY)


class BagError(SquealError):
    """A bag that cannot be read or written."""

    def __init__(self, path: object, what: str, remedy: str) -> None:
        super().__init__(f'{path}: {what}; {remedy}')


class BagMessages:
    """Message classes as rosbags provides them."""

    def type(self, name: str) -> Any:
        return _JAZZY.types[name]

    def floats(self, values: Sequence[float]) -> Any:
        return np.array(values, dtype=np.float64)

    def byte(self, value: int) -> Any:
        return value


def read_bag(path: str | Path, topics: Collection[str]) -> Iterator[tuple[str, int, Any]]:
    """Yield (topic, time of recording [ns], message) of the wanted topics, in order of time.

    Raises
    ------
    BagError
        For what is no bag, is damaged, or holds none of the topics.
    """
    path = Path(path)
    if not path.exists():
        raise BagError(path, 'does not exist', 'check the path')
    try:
        yield from _read(path, topics)
    except (BagError, GeneratorExit):
        raise
    except Exception as error:  # rosbags lets struct, sqlite and assertion errors through
        text = ' '.join(str(error).split())[:200]
        raise BagError(path, f'cannot be read ({type(error).__name__}: {text})',
                       'give a rosbag2 folder or an .mcap or .db3 file') from None


def _read(path: Path, topics: Collection[str]) -> Iterator[tuple[str, int, Any]]:
    count = 0
    with Reader(path) as reader:
        wanted = [c for c in reader.connections if c.topic in topics]
        if not wanted:
            there = ', '.join(sorted({c.topic for c in reader.connections})) or 'nothing'
            raise BagError(path, f'has none of the topics {", ".join(sorted(topics))}',
                           f'name its topics in the settings; it has: {there}')
        store = _store_for(wanted)
        for connection, time, data in reader.messages(wanted):
            count += 1
            yield connection.topic, time, _decode(store, data, connection.msgtype)[0]
        if count == 0 and sum(c.msgcount for c in wanted):
            raise BagError(path, 'its metadata.yaml does not fit its storage file, so nothing '
                           'was read', 'give the .mcap or .db3 file itself')


def _store_for(connections: Sequence[Connection]) -> Typestore:
    """Return the standard types and those that only the bag itself defines."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for connection in connections:
        if connection.msgtype not in store.types:
            store.register({
                name: fields for name, fields in get_types_from_msg(
                    connection.msgdef.data, connection.msgtype).items()
                if name not in store.types})
    return store


def _decode(store: Typestore, data: bytes, type_name: str) -> tuple[Any, int]:
    """Return a message and its length in bytes.

    rclpy's `serialize_message` leaves a tail of undefined bytes behind some messages, which
    rosbags' own decoder refuses.
    """
    definition = store.get_msgdef(type_name)
    if bytes(data[:2]) not in (b'\0\0', b'\0\1'):
        raise ValueError(f'a message of {type_name} is not plain CDR')
    read = definition.deserialize_cdr_le if data[1] else definition.deserialize_cdr_be
    message, length = read(memoryview(data)[4:], 0, definition.cls, store)
    return message, length + 4


class BagWriter:
    """Writes a bag: `NAME.mcap` as one file, any other name as a folder. A context manager.

    Nothing stands under the name until the bag is whole; an existing one is not overwritten.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        if self.path.exists():
            raise BagError(self.path, 'exists', 'remove it or choose another name')
        self._connections: dict[str, Connection] = {}

    def __enter__(self) -> 'BagWriter':
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._folder = Path(tempfile.mkdtemp(prefix=f'.{self.path.name}.',
                                                 dir=self.path.parent))
        except OSError as error:
            raise BagError(self.path, f'cannot be written ({error.strerror})',
                           'check folder and rights') from None
        self._writer = Writer(self._folder / self.path.stem, version=9,
                              storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        return self

    def write(self, topic: str, type_name: str, time: int, message: Any) -> None:
        """Write a message of rosbags' classes, or its CDR bytes."""
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic, type_name, typestore=_JAZZY)
        if isinstance(message, bytes):
            data = message[:_decode(_JAZZY, message, type_name)[1]]
        else:
            data = bytes(_JAZZY.serialize_cdr(message, type_name))
        self._writer.write(self._connections[topic], time, data)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        try:
            self._writer.close()
            if kind is None:
                folder = self._folder / self.path.stem
                whole = next(folder.glob('*.mcap')) if self.path.suffix == '.mcap' else folder
                whole.rename(self.path)
        finally:
            shutil.rmtree(self._folder, ignore_errors=True)
