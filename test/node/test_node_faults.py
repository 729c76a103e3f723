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

from collections.abc import Iterator
from contextlib import contextmanager
import math
import re
from typing import Any

import pytest
from support.faults import braking, Event, FAULTS, NODE_FAULTS, SECOND

pytest.importorskip('rclpy', reason='needs rclpy')

from rclpy.time import Time  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState  # noqa: E402
from squeal_core.monitor.settings import Signal  # noqa: E402
from squeal_core.monitor.vehicle_monitor import Sample  # noqa: E402
from squeal_ros.node import subscriptions as input_topics  # noqa: E402
from std_msgs.msg import Float32, Float64, Header  # noqa: E402
from support.harness import Vehicle, vehicle  # noqa: E402, I100
from test_faults import (  # noqa: E402
    bad,
    BEGIN,
    END,
    FAIR,
    MAX_AGE,
    MEASURED,
    START,
    STEP,
    STUCK,
)
from test_node_inputs import stranger  # noqa: E402

TOPICS: dict[Signal, str] = {'rotor_speed': 'joint_states', 'pressure': 'fl/brake_pressure',
                             'friction': 'fl/friction'}
TYPES: dict[Signal, Any] = {'rotor_speed': JointState, 'pressure': FluidPressure,
                            'friction': Float64}
# samples fall between ticks, so that it is plain which tick sees them
STREAM = [event for event in braking(8.0, rate=20.0, signals=MEASURED,
                                     start=BEGIN + SECOND // 1000)
          if START - SECOND < event.time < END + MAX_AGE + SECOND // 2]


class Stage:
    """A node whose time goes on only when it has taken what was published."""

    def __init__(self, car: Vehicle) -> None:
        self._car = car
        car.set_time(BEGIN)
        car.meet()
        self.publishers: dict[Signal, Any] = {s: car._publishers[s] for s in TOPICS}
        self.wait = car.wait

    def send(self, signal: Signal, sample: Sample) -> None:
        """Publish a value, and wait until the node has taken it."""
        header = Header(stamp=Time(nanoseconds=sample.stamp).to_msg())
        message = Float64(data=sample.value)
        if signal == 'rotor_speed':
            message = JointState(header=header, name=['fl_wheel_joint'], velocity=[sample.value])
        elif signal == 'pressure':
            message = FluidPressure(header=header, fluid_pressure=sample.value)
        before = self._taken(signal)
        self.publishers[signal].publish(message)
        self.wait(lambda: self._taken(signal) > before, signal)

    def connected(self, publisher: Any, count: int) -> None:
        """Wait until a publisher and the node know of each other, of so many on its topic."""
        self.wait(publisher.get_subscription_count, 'the subscription')
        self.wait(lambda: [topic.get_publisher_count() for topic in self._car.monitor.subscriptions
                           if topic.topic_name == publisher.topic_name] == [count],
                  'the new publisher')

    def _taken(self, signal: Signal) -> int:
        figures = self._car.monitor._configured.inputs.values(0)
        return int(str(figures[f'{TOPICS[signal]} received']))

    @property
    def now(self) -> int:
        assert self._car.simulated is not None
        return self._car.simulated

    def until(self, now: int) -> None:
        """Let time pass [ns]; hear what the node says at each tick on the way."""
        for instant in (*range((self.now // STEP + 1) * STEP, now + 1, STEP), now):
            self._car.set_time(instant)
            assert self._car.stamp == instant // STEP * STEP

    @property
    def risk(self) -> float:
        """Return the risk in the last diagnostics."""
        values = {item.key: item.value for item in self._car.status.values}
        assert math.isnan(float(values['squeal_risk'])) == (values['state'] != 'steady')
        assert str(self._car.risk) == values['squeal_risk']
        return self._car.risk

    def play(self, events: list[Event]) -> Iterator[int]:
        """Publish events at their times; yield each tick, after the node spoke."""
        for event in events:
            for tick in range((self.now // STEP + 1) * STEP, event.time, STEP):
                self.until(tick)
                yield tick
            self.until(event.time)
            self.send(event.signal, event.sample)


@contextmanager
def stage(**values: Any) -> Iterator[tuple[Stage, Vehicle]]:
    stuck = {f'fl__{signal}__stuck_after': STUCK / SECOND for signal in TOPICS}
    with vehicle(rate=SECOND / STEP, stuck_changes=10.0, **stuck, **values) as car:
        yield Stage(car), car


SHORT = [('off', 'friction'), ('stuck', 'rotor_speed'), ('NaN', 'friction'),
         ('wrong unit', 'pressure'), ('delayed', 'pressure'), ('out of order', 'rotor_speed')]
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


def drive(acted: Stage, seconds: float, *, without: tuple[Signal, ...] = ()) -> None:
    """Go on with all inputs but some, to just after the last samples."""
    start = acted.now
    for event in braking(seconds, rate=20.0, signals=MEASURED, start=start + SECOND // 1000):
        acted.until(event.time)
        if event.signal not in without:
            acted.send(event.signal, event.sample)


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the node look at the graph whenever it speaks, not once a second."""
    monkeypatch.setattr(input_topics, '_LOOK_PERIOD', 0)


@pytest.mark.usefixtures('often')
@pytest.mark.parametrize('signal', ['friction', 'rotor_speed'])
@pytest.mark.parametrize('name', NODE_FAULTS)
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
