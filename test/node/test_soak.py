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
An hour of driving, faster than real time: memory, threads and open files stay as they are.

The node is a process of its own on simulated time, four brakes at 10 Hz, through a drive cycle
again and again; its signals have the noise of sensors. Time goes on when the node has answered,
so that a busy machine takes longer over the same ticks.
"""

from dataclasses import replace
import time

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='needs rclpy')

from squeal_core import BrakeModel  # noqa: E402
from squeal_core.common.resources import find  # noqa: E402
from squeal_core.vehicle.drive_cycle import read_drive_cycle  # noqa: E402
from squeal_core.vehicle.vehicle_model import BrakeSignals, read_vehicle  # noqa: E402
from squeal_ros.cli.drive_signals import signals_of  # noqa: E402
from squeal_ros.cli.player import BrakePlayer  # noqa: E402
from support import processes  # noqa: E402
from support.domains import free_domain  # noqa: E402, I100
from support.node_runs import outside  # noqa: E402
from support.processes import cpu_seconds, Footprint, linux, short_and_long  # noqa: E402
from support.vehicle import TIMEOUT, Vehicle  # noqa: E402

RATE = 10.0  # Hz
SHORT, HOUR = 36.0, 3600.0  # s
SPEED_UP = 12.0  # at most
# s after which time goes on without: the node may not be heard yet; a time on /clock may be lost
FIRST, ANSWER = 1.0, 10.0
WARM = {SHORT: 3, HOUR: 1}  # sixths: what is made once was made by then
# of memory; in half a minute Python's pools still grow
GROWTH = {SHORT: 1.25, HOUR: 1.02}
NOISE = {'rotor_speed': 0.02, 'pressure': 2e3, 'temperature': 0.1, 'friction': 1e-3}


def wait_for_answer(car: Vehicle) -> None:
    """Return when the node has said something of a brake since the last call: once a tick."""
    end = time.monotonic() + (ANSWER if car.count else FIRST)
    while car.said.pop('squeal_risk', None) is None and time.monotonic() < end:
        car.executor.spin_once(timeout_sec=0.1)


def hours(model: BrakeModel, seconds: float) -> BrakeSignals:
    """Signals of a cycle that is driven again and again."""
    cycle = read_drive_cycle(find('drive_cycles', 'us06', '.csv'))
    span = cycle.time[-1] + 1.0
    times = int(np.ceil(seconds / span))
    again = replace(cycle, speed=np.tile(cycle.speed, times), time=np.concatenate(
        [cycle.time + i * span for i in range(times)]))
    signals = signals_of(again, read_vehicle(find('vehicles', 'midsize', '.yaml')), model,
                         rate=RATE, duration=seconds)
    noise = np.random.default_rng(1)
    return replace(signals, **{
        name: getattr(signals, name) + spread * noise.standard_normal(signals.pressure.shape)
        for name, spread in NOISE.items()})


@linux
@short_and_long('seconds', SHORT, HOUR, minutes=30.0)
def test_driving(seconds: float, kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    signals = hours(kang, seconds)
    parameters = {f'{brake}__temperature__topic': f'{brake}/rotor_temperature'
                  for brake in signals.brakes}
    prints, done, known = [], 0, 0
    with free_domain() as domain:
        monkeypatch.setenv('ROS_DOMAIN_ID', str(domain))
        with processes.monitor(domain, brakes=list(signals.brakes), use_sim_time=True, rate=RATE,
                               diagnostics_rate=1.0, clock_timeout=60.0,
                               **parameters) as node, BrakePlayer(signals) as player, \
                outside(domain, brake=signals.brakes[0]) as car:
            assert player.wait_for_listener(TIMEOUT, still_alive=lambda: node.poll() is None)
            for half, heard in enumerate(player.play(speed_up=SPEED_UP)):
                if half % 2 == 0:  # the clock moved
                    wait_for_answer(car)
                if half % 40 == 0:
                    assert node.poll() is None, f'the node ended in step {half // 2}'
                    prints.append(Footprint.of(node.pid))
                for progress in heard:
                    done, lost = progress.ticks_done, progress.ticks_lost
                    known += sum(row.squeal_risk >= 0.0 for row in progress.rows)
            load = cpu_seconds(node.pid)
    sixths = np.array_split(np.array([held.memory for held in prints]), 6)
    memory = [float(np.median(sixth)) for sixth in sixths]
    warm, last = prints[len(prints) * WARM[seconds] // 6], prints[-1]
    print(f'\n{seconds:.0f} s of driving at {SPEED_UP:g} x: {done} ticks, {lost} lost; '
          f'node computed {load:.0f} s; {last}; medians of memory '
          f'{", ".join(f"{held / 1e6:.1f}" for held in memory)} MB')
    assert done > 0.9 * RATE * seconds
    assert known > 0
    assert memory[-1] < GROWTH[seconds] * memory[WARM[seconds]]
    assert last.threads == warm.threads
    assert last.files == warm.files
