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

"""Bags of one brake, made for tests: any storage, any definition, any fault."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import get_types_from_msg, get_typestore, Stores
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.settings import MonitorSettings
from squeal_ros.recordings.bags.bag_reader import Bag
from squeal_ros.recordings.bags.bag_writer import BagMessages, BagWriter
from squeal_ros.recordings.recording_files import open_recording
from squeal_ros.recordings.replay.replay import Replay
import yaml

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
WHEELS = 'acme_msgs/msg/WheelReport'
FRAME = 'can_msgs/msg/Frame'
JOINTS, PRESSURE, FLOAT = ('sensor_msgs/msg/JointState', 'sensor_msgs/msg/FluidPressure',
                           'std_msgs/msg/Float64')
WANTED = {'/wheels': WHEELS, '/fl/friction': FLOAT}
WHEELS_MSG = 'std_msgs/Header header\nfloat32 speed\nfloat32[2] pressures\n'
FRAME_MSG = 'std_msgs/Header header\nuint32 id\nuint8 dlc\nuint8[8] data\n'
HEADER_MSG = ('{line}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n'
              '{line}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n'
              ).format(line='=' * 80)
STORE = get_typestore(Stores.ROS2_JAZZY)
STORE.register({**get_types_from_msg(WHEELS_MSG, WHEELS), **get_types_from_msg(FRAME_MSG, FRAME)})


class Entry(NamedTuple):
    """One message: its topic, type, time of recording [ns] and content."""

    topic: str
    type: str  # noqa: A003
    time: int
    message: Any


def make(kind: str, /, **fields: Any) -> Any:
    return STORE.types[kind](**fields)


def header(stamp: int, frame: str = '') -> Any:
    return make('std_msgs/msg/Header', frame_id=frame, stamp=make(
        'builtin_interfaces/msg/Time', sec=stamp // SECOND, nanosec=stamp % SECOND))


def times(seconds: float, step: float = 0.05) -> Iterator[int]:
    yield from (START + round(step * SECOND) * n for n in range(round(seconds / step)))


def braking(seconds: float = 2.0, *, behind: int = 0, joint: str = 'fl_wheel_joint',
            pressure: float = 8e5, topics: str = '/fl') -> list[Entry]:
    """
    Return what a vehicle publishes that brakes all the time.

    Parameters
    ----------
    seconds : float
        Duration [s].
    behind : int
        By which stamps are behind the times of recording [ns].
    joint : str
        Name of the joint.
    pressure : float
        [Pa].
    topics : str
        Where the topics of the brake are.

    """
    found = []
    for number, time in enumerate(times(seconds)):
        stamp, flicker = header(time - behind), 1e-3 * (number % 7)
        found += [
            Entry('/joint_states', JOINTS, time, make(
                JOINTS, header=stamp, name=['steering', joint], position=np.zeros(0),
                velocity=np.array([0.0, 20.0 + flicker]), effort=np.zeros(0))),
            Entry(f'{topics}/brake_pressure', PRESSURE, time, make(
                PRESSURE, header=stamp, fluid_pressure=pressure * (1.0 + flicker), variance=0.0)),
            Entry(f'{topics}/friction', FLOAT, time, make(FLOAT, data=0.42 + flicker))]
    return found


def reports(seconds: float = 2.0) -> list[Entry]:
    """Return the same as messages of a type of its own, with the pressure in bar."""
    return [Entry('/wheels', WHEELS, time, make(
        WHEELS, header=header(time), speed=20.0, pressures=np.array([8.0, 3.0], np.float32)))
        for time in times(seconds)] + [e for e in braking(seconds) if e.type == FLOAT]


def settings_file(path: Path, brake: str = 'fl', **inputs: Any) -> Path:
    """Write a settings file of one brake; `pressure={'topic': ...}` and so on."""
    path.write_text(yaml.safe_dump({'/**': {'ros__parameters': {
        'brakes': [brake], brake: inputs} if inputs else {'brakes': [brake]}}}))
    return path


def report_inputs() -> dict[str, dict[str, Any]]:
    """Return the inputs that read `reports`."""
    about = {'topic': '/wheels', 'type': WHEELS}
    return {'rotor_speed': {**about, 'field': 'speed'},
            'pressure': {**about, 'field': 'pressures[0]', 'scale': 1e5}}


def write_bag(folder: Path, entries: list[Entry], *, storage: StoragePlugin = StoragePlugin.MCAP,
              packed: CompressionMode = CompressionMode.NONE,
              definitions: dict[str, str] | None = None) -> Path:
    """Write a rosbag2 folder; `definitions` replace the right ones by other texts."""
    with_own = {WHEELS: WHEELS_MSG + HEADER_MSG, FRAME: FRAME_MSG + HEADER_MSG,
                **(definitions or {})}
    bag = Writer(folder, version=9, storage_plugin=storage)
    if packed != CompressionMode.NONE:
        bag.set_compression(packed, CompressionFormat.ZSTD)
    with bag:
        connections: dict[str, Any] = {}
        for entry in sorted(entries, key=lambda e: e.time):
            if entry.topic not in connections:
                text = with_own.get(entry.type)
                about = {'typestore': STORE} if text is None else {
                    'msgdef': text, 'rihs01': STORE.hash_rihs01(entry.type)}
                connections[entry.topic] = bag.add_connection(entry.topic, entry.type, **about)
            bag.write(connections[entry.topic], entry.time,
                      STORE.serialize_cdr(entry.message, entry.type))
    return folder


def storage_file(folder: Path) -> Path:
    (file,) = [path for path in folder.iterdir() if path.suffix in ('.mcap', '.db3')]
    return file


def values(bag: Bag) -> list[tuple[Any, ...]]:
    """Return topic, time and number of all messages."""
    return sorted((topic, time, float(message.data) if topic == '/fl/friction'
                   else (float(message.speed), float(message.pressures[0])))
                  for topic, time, message, _ in bag.messages(WANTED))


def replay_of(path: Path, settings: MonitorSettings, model: BrakeModel,
              **options: Any) -> Replay:
    return Replay(open_recording(path, settings), settings, model, **options)


def float_messages(seconds: float, step: float = 0.1) -> list[tuple[str, int, float]]:
    """Braking from 1 s to 3 s at a constant rotor speed."""
    found = []
    for time in np.arange(0.0, seconds, step):
        stamp = 100 * SECOND + round(time * SECOND)
        for topic, value in (('/speed', 20.0), ('/fl/friction', 0.42),
                             ('/pressure', 7.84e5 if 1.0 <= time < 3.0 else 0.0)):
            found.append((topic, stamp, value))
    return found


def write_floats(path: Path, entries: list[tuple[str, int, float]]) -> Path:
    library = BagMessages()
    with BagWriter(path) as bag:
        for topic, time, value in entries:
            bag.write(topic, FLOAT, time, library.type(FLOAT)(data=value))
    return path
