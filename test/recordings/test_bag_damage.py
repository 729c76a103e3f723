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

"""Bags that are damaged, cut off, in parts, or no bags at all."""

from pathlib import Path
import sqlite3
import struct

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.rosbag1 import Writer as Ros1Writer  # noqa: E402
from rosbags.rosbag2 import CompressionMode, StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import get_typestore, Stores  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag, BagError  # noqa: E402
from support.bags import (  # noqa: E402, I100
    Entry,
    FLOAT,
    make,
    PRESSURE,
    reports,
    SECOND,
    START,
    storage_file,
    STORE,
    values,
    WANTED,
    write_bag,
)

PLAIN, MCAP, SQLITE = CompressionMode.NONE, StoragePlugin.MCAP, StoragePlugin.SQLITE3


def test_parts_of_a_split_bag_in_order_and_one_of_them_lost(tmp_path: Path) -> None:
    folder = tmp_path / 'bag'
    folder.mkdir()
    for number in (0, 1, 2, 10):
        part = write_bag(tmp_path / f'part_{number}', [Entry('/fl/friction', FLOAT, START + number,
                                                             make(FLOAT, data=float(number)))])
        storage_file(part).rename(folder / f'bag_{number}.mcap')
    bag = Bag(folder)
    assert [m.data for _, _, m, _ in bag.messages(WANTED)] == [0.0, 1.0, 2.0, 10.0]


def test_messages_that_are_damaged_are_counted_and_the_others_read(tmp_path: Path) -> None:
    """As the node does: one bad message ends nothing."""
    folder = write_bag(tmp_path / 'bag', reports(), storage=SQLITE)
    with sqlite3.connect(storage_file(folder)) as database:
        database.execute('UPDATE messages SET data = ? WHERE id = 5', (b'\0\1\0\0\1',))
        database.execute('UPDATE messages SET data = ? WHERE id = 6', (b'\x28\xb5\x2f\xfd1234',))
    bag = Bag(folder)
    assert len(values(bag)) == 78
    assert sum(count for count, _ in bag.undecodable.values()) == 2


def test_a_log_that_was_not_merged_is_told(tmp_path: Path) -> None:
    file = storage_file(write_bag(tmp_path / 'bag', reports(), storage=SQLITE))
    file.with_name(f'{file.name}-wal').write_bytes(b'1')
    assert 'wal are not read' in Bag(file).notes[0]


@pytest.mark.parametrize('size', [3, 1_000_000])
def test_a_record_that_is_cut_off_in_a_chunk_is_one_line(size: int, tmp_path: Path) -> None:
    file = storage_file(write_bag(tmp_path / 'bag', [
        Entry('/fl/friction', FLOAT, START, make(FLOAT, data=0.4))]))
    whole, cut = (struct.pack('<BQH', 5, number, 1) for number in (22 + 12, size))
    assert file.read_bytes().count(whole) == 1
    file.write_bytes(file.read_bytes().replace(whole, cut))
    with pytest.raises(BagError, match='cannot be read .*a message of .* bytes is cut off'):
        values(Bag(file))


@pytest.mark.parametrize('storage', [MCAP, SQLITE])
@pytest.mark.parametrize('packed', [PLAIN, CompressionMode.STORAGE, CompressionMode.MESSAGE,
                                    CompressionMode.FILE])
@pytest.mark.parametrize('part', [0.5, 0.97])
def test_of_a_truncated_bag_what_is_whole_is_read(
        storage: StoragePlugin, packed: CompressionMode, part: float, tmp_path: Path) -> None:
    """Never as few messages as can be got without a word."""
    if storage == SQLITE and packed == CompressionMode.STORAGE:
        pytest.skip('there is none')
    seconds = 100.0 if packed == CompressionMode.FILE else 15.0  # blocks are unpacked as a whole
    folder = write_bag(tmp_path / 'bag', reports(seconds), storage=storage, packed=packed)
    whole = values(Bag(folder))
    (file,) = (path for path in folder.iterdir() if path.name != 'metadata.yaml')
    data = file.read_bytes()
    file.write_bytes(data[:round(part * len(data))])
    for path in (file, folder):
        bag = Bag(path)
        found = values(bag)
        assert set(found) <= set(whole)
        assert len(found) > 0.3 * part * len(whole)
        assert 'messages are whole and read, the rest is lost' in ' '.join(bag.notes)


