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

"""Ranges that a model was validated for, and those of its friction table."""

import numpy as np
import pytest
from squeal_core.brake.friction import FrictionTable
from support.brake_monitors import assess, GOOD, NAN, small_model, TABLE_ONLY


@pytest.mark.parametrize(('signal', 'value', 'shown'), [
    ('rotor_speed', 200.1, 'rotor_speed is 200.1 rad/s, {} 0.5 to 200'),
    ('rotor_speed', -250.0, 'rotor_speed is -250 rad/s, {} 0.5 to 200'),
    ('pressure', 1.61e7, 'pressure is 1.61e+07 Pa, {} 20000 to 1.6e+07'),
    ('friction', 0.901, 'friction is 0.901, {} 0.05 to 0.9'),
    ('friction', 0.049, 'friction is 0.049, {} 0.05 to 0.9')])
def test_outside_the_validated_range(signal: str, value: float, shown: str) -> None:
    if signal == 'rotor_speed':  # of a released brake, too
        assert assess({**GOOD, 'pressure': 0.0, signal: value}).reason.startswith(signal)
    found = assess({**GOOD, signal: value})
    assert (found.state, found.is_valid) == ('outside validated range', False)
    assert found.reason == shown.format("outside the model's validated range") + ' (0.00 s old)'
    assert np.isnan(found.risk)
    assert found.inputs[signal].status == 'outside validated range'


def test_the_low_ends_of_speed_and_preload_count_under_load_only() -> None:
    low = {'release_pressure': 1e4, 'minimum_rotor_speed': 0.1}
    assert assess({**GOOD, 'pressure': 19e3}, **low).reason == (
        "pressure is 19000 Pa, outside the model's validated range 20000 to 1.6e+07 (0.00 s old)")
    assert assess({**GOOD, 'rotor_speed': -0.4}, **low).state == 'outside validated range'
    assert assess({**GOOD, 'pressure': 21e3, 'rotor_speed': 0.6}, **low).state == 'steady'
    assert assess({**GOOD, 'pressure': 9e3, 'rotor_speed': 0.4}, **low).state == 'released'
    assert assess({**GOOD, 'rotor_speed': 0.05}, **low).state == 'not sliding'


def test_unbelievable_comes_before_unvalidated() -> None:
    found = assess({**GOOD, 'rotor_speed': 250.0, 'friction': NAN})
    assert found.state == 'invalid'
    assert [part.split()[0] for part in found.reason.split('; ')] == ['rotor_speed', 'friction']


@pytest.mark.parametrize(('kelvin', 'friction'), [
    (299.5, 0.5), (300.0, 0.5), (400.0, 0.3), (500.0, 0.1), (500.9, 0.1)])
def test_a_table_is_not_extrapolated(kelvin: float, friction: float) -> None:
    """A sensor may err by 1 K at the ends, where the table is flat."""
    found = assess({**GOOD, 'temperature': kelvin}, **TABLE_ONLY)
    assert (found.state, found.friction) == ('steady', pytest.approx(friction))


@pytest.mark.parametrize('kelvin', [298.9, 250.0, 501.1, 900.0])
@pytest.mark.parametrize('others', [{}, {'a.friction.topic': ''}])
def test_a_temperature_outside_the_table(kelvin: float, others: dict[str, str]) -> None:
    values = {'rotor_speed': 10.0, 'pressure': 2e6, 'temperature': kelvin}
    found = assess(values, **{'a.temperature.topic': '/t', **others})
    assert not found.is_valid
    assert found.reason.endswith(f"temperature is {kelvin:g} K, outside the model's validated "
                                 'range 300 to 500 (0.00 s old)')
    if others:
        assert found.state == 'outside validated range'
    else:
        assert (found.state, found.reason.split(';')[0]) == ('stale', 'friction never received')


def test_a_table_that_gives_more_friction_than_the_model_was_validated_for() -> None:
    hot = small_model(friction_table=FrictionTable((300.0, 500.0), (0.5, 1.3)))
    found = assess({**GOOD, 'temperature': 450.0}, hot, **TABLE_ONLY)
    assert found.state == 'outside validated range'
    assert found.reason.startswith('temperature is 450 K, which gives friction 1.1, outside the')
