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

"""A node on simulated time in step with what it has taken, and inputs played to it."""

from collections.abc import Iterator
from contextlib import contextmanager
import math
from typing import Any

from rclpy.time import Time
from sensor_msgs.msg import FluidPressure, JointState
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.vehicle_monitor import Sample
from std_msgs.msg import Float64, Header
from support.fault_times import (
    BEGIN,
    END,
    MAX_AGE,
    MEASURED,
    START,
    STEP,
    STUCK,
)
from support.faults import braking, Event, SECOND
from support.node_runs import vehicle
from support.vehicle import Vehicle

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
        self.wait, self.connected = car.wait, car.connected

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


def drive(acted: Stage, seconds: float, *, without: tuple[Signal, ...] = ()) -> None:
    """Go on with all inputs but some, to just after the last samples."""
    start = acted.now
    for event in braking(seconds, rate=20.0, signals=MEASURED, start=start + SECOND // 1000):
        acted.until(event.time)
        if event.signal not in without:
            acted.send(event.signal, event.sample)
