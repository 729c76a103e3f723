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
A replay of any cut of a drive gives the live numbers, bit for bit, whatever ran before.

Stability is a function of the samples, hence equal from the second assessment on (the first may
see less of them). So is the instability probability, from the second evaluation of the risk on:
the first is at the first tick, and held. Risk is a function of the brake application, too: equal
from the first release on, and marked as incomplete before.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.monitor import vehicle_risk
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import write_table
from support.engine_models import random_model
from support.linear_growth import LinearGrowth

PERIOD = 50_000_000  # ns
BEGIN, COUNT = 2000 * PERIOD, 120
RISK_EVERY = 2  # ticks
BRAKES = ('fl', 'fr', 'rl', 'rr')
SIGNALS: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
FLOAT = 'std_msgs/msg/Float64'
Drive = list[tuple[str, Signal, int, float]]  # brake, signal, time of receipt [ns], value


@pytest.fixture(scope='module')
def model() -> BrakeModel:
    return random_model(8, seed=5, friction_law=FrictionLaw(), caliper=Caliper(2.5e-3))


@pytest.fixture(autouse=True)
def _emulator(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give the model an emulator of growth, whose build-up is between floor and saturation."""
    emulator = LinearGrowth([900.0, 1100.0], [10.0, 12.0], [90.0, 60.0])
    monkeypatch.setattr(vehicle_risk, 'named_emulator', lambda path, model: emulator)


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
                          'margin_confirm_interval': 1.0, 'squeal_band_low_hz': 500.0,
                          'ensemble_size': 16.0, 'risk_rate': 20.0 / RISK_EVERY, **inputs})


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


class Numbers(NamedTuple):
    """What is known of a brake, to the last bit."""

    state: str
    stability: str
    instability: str
    risk: str
    incomplete: bool


def numbers(found: Assessment) -> Numbers:
    known, risk = found.stability, found.risk_result
    margin = None if known is None else known.margins.friction
    return Numbers(
        found.state,
        repr((found.brake, found.state, found.growth_rate, found.worst_frequency_hz,
              found.friction_margin, found.modes, margin)),
        repr(found.instability_probability),
        repr((found.reason, found.risk, found.instability_probability, found.build_up,
              found.time_to_squeal, found.build_ups, risk and vars(risk.result),
              risk and risk.result.family_build_up.tolist())),
        risk is not None and risk.result.incomplete)


def live(monitor: VehicleMonitor, events: Drive) -> dict[int, list[Numbers]]:
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


def check(whole: Mapping[int, list[Numbers]], cut: Mapping[int, list[Numbers]]) -> None:
    first, *ticks = sorted(cut)
    evaluated = first + RISK_EVERY  # at the latest
    assert len(ticks) > 3
    released: set[int] = set()
    for tick in ticks:
        for place, (ours, theirs) in enumerate(zip(cut[tick], whole[tick], strict=True)):
            assert ours.stability == theirs.stability
            assert tick < evaluated or ours.instability == theirs.instability
            if ours.state == 'released':
                released.add(place)
            if place in released:
                assert ours.risk == theirs.risk or ours.state == 'released'
            else:
                assert ours.incomplete == (ours.state == 'steady')


@pytest.mark.parametrize('with_table', [True, False])
def test_cuts_of_a_drive(model: BrakeModel, table: str, with_table: bool) -> None:
    """A fresh monitor, and one that other drives went through before."""
    chosen, events = settings(table if with_table else 'none'), drive(1)
    monitor = VehicleMonitor(chosen, model)
    whole = live(monitor, events)
    figures = monitor.evaluator.figures()
    assert (figures['solver_tabulated'] > 100) == with_table
    assert figures['solver_full'] > 50
    assert (figures['margins_confirmed'] > 0) == with_table
    assert figures['margins_not_confirmed'] == 0
    assert {one.incomplete for tick in whole.values() for one in tick} == {True, False}
    used = VehicleMonitor(chosen, model)
    live(used, drive(2))
    for cut in cuts(events, 2, seed=3):
        check(whole, live(VehicleMonitor(chosen, model), cut))
        used.reset()
        check(whole, live(used, cut))


@pytest.mark.parametrize('with_table', [True, False])
def test_cuts_of_a_bag(model: BrakeModel, table: str, with_table: bool, tmp_path: Path) -> None:
    pytest.importorskip('rosbags', reason='needs rosbags')
    from support.bags import replay_of, write_floats

    chosen, events = settings(table if with_table else 'none'), drive(4)
    whole = live(VehicleMonitor(chosen, model), events)
    for place, cut in enumerate([events, *cuts(events, 2, seed=5)]):
        path = write_floats(tmp_path / f'{place}.mcap', [
            (f'/{brake}/{signal}', time, value) for brake, signal, time, value in cut])
        check(whole, {tick[0].time // PERIOD: [numbers(one) for one in tick]
                      for tick in replay_of(path, chosen, model)})
