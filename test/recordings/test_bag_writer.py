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

"""Bags as they are written: read again, and without the tail that a message had."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.rosbag2 import Reader, StoragePlugin, Writer  # noqa: E402
from squeal_core.common.output import OutputError  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag  # noqa: E402
from squeal_ros.recordings.bags.bag_writer import _qos, BagMessages, BagWriter  # noqa: E402
from support.bags import FLOAT, float_messages, SECOND, STORE, write_floats  # noqa: E402, I100


@pytest.mark.parametrize('name', ['in.mcap', 'in'])
def test_bag_round_trip(name: str, tmp_path: Path) -> None:
    entries = float_messages(1.0)
    path = write_floats(tmp_path / name, entries)
    assert path.is_file() == name.endswith('.mcap')
    wanted = {topic: FLOAT for topic, _, _ in entries}
    assert sorted((t, s, m.data) for t, s, m, _ in Bag(path).messages(wanted)) == sorted(entries)
    assert [p.name for p in tmp_path.iterdir()] == [name]
    with pytest.raises(OutputError, match='exists'), BagWriter(path):
        pass


def test_bytes_are_those_of_rosbags(tmp_path: Path) -> None:
    """Of several chunks; three topics at once, and one that comes in between."""
    topics, later = ('/a', '/b', '/c'), '/later'
    with BagWriter(tmp_path / 'ours') as bag:
        for time in range(1, 10_001):
            data = [bytes(STORE.serialize_cdr(STORE.types[FLOAT](data=float(place + time)), FLOAT))
                    for place in range(4)]
            bag.write_serialised(time, [(topics, FLOAT, b''.join(data[:3]))])
            if time % 7 == 0:
                bag.write_serialised(time, [((later,), FLOAT, data[3])])
    (tmp_path / 'theirs').mkdir()
    with Writer(tmp_path / 'theirs' / 'ours', version=9,
                storage_plugin=StoragePlugin.MCAP) as theirs:
        def connected(topic: str) -> Any:
            return theirs.add_connection(topic, FLOAT, typestore=STORE,
                                         offered_qos_profiles=[_qos(0)])

        known = {topic: connected(topic) for topic in topics}
        for record in Bag(tmp_path / 'ours').records(dict.fromkeys((*topics, later), FLOAT)):
            if record.topic not in known:
                known[record.topic] = connected(record.topic)
            theirs.write(known[record.topic], record.time, record.data)
    ours, expected = (path / 'ours' / 'ours.mcap' for path in (tmp_path, tmp_path / 'theirs'))
    assert ours.read_bytes() == expected.read_bytes()


def test_tail_of_undefined_bytes_is_left_out(tmp_path: Path) -> None:
    """As rclpy's serialize_message leaves behind a JointState."""
    joints: Any = BagMessages().type('sensor_msgs/msg/JointState')(
        header=STORE.types['std_msgs/msg/Header'](
            stamp=STORE.types['builtin_interfaces/msg/Time'](sec=1, nanosec=0), frame_id=''),
        name=['fl_wheel_joint'], position=np.zeros(0), velocity=np.array([math.pi]),
        effort=np.zeros(0))
    data = bytes(STORE.serialize_cdr(joints, 'sensor_msgs/msg/JointState')) + b'\xa0' * 12
    with BagWriter(tmp_path / 'a.mcap') as bag:
        bag.write('/joint_states', 'sensor_msgs/msg/JointState', SECOND, data)
    (_, _, message, _), = Bag(tmp_path / 'a.mcap').messages(
        {'/joint_states': 'sensor_msgs/msg/JointState'})
    assert message.velocity.tolist() == [math.pi]
    with Reader(tmp_path / 'a.mcap') as reader:
        _, _, stored = next(reader.messages())
    assert len(stored) == len(data) - 12
