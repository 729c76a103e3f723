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

"""Messages of any content into the real node: it answers on, and never from what is no input."""

import math
from typing import Any

from hypothesis import given, HealthCheck, Phase, settings
from hypothesis import strategies as st
import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from builtin_interfaces.msg import Time  # noqa: E402, I100
from rclpy.serialization import serialize_message  # noqa: E402
from sensor_msgs.msg import FluidPressure, JointState  # noqa: E402
from std_msgs.msg import Float64, Header  # noqa: E402
from support.node_runs import vehicle  # noqa: E402
from support.processes import short_and_long  # noqa: E402
from support.vehicle import Vehicle  # noqa: E402

BATCH = 10  # messages an example and a topic
RANGES = {'rotor_speed': (-200.0, 200.0), 'pressure': (-1.05e5, 1.6e7), 'friction': (0.05, 0.9)}
STATUS = {'steady', 'released'}  # states in which there is a number

TEXT = st.text(st.characters(codec='utf-8'), max_size=8)
# fair values among all others, so that there are moments in which something is known
SPEED = st.sampled_from([20.0, 20.5, 21.0]) | st.sampled_from([20.0, 0.0, -20.0]) | st.floats()
PRESSURE = st.sampled_from([7.84e5, 8e5]) | st.sampled_from([0.0, 7.84e5]) | st.floats()
FRICTION = st.sampled_from([0.4, 0.42]) | st.sampled_from([0.3, 0.95]) | st.floats()
STAMP = st.none() | st.just(None) | st.builds(Time, sec=st.integers(-2**31, 2**31 - 1),
                                              nanosec=st.integers(0, 2**32 - 1))
NAMES = st.lists(st.just('fl_wheel_joint') | TEXT, max_size=3)
JOINTS = st.builds(lambda names, speeds, positions: JointState(
    name=names, velocity=speeds, position=positions), NAMES | st.just(['fl_wheel_joint']),
    st.lists(SPEED, max_size=3) | st.lists(SPEED, min_size=1, max_size=1),
    st.lists(st.floats(), max_size=2))
PRESSURES = st.builds(FluidPressure, fluid_pressure=PRESSURE, variance=st.floats())
# bytes that are no message, or another one: cut, spliced, with any bit turned
DAMAGE = st.none() | st.just(None) | st.just(None) | st.tuples(
    st.floats(0.0, 1.0), st.integers(0, 12), st.binary(max_size=12))


def batch(messages: Any) -> Any:
    """Messages of one topic: content, stamp or None for the present, damage or None."""
    return st.lists(st.tuples(messages, STAMP, DAMAGE), min_size=BATCH, max_size=BATCH)


STORM = st.tuples(batch(JOINTS), batch(PRESSURES),
                  batch(st.builds(Float64, data=FRICTION)))


def encode(message: Any, stamp: Any, damage: Any, now: Any) -> bytes:
    if hasattr(message, 'header'):
        message.header = Header(stamp=now if stamp is None else stamp, frame_id='é')
    data = bytes(serialize_message(message))
    if damage is None:
        return data
    where, cut, spliced = damage
    at = round(where * len(data))
    damaged = data[:at] + spliced + data[at + cut:]
    # the middleware publishes nothing longer than a message of bounded size can be
    return damaged if hasattr(message, 'header') else damaged[:len(data)]


class Storm:
    """Plays storms to a node and checks what it says in them."""

    def __init__(self, car: Vehicle) -> None:
        self._car, self.sent, self.known = car, 0, 0
        self._publishers = [car._publishers[s] for s in RANGES]
        self._inputs = car.monitor._configured.inputs

    def _taken(self) -> int:
        return sum(topic.received for topic in self._inputs._topics.values())

    def play(self, storm: Any) -> None:
        car, before = self._car, self._taken()
        now = car.now
        for publisher, messages in zip(self._publishers, storm, strict=True):
            for message in messages:
                publisher.publish(encode(*message, now))
        count = BATCH * len(RANGES)
        self.sent += count
        car.silent = set(car._publishers)
        car.step()
        assert self._taken() - before == count
        self.check()

    def check(self) -> None:
        """Return what the node last said: a number only of inputs that are good."""
        assert -1.0 <= self._car.risk <= 1.0 or math.isnan(self._car.risk)
        if self._car.status is None:
            return
        values = {item.key: item.value for item in self._car.status.values}
        if values['state'] not in STATUS:
            assert math.isnan(float(values['squeal_risk']))
            assert self._car.status.message
            return
        self.known += 1
        for signal, (low, high) in RANGES.items():
            if values['state'] == 'released' and signal == 'friction':
                continue  # it is not needed
            assert values[f'{signal}_status'] == 'good'
            assert 0.0 <= float(values[f'{signal}_age_s']) <= 0.5
            assert low <= float(values[f'{signal}_input']) <= high


def reliable() -> dict[str, Any]:
    topics = ('/joint_states', '/fl/brake_pressure', '/fl/friction')
    return {f'qos_overrides.{topic}.subscription.{policy}': value for topic in topics
            for policy, value in (('reliability', 'reliable'), ('depth', 100))}


@short_and_long('count', 3000, 100_000, minutes=30.0)
def test_messages_of_any_content(count: int) -> None:
    with vehicle(rate=50.0, diagnostics_rate=50.0, **reliable()) as car:
        car.until(lambda: car.risk > 0.99)
        storm = Storm(car)
        # nothing is shrunk: a node remembers what came before
        settings(max_examples=-(-count // (BATCH * len(RANGES))), database=None,
                 suppress_health_check=list(HealthCheck), phases=[Phase.generate])(
            given(STORM)(storm.play))()
        assert storm.sent >= count
        print(f'\n{storm.sent} messages, {storm.known} moments with a number, '
              f'{storm._inputs.undecodable} undecodable')
        assert storm.known > 0
        assert storm._inputs.undecodable > 0
        assert car.monitor.health.errors == 0
        car.silent = set()
        car.said.clear()
        # the guards forgive within a minute at most: what looked like rpm is doubted so long
        car.monitor.trigger_deactivate()
        car.monitor.trigger_activate()
        car.until(lambda: car.risk > 0.99)
