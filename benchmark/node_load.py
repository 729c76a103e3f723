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
Load and lateness of the node: four brakes at 100 Hz, all braking all the time, or in a drive.

Run: python benchmark/node_load.py [--seconds 30] [--warm-up 300] [--rate 100] [--still]
     [--drive us06] [--table TABLE.npz] [--in-step 300]

With --in-step N the clock is simulated and goes on when the node has assessed: its processor time
for N ticks, whatever else the machine does.
With --drive the signals are those of the shipped vehicle in that drive, --seconds of it, once.

The node is a process of its own, as on the vehicle; the CPU time of its threads is read from
/proc. Workers are the threads that give way to the ticks, in the order in which they began; the
rest is the middleware's. Lateness is from the tick, a multiple of the period in ROS time, to the
receipt of a brake's risk here: of two that come within one period the first is the one before's.
Lost ticks are those that the node counts. The processor time of a tick made hardly depends on what
else the machine does; it includes receiving, publishing and diagnostics.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse  # noqa: I100
from collections import Counter
from collections.abc import Callable
from contextlib import contextmanager
from functools import partial
import math
import os
from pathlib import Path
import re
import subprocess
import sys
import time
from typing import Any, TypeAlias

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from drives import drive_signals, DRIVES
import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

from squeal_core import BrakeModel  # noqa: I100
from squeal_core.monitor.settings import NODE_NAME

Inputs: TypeAlias = Callable[[float], tuple[Any, Any, Any]]
BRAKES = ('front_left', 'front_right', 'rear_left', 'rear_right')
TICKS = os.sysconf('SC_CLK_TCK')
_FIRST = 20  # ticks that are not counted: code and pages are loaded in them


def swept(time: float) -> tuple[Any, Any, Any]:
    """Return rotor speeds, pressures and frictions (4,) of brakes that brake for ever."""
    speed = 40.0 + 35.0 * math.sin(0.3 * time)  # a braking from 75 to 5 rad/s takes 10 s
    pressure = 1.5e6 + 5e5 * math.sin(1.1 * time)
    return (speed * (1.0 + 0.001 * np.arange(4)), pressure * np.array([1.0, 1.0, 0.8, 0.8]),
            np.full(4, 0.42 + 0.02 * math.sin(0.2 * time)))


def driven(drive: str, rate: float) -> Inputs:
    """Return these of a drive; its end lasts."""
    signals = drive_signals(BrakeModel.load('kang2009'), drive, rate)

    def inputs(time: float) -> tuple[Any, Any, Any]:
        row = min(round(time * rate), len(signals.time) - 1)
        return signals.rotor_speed[row], signals.pressure[row], signals.friction[row]

    return inputs


class Vehicle:
    """Publishes three signals of four brakes, and hears what the node says."""

    def __init__(self, node: Any, rate: float, inputs: Inputs) -> None:
        self.node, self.period, self.inputs = node, round(1e9 / rate), inputs
        self.receipts: dict[str, list[int]] = {brake: [] for brake in BRAKES}
        self.figures: dict[str, str] = {}
        self.heard: Counter[str] = Counter()
        self.begin = time.monotonic()
        self.joints = node.create_publisher(JointState, 'joint_states', 10)
        self.publishers = [(node.create_publisher(FluidPressure, f'{brake}/brake_pressure', 10),
                            node.create_publisher(Float64, f'{brake}/friction', 10))
                           for brake in BRAKES]
        for brake in BRAKES:
            node.create_subscription(
                Float64, f'/squeal_monitor/{brake}/squeal_risk', partial(self.hear, brake), 10)
        node.create_subscription(DiagnosticArray, '/diagnostics', self.note, 10)
        self.timer = node.create_timer(1.0 / rate, self.publish_now)

    def hear(self, brake: str, message: Float64) -> None:
        self.heard[brake] += 1
        if not math.isnan(message.data):
            self.receipts[brake].append(self.node.get_clock().now().nanoseconds)

    def lateness(self) -> np.ndarray:
        """Return how late each risk came [ms]."""
        return np.concatenate([late(np.array(times), self.period)
                               for times in self.receipts.values()])

    def note(self, message: DiagnosticArray) -> None:
        self.figures |= {item.key: item.value for status in message.status
                         if status.name == f'{NODE_NAME}: node' for item in status.values}

    def ticks(self) -> tuple[int, int]:
        """Return how many ticks the node made and how many it lost, by its last diagnostics."""
        return int(self.figures.get('ticks_done', 0)), int(self.figures.get('ticks_lost', 0))

    def publish_now(self) -> None:
        self.publish(time.monotonic() - self.begin, self.node.get_clock().now().to_msg())

    def publish(self, passed: float, stamp: Any) -> None:
        speed, pressed, friction = self.inputs(passed)
        joints, pressure = JointState(), FluidPressure()
        joints.header.stamp = pressure.header.stamp = stamp
        joints.name = [f'{brake}_wheel_joint' for brake in BRAKES]
        joints.velocity = speed.tolist()
        self.joints.publish(joints)
        for i, (pressures, frictions) in enumerate(self.publishers):
            pressure.fluid_pressure = float(pressed[i])
            pressures.publish(pressure)
            frictions.publish(Float64(data=float(friction[i])))


def late(receipts: np.ndarray, period: int) -> np.ndarray:
    """Return receipts less the ticks they are of [ms]: no two of them are of the same tick."""
    ticks = receipts // period
    for i in range(len(ticks) - 1, 0, -1):
        ticks[i - 1] = min(ticks[i - 1], ticks[i] - 1)
    return 1e-6 * (receipts - ticks * period)


