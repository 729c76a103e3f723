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

"""
Faults of inputs through real DDS: no number past the limit, the cause named, quick recovery.

Simulated time goes on in step with what the node has taken, so nothing hangs on the machine's
speed. `test_faults.py` plays every fault on every input of the monitor without a node.
"""

import math
import re

import pytest
from support.faults import FAULTS, NODE_FAULTS, SECOND

pytest.importorskip('rclpy', reason='needs rclpy')

from squeal_core.monitor.setting_specs import Signal  # noqa: E402, I100
from std_msgs.msg import Float32, Float64  # noqa: E402
from support.fault_times import (  # noqa: E402
    bad,
    BEGIN,
    END,
    FAIR,
    MAX_AGE,
    MEASURED,
    START,
)
from support.node_runs import stranger  # noqa: E402
from support.stages import drive, stage, STREAM, TOPICS, TYPES  # noqa: E402

# where time and order of receipt and stamps count; what the monitor makes of the others needs none
SHORT = [('off', 'friction'), ('delayed', 'pressure'), ('out of order', 'rotor_speed')]
# without a stamp the time of receipt counts, and friction has none
STAMPED = {'delayed', 'future stamp'}
LONG = [(name, signal) for name in FAULTS for signal in MEASURED if name != 'zero stamp'
        and not (name in STAMPED and signal == 'friction')
        and (name, signal) not in {*SHORT, *FAIR}]


@pytest.mark.parametrize(('name', 'signal'), [
    *SHORT, *(pytest.param(*case, marks=pytest.mark.soak) for case in LONG)])
def test_fault(name: str, signal: Signal) -> None:
    fault = FAULTS[name]
    stream = fault.apply(STREAM, signal, START, END)
    wrong = known = 0
    with stage() as (acted, car):
        for tick in acted.play(stream):
            if tick < START - SECOND // 2:
                continue
            if tick <= START or tick >= END + MAX_AGE:
                assert acted.risk >= 0.0, (tick - BEGIN, car.status.message)
                known += 1
            elif START < tick < END and bad(fault, signal, stream, tick):
                assert math.isnan(acted.risk)
                assert re.fullmatch(f'{signal} {fault.cause}.*', car.status.message)
                assert car.status.level in (b'\x02', b'\x03')
                wrong += 1
        assert car.figures['errors'] == '0'
    assert (wrong > 3) == (fault.kind != 'harmless')
    assert known >= 8  # half a second before it, nearly as long after


@pytest.mark.usefixtures('often')
@pytest.mark.parametrize(('name', 'signal'), zip(
    NODE_FAULTS, ('friction', 'rotor_speed'), strict=True))
def test_another_publisher(name: str, signal: Signal) -> None:
    """An input's publisher ends; after a while one in another process takes over."""
    with stage() as (acted, car), stranger(car) as other:
        drive(acted, 0.5)
        assert acted.risk >= 0.0
        car.node.destroy_publisher(acted.publishers[signal])
        if name == 'type changed':
            wrong = other.create_publisher(Float32, TOPICS[signal], 10)
            said = f'{TOPICS[signal]}: /stranger publishes std_msgs/msg/Float32, and '

            def named() -> bool:
                wrong.publish(Float32(data=0.4))
                drive(acted, 0.1, without=(signal,))
                return str(car.node_status.message).startswith(said)

            acted.wait(named, 'the wrong type')
            assert car.figures['wrong_publishers'] == '1'
            other.destroy_publisher(wrong)
        drive(acted, 0.8, without=(signal,))
        assert math.isnan(acted.risk)
        assert re.fullmatch(rf'{signal} is \d\.\d\d s old: .*', car.status.message)
        fresh = other.create_publisher(TYPES[signal], TOPICS[signal], 10)
        acted.connected(fresh, 1)
        acted.publishers[signal] = fresh
        drive(acted, 0.15)  # a sample of each, and a tick
        assert acted.risk >= 0.0
        assert car.status.level < b'\x02'
        assert car.figures['dropped_messages'] == car.figures['errors'] == '0'


def test_a_publisher_that_is_replaced_at_once_is_not_missed() -> None:
    with stage() as (acted, car), stranger(car) as other:
        for count in range(4):
            drive(acted, 0.3)
            assert acted.risk >= 0.0
            old, node = acted.publishers['friction'], (other, car.node)
            acted.publishers['friction'] = new = node[count % 2].create_publisher(
                Float64, TOPICS['friction'], 10)
            acted.connected(new, 2)
            node[(count + 1) % 2].destroy_publisher(old)
            acted.connected(new, 1)  # else the old one may be taken for the next new one
        assert car.figures['dropped_messages'] == '0'


@pytest.mark.usefixtures('often')
def test_one_that_stood_by_has_dropped_nothing() -> None:
    """It counts its messages from a number of its own, far from that of the one before."""
    with stage() as (acted, car), stranger(car) as other:
        def sees(count: int) -> None:
            """Go on until the node has looked at the graph and found so many publishers."""
            acted.wait(lambda: car.monitor.count_publishers(TOPICS['friction']) == count, 'graph')
            drive(acted, 0.1, without=('friction',))

        drive(acted, 0.3)
        standby = other.create_publisher(Float64, TOPICS['friction'], 10)
        acted.connected(standby, 2)
        sees(2)
        for _ in range(300):
            standby.publish(Float64(data=0.42))
        drive(acted, 0.3)  # the last number is the old one's
        car.node.destroy_publisher(acted.publishers['friction'])
        sees(1)
        acted.publishers['friction'] = standby
        drive(acted, 0.3)
        assert acted.risk >= 0.0
        assert car.figures['dropped_messages'] == '0'
