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

"""Bags as they are: schemas, definitions from elsewhere, storage against metadata."""

from pathlib import Path
import sqlite3
from typing import Any

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.rosbag2 import CompressionMode, Reader, StoragePlugin, Writer  # noqa: E402
from rosbags.typesys import get_typestore, Stores  # noqa: E402
from squeal_core.common.errors import SquealError  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag  # noqa: E402
from squeal_ros.recordings.bags.mcap_chunks import BagStorage  # noqa: E402
from squeal_ros.recordings.bags.message_definitions import (  # noqa: E402
    DefinitionError,
    MessageDefinitions,
)
from support.bags import (  # noqa: E402, I100
    braking,
    Entry,
    FLOAT,
    HEADER_MSG,
    reports,
    START,
    storage_file,
    values,
    WHEELS,
    WHEELS_MSG,
    write_bag,
)

MCAP, SQLITE = StoragePlugin.MCAP, StoragePlugin.SQLITE3
LINE = '=' * 80 + '\n'
# as rosbag2 writes them: blocks with headers; with what ROS's generator puts into such files
IDL = f"""{LINE}IDL: {WHEELS}
// generated from a .msg file
#include "std_msgs/msg/Header.idl"
  #include "builtin_interfaces/msg/Time.idl"

module acme_msgs {{
  module msg {{
    typedef float float__2[2];
    module WheelReport_Constants {{
      const float PI = 3.14;
    }};
    @verbatim (language="comment", text="speed and pressures")
    struct WheelReport {{
      std_msgs::msg::Header header;

      @unit (value="rad/s")
      float speed;

      float__2 pressures;
    }};
  }};
}};
{LINE}IDL: std_msgs/msg/Header
#include "builtin_interfaces/msg/Time.idl"
module std_msgs {{ module msg {{
  struct Header {{ builtin_interfaces::msg::Time stamp; string frame_id; }};
}}; }};
{LINE}IDL: builtin_interfaces/msg/Time
module builtin_interfaces {{ module msg {{ struct Time {{ int32 sec; uint32 nanosec; }}; }}; }};
"""


@pytest.fixture(scope='module')
def expected(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Any, ...]]:
    found = values(Bag(write_bag(tmp_path_factory.mktemp('bags') / 'plain', reports())))
    assert len(found) == 80
    assert found[-1] == ('/wheels', found[39][1], (20.0, 8.0))
    return found


def as_idl(folder: Path) -> Path:
    """Have a bag whose definitions are IDL say so."""
    file = storage_file(folder)
    if file.suffix == '.db3':
        with sqlite3.connect(file) as database:
            database.execute('UPDATE message_definitions SET encoding = "ros2idl" '
                             'WHERE topic_type = ?', (WHEELS,))
    else:
        file.write_bytes(file.read_bytes().replace(WHEELS.encode() + b'\x07\0\0\0ros2msg',
                                                   WHEELS.encode() + b'\x07\0\0\0ros2idl'))
    return folder


@pytest.mark.parametrize('storage', [MCAP, SQLITE])
@pytest.mark.parametrize('text', [IDL, IDL.replace(LINE, '', 1).partition('\n')[2],
                                  IDL.replace('\n', '\r\n')], ids=['blocks', 'bare', 'CRLF'])
def test_an_idl_schema_reads_as_a_msg_one(storage: StoragePlugin, text: str, tmp_path: Path,
                                          expected: list[Any]) -> None:
    if not text.startswith('='):  # then it holds one type, and the others are standard ones
        text = text.partition(LINE)[0]
    bag = as_idl(write_bag(tmp_path / 'bag', reports(), storage=storage,
                           definitions={WHEELS: text}))
    assert values(Bag(bag)) == expected


@pytest.mark.parametrize(('storage', 'packed'), [
    (MCAP, CompressionMode.STORAGE), (MCAP, CompressionMode.FILE), (SQLITE, CompressionMode.FILE),
    (MCAP, CompressionMode.MESSAGE), (SQLITE, CompressionMode.MESSAGE)])
def test_compressed_bags(storage: StoragePlugin, packed: CompressionMode, tmp_path: Path,
                         expected: list[Any]) -> None:
    bag = Bag(write_bag(tmp_path / 'bag', reports(), storage=storage, packed=packed))
    assert values(bag) == expected
    assert bag.notes == []


@pytest.mark.parametrize('storage', [MCAP, SQLITE])
def test_the_bags_own_definition_wins(storage: StoragePlugin, tmp_path: Path) -> None:
    folder = write_bag(tmp_path / 'bag', [Entry('/x', WHEELS, START, reports()[0].message)],
                       storage=storage, definitions={WHEELS: 'std_msgs/Header header\n'
                                                     'float32 fast\nfloat32[2] p\n' + HEADER_MSG})
    (_, _, message, _), = Bag(folder).messages({'/x': WHEELS})
    assert message.fast == 20.0
    assert not hasattr(message, 'speed')


@pytest.fixture
def undefined(tmp_path: Path) -> Path:
    """Return a bag of an older distribution: without definitions, and without hashes."""
    folder = write_bag(tmp_path / 'humble', reports(), storage=SQLITE)
    with sqlite3.connect(storage_file(folder)) as database:
        database.execute('DROP TABLE message_definitions')
        database.execute('DROP TABLE schema')
    (folder / 'metadata.yaml').unlink()
    return storage_file(folder)


def test_a_type_without_definition_is_named_with_the_remedy(undefined: Path) -> None:
    with pytest.raises(DefinitionError, match=f'no definition of {WHEELS}; .*--types.*workspace'):
        values(Bag(undefined))


