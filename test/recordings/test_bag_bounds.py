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

"""Bags that would make a reader unpack, allocate or decode without end are refused at once."""

import os
from pathlib import Path
import sqlite3
from typing import Any

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.rosbag2 import CompressionMode, StoragePlugin  # noqa: E402
from rosbags.rosbag2.storage_mcap import zstd  # noqa: E402
from squeal_ros.recordings.bags import bag_bounds  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag, BagError  # noqa: E402
from squeal_ros.recordings.bags.message_definitions import DefinitionError  # noqa: E402
from support.bags import HEADER_MSG, reports, storage_file, WHEELS, write_bag  # noqa: E402, I100

MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3
START = 'std_msgs/Header header\nfloat32 speed\nfloat32[2] pressures\n'


def read(path: Path) -> list[Any]:
    return list(Bag(path).messages({'/wheels': WHEELS}))


def nested(levels: int, count: int) -> str:
    """Return definitions of types that each hold an array of the next."""
    parts = [f'{START}acme_msgs/A0[{count}] deep\n{HEADER_MSG}']
    for level in range(levels):
        inner = 'float32 x' if level == levels - 1 else f'acme_msgs/A{level + 1}[{count}] a'
        parts.append(f'{"=" * 80}\nMSG: acme_msgs/A{level}\n{inner}\n')
    return ''.join(parts)


@pytest.mark.parametrize('text', [
    f'{START}string[900000] many\n{HEADER_MSG}',
    f'{START}std_msgs/Header[900000] many\n{HEADER_MSG}',
    f'{START}float64[900000000] many\n{HEADER_MSG}', nested(6, 100), nested(40, 1),
    f'{START}acme_msgs/WheelReport[2] again\n{HEADER_MSG}',
    f'{START}acme_msgs/WheelReport[] again\n{HEADER_MSG}'],
    ids=['texts', 'messages', 'numbers', 'nested', 'deep', 'itself', 'itself in a sequence'])
def test_arrays_are_bounded_before_a_decoder_is_made(text: str, tmp_path: Path) -> None:
    folder = write_bag(tmp_path / 'bag', reports(), definitions={WHEELS: text})
    with pytest.raises((DefinitionError, BagError)) as caught:
        read(folder)
    assert '\n' not in str(caught.value)
    assert 'entries' in str(caught.value) or 'contains itself' in str(caught.value)


def test_a_large_array_of_numbers_is_no_fault() -> None:
    numbers = {'a/msg/B': ([], [('data', (3, ((1, ('float32', 0)), 1_000_000)))])}
    assert bag_bounds.least_size('a/msg/B', numbers) == 4_000_000


def test_chunks_unpack_to_what_they_state_and_no_further() -> None:
    from lz4.frame import compress
    zeros = bytes(10_000_000)
    for packed, unpack in ((zstd.compress(zeros), bag_bounds.unpack_zstd),
                           (compress(zeros), bag_bounds.unpack_lz4)):
        assert len(packed) < 100_000
        assert unpack(packed, len(zeros)) == zeros
        assert len(unpack(packed, 1000)) == 1001  # which is not what was stated: refused then
        with pytest.raises(ValueError, match='more than the'):
            unpack(packed, 2**40)


def test_a_bag_whose_chunks_lie_is_refused(tmp_path: Path, monkeypatch: Any) -> None:
    folder = write_bag(tmp_path / 'bag', reports(), packed=CompressionMode.STORAGE)
    monkeypatch.setattr(bag_bounds, 'MAX_CHUNK', 100)
    with pytest.raises(BagError, match='a chunk of .* more than the 100 that are read'):
        read(folder)


def test_a_file_that_unpacks_without_end_is_refused(tmp_path: Path, monkeypatch: Any) -> None:
    folder = write_bag(tmp_path / 'bag', reports(), packed=CompressionMode.FILE)
    (packed,) = folder.glob('*.zstd')
    packed.write_bytes(zstd.compress(bytes(30_000_000)))
    monkeypatch.setattr(bag_bounds, 'MAX_CHUNK', 1_000_000)
    with pytest.raises(BagError, match='unpacks to more than'):
        read(folder)
    packed.write_bytes(b'no zstd at all')
    with pytest.raises(BagError, match='cannot be unpacked'):
        read(folder)


def test_a_message_that_unpacks_without_end_is_counted_as_damaged(tmp_path: Path,
                                                                  monkeypatch: Any) -> None:
    folder = write_bag(tmp_path / 'bag', reports(), packed=CompressionMode.MESSAGE)
    monkeypatch.setattr(bag_bounds, 'MAX_CHUNK', 26)  # a report has more
    bag = Bag(folder)
    assert list(bag.messages({'/wheels': WHEELS})) == []
    assert bag.undecodable


def test_a_database_with_a_view_is_refused(tmp_path: Path) -> None:
    file = storage_file(write_bag(tmp_path / 'bag', reports(), storage=SQLITE))
    with sqlite3.connect(file) as database:
        database.execute('ALTER TABLE messages RENAME TO others')
        database.execute('CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL '
                         'SELECT i + 1 FROM n) SELECT i AS id, 1 AS topic_id, i AS timestamp, '
                         "x'00' AS data FROM n")
    with pytest.raises(BagError, match="holds a view 'messages'"):
        read(file)


@pytest.mark.parametrize('suffix', ['.mcap', '.db3'])
def test_what_is_no_regular_file_is_refused(suffix: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f'pipe{suffix}')
    (tmp_path / f'zero{suffix}').symlink_to('/dev/zero')
    for name, words in (('pipe', 'pipe'), ('zero', 'device')):
        with pytest.raises(BagError, match=words):
            read(tmp_path / f'{name}{suffix}')
