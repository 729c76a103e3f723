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

"""The replay of what a node was given, from whole bags and damaged ones."""

from dataclasses import replace
import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.interfaces import (  # noqa: E402
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: E402
from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_core.monitor.results.history import read_rows, row_of  # noqa: E402
from squeal_core.monitor.results.squeal_events import squeal_events  # noqa: E402
from squeal_core.monitor.setting_specs import Signal  # noqa: E402
from squeal_core.monitor.settings import MonitorSettings, read_settings  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Assessment, Sample, VehicleMonitor  # noqa: E402
from squeal_core.surrogate.table_builder import build_table  # noqa: E402
from squeal_core.surrogate.table_domain import TableDomain  # noqa: E402
from squeal_core.surrogate.table_file import write_table  # noqa: E402
from squeal_ros.node.messages import TYPES  # noqa: E402
from squeal_ros.recordings.bags.bag_reader import Bag, BagError  # noqa: E402
from squeal_ros.recordings.bags.bag_writer import BagMessages, BagWriter  # noqa: E402
from squeal_ros.recordings.replay.evaluation_process import write_replay  # noqa: E402
from squeal_ros.recordings.replay.replay_outputs import Outputs  # noqa: E402
from support.bags import (  # noqa: E402, I100
    FLOAT,
    float_messages,
    replay_of,
    SECOND,
    STORE,
    write_floats,
)
from support.brake_monitors import EAGER  # noqa: E402

QOS = Qos(QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, QosDurability.VOLATILE,
          QosTime(0, 0), QosTime(0, 0), QosLiveliness.AUTOMATIC, QosTime(0, 0), False)


@pytest.fixture
def settings() -> MonitorSettings:
    speed = {'fl.rotor_speed.topic': 'speed', 'fl.rotor_speed.type': FLOAT,
             'fl.rotor_speed.field': 'data'}
    pressure = {'fl.pressure.topic': 'pressure', 'fl.pressure.type': FLOAT,
                'fl.pressure.field': 'data'}
    return read_settings({**EAGER, 'brakes': ['fl'], 'rate': 2.0, **speed, **pressure})


def replay(path: Path, settings: MonitorSettings, model: BrakeModel
           ) -> list[tuple[Assessment, ...]]:
    return list(replay_of(path, settings, model))


def test_sqlite_bag_of_another_writer(tmp_path: Path, settings: MonitorSettings,
                                      kang: BrakeModel) -> None:
    path = tmp_path / 'other'
    with Writer(path, version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        connections = {}
        for topic, time, value in float_messages(4.0):
            if topic not in connections:
                connections[topic] = bag.add_connection(topic, FLOAT, typestore=STORE)
            data = STORE.serialize_cdr(BagMessages().type(FLOAT)(data=value), FLOAT)
            bag.write(connections[topic], time, data)
    for source in (path, next(path.glob('*.db3'))):
        risks = [tick[0].risk for tick in replay(source, settings, kang)]
        # ticks at 100.0, 100.5, ... 104.0; braking from 101.0 on, off again at 103.0
        assert risks == pytest.approx([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def test_outputs_as_bag_and_table(tmp_path: Path, settings: MonitorSettings,
                                  kang: BrakeModel) -> None:
    bag = write_floats(tmp_path / 'in.mcap', float_messages(4.0))
    outputs = Outputs(tmp_path / 'out.mcap', settings)
    ticks = replay(bag, settings, kang)
    outputs.write(iter(ticks))
    with AnyReader([tmp_path / 'out.mcap']) as reader:  # by the definitions in the bag
        counts = {c.topic: c.msgcount for c in reader.connections}
        latched = {c.topic.rpartition('/')[2]: c.ext.offered_qos_profiles[0].depth
                   for c in reader.connections if c.ext.offered_qos_profiles[0].durability
                   == QosDurability.TRANSIENT_LOCAL}
        states = [reader.deserialize(data, connection.msgtype) for connection, _, data
                  in reader.messages() if connection.topic.endswith('/state')]
    assert counts == {**dict.fromkeys([f'/squeal_monitor/fl/{name}' for name in (
        *TYPES, 'state')], 9), '/diagnostics': 9, '/squeal_monitor/events': 2}
    assert latched == {'unstable_frequencies': 1, 'events': 50}
    # text, so that NaN equals NaN
    rows = list(read_rows(outputs.paths.table))
    assert repr(rows) == repr([row_of(a) for tick in ticks for a in tick])
    assert repr([(s.squeal_risk, s.growth_rate, tuple(s.frequencies_hz.tolist())) for s in states]
                ) == repr([(r.squeal_risk, r.growth_rate_1_s, r.unstable_frequencies_hz)
                           for r in rows])
    assert [(e.start_s, e.end_s) for e in outputs.events] == [(101.0, 102.5)]
    assert repr(squeal_events(rows, settings)) == repr(outputs.events)
    assert not [p for p in tmp_path.iterdir() if p.name.startswith('.') or p.suffix == '.part']


def test_diagnostics_as_the_node_publishes_them(tmp_path: Path, settings: MonitorSettings,
                                                kang: BrakeModel) -> None:
    """Each status once a second, in turn; all at first, and that of a brake on a new level."""
    path = write_floats(tmp_path / 'in.mcap', float_messages(4.0))
    chosen = replace(settings, rate=10.0)
    outputs = Outputs(tmp_path / 'out.mcap', chosen)
    write_replay(replay_of(path, chosen, kang), outputs)
    seen: dict[str, list[float]] = {}
    for _, time, message, _ in Bag(outputs.path).messages(
            {'/diagnostics': 'diagnostic_msgs/msg/DiagnosticArray'}):
        for status in message.status:
            seen.setdefault(status.name, []).append(time / SECOND)
    assert seen == {
        'squeal_monitor: fl': [100.0, 101.0, 102.0, 103.0, 103.4],  # 0.5 s after the last risk
        'squeal_monitor: node': [100.0, 100.5, 101.5, 102.5, 103.5]}


def test_replay_is_the_same_every_time(tmp_path: Path, settings: MonitorSettings,
                                       kang: BrakeModel) -> None:
    bag = write_floats(tmp_path / 'in.mcap', float_messages(3.0))
    first, second = (repr(replay(bag, settings, kang)) for _ in range(2))
    assert first == second


def test_clock_back_and_long_silence(tmp_path: Path, settings: MonitorSettings,
                                     kang: BrakeModel) -> None:
    entries = float_messages(2.0)
    later = [(topic, time + 3600 * SECOND, value) for topic, time, value in entries]
    bag = write_floats(tmp_path / 'a.mcap', entries + later)
    ticks = [t[0] for t in replay(bag, settings, kang)]
    assert len(ticks) < 40  # not one tick for each half second of the silent hour
    assert ticks[8].state == 'stale'
    assert ticks[-1].state == 'steady'


def fail(kind: str, path: Path) -> None:
    data = path.read_bytes()
    if kind == 'truncated':
        path.write_bytes(data[:60])
    elif kind == 'empty':
        path.write_bytes(b'')
    elif kind == 'text':
        path.write_text('speed,pressure\n')
    else:
        path.unlink()


@pytest.mark.parametrize('kind', ['truncated', 'empty', 'text', 'missing'])
def test_damaged_bag_is_one_clear_error_and_leaves_nothing(
        kind: str, tmp_path: Path, settings: MonitorSettings, kang: BrakeModel) -> None:
    bag = write_floats(tmp_path / 'in.mcap', float_messages(1.0))
    fail(kind, bag)
    outputs = Outputs(tmp_path / 'out.mcap', settings)
    with pytest.raises(BagError, match=r'in\.mcap: .*; ') as error:
        outputs.write(iter(replay_of(bag, settings, kang)))
    assert '\n' not in str(error.value)
    assert {p.name for p in tmp_path.iterdir()} <= {'in.mcap'}


def test_times_that_ros_cannot_hold_are_left_out_and_said(
        tmp_path: Path, settings: MonitorSettings, kang: BrakeModel) -> None:
    entries = float_messages(2.0)
    whole = replay_of(write_floats(tmp_path / 'in.mcap', entries), settings, kang)
    late = replay_of(write_floats(tmp_path / 'late.mcap', [
        *entries, ('/speed', 2**31 * SECOND, 20.0)]), settings, kang)
    assert [tick[0].time for tick in late] == [tick[0].time for tick in whole]
    assert '1 messages recorded before 1970 or after' in ' '.join(late.notes)


def test_bag_without_the_topics_names_them(tmp_path: Path, settings: MonitorSettings,
                                           kang: BrakeModel) -> None:
    bag = write_floats(tmp_path / 'in.mcap', [('/other', SECOND, 1.0)])
    with pytest.raises(BagError, match='/speed.*/other'):
        replay(bag, settings, kang)


def test_two_connections_of_one_topic_that_contradict_each_other(
        tmp_path: Path, settings: MonitorSettings, kang: BrakeModel) -> None:
    """As two publishers recorded apart and merged: the one that says 0 Pa hides no squeal."""
    library = BagMessages()
    with Writer(tmp_path / 'bag', version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        connections = {topic: bag.add_connection(topic, FLOAT, typestore=STORE)
                       for topic in ('/speed', '/fl/friction', '/pressure')}
        connections['second'] = bag.add_connection(
            '/pressure', FLOAT, typestore=STORE, offered_qos_profiles=[QOS])
        for topic, time, value in float_messages(4.0, step=0.02):
            for name, number in ((topic, value), *([('second', 0.0)] * (topic == '/pressure'))):
                data = STORE.serialize_cdr(library.type(FLOAT)(data=number), FLOAT)
                bag.write(connections[name], time + (name == 'second'), data)
    said = [tick[0] for tick in replay(tmp_path / 'bag', settings, kang)]
    assert [found.state for found in said] == [
        'released', 'released', 'steady', *['invalid'] * 4, *['released'] * 2]
    assert 'contradicted by another publisher' in said[4].reason
    assert 'until it has been steady for 0.5 s' in said[6].reason  # they agree since 0.02 s


def test_a_second_publisher_of_other_joints_is_no_finding(tmp_path: Path,
                                                          kang: BrakeModel) -> None:
    kind = 'sensor_msgs/msg/JointState'
    joints, library = STORE.types[kind], BagMessages()
    header = STORE.types['std_msgs/msg/Header'](
        STORE.types['builtin_interfaces/msg/Time'](0, 0), '')
    pressure = {'fl.pressure.topic': 'pressure', 'fl.pressure.type': FLOAT,
                'fl.pressure.field': 'data'}
    with BagWriter(tmp_path / 'in.mcap') as bag:
        for topic, time, value in float_messages(4.0):
            if topic != '/speed':
                bag.write(topic, FLOAT, time, library.type(FLOAT)(data=value))
                continue
            none = np.array([])
            for name, velocity in (('arm', [0.1]), ('fl_wheel_joint', [value])):
                bag.write('/joint_states', kind, time,
                          joints(header, [name], none, np.array(velocity), none))
    played = replay_of(tmp_path / 'in.mcap', read_settings({
        'brakes': ['fl'], 'rate': 2.0, **pressure}), kang)
    assert {tick[0].state for tick in played} == {'steady', 'released'}
    assert played.findings == []


def test_a_friction_that_is_no_number_while_the_brake_is_released(
        tmp_path: Path, settings: MonitorSettings, kang: BrakeModel) -> None:
    """As torque over pressure gives it; a made-up stop."""
    entries = float_messages(4.0)
    braked = {time for topic, time, value in entries if topic == '/pressure' and value}
    path = write_floats(tmp_path / 'in.mcap', [
        (topic, time, math.nan if topic == '/fl/friction' and time not in braked else value)
        for topic, time, value in entries])
    risks = [tick[0].risk for tick in replay(path, settings, kang)]
    assert risks == pytest.approx([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def test_a_long_drag_in_coarse_steps_is_not_stuck(tmp_path: Path, settings: MonitorSettings,
                                                  kang: BrakeModel) -> None:
    """Pressure in steps of 1 bar at 10 Hz, half a minute within one step."""
    random, entries = np.random.default_rng(0), []
    for tenth in range(450):
        time = 100 * SECOND + tenth * SECOND // 10
        pressure = 12.0 if tenth > 100 else abs(12.0 * math.sin(tenth / 5.0))
        entries += [('/speed', time, 25.0 + 0.02 * round(random.normal(0.0, 3.0))),
                    ('/fl/friction', time, 0.42 + random.normal(0.0, 0.003)),
                    ('/pressure', time, 1e5 * round(pressure))]
    bag = write_floats(tmp_path / 'in.mcap', entries)
    ticks = [tick[0] for tick in replay(bag, settings, kang)]
    assert len(ticks) == 91
    assert {found.state for found in ticks} == {'steady', 'released'}
    assert {found.state for found in ticks[22:]} == {'steady'}


def test_many_ticks_at_once_are_those_of_one_by_one(tmp_path: Path, kang: BrakeModel) -> None:
    """By a table, to the bits of the node."""
    assert kang.caliper is not None
    preload = kang.caliper.preload(7.84e5)
    table = build_table(kang, TableDomain.usual(
        kang, rotor_speed=(19.0, 21.0), preload=(0.9 * preload, 1.1 * preload),
        friction=(0.41, 0.43)))
    write_table(table, kang, tmp_path / 'table.npz')
    chosen = read_settings({'brakes': ['fl'], 'table': str(tmp_path / 'table.npz'), **{
        f'fl.{signal}.{key}': value for signal, topic in (
            ('rotor_speed', 'speed'), ('pressure', 'pressure'))
        for key, value in (('topic', topic), ('type', FLOAT), ('field', 'data'))}})
    random = np.random.default_rng(0)
    bag = write_floats(tmp_path / 'in.mcap', [
        (topic, time, value * random.uniform(0.98, 1.02))
        for topic, time, value in float_messages(4.0)])
    at_once = [tick[0] for tick in replay(bag, chosen, kang)]
    monitor, live = VehicleMonitor(chosen, kang), []
    signals: dict[str, Signal] = {
        '/speed': 'rotor_speed', '/pressure': 'pressure', '/fl/friction': 'friction'}
    for topic, time, message, _ in Bag(bag).messages(dict.fromkeys(signals, FLOAT)):
        monitor.receive('fl', signals[topic], Sample(time, message.data))
        if topic == '/pressure':  # the last one of each time, at which a tick is
            live += monitor.assess(time)
    assert repr(at_once) == repr(live)
    braking = [found.stability for found in at_once if found.stability]
    assert len(braking) == 20
    assert {found.modes.source for found in braking} == {'table'}
    assert [found.modes.mode_eigenvalues.tolist() for found in braking] == [
        found.stability.modes.mode_eigenvalues.tolist() for found in live if found.stability]