@pytest.mark.parametrize('place', ['acme_msgs/msg', 'acme_msgs', '.', 'msg', 'deep/acme_msgs/msg'])
def test_definitions_from_a_folder(place: str, undefined: Path, tmp_path: Path,
                                   expected: list[Any]) -> None:
    folder = tmp_path / 'types' / place
    folder.mkdir(parents=True)
    (folder / 'WheelReport.msg').write_text(WHEELS_MSG)
    bag = Bag(undefined, MessageDefinitions(tmp_path / 'types'))
    assert values(bag) == expected
    assert bag.notes == [f'the bag holds no definition of {FLOAT}; that of ROS 2 Jazzy is used']


def test_definitions_from_a_workspace(undefined: Path, tmp_path: Path, expected: list[Any],
                                      monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / 'install' / 'share' / 'acme_msgs' / 'msg'
    folder.mkdir(parents=True)
    (folder / 'WheelReport.idl').write_text(IDL.partition(f'{LINE}IDL: std')[0].partition('\n')[2]
                                            .partition('\n')[2])
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'/nowhere:{tmp_path / "install"}')
    assert values(Bag(undefined)) == expected


@pytest.mark.parametrize(('place', 'text', 'words'), [
    ('other_msgs/msg/WheelReport.msg', WHEELS_MSG, f'no definition of {WHEELS}'),
    ('WheelReport.msg', 'float32 a[\n', 'is no message definition'),
    ('WheelReport.msg', 'Missing a\n', 'acme_msgs/msg/Missing, which .*WheelReport contains'),
    ('WheelReport.msg', 'float64[2000000000] a\n', 'an array of 2000000000 entries'),
    ('notes.txt', '', 'holds no .msg')])
def test_folders_that_do_not_help(place: str, text: str, words: str, undefined: Path,
                                  tmp_path: Path) -> None:
    file = tmp_path / 'types' / place
    file.parent.mkdir(parents=True)
    file.write_text(text)
    with pytest.raises(SquealError, match=words) as error:
        values(Bag(undefined, MessageDefinitions(tmp_path / 'types')))
    assert '\n' not in str(error.value)


def test_a_definition_of_another_version_is_refused(tmp_path: Path) -> None:
    """Where the bag holds the hash of the type it was recorded with."""
    folder = write_bag(tmp_path / 'bag', reports(), definitions={WHEELS: ''})
    types = tmp_path / 'types'
    types.mkdir()
    (types / 'WheelReport.msg').write_text(WHEELS_MSG.replace('speed', 'rate'))
    with pytest.raises(DefinitionError, match=f'another version of {WHEELS}'):
        values(Bag(folder, MessageDefinitions(types)))


def test_storage_is_read_whatever_the_metadata_says(tmp_path: Path, expected: list[Any]) -> None:
    """Other counts, other topics' policies, no file of that name, no metadata at all."""
    folder = write_bag(tmp_path / 'bag', reports())
    metadata = folder / 'metadata.yaml'
    right = metadata.read_text()
    assert right.count('message_count: 40') == 2
    metadata.write_text(right.replace('message_count: 40', 'message_count: 900'))
    bag = Bag(folder)
    assert values(bag) == expected
    assert [note for note in bag.notes if 'metadata.yaml counts 900' in note]
    metadata.write_text(right.replace('offered_qos_profiles: []', 'offered_qos_profiles: '
                                      '[{history: 1, depth: 3}]').replace('RIHS01_', 'RIHS01_0'))
    assert values(Bag(folder)) == expected
    metadata.write_text(right.replace('bag.mcap', 'renamed.mcap'))
    bag = Bag(folder)
    assert values(bag) == expected
    assert 'renamed.mcap is not there' in bag.notes[0]
    for text in ('nonsense: [', '', None):
        metadata.unlink(missing_ok=True) if text is None else metadata.write_text(text)
        bag = Bag(folder)
        assert values(bag) == expected
        assert 'metadata.yaml is missing or cannot be read' in bag.notes[0]


@pytest.mark.parametrize('times', [range(12), [3, 1, 2, 1, *range(4, 12)],
                                   [*range(8, 12), *range(8)], [0, 1, 2, 3, 3, 3, 3, 3, 3, 4]],
                         ids=['ordered', 'shuffled', 'overlapping', 'equal'])
def test_chunks_are_read_as_rosbags_reads_them(times: list[int], tmp_path: Path) -> None:
    kind = 'std_msgs/msg/String'
    store = get_typestore(Stores.ROS2_JAZZY)
    with Writer(tmp_path / 'bag', version=9, storage_plugin=MCAP) as bag:
        topics = [bag.add_connection(topic, kind, typestore=store) for topic in ('/a', '/b', '/c')]
        for number, time in enumerate(times):
            text = store.types[kind](data=f'{number} ' + 'x' * 300_000)
            bag.write(topics[number % 3], START + time, bytes(store.serialize_cdr(text, kind)))
    file = storage_file(tmp_path / 'bag')
    with Reader(file) as expected, BagStorage(file) as reader:
        assert len(reader.storage.chunks) == 3
        for count in (1, 2, 3):
            assert [message[1:] for message in reader.messages(reader.connections[:count])] == [
                message[1:] for message in expected.messages(expected.connections[:count])]


def test_only_messages_of_the_wanted_type_are_read(tmp_path: Path) -> None:
    folder = write_bag(tmp_path / 'bag', braking(0.2))
    assert list(Bag(folder).messages({'/fl/friction': 'std_msgs/msg/Float32'})) == []
    assert len(list(Bag(folder).messages({'/fl/friction': 'std_msgs/Float64'}))) == 4
