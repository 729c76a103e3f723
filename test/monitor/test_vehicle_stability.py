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

"""Stability of a vehicle's brakes: what each of them has by itself, whatever ran before."""

from dataclasses import replace
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import OperatingPoint, SlidingConditions
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.stability.eigensolution import complex_modes, ComplexModes
from squeal_core.surrogate import tabulated_solver
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import write_table

TICK = 1_000_000_000
HERE = SlidingConditions(rotor_speed=20.0, pressure=7.84e5, friction=0.42)


def stability(model: BrakeModel, **changes: Any) -> VehicleStability:
    return VehicleStability(
        model, read_settings({'brakes': ['fl'], 'table': 'none', **changes}))


def evaluated(model: BrakeModel, at: SlidingConditions, **changes: Any) -> BrakeStability:
    found, = stability(model, **changes).evaluate([at], [False])
    assert isinstance(found, BrakeStability)
    return found


def test_modes_are_those_of_the_full_solution(kang: BrakeModel) -> None:
    found = evaluated(kang, HERE)
    truth = complex_modes(kang, kang.operating_point(
        rotor_speed=HERE.rotor_speed, pressure=HERE.pressure, friction=HERE.friction))
    assert found.modes.source == 'full'
    assert found.modes.mode_eigenvalues.tolist() == truth.mode_eigenvalues.tolist()
    assert found.worst == truth.least_stable(1250.0, 16000.0)[0]


def vehicle(model: BrakeModel, inputs: dict[str, tuple[float, float, float]]) -> VehicleMonitor:
    watch = VehicleMonitor(read_settings({'brakes': list(inputs), 'table': 'none'}), model)
    signals: tuple[Signal, ...] = ('rotor_speed', 'pressure', 'friction')
    for brake, values in inputs.items():
        for signal, value in zip(signals, values, strict=True):
            watch.receive(brake, signal, Sample(TICK, value))
    return watch


def test_a_vehicle_is_its_brakes(kang: BrakeModel) -> None:
    """Modes, risk and states of four brakes, of which one is released and one does not slide."""
    inputs = {'front_left': (40.0, 1.2e6, 0.4), 'front_right': (40.1, 1.21e6, 0.4),
              'rear_left': (40.0, 0.0, 0.4), 'rear_right': (0.0, 5e5, 0.4)}
    watch = vehicle(kang, inputs)
    found = watch.assess(TICK)
    assert [one.brake for one in found] == list(inputs)
    assert [one.state for one in found] == ['steady', 'steady', 'released', 'not sliding']
    for one in found[:2]:
        assert repr(watch.brakes[one.brake].assess(TICK)) == repr(one)


def test_no_eigensolution_of_one_brake_is_its_own(kang: BrakeModel,
                                                  monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are assessed, though the brakes are evaluated together."""
    def failing(model: BrakeModel, point: OperatingPoint, **options: Any) -> ComplexModes:
        if point.friction > 0.5:
            raise np.linalg.LinAlgError('did not converge')
        return complex_modes(model, point, **options)

    monkeypatch.setattr(tabulated_solver, 'complex_modes', failing)
    found = vehicle(kang, {f'b{i}': (40.0, 1.2e6, 0.6 if i == 1 else 0.4)
                           for i in range(4)}).assess(TICK)
    assert [one.state for one in found] == ['steady', 'invalid', 'steady', 'steady']
    assert found[1].reason == 'no eigensolution (did not converge)'
    assert all(math.isfinite(one.growth_rate) for one in (found[0], *found[2:]))


def test_many_ticks_at_once_are_each_of_them(kang: BrakeModel) -> None:
    """Prepared in their order and completed together, to the last bit."""
    runs = []
    for together in (False, True):
        watch, found = vehicle(kang, {'fl': (40.0, 1.2e6, 0.4), 'fr': (40.0, 0.0, 0.4)}), []
        for i in range(6):
            time = TICK + i * 100_000_000
            watch.receive('fl', 'rotor_speed', Sample(time, 40.0 - i))
            found.append(watch.prepare(time) if together else watch.assess(time))
        runs.append(watch.complete(found) if together else found)
    assert repr(runs[0]) == repr(runs[1])


# ---------------------------------------------------------------- a table that is wrong

def test_a_margin_that_is_not_confirmed_drops_the_cell(tmp_path: Path) -> None:
    """The margin says why it is none; from then on the table has no answer there."""
    model = BrakeModel(
        angular_frequencies=np.array([1e4, 1.02e4]), caliper=Caliper(2.5e-3),
        friction_couple=np.array([[0.0, 5e-4], [-5e-4, 0.0]]), damping_ratios=2e-3,
        nominal_contact_stiffness=1e10, friction_law=FrictionLaw())
    table = build_table(model, TableDomain.usual(
        model, rotor_speed=(6.0, 12.0), preload=(1000.0, 3000.0), friction=(0.3, 0.6)))
    at = SlidingConditions(rotor_speed=9.0, pressure=8e5, friction=0.5)
    found, wrong = [], [replace(cell, series=cell.series + np.where(
        np.arange(len(cell.series)) > 0, 0.0, 1.0)[:, None]) for cell in table.cells]
    for cells in (table.cells, wrong):
        path = tmp_path / 'table.npz'
        write_table(replace(table, cells=cells), model, path)
        vehicle = stability(model, table=str(path))
        found.append([vehicle.evaluate([at], [confirm])[0] for confirm in (True, False)])
        counts = vehicle.figures()
        assert counts['margins_not_confirmed'] == counts['solver_mismatches'] == (cells is wrong)
    margins = [[one.margins.friction for one in run if isinstance(one, BrakeStability)]
               for run in found]
    (confirmed, again), (refused, lost) = margins
    assert (confirmed.confirmed, again.confirmed) == (True, False)
    assert confirmed.critical == again.critical
    assert math.isnan(refused.critical)
    assert 'not confirmed' in refused.reason
    assert 'outside the table' in lost.reason
