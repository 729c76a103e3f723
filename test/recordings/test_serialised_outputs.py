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

"""Bytes of the outputs against those that rosbags makes of message objects."""

from dataclasses import replace
import math

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.model.brake_model import BrakeModel  # noqa: E402
from squeal_core.monitor.results.history import row_of  # noqa: E402
from squeal_core.monitor.settings import read_settings  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Assessment, Sample, VehicleMonitor  # noqa: E402
from squeal_core.stability.eigensolution import Mode  # noqa: E402
from squeal_ros.node import messages  # noqa: E402
from squeal_ros.node.state_message import serialised_state, TYPE  # noqa: E402
from squeal_ros.recordings.bags.typestore import BagMessages, JAZZY  # noqa: E402
from squeal_ros.recordings.replay.serialised_outputs import serialised_outputs  # noqa: E402
from squeal_ros.recordings.replay.tick_record import TickRecord  # noqa: E402

TIME = 1_700_000_000_123_456_789
NODE = '/squeal_monitor'


@pytest.fixture(scope='module')
def tick(kang: BrakeModel) -> tuple[Assessment, ...]:
    """Return a braking, a released, a silent and an invalid brake."""
    settings = read_settings({})
    monitor = VehicleMonitor(settings, kang)
    for brake, pressure in (('front_left', 7.84e5), ('front_right', 0.0), ('rear_right', 9e8)):
        for signal, value in (('rotor_speed', 20.0), ('pressure', pressure), ('friction', 0.42)):
            monitor.receive(brake, signal, Sample(TIME - 1000, value))  # type: ignore[arg-type]
    return monitor.assess(TIME)


def check(assessments: tuple[Assessment, ...], status: messages.NodeStatus) -> None:
    """Compare message by message with the type store's own."""
    library, levels, expected = BagMessages(), [0, 1, 2, 3][:len(assessments)], {}
    statuses, time = messages.statuses(NODE[1:], assessments, levels, status), assessments[0].time
    for assessment in assessments:
        for name, message in messages.brake_messages(library, assessment):
            expected[f'{NODE}/{assessment.brake}/{name}'] = messages.TYPES[name], message
        expected[f'{NODE}/{assessment.brake}/state'] = TYPE, JAZZY.deserialize_cdr(
            serialised_state(assessment), TYPE)  # what it holds: test/node/test_state_message.py
    expected['/diagnostics'] = messages.DIAGNOSTICS_TYPE, messages.diagnostics(
        library, time, statuses)
    expected[f'{NODE}/events'] = messages.DIAGNOSTICS_TYPE, messages.diagnostics(
        library, time, statuses[:1])
    record = TickRecord(time, [*map(row_of, assessments)],
                        [*map(serialised_state, assessments)], statuses, statuses[:1])
    seen = {}
    for topics, kind, data in serialised_outputs(NODE, record):
        size = len(data) // len(topics)
        seen |= {topic: (kind, data[place * size:(place + 1) * size])
                 for place, topic in enumerate(topics)}
    assert list(seen) == list(expected)  # in order
    for topic, (kind, message) in expected.items():
        assert seen[topic] == (kind, bytes(JAZZY.serialize_cdr(message, kind))), topic


def test_states(tick: tuple[Assessment, ...]) -> None:
    assert [one.state for one in tick] == ['steady', 'released', 'stale', 'invalid']
    check(tick, messages.NodeStatus({'ticks_done': 1}))


@pytest.mark.parametrize('count', range(10))
def test_texts_and_lists_of_any_length(tick: tuple[Assessment, ...], count: int) -> None:
    """Padding depends on each length; texts may be no ASCII."""
    modes = tuple(Mode(i, complex(1.0, 1e4 + i), 'flutter') for i in range(count))
    odd = replace(tick[0], brake='b' * (count + 1), reason='µ' * count, modes=modes,
                  risk=math.inf, growth_rate=-math.nan, friction_source='x' * count)
    check((odd, replace(tick[1], reason='')), messages.NodeStatus(
        {'k' * count: 'v' * (9 - count), '': count, 'last': '£' * count}, message='m' * count))
    check((odd,), messages.NodeStatus({}))
