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

"""A replay of any cut of a drive gives the live numbers, bit for bit, whatever ran before."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import write_table
from support.engine_models import random_model

PERIOD = 50_000_000  # ns
BEGIN, COUNT = 2000 * PERIOD, 120
BRAKES = ('fl', 'fr', 'rl', 'rr')
SIGNALS: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
FLOAT = 'std_msgs/msg/Float64'
Drive = list[tuple[str, Signal, int, float]]  # brake, signal, time of receipt [ns], value


@pytest.fixture(scope='module')
def model() -> BrakeModel:
    return random_model(8, seed=5, friction_law=FrictionLaw(), caliper=Caliper(2.5e-3))


@pytest.fixture(scope='module')
def table(model: BrakeModel, tmp_path_factory: pytest.TempPathFactory) -> str:
    """Build the table of a part of the drive; the rest is solved in full."""
    path = tmp_path_factory.mktemp('table') / 'table.npz'
    domain = TableDomain.usual(model, rotor_speed=(8.0, 14.0), preload=(1000.0, 4000.0),
                               friction=(0.2, 0.5))
    write_table(build_table(model, domain), model, path)
    return str(path)


def settings(table: str) -> MonitorSettings:
    inputs: dict[str, Any] = {}
    for brake in BRAKES:
        for signal in SIGNALS:
            inputs |= {f'{brake}.{signal}.topic': f'/{brake}/{signal}',
                       f'{brake}.{signal}.type': FLOAT, f'{brake}.{signal}.field': 'data'}
    return read_settings({'brakes': list(BRAKES), 'rate': 20.0, 'table': table,
                          'margin_confirm_interval': 1.0, **inputs})


def drive(seed: int) -> Drive:
    """Return a stop with a pause in the middle, noisy, each signal shortly before each tick."""
    noise, found = np.random.default_rng(seed), Drive()
    for tick in range(COUNT):
        time, pause = BEGIN + tick * PERIOD, 50 <= tick < 60
        for place, brake in enumerate(BRAKES):
            pressure = 0.0 if pause else (1.2e6 + 4e3 * tick) * (1.0 if place < 2 else 0.6)
            for signal, value in zip(SIGNALS, (
                    15.0 - 0.06 * tick, pressure, 0.35 + 0.001 * tick), strict=True):
                found.append((brake, signal, time - 10_000_000 + 1000 * place,
                              value * (1.0 + 2e-3 * noise.standard_normal())))
    return found


def numbers(found: Assessment) -> str:
    """Return all that is known of a brake, to the last bit."""
    known = found.stability
    margin = None if known is None else known.margins.friction
    return repr((found.brake, found.state, found.reason, found.risk, found.growth_rate,
                 found.worst_frequency_hz, found.friction_margin, found.modes, margin))


def live(monitor: VehicleMonitor, events: Drive) -> dict[int, list[str]]:
    """Play a drive; return the numbers of each tick."""
    found, place = {}, 0
    first = -(-events[0][2] // PERIOD)
    for tick in range(first, BEGIN // PERIOD + COUNT):
        while place < len(events) and events[place][2] <= tick * PERIOD:
            brake, signal, time, value = events[place]
            monitor.receive(brake, signal, Sample(time, value))
            place += 1
        found[tick] = [numbers(one) for one in monitor.assess(tick * PERIOD)]
    return found


def cuts(events: Drive, count: int, seed: int) -> Iterator[Drive]:
    for place in np.random.default_rng(seed).integers(1, len(events) - 60, count).tolist():
        yield events[place:]


def check(whole: Mapping[int, list[str]], cut: Mapping[int, list[str]]) -> None:
    """Compare from the second assessment of the cut on."""
    ticks = sorted(cut)[1:]
    assert len(ticks) > 3
    assert [cut[tick] for tick in ticks] == [whole[tick] for tick in ticks]


@pytest.mark.parametrize('with_table', [True, False])
def test_cuts_of_a_drive(model: BrakeModel, table: str, with_table: bool) -> None:
    """A fresh monitor, and one that other drives went through before."""
    chosen, events = settings(table if with_table else 'none'), drive(1)
    monitor = VehicleMonitor(chosen, model)
    whole = live(monitor, events)
    figures = monitor.stability.figures()
    assert (figures['solver_tabulated'] > 100) == with_table
    assert figures['solver_full'] > 50
    assert (figures['margins_confirmed'] > 0) == with_table
    assert figures['margins_not_confirmed'] == 0
    used = VehicleMonitor(chosen, model)
    live(used, drive(2))
    for cut in cuts(events, 4, seed=3):
        check(whole, live(VehicleMonitor(chosen, model), cut))
        used.reset()
        check(whole, live(used, cut))


@pytest.mark.parametrize('with_table', [True, False])
def test_cuts_of_a_bag(model: BrakeModel, table: str, with_table: bool, tmp_path: Path) -> None:
    pytest.importorskip('rosbags', reason='needs rosbags')
    from squeal_ros.recordings.bag_reader import Bag
    from squeal_ros.recordings.replay import Replay
    from support.bags import write_floats

    chosen, events = settings(table if with_table else 'none'), drive(4)
    whole = live(VehicleMonitor(chosen, model), events)
    for place, cut in enumerate([events, *cuts(events, 2, seed=5)]):
        path = write_floats(tmp_path / f'{place}.mcap', [
            (f'/{brake}/{signal}', time, value) for brake, signal, time, value in cut])
        check(whole, {tick[0].time // PERIOD: [numbers(one) for one in tick]
                      for tick in Replay(Bag(path), chosen, model)})
