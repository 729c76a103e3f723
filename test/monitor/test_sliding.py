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

"""The sliding brake: modes, risk and margins over the ticks, against their offline references."""

from dataclasses import replace
import math

import pytest
from squeal_core import BrakeModel
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.monitor.brake_stability import BrakeEvaluator, BrakeStability
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.risk.probability import (
    first_order_risk,
    Inputs,
    InputUncertainty,
    risks_by_series,
)
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.surrogate.tabulated_solver import TabulatedSolver

SPEED, PRESSURE, FRICTION = 20.0, 7.84e5, 0.42
PERIOD = 20_000_000  # ns


def settings(**changes: object) -> MonitorSettings:
    return read_settings({'brakes': ['fl'], 'rate': 50.0, 'contact_stiffness_deviation': 0.0,
                          **changes})


def ticks(brake: BrakeEvaluator, count: int, begin: int = 0, *,
          speed: float = SPEED) -> BrakeStability:
    for i in range(count):
        found = brake.evaluate(speed, PRESSURE, FRICTION, (begin + i) * PERIOD)
    return found


def test_margins_come_confirmed_and_as_the_offline_search_has_them(kang: BrakeModel) -> None:
    at = settings()
    engines = VehicleStability(kang, at)
    brake, count = BrakeEvaluator(engines, at), 0
    while math.isnan((found := ticks(brake, 10, count)).friction_margin):
        count += 10
        assert count < 2000
    engines.close()
    point = kang.operating_point(rotor_speed=SPEED, pressure=PRESSURE, friction=FRICTION)
    expected = critical_value(kang, point, 'friction', (0.05, 0.9)).below
    margin = found.margins.friction
    assert margin is not None
    assert margin.converged
    assert found.friction_margin == pytest.approx(expected.value - FRICTION, abs=2e-4)
    assert margin.frequency_hz == pytest.approx(expected.frequency_hz, rel=1e-3)
    later = brake.evaluate(1.5 * SPEED, PRESSURE, FRICTION, (count + 10) * PERIOD)
    assert math.isnan(later.friction_margin)  # was found for another speed


def test_same_ticks_same_numbers_with_workers_beside(kang: BrakeModel) -> None:
    """Anchors and cells are taken into use by count, whenever they were finished."""
    runs = []
    for _ in range(2):
        at = settings(anchor_delay=0.2)
        engines = VehicleStability(kang, at)
        brake = BrakeEvaluator(engines, at)
        runs.append([ticks(brake, 1, i, speed=SPEED * (1.0 - 2e-3 * i)) for i in range(60)])
        engines.close()
    for one, other in zip(*runs, strict=True):
        assert one.modes.mode_eigenvalues.tolist() == other.modes.mode_eigenvalues.tolist()
        assert repr(one.risk) == repr(other.risk)  # NaN equals itself in print alone
        assert one.modes.source == other.modes.source
    assert {one.modes.source for one in runs[0]} == {'full', 'table'}


def test_modes_are_those_of_the_full_solution(kang: BrakeModel) -> None:
    at = settings()
    engines = VehicleStability(kang, at)
    found = ticks(BrakeEvaluator(engines, at), 40)
    engines.close()
    truth = complex_modes(kang, found.point)
    assert found.modes.source == 'table'
    assert [m.index for m in found.modes.unstable] == [m.index for m in truth.unstable]
    assert found.worst is not None
    assert found.worst.growth_rate == pytest.approx(
        truth.least_stable(1250.0, 16000.0)[0].growth_rate, abs=at.engine_tolerance)


@pytest.mark.parametrize('friction', [0.1, 0.16, 0.42])
def test_tangent_by_series_is_that_by_vectors(kang: BrakeModel, friction: float) -> None:
    deviations = InputUncertainty(friction=0.02, pressure=0.03, rotor_speed=0.01,
                                  contact_stiffness=0.05)
    at = Inputs(rotor_speed=SPEED, pressure=PRESSURE, friction=friction,
                contact_stiffness=kang.nominal_contact_stiffness)

    def point_of(inputs: Inputs) -> OperatingPoint:
        return kang.operating_point(**vars(inputs))

    found = TabulatedSolver(kang).complex_modes(point_of(at))
    modes = found.least_stable(1250.0, 16000.0, 3)
    expected = first_order_risk(kang, point_of, at, modes, deviations).each
    # differences over a fiftieth of a deviation: of second order in it
    harder = replace(at, pressure=1.1 * PRESSURE)
    here, there = risks_by_series(
        found.series, point_of, [(at, modes), (harder, modes[:1])], deviations)
    assert here == pytest.approx(expected, abs=1e-3)
    assert there == pytest.approx(risks_by_series(
        found.series, point_of, [(harder, modes)], deviations)[0][:1])


def test_without_uncertainty_the_risk_is_zero_or_one(kang: BrakeModel) -> None:
    certain = {f'{name}_deviation': 0.0 for name in (
        'friction', 'pressure', 'rotor_speed', 'contact_stiffness')}
    at = settings(**certain)
    engines = VehicleStability(kang, at)
    brake = BrakeEvaluator(engines, at)
    assert brake.evaluate(SPEED, PRESSURE, FRICTION, 0).risk.probability == 1.0
    assert brake.evaluate(SPEED, PRESSURE, 0.05, 0).risk.probability == 0.0
    engines.close()