@pytest.mark.parametrize('packed', [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_a_packed_bag_without_its_metadata(packed: CompressionMode, tmp_path: Path) -> None:
    folder = write_bag(tmp_path / 'bag', reports(), storage=SQLITE, packed=packed)
    whole = values(Bag(folder))
    (folder / 'metadata.yaml').unlink()
    (file,) = folder.iterdir()
    assert values(Bag(folder)) == values(Bag(file)) == whole
    assert len(whole) == 80


def test_past_a_damaged_chunk_reading_goes_on(tmp_path: Path) -> None:
    path = tmp_path / 'bag.mcap'
    with Writer(tmp_path / 'bag', version=9, storage_plugin=MCAP) as bag:
        about = bag.add_connection('/fl/friction', FLOAT, typestore=STORE)
        for number in range(400):
            if not number % 50:
                bag.storage.close_chunk()
            bag.write(about, START + number, STORE.serialize_cdr(make(
                FLOAT, data=0.001 * number), FLOAT))
    data = bytearray(storage_file(tmp_path / 'bag').read_bytes())
    message = data.index(STORE.serialize_cdr(make(FLOAT, data=0.001 * 160), FLOAT))
    data[message - 28] ^= 0xff  # of the length of its record
    path.write_bytes(data)
    bag = Bag(path)
    found = [time - START for _, time, _, _ in bag.messages(WANTED)]
    assert found == [number for number in range(400) if not 160 <= number < 200]
    assert '360 messages are whole and read, the rest is lost: a record' in bag.notes[0]


def write_ros1(path: Path, count: int, compression: Ros1Writer.CompressionFormat | None = None
               ) -> list[tuple[str, int, float]]:
    """Write a bag of ROS 1, of two publishers; return its messages."""
    ros1 = get_typestore(Stores.ROS1_NOETIC)
    header, time, fluid = (ros1.types[f'{name}'] for name in (
        'std_msgs/msg/Header', 'builtin_interfaces/msg/Time', PRESSURE))
    bag = Ros1Writer(path)
    if compression:
        bag.set_compression(compression)
    found: list[tuple[str, int, float]] = []
    with bag:
        bag.chunk_threshold = 2000
        pressure = bag.add_connection('/fl/brake_pressure', PRESSURE, typestore=ros1)
        friction = bag.add_connection('/fl/friction', FLOAT, typestore=ros1)
        for number in range(count):
            at = START + 1000 * number
            bag.write(pressure, at, ros1.serialize_ros1(fluid(
                header=header(seq=number, stamp=time(sec=at // SECOND, nanosec=at % SECOND + 7),
                              frame_id='fl' * (number % 3)),
                fluid_pressure=1e5 * number, variance=0.0), PRESSURE))
            bag.write(friction, at + 10, ros1.serialize_ros1(
                ros1.types[FLOAT](data=0.001 * number), FLOAT))
            found += [('/fl/brake_pressure', at, 1e5 * number),
                      ('/fl/friction', at + 10, 0.001 * number)]
    return found


def of_ros1(bag: Bag) -> list[tuple[str, int, float]]:
    wanted = {'/fl/brake_pressure': PRESSURE, '/fl/friction': 'std_msgs/Float64'}
    return [(topic, time, getattr(message, 'data', 0.0) or getattr(message, 'fluid_pressure', 0.0))
            for topic, time, message, _ in bag.messages(wanted)]


@pytest.mark.parametrize('compression', [None, *Ros1Writer.CompressionFormat])
def test_bags_of_ros_1(compression: Ros1Writer.CompressionFormat | None, tmp_path: Path) -> None:
    path = tmp_path / 'old.bag'
    expected = write_ros1(path, 200, compression)
    bag = Bag(path)
    assert of_ros1(bag) == expected
    assert (bag.kind, bag.notes) == ('rosbag1', [])
    _, _, message, _ = next(iter(bag.messages({'/fl/brake_pressure': PRESSURE})))
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (START // SECOND, 7)
    data = path.read_bytes()
    for part in (0.5, 0.95):  # cut off, and so without an index
        path.write_bytes(data[:round(part * len(data))])
        bag = Bag(path)
        found = of_ros1(bag)
        assert found == expected[:len(found)]
        assert len(found) > 0.3 * part * len(expected)
        assert 'messages are whole and read, the rest is lost' in bag.notes[0]


def test_other_files_are_told_apart(tmp_path: Path) -> None:
    (tmp_path / 'old.bag').write_bytes(b'#ROSBAG V2.0\n')
    with pytest.raises(BagError, match='cannot be read .*Header'):
        Bag(tmp_path / 'old.bag')
    (tmp_path / 'empty').mkdir()
    with pytest.raises(BagError, match='no storage file'):
        Bag(tmp_path / 'empty')
    with pytest.raises(BagError, match='is a device'):
        Bag('/dev/zero')
