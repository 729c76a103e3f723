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

"""Friction laws against closed forms and finite differences; the table and what it refuses."""

from dataclasses import FrozenInstanceError
import math
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.common.errors import SquealError

LAW = FrictionLaw(static=0.5, kinetic=0.32, decay=1.0)
LAWS = [LAW, FrictionLaw(0.6, 0.3, 2.5), FrictionLaw(0.3, 0.45, 0.7), FrictionLaw(0.5, 0.3, 0.0)]
TABLE = FrictionTable(np.array([300.0, 400.0, 600.0]), np.array([0.30, 0.50, 0.40]))
SPEEDS = [0.01, 0.1, 0.611, 1.0, 2.44, 10.0]


@pytest.mark.parametrize(('speed', 'expected'), [
    (0.0, 0.5), (1.0, 0.32 + 0.18 / math.e), (math.log(2.0), 0.41), (60.0, 0.32)])
def test_coefficient_of_k09(speed: float, expected: float) -> None:
    assert LAW.coefficient(speed) == pytest.approx(expected, rel=1e-12)
    assert LAW.coefficient(-speed) == LAW.coefficient(speed)


def test_the_default_law_is_k09s() -> None:
    assert FrictionLaw() == LAW


def test_slope_of_k09() -> None:
    assert LAW.slope(0.0) == pytest.approx(-0.18)
    assert LAW.slope(math.log(2.0)) == pytest.approx(-0.09)
    assert LAW.slope(-1.0) == LAW.slope(1.0)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('speed', SPEEDS)
def test_slope_is_the_derivative(law: FrictionLaw, speed: float) -> None:
    step = 1e-4 * speed
    difference = (law.coefficient(speed + step) - law.coefficient(speed - step)) / (2.0 * step)
    assert law.slope(speed) == pytest.approx(difference, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize('law', LAWS)
@pytest.mark.parametrize('speed', [-1.0, *SPEEDS])
def test_slope_at_scales_with_the_measured_friction(law: FrictionLaw, speed: float) -> None:
    own = law.coefficient(speed)
    assert law.slope_at(speed, own) == pytest.approx(law.slope(speed), rel=1e-14)
    assert law.slope_at(speed, 1.3 * own) == pytest.approx(1.3 * law.slope(speed), rel=1e-14)
    assert own * float(law.relative_slope(speed)) == pytest.approx(law.slope(speed), rel=1e-14)


@given(st.floats(0.0, 50.0), st.floats(1e-3, 5.0))
def test_coefficient_falls_from_static_to_kinetic(speed: float, more: float) -> None:
    assert 0.32 <= LAW.coefficient(speed + more) <= LAW.coefficient(speed) <= 0.5
    assert LAW.slope(speed) <= LAW.slope(speed + more) <= 0.0


@pytest.mark.parametrize(('temperature', 'expected'), [
    (300.0, 0.30), (350.0, 0.40), (400.0, 0.50), (500.0, 0.45), (600.0, 0.40),
    (0.0, 0.30), (299.9, 0.30), (600.1, 0.40), (5000.0, 0.40)])
def test_table_is_linear_between_points_and_flat_beyond(temperature: float,
                                                        expected: float) -> None:
    assert float(TABLE(temperature)) == pytest.approx(expected, rel=1e-12)


def test_table_of_arrays() -> None:
    assert TABLE(np.array([[350.0], [500.0]])) == pytest.approx(np.array([[0.40], [0.45]]))
    assert float(FrictionTable(np.array([300.0]), np.array([0.4]))(999.0)) == 0.4


@given(st.floats(-1e6, 1e6))
def test_table_stays_between_its_extremes(temperature: float) -> None:
    assert 0.30 <= float(TABLE(temperature)) <= 0.50


def test_table_does_not_guess_at_a_temperature_that_is_not_known() -> None:
    assert math.isnan(float(TABLE(math.nan)))


def test_table_keeps_its_own_constant_copy() -> None:
    given_friction = np.array([0.3, 0.4])
    table = FrictionTable(np.array([300.0, 400.0]), given_friction)
    given_friction[:] = 9.0
    assert (table.temperature, table.friction) == ((300.0, 400.0), (0.3, 0.4))
    assert {type(value) for value in table.temperature + table.friction} == {float}
    with pytest.raises(FrozenInstanceError):
        table.friction = (9.0, 9.0)  # type: ignore[misc]


@pytest.mark.parametrize(('temperature', 'friction', 'parts'), [
    ([300.0, 400.0], [0.4], ('2 temperatures and 1 friction', 'give as many')),
    ([[300.0, 400.0]], [[0.4, 0.4]], ('temperature[0] is [300.0, 400.0]', 'a finite number')),
    (np.ones((1, 2)), [0.4], ('temperature[0] is ', 'give a finite number')),
    (300.0, [0.4], ('temperature is 300.0', 'give a list of numbers')),
    ([300.0], None, ('friction is None', 'give a list of numbers')),
    ([300.0, 400.0], [0.4, 'high'], ("friction[1] is 'high'", 'give a finite number')),
    ([300.0, True], [0.4, 0.5], ('temperature[1] is True', 'give a finite number')),
    ([], [], ('do not rise', 'sort')),
    ([400.0, 300.0], [0.4, 0.5], ('[400.0, 300.0]', 'do not rise', 'sort')),
    ([300.0, 300.0], [0.4, 0.5], ('[300.0, 300.0]', 'do not rise', 'sort')),
    ([0.0, 400.0], [0.4, 0.5], ('temperature[0] is 0', 'give a number above 0')),
    ([300.0, 400.0], [0.4, 0.0], ('friction[1] is 0', 'give a number above 0')),
    ([300.0, 400.0], [-0.1, 0.4], ('friction[0] is -0.1', 'give a number above 0')),
    ([300.0, 400.0], [0.4, math.nan], ('friction[1] is nan', 'give a finite number')),
    ([math.nan, 400.0], [0.4, 0.5], ('temperature[0] is nan', 'give a finite number')),
    ([300.0, math.inf], [0.4, 0.5], ('temperature[1] is inf', 'give a finite number')),
    ([300.0, 400.0], [0.4, math.inf], ('friction[1] is inf', 'give a finite number'))])
def test_table_refuses(temperature: Any, friction: Any, parts: tuple[str, ...]) -> None:
    with pytest.raises(SquealError) as caught:
        FrictionTable(temperature, friction)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert [part for part in ('friction table', *parts) if part not in text] == []


def test_tables_can_be_compared() -> None:
    assert (FrictionTable(np.array([300.0, 400.0]), np.array([0.3, 0.4])) == TABLE) is False
    again = FrictionTable([300, 400, 600], (0.30, 0.50, 0.40))
    assert again == TABLE
    assert len({again, TABLE}) == 1


@pytest.mark.parametrize(('wrong', 'text'), [
    ({'static': math.nan}, 'friction_law.static is nan; give a finite number'),
    ({'static': 0.0}, 'friction_law.static is 0; give a number above 0, at most inf'),
    ({'kinetic': -0.3}, 'friction_law.kinetic is -0.3; give a number above 0, at most inf'),
    ({'decay': -1.0}, 'friction_law.decay is -1; give a number above 0, at most inf'),
    ({'decay': math.inf}, 'friction_law.decay is inf; give a finite number'),
    ({'static': 'high'}, "friction_law.static is 'high'; give a finite number")])
def test_law_refuses(wrong: dict[str, Any], text: str) -> None:
    with pytest.raises(SquealError) as caught:
        FrictionLaw(**wrong)
    assert str(caught.value) == text
