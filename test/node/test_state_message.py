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

"""squeal_msgs/BrakeSqueal: what it holds, heard in another process, and without the package."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
import json
import math
import os
from pathlib import Path
import subprocess
import sys
from types import ModuleType
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='needs rclpy')
pytest.importorskip('rosbags', reason='needs rosbags')

from rclpy.serialization import deserialize_message, serialize_message  # noqa: E402
from rosbags.highlevel import AnyReader  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Assessment  # noqa: E402
from squeal_core.stability.eigensolution import Mode  # noqa: E402
from squeal_ros.node.message_types import RosMessages  # noqa: E402
from squeal_ros.node.messages import NUMBERS  # noqa: E402
from squeal_ros.node.publishers import why_no_state  # noqa: E402
from squeal_ros.node.state_message import CODES, FIELDS, serialised_state, TYPE  # noqa: E402
from squeal_ros.recordings.bags.bag_writer import BagWriter  # noqa: E402
from squeal_ros.recordings.bags.typestore import JAZZY  # noqa: E402
from support.node_runs import needs_squeal_msgs, vehicle  # noqa: E402, I100
from support.processes import process  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

TIME = 1_700_000_000_123_456_789
TOPIC = '/squeal_monitor/fl/state'
# knows squeal_msgs alone, as another workspace would; says what it hears, a line a message
SUBSCRIBER = """
import json, sys
sys.modules.update(squeal_core=None, squeal_ros=None)
import rclpy
from squeal_msgs.msg import BrakeSqueal

def hear(message):
    said = {name: getattr(message, name) for name in message.get_fields_and_field_types()}
    stamp = said.pop('header').stamp
    said = {name: list(v) if hasattr(v, 'typecode') else v for name, v in said.items()}
    print(json.dumps({'time': stamp.sec * 10**9 + stamp.nanosec, **said}), flush=True)

rclpy.init()
node = rclpy.create_node('listener')
subscription = node.create_subscription(BrakeSqueal, sys.argv[1], hear, 100)
while not subscription.get_publisher_count():  # what comes before is lost
    rclpy.spin_once(node, timeout_sec=0.02)
