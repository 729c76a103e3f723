"""Load and lateness of the node: four brakes at 100 Hz, all braking all the time.

Run: python benchmark/node_load.py [--seconds 30] [--rate 100]

The node is a process of its own, as on the vehicle; its CPU time is read from /proc. Lateness is
from the tick, a multiple of the period in ROS time, to the receipt of a brake's risk here.
"""

import squeal_ros.blas  # noqa: F401, I001 - before anything imports numpy

import argparse
from contextlib import contextmanager
import math
import os
from pathlib import Path
import subprocess
import sys
import time
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import FluidPressure, JointState
from std_msgs.msg import Float64

BRAKES = ('front_left', 'front_right', 'rear_left', 'rear_right')
TICKS = os.sysconf('SC_CLK_TCK')


class Vehicle:
    """Publishes three signals of four brakes that brake for ever, and hears their risk."""

    def __init__(self, node: Any, rate: float) -> None:
        self.node, self.period = node, round(1e9 / rate)
        self.lateness: list[int] = []
        self.begin = time.monotonic()
        self.joints = node.create_publisher(JointState, 'joint_states', 10)
        self.publishers = [(node.create_publisher(FluidPressure, f'{brake}/brake_pressure', 10),
                            node.create_publisher(Float64, f'{brake}/friction', 10))
                           for brake in BRAKES]
        for brake in BRAKES:
            node.create_subscription(
                Float64, f'/squeal_monitor/{brake}/squeal_risk', self.hear, 10)
        node.create_timer(1.0 / rate, self.publish)

    def hear(self, message: Float64) -> None:
        if not math.isnan(message.data):
            self.lateness.append(self.node.get_clock().now().nanoseconds % self.period)

    def publish(self) -> None:
        way = time.monotonic() - self.begin
        joints, pressure = JointState(), FluidPressure()
        joints.header.stamp = pressure.header.stamp = self.node.get_clock().now().to_msg()
        speed = 40.0 + 35.0 * math.sin(0.3 * way)  # a braking from 75 to 5 rad/s takes 10 s
        joints.name = [f'{brake}_wheel_joint' for brake in BRAKES]
        joints.velocity = [speed * (1.0 + 0.001 * i) for i in range(4)]
        self.joints.publish(joints)
        for i, (pressures, frictions) in enumerate(self.publishers):
            pressure.fluid_pressure = (1.5e6 + 5e5 * math.sin(1.1 * way)) * (1.0 - 0.2 * (i > 1))
            pressures.publish(pressure)
            frictions.publish(Float64(data=0.42 + 0.02 * math.sin(0.2 * way)))


def cpu_time(process: int) -> float:
    """Return the CPU time of a process and its threads [s]."""
    fields = Path(f'/proc/{process}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


@contextmanager
def monitor(rate: float) -> Any:
    """Run the node as a process."""
    code = 'import sys; from squeal_ros.node import main; sys.exit(main())'
    process = subprocess.Popen([sys.executable, '-c', code, '--ros-args', '-p', f'rate:={rate}'],
                               stderr=subprocess.DEVNULL)
    try:
        yield process.pid
    finally:
        process.terminate()
        process.wait()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--rate', type=float, default=100.0)
    arguments = parser.parse_args()
    rclpy.init()
    node = rclpy.create_node('vehicle')
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    vehicle = Vehicle(node, arguments.rate)
    with monitor(arguments.rate) as process:
        for phase in ('cold', 'warm'):
            while not vehicle.lateness:
                executor.spin_once(timeout_sec=1.0)
            vehicle.lateness.clear()
            start, used = time.monotonic(), cpu_time(process)
            while time.monotonic() - start < arguments.seconds:
                executor.spin_once(timeout_sec=1.0)
            load = (cpu_time(process) - used) / (time.monotonic() - start)
            late = 1e-6 * np.array(vehicle.lateness)
            expected = 4 * arguments.rate * arguments.seconds
            print(f'{phase}: {100.0 * load:.0f} % of a core, {late.size / expected:.1%} of the '
                  f'risks, lateness median {np.median(late):.2f}, p99 '
                  f'{np.quantile(late, 0.99):.2f} ms')
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == '__main__':
    main()
