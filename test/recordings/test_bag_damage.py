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

from rosbags.rosbag2 import StoragePlugin  # noqa: E402
from squeal_ros.recordings.bag_reader import Bag, BagError  # noqa: E402
from support.bags import (  # noqa: E402, I100
    Entry,
    FLOAT,
    make,
    reports,
    START,
    storage_file,
    values,
    WANTED,
    write_bag,
)

MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3


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
@pytest.mark.parametrize('part', [0.3, 0.7, 0.97])
def test_a_truncated_bag_is_one_line(storage: StoragePlugin, part: float, tmp_path: Path) -> None:
    """Never as few messages as can be got without a word."""
    file = storage_file(write_bag(tmp_path / 'bag', reports(20.0), storage=storage))
    data = file.read_bytes()
    file.write_bytes(data[:round(part * len(data))])
    for path in (file, file.parent):
        with pytest.raises(BagError, match=r'cannot be read.*recover') as error:
            values(Bag(path))
        assert '\n' not in str(error.value)


def test_other_files_are_told_apart(tmp_path: Path) -> None:
    (tmp_path / 'old.bag').write_bytes(b'#ROSBAG V2.0\n')
    with pytest.raises(BagError, match='ROS 1; convert it'):
        Bag(tmp_path / 'old.bag')
    (tmp_path / 'empty').mkdir()
    with pytest.raises(BagError, match='no storage file'):
        Bag(tmp_path / 'empty')
    with pytest.raises(BagError, match='is a device'):
        Bag('/dev/zero')