def cpu_times(process: int) -> Counter[str]:
    """Return the CPU time of each part of a process [s]."""
    times: Counter[str] = Counter()
    workers = 0
    for thread in sorted(Path(f'/proc/{process}/task').iterdir(), key=lambda path: int(path.name)):
        fields = (thread / 'stat').read_text().rpartition(')')[2].split()
        gives_way = int(fields[16]) > 0  # its nice value
        workers += gives_way
        part = (f'worker {workers}' if gives_way else
                'main thread' if thread.name == str(process) else 'middleware')
        times[part] += (int(fields[11]) + int(fields[12])) / TICKS
    return times


def memory(process: int) -> int:
    """Return the resident memory of a process [MB]."""
    status = Path(f'/proc/{process}/status').read_text()
    return round(int(re.findall(r'VmRSS:\s+(\d+) kB', status)[0]) / 1024)


@contextmanager
def monitor(rate: float, table: str, *more: str) -> Any:
    """Run the node as a process."""
    code = 'import sys; from squeal_ros.node.lifecycle_node import main; sys.exit(main())'
    process = subprocess.Popen([sys.executable, '-c', code, '--ros-args', '-p', f'rate:={rate}',
                                '-p', f"table:='{table}'", *more],
                               stderr=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.terminate()
        process.wait()


def measure(name: str, vehicle: Vehicle, executor: Any, process: int, seconds: float) -> None:
    """Let the node run for a while and print how it did."""
    for times in vehicle.receipts.values():
        times.clear()
    start, used, ticks = time.monotonic(), cpu_times(process), vehicle.ticks()
    while time.monotonic() - start < seconds:
        executor.spin_once(timeout_sec=1.0)
    passed = time.monotonic() - start
    loads = {part: 100.0 * (cpu - used[part]) / passed for part, cpu in cpu_times(process).items()}
    done, lost = np.subtract(vehicle.ticks(), ticks)
    tick = 10.0 * passed * sum(loads.values()) / max(done, 1)
    late_by = vehicle.lateness()
    print(f'{name}: {sum(loads.values()):.0f} % of a core ('
          + ', '.join(f'{part} {load:.0f}' for part, load in loads.items())
          + f'), {tick:.1f} ms a tick made, {memory(process)} MB; '
          f'{lost} of {done + lost} ticks lost; lateness median {np.median(late_by):.2f}, '
          f'p99 {np.quantile(late_by, 0.99):.2f} ms; answers of the table '
          f'{vehicle.figures.get("solver_tabulated")}, full solutions '
          f'{vehicle.figures.get("solver_full")}', flush=True)


def measure_phases(vehicle: Vehicle, executor: Any, process: int,
                   arguments: argparse.Namespace) -> None:
    """Print how the node does while it is cold and warm, or in a drive."""
    while not any(vehicle.receipts.values()):
        executor.spin_once(timeout_sec=1.0)
    vehicle.begin = time.monotonic()
    phases = [('drive', arguments.seconds)] if arguments.drive else [
        ('cold', arguments.seconds), ('next', arguments.warm_up), ('warm', arguments.seconds)]
    for phase, seconds in phases:
        if seconds > 0.0:
            measure(phase, vehicle, executor, process, seconds)


def measure_in_step(vehicle: Vehicle, executor: Any, process: int, ticks: int) -> None:
    """Give the node one tick after the other and print what they cost."""
    clock = vehicle.node.create_publisher(Clock, '/clock', 1)
    vehicle.timer.cancel()
    while vehicle.node.count_subscribers('/clock') < 1 or (
            vehicle.node.count_subscribers('joint_states') < 1):
        executor.spin_once(timeout_sec=0.1)
    used = cpu_times(process)
    for number in range(_FIRST + ticks):
        if number == _FIRST:
            used = cpu_times(process)
        at, before = (1000 * 10**9 // vehicle.period + number) * vehicle.period, +vehicle.heard
        stamp = Time(sec=at // 10**9, nanosec=at % 10**9)
        vehicle.publish(number * vehicle.period * 1e-9, stamp)
        clock.publish(Clock(clock=stamp))
        due = time.monotonic() + 2.0
        while any(vehicle.heard[brake] == before[brake] for brake in BRAKES) and (
                time.monotonic() < due):
            executor.spin_once(timeout_sec=0.1)
    spent = sum((cpu_times(process) - used).values())
    load = 1e11 * spent / ticks / vehicle.period
    print(f'in step: {1e3 * spent / ticks:.1f} ms a tick, {load:.0f} % of a core at this rate, '
          f'{memory(process)} MB; {sum(vehicle.heard.values())} risks of '
          f'{4 * (_FIRST + ticks)} heard', flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.strip().splitlines()[0])
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--warm-up', type=float, default=300.0,
                        help='seconds between the cold and the warm figures')
    parser.add_argument('--rate', type=float, default=100.0)
    parser.add_argument('--still', action='store_true', help='inputs that do not change')
    parser.add_argument('--drive', choices=DRIVES, help='inputs of a drive')
    parser.add_argument('--in-step', type=int, default=0, help='ticks on a simulated clock')
    parser.add_argument('--table', default='', help='of `squeal tabulate`, to start with')
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node('vehicle')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    inputs = (driven(arguments.drive, arguments.rate) if arguments.drive else
              lambda time: swept(0.0 if arguments.still else time))
    vehicle = Vehicle(node, arguments.rate, inputs)
    clock = ('-p', 'use_sim_time:=true', '-p', 'clock_timeout:=600.0')
    with monitor(arguments.rate, arguments.table, *clock * bool(arguments.in_step)) as process:
        if arguments.in_step:
            measure_in_step(vehicle, executor, process, arguments.in_step)
        else:
            measure_phases(vehicle, executor, process, arguments)
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
