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

"""Brakes that are released: what their next application will ask for is ready when it comes."""

from collections.abc import Sequence
from dataclasses import replace

import pytest
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.surrogate.onset import Onset
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from squeal_core.surrogate.workers import Worker

RATE, SPEED, FRICTION = 50.0, 30.0, 0.42
RELEASED = 0.5e5  # Pa


def settings(**changes: float) -> MonitorSettings:
    return replace(read_settings({'brakes': ['front', 'rear']}), rate=RATE,
                   contact_stiffness_deviation=0.0, **changes)


class Drive:
    """Ticks of two brakes, the rear one with less pressure."""

    def __init__(self, watch: VehicleMonitor) -> None:
        self.watch, self.tick = watch, 0

    def go(self, pressures: Sequence[float], *, speed: float = SPEED,
           friction: float = FRICTION) -> list[Assessment]:
        found: list[Assessment] = []
        for pressure in pressures:
            self.tick += 1
            time = self.tick * self.watch.settings.period
            for brake, part in (('front', 1.0), ('rear', 0.43)):
                self.watch.receive(brake, 'rotor_speed', Sample(time, speed + 1e-3 * self.tick))
                self.watch.receive(brake, 'pressure', Sample(time, part * pressure))
                self.watch.receive(brake, 'friction', Sample(time, friction))
            found += self.watch.assess(time)
        return found


def cruise_and_brake(kang: BrakeModel, **changes: float) -> tuple[str, int, int]:
    """Return modes to the last bit, how many anchors were ready, and full solves on the way."""
    watch = VehicleMonitor(settings(**changes), kang)
    drive, statistics = Drive(watch), watch.engines.modes.statistics
    assert {one.state for one in drive.go(100 * [0.0])} == {'released'}
    ready = statistics.made
    found = drive.go([5e4 * 1.15**i for i in range(25)])
    assert {one.state for one in found[-10:]} == {'steady'}
    watch.close()
    return repr([(one.growth_rate, one.risk) for one in found]), ready, statistics.full


def test_an_application_finds_its_anchors_ready(kang: BrakeModel,
                                                monkeypatch: pytest.MonkeyPatch) -> None:
    numbers, ready, full = cruise_and_brake(kang)
    assert ready >= 5
    assert full == 0
    assert cruise_and_brake(kang) == (numbers, ready, full)
    with monkeypatch.context() as starving:
        starving.setattr(Worker, '_do', lambda worker, work: None)
        assert cruise_and_brake(kang) == (numbers, ready, full)
    monkeypatch.setattr(Onset, 'look', lambda *_: None)
    _, ready, full = cruise_and_brake(kang)
    assert ready == 0
    assert full > 5


def test_nothing_is_made_ready_where_anchors_are_made_at_once(kang: BrakeModel) -> None:
    assert cruise_and_brake(kang, anchor_delay=0.0)[1] == 0


@pytest.mark.parametrize(('changed', 'state'), [
    ({'speed': 0.0}, 'released'), ({'speed': 0.1}, 'released'),
    ({'friction': 1.4}, 'released')])
def test_nothing_is_made_ready_for_what_cannot_come(kang: BrakeModel, changed: dict[str, float],
                                                    state: str) -> None:
    watch = VehicleMonitor(settings(), kang)
    found = Drive(watch).go(60 * [0.0], **changed)
    assert {one.state for one in found} == {state}
    watch.close()
    assert watch.engines.modes.statistics.made == 0


def covered(kang: BrakeModel, table: TabulatedSolver, pressure: float) -> bool:
    return table.covers(point(kang, pressure))


def point(kang: BrakeModel, pressure: float) -> OperatingPoint:
    return kang.operating_point(rotor_speed=SPEED, pressure=pressure, friction=FRICTION)


def test_from_light_to_firm_pressure(kang: BrakeModel) -> None:
    table = TabulatedSolver(kang, SolverSettings(delay=12))
    onset = Onset(table)
    for _ in range(300):
        onset.look([(SPEED, FRICTION)], RELEASED)
    made = table.statistics.made
    assert made <= 7
    assert all(covered(kang, table, RELEASED * 1.1**i) for i in range(1, 36))  # to 14 bar
    for _ in range(300):
        onset.look([(SPEED, FRICTION)], RELEASED)
    assert table.statistics.made == made  # once is enough
    table.close()


@pytest.mark.parametrize('pressure', [0.0, 1e7])
def test_any_pressure_of_release(kang: BrakeModel, pressure: float) -> None:
    table = TabulatedSolver(kang, SolverSettings(delay=12))
    onset = Onset(table)
    for _ in range(120):
        onset.look([(SPEED, FRICTION)], pressure)
    assert table.statistics.failed == 0
    assert covered(kang, table, max(1.5 * pressure, 3e4))
    table.close()


def test_what_no_anchor_answers_is_not_made_again_and_again(kang: BrakeModel) -> None:
    table = TabulatedSolver(kang, SolverSettings(delay=12, tolerance=1e-12))
    onset = Onset(table)
    for _ in range(600):
        onset.look([(SPEED, FRICTION)], RELEASED)
    assert table.statistics.made == 6
    table.close()


def test_anchors_that_were_never_needed_keep_no_other_from_being_made(kang: BrakeModel) -> None:
    """After some that nobody used others are asked for less often, but for these."""
    table = TabulatedSolver(kang, SolverSettings(delay=4))
    onset = Onset(table)
    for step in range(4):
        for _ in range(120):
            onset.look([(SPEED * 1.6**step, FRICTION)], RELEASED)
    made = table.statistics.made
    assert made > 12
    far = replace(point(kang, 1e6), rotor_speed=2.0)
    sources = [table.complex_modes(far).source for _ in range(8)]
    assert sources[-1] == 'table'
    assert table.statistics.made == made + 1
    table.close()


def test_brakes_of_one_vehicle_take_turns(kang: BrakeModel) -> None:
    """At other frictions there are other anchors."""
    engines = VehicleStability(kang, settings())
    for _ in range(600):
        engines.onset.look([(SPEED, 0.3), (SPEED, 0.6)], RELEASED)
    for friction in (0.3, 0.6):
        at = kang.operating_point(rotor_speed=SPEED, pressure=4e5, friction=friction)
        assert engines.modes.covers(at)
    engines.close()
