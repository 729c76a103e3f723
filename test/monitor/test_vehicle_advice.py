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

"""Advice of a vehicle's brakes from their assessments."""

import math
from typing import Any

import pytest
from squeal_core import BrakeModel
from squeal_core.monitor.advice import PressureAdvice
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.force_split import SplitAdvice, SplitSteps
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_advice import front_brakes, VehicleAdvice
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.stability.critical_parameter import critical_value
from support.advised_brakes import falling, falling_growth, falling_risk

MODEL = falling()
CAR = ('front_left', 'front_right', 'rear_left', 'rear_right')


def assessment(brake: str, pressure: float, **changes: Any) -> Assessment:
    inputs = {'rotor_speed': Reading('good', 10.0, 0.0),
              'pressure': Reading('good', pressure, 0.0)}
    return Assessment(**{'brake': brake, 'time': 0, 'state': 'steady', 'reason': 'as told',
                         'inputs': inputs, 'friction': 0.3, **changes})


def advice(*, risk: bool = True, **settings: Any) -> VehicleAdvice:
    """Return the advice for a car whose model has no table."""
    chosen = read_settings({'table': 'none', 'advice_hold': 3.0, **settings})
    return VehicleAdvice(MODEL, chosen, VehicleStability(MODEL, chosen),
                         falling_risk(MODEL) if risk else None)


def ended(steps: SplitSteps) -> tuple[SplitAdvice, int]:
    count = 0
    while True:
        try:
            next(steps)
            count += 1
        except StopIteration as done:
            return done.value, count


def test_pressures_by_the_emulator_where_there_is_no_table() -> None:
    found = advice().pressures(assessment('front_left', 8e6))
    growth = falling_growth(MODEL, 10.0, MODEL.contact_pressure(found.below), 0.3)
    assert -0.05 < growth <= 0.01  # growth_threshold
    assert math.isnan(found.above)
    assert found.confirmed
    assert 0.5 < found.confidence_below <= 1.0


def test_pressures_by_the_shipped_table_against_full_solutions(
        kang: BrakeModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """In a part of the band in which K09's brake is stable under high pressure."""
    monkeypatch.delenv('SQUEAL_TABLES')
    band = 2000.0, 3000.0
    chosen = read_settings({'squeal_band_low_hz': band[0], 'squeal_band_high_hz': band[1]})
    adviser = VehicleAdvice(kang, chosen, VehicleStability(kang, chosen), None)
    at = assessment('front_left', 3e6, friction=0.42, inputs={
        'rotor_speed': Reading('good', 20.0, 0.0), 'pressure': Reading('good', 3e6, 0.0)})
    found = adviser.pressures(at)
    point = kang.operating_point(rotor_speed=20.0, pressure=3e6, friction=0.42)
    limits = kang.contact_pressure(2e6), kang.contact_pressure(5e6)
    truth = critical_value(kang, point, 'contact_pressure', limits, band_hz=band, samples=8).above
    assert math.isnan(found.below)
    assert found.confirmed
    assert 1.0 <= kang.contact_pressure(1.0) * found.above / truth.value < 1.01


def test_without_table_and_emulator_nothing_is_known() -> None:
    nothing = advice(risk=False)
    found = nothing.pressures(assessment('front_left', 8e6))
    assert (math.isnan(found.below), math.isnan(found.above), found.intervals) == (True, True, ())
    assert 'squeal tabulate' in found.reason
    split, _ = ended(nothing.split([assessment(name, 5e6) for name in CAR]))
    assert math.isnan(split.front_share)
    assert 'squeal tabulate' in split.reason


@pytest.mark.parametrize('state', ['released', 'not sliding', 'stale', 'invalid',
                                   'outside validated range'])
def test_an_unknown_input_gives_nan_and_says_why(state: Any) -> None:
    found: PressureAdvice = advice().pressures(assessment('front_left', 8e6, state=state))
    assert math.isnan(found.below)
    assert math.isnan(found.above)
    assert found.reason == f'{state}: as told'
    car = [assessment(name, 5e6) for name in CAR[:3]] + [assessment(CAR[3], 5e6, state=state)]
    split, steps = ended(advice().split(car))
    assert (math.isnan(split.front_share), steps) == (True, 0)
    assert split.reason == f'rear_right {state}: as told'


def test_split_in_steps_within_the_limits_of_the_settings() -> None:
    car = [assessment(name, pressure) for name, pressure in zip(
        CAR, (8e6, 8e6, 3e6, 3e6), strict=True)]
    found, steps = ended(advice(advice_front_share_high=0.6).split(car))
    assert found.front_share <= 0.6
    assert 4 * 9 <= steps <= 4 * 13  # one a brake for each share and each full solution
    assert found.gain > 0.1


@pytest.mark.parametrize(('brakes', 'axles', 'front'), [
    (CAR, ['auto'], (True, True, False, False)),
    (('rear', 'front'), ['auto'], (True, False)),
    (CAR, ['none'], (False,) * 4),
    (('a', 'b', 'c', 'd'), ['a+c', 'b+d'], (True, False, True, False)),
    (CAR[:2], ['auto'], (False, False))])
def test_front_axle(brakes: tuple[str, ...], axles: list[str], front: tuple[bool, ...]) -> None:
    assert front_brakes(brakes, axles) == front