print('ready', flush=True)
rclpy.spin(node)
"""


@contextmanager
def listener(car: Vehicle, folder: Path) -> Iterator[Iterator[dict[str, Any]]]:
    """Run a subscriber in a process of its own; yield what it hears, as it hears it."""
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(car.context.get_domain_id())}
    with process(['-P', '-c', SUBSCRIBER, TOPIC], environment, cwd=folder, text=True,
                 stdout=subprocess.PIPE) as started:
        (publisher,) = [p for p in car.monitor.publishers if p.topic_name == TOPIC]
        car.wait(lambda: publisher.get_subscription_count() or started.poll(), 'a subscriber')
        assert started.stdout.readline() == 'ready\n'
        yield map(json.loads, started.stdout)


def heard_at(heard: Iterator[dict[str, Any]], car: Vehicle) -> dict[str, Any]:
    """Return what was heard of the tick that the other topics spoke of last."""
    return next(said for said in heard if said['time'] == car.stamp)


@needs_squeal_msgs
def test_a_process_that_has_only_squeal_msgs_hears_what_the_topics_say(tmp_path: Path) -> None:
    with vehicle() as car, listener(car, tmp_path) as heard:
        # the first tick of an application is its start: nothing has grown yet
        car.until(lambda: car.risk > 0.0 and car.said['build_up'].data > 0.0, 'a build-up')
        said = heard_at(heard, car)
        assert (said['brake'], said['state']) == ('fl', CODES['steady'])
        for name in NUMBERS:
            assert repr(said[name]) == repr(car.said[name].data), name
        assert said['frequencies_hz'] == list(car.said['unstable'].data)
        assert len(said['mode_numbers']) == len(said['frequencies_hz']) > 1
        by_frequency = sorted(zip(said['frequencies_hz'], said['mode_numbers'], strict=True))
        assert [number for _, number in by_frequency] == sorted(said['mode_numbers'])
        assert said['growth_rates'] == sorted(said['growth_rates'], reverse=True)
        for zeta, sigma, hz in zip(
                [said['damping_ratio'], *said['damping_ratios']],
                [said['growth_rate'], *said['growth_rates']],
                [said['frequency_hz'], *said['frequencies_hz']], strict=True):
            assert zeta == pytest.approx(-sigma / math.hypot(sigma, math.tau * hz), rel=1e-12)
        assert len(said['build_ups']) == len(said['mode_numbers'])
        known = [value for value in said['build_ups'] if not math.isnan(value)]
        assert max(known) == said['build_up'] > 0.0  # of one brake; NaN: below the squeal band
        car.pressure = 0.0
        car.until(lambda: car.risk == 0.0, 'the release')
        said = heard_at(heard, car)
        assert (said['state'], said['squeal_risk'], said['mode_numbers']) == (
            CODES['released'], 0.0, [])
        car.monitor.trigger_deactivate()  # its last word
        said = next(said for said in heard if said['state'] != CODES['released'])
        assert said['state'] == CODES['stale']
        assert math.isnan(said['squeal_risk'])


@needs_squeal_msgs
def test_the_type_is_the_one_of_the_definition() -> None:
    """By the hash that DDS discovery and bags carry: a subscriber of another version is told."""
    with vehicle() as car:
        (info,) = car.node.get_publishers_info_by_topic(TOPIC)
        assert info.topic_type == TYPE
        assert str(info.topic_type_hash) == JAZZY.hash_rihs01(TYPE)


def assessments() -> list[Assessment]:
    """Return one of each state; the steady ones with no to three modes."""
    modes = [Mode(13, complex(21.5, 10437.25), 'flutter'), Mode(7, 3.5 + 0.0j, 'divergence'),
             Mode(25, complex(7.75, 20174.5), 'flutter'), Mode(92, complex(0.5, 9e4), 'flutter')]
    known = Assessment(brake='front_left', time=TIME, state='steady', reason='', risk=0.875,
                       growth_rate=21.5, worst_frequency_hz=1661.125, friction_margin=-0.25)
    return [*(replace(known, brake='b' * count, modes=tuple(modes[:count])) for count in range(5)),
            replace(known, state='released', risk=0.0),
            *(Assessment(brake='rear', time=TIME, state=state, reason='')
              for state in CODES if state not in ('steady', 'released'))]


def test_the_record_of_an_assessment() -> None:
    found = JAZZY.deserialize_cdr(serialised_state(assessments()[3]), TYPE)
    assert (found.brake, found.state) == ('bbb', 1)
    assert (found.squeal_risk, found.frequency_hz, found.growth_rate, found.friction_margin) == (
        0.875, 1661.125, 21.5, -0.25)
    assert list(found.mode_numbers) == [13, 25]  # two of three modes oscillate
    assert list(found.growth_rates) == [21.5, 7.75]
    assert found.frequencies_hz == pytest.approx([10437.25 / math.tau, 20174.5 / math.tau])
    assert found.damping_ratios == pytest.approx(
        [-21.5 / abs(21.5 + 10437.25j), -7.75 / abs(7.75 + 20174.5j)])
    assert list(map(math.isnan, found.build_ups)) == [True, True]


@pytest.mark.parametrize('number', range(len(assessments())))
def test_the_bytes_are_those_that_rosbags_writes(number: int) -> None:
    data = serialised_state(assessments()[number])
    assert bytes(JAZZY.serialize_cdr(JAZZY.deserialize_cdr(data, TYPE), TYPE)) == data


def test_the_constants_of_the_definition_are_the_states() -> None:
    constants, _ = JAZZY.fielddefs[TYPE]
    assert {name: value for name, _, value in constants} == {
        state.upper().replace(' ', '_'): code for state, code in CODES.items()}


@needs_squeal_msgs
def test_rclpy_and_rosbags_read_the_same(tmp_path: Path) -> None:
    kind, path = RosMessages().type(TYPE), tmp_path / 'state.mcap'
    heard = [deserialize_message(serialised_state(one), kind) for one in assessments()]
    with BagWriter(path) as bag:  # as a recorder would, what rclpy makes of a message
        for number, message in enumerate(heard):
            bag.write(TOPIC, TYPE, TIME + number, bytes(serialize_message(message)))
    with AnyReader([path]) as reader:  # by the definition in the bag
        read = [reader.deserialize(data, connection.msgtype)
                for connection, _, data in reader.messages()]
    assert len(read) == len(heard)
    for found, message in zip(read, heard, strict=True):
        for name in FIELDS:
            mine, theirs = getattr(message, name), getattr(found, name)
            if name == 'header':
                mine, theirs = ([one.stamp.sec, one.stamp.nanosec, one.frame_id]
                                for one in (mine, theirs))
            elif not isinstance(mine, str | int | float):
                mine, theirs = mine.tolist(), theirs.tolist()
            assert repr(mine) == repr(theirs), name


def test_without_the_package_the_node_says_so_once_and_goes_on(
        monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, 'squeal_msgs.msg', None)  # as if it were not there
    with vehicle() as car:
        car.until(lambda: car.risk >= 0.0, 'a risk')
        assert TOPIC not in [publisher.topic_name for publisher in car.monitor.publishers]
        assert {'growth_rate', 'friction_margin', 'unstable', 'diagnostics'} <= car.said.keys()
        for transition in ('deactivate', 'cleanup', 'configure', 'activate'):
            getattr(car.monitor, f'trigger_{transition}')()
        assert car.monitor.health.errors == 0
    said = [line for line in capfd.readouterr().err.splitlines() if '/state' in line]
    assert len(said) == 1
    assert '[INFO]' in said[0]
    assert 'squeal_msgs is not installed here' in said[0]


class _Other:
    """What is no BrakeSqueal of this checkout, or one without its libraries."""

    fields = {'brake': 'string'}

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        return cls.fields


def test_a_package_that_cannot_be_used_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType('squeal_msgs.msg')
    monkeypatch.setitem(sys.modules, 'squeal_msgs.msg', module)
    assert 'not installed' in why_no_state(RosMessages())
    module.BrakeSqueal = _Other  # type: ignore[attr-defined]
    assert 'another version' in why_no_state(RosMessages())
    monkeypatch.setattr(_Other, 'fields', FIELDS)
    assert 'cannot be used' in why_no_state(RosMessages())
