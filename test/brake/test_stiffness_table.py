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

"""Contact stiffness over pressure in a brake description, right and wrong."""

import math
from typing import Any

import pytest
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.dimensions import StiffnessTable
from squeal_core.common.errors import SquealError
from support.brake_descriptions import check, DELETED, edited, refusal
from support.rows import each

STIFFNESSES = {'contact_pressure_bar': [2, 8, 40], 'stiffness_n_m3': [0.2e11, 0.35e11, 0.8e11]}


@each(('suffix', 'scale'), [('bar', 1.0), ('mpa', 0.1), ('pa', 1e5)])
def test_contact_stiffness_over_pressure(suffix: str, scale: float) -> None:
    pressures = [scale * value for value in STIFFNESSES['contact_pressure_bar']]
    brake = parse_brake(edited({'contact.stiffness_table': {
        'source': 'bench', f'contact_pressure_{suffix}': pressures,
        'stiffness_n_m3': STIFFNESSES['stiffness_n_m3']}}))
    table = brake.contact.stiffness_table
    assert table is not None
    assert table.pressure == pytest.approx((2e5, 8e5, 40e5), rel=1e-12)
    assert table([0.0, 2e5, 5e5, 24e5, 40e5, 1e9]) == pytest.approx(
        [0.2e11, 0.2e11, 0.275e11, 0.575e11, 0.8e11, 0.8e11], rel=1e-12)
    assert brake.contact.stiffness == 0.35e11
    assert brake.sources['contact.stiffness_table'] == 'bench'


@each(('key', 'value', 'part'), [
    ('stiffness_n_m3', [1e10], '3 pressures and 1 stiffnesses; give as many'),
    ('stiffness_n_m3', [1e10, 0.0, 1e10], 'stiffness_n_m3[1]: is 0.0 N/m^3; give'),
    ('stiffness_n_m3', [1e10, math.nan, 1e10], 'stiffness_n_m3[1]: is nan; write a finite number'),
    ('stiffness_n_m3', 1e10, 'is 10000000000.0; write a list'),
    ('stiffness_n_m3', DELETED, 'stiffness_n_m3: is missing; add stiffness_n_m3'),
    ('stiffness', 3, 'stiffness: unknown key'),
    ('contact_pressure_bar', [2, 40, 8], 'do not rise; sort'),
    ('contact_pressure_bar', [2, 2, 8], 'do not rise; sort'),
    ('contact_pressure_bar', [-1, 2, 8], 'contact_pressure_bar[0]: is -1.0 bar; give 0 to'),
    ('contact_pressure_bar', [], 'write a list of numbers'),
    ('contact_pressure_pa', [1, 2, 3], 'says again what contact_pressure_pa says'),
    ('friction', 0.4, 'unknown key'), ('source', 3, 'is 3; write a text')])
def test_wrong_stiffness_table(key: str, value: Any, part: str) -> None:
    table = {**STIFFNESSES, key: value}
    table = {name: item for name, item in table.items() if item is not DELETED}
    check(refusal(edited({'contact.stiffness_table': table})), 'brake.contact.stiffness_table',
          part)


@each(('pressure', 'stiffness', 'part'), [
    ([1e5], 3.0, 'stiffness is 3.0; give a list'), ([], [], 'do not rise; sort'),
    ([1e5], [-1.0], 'stiffness[0] is -1; give a number above 0'),
    ([-1.0], [1e10], 'pressure[0] is -1; give a number')])
def test_stiffness_tables_that_are_none(pressure: Any, stiffness: Any, part: str) -> None:
    with pytest.raises(SquealError, match='stiffness table: ') as caught:
        StiffnessTable(pressure, stiffness)
    check(str(caught.value), part)
