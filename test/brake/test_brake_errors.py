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

"""Brake descriptions with wrong keys, units and values, refused in one line."""

from copy import deepcopy
import math
from typing import Any

from support.brake_descriptions import (
    check,
    CONTENT,
    DELETED,
    edited,
    NUMBERS,
    OPTIONAL,
    place_of,
    refusal,
)
from support.rows import each

SECTIONS = ('', 'disc', 'pads', 'contact', 'caliper', 'friction', 'modes')


@each('key', ['name', *(k for k in NUMBERS if k not in OPTIONAL)])
def test_missing_number(key: str) -> None:
    stem = key
    for unit in ('_mm', '_gpa', '_kg_m3', '_deg', '_n_m3', '_s_m'):
        stem = stem.removesuffix(unit)
    check(refusal(edited({key: DELETED})), f'brake.{stem}', 'is missing; add')


@each('section', SECTIONS[1:])
@each(('value', 'part'), [
    (DELETED, 'is missing; add this section'), (None, 'is None; write a mapping'),
    ([1], 'is [1]; write a mapping'), (3, 'is 3; write a mapping')])
def test_missing_or_wrong_section(section: str, value: Any, part: str) -> None:
    check(refusal(edited({section: value})), f'brake.{section}: {part}')


@each('section', [*SECTIONS, 'friction.temperature_table'])
@each('key', ['thicknes_mm', 'colour', 3, None])
def test_unknown_key(section: str, key: Any) -> None:
    content = deepcopy(CONTENT)
    place_of(filter(None, section.split('.')), content)[key] = 'red'
    check(refusal(content), f'{".".join(filter(None, ["brake", section, str(key)]))}: ',
          "'red'", 'remove it, or use one of')


def test_unknown_key_beside_value_and_source() -> None:
    text = refusal(edited({'pads.thickness_mm': {'value': 11, 'source': 'x', 'sorce': 'y'}}))
    check(text, 'brake.pads.thickness_mm.sorce', "'y'", 'source, value')


@each(('value', 'part'), [
    ({'source': 'x'}, '.value: is missing'), ({'value': 11}, '.source: is missing'),
    ({'value': 11, 'source': 3}, '.source: is 3; write a text'),
    ({'value': 'thick', 'source': 'x'}, ": is 'thick'; write a number")])
def test_value_and_source_incomplete(value: Any, part: str) -> None:
    check(refusal(edited({'pads.thickness_mm': value})), f'brake.pads.thickness_mm{part}')


@each(('key', 'wrong', 'remedy'), [
    ('pads.thickness_mm', 'pads.thickness_cm', 'use thickness_m or thickness_mm'),
    ('disc.rotor_thickness_mm', 'disc.rotor_thickness', 'use rotor_thickness_m or'),
    ('contact.angle_deg', 'contact.angle_gon', 'use angle_rad or angle_deg'),
    ('contact.stiffness_n_m3', 'contact.stiffness_n_mm3', 'use stiffness_n_m3'),
    ('friction.decay_s_m', 'friction.decay', 'use decay_s_m'),
    ('damping_ratio', 'damping_ratio_percent', 'use damping_ratio')])
def test_wrong_unit_suffix(key: str, wrong: str, remedy: str) -> None:
    text = refusal(edited({key: DELETED, wrong: 12.5}))
    check(text, f'brake.{wrong}: ', 'wrong unit suffix', '12.5', remedy)


@each(('key', 'again'), [
    ('pads.thickness_mm', 'thickness_m'), ('contact.angle_deg', 'angle_rad'),
    ('disc.young_modulus_gpa', 'young_modulus_pa')])
def test_both_units_given(key: str, again: str) -> None:
    section, _, first = key.partition('.')
    check(refusal(edited({f'{section}.{again}': 0.011})), f'brake.{section}.', first, again,
          'keep one of them')


@each('key', NUMBERS)
@each('value', [
    -1.0, math.nan, math.inf, -math.inf, '.nan', 'thick', '', True, [1.0], None])
def test_wrong_value(key: str, value: Any) -> None:
    check(refusal(edited({key: value})), f'brake.{key}: is {value!r}', '; ')


@each(('key', 'value'), [
    *((key, 1e300) for key in NUMBERS), ('pads.thickness_mm', 10**400)])
def test_huge_value(key: str, value: float) -> None:
    check(refusal(edited({key: value})), f'brake.{key}: is 1')


@each(('key', 'value', 'remedy'), [
    ('pads.thickness_mm', 0.0, 'mm; give 0.3 to 150 mm'),
    ('pads.density_kg_m3', 0.0, 'kg/m^3; give 300 to 25000 kg/m^3'),
    ('disc.poisson_ratio', 0.5, '-0.5 to 0.49'), ('contact.angle_deg', 180.0, '1 to 179 deg'),
    ('caliper.efficiency', 1.01, '0.01 to 1'), ('friction.static', 2.0, '0.01 to 1.5'),
    ('damping_ratio', 1.0, '0 to 0.5 (1 % would be 0.01)'), ('modes.disc', 52.5, 'whole number'),
    ('modes.disc', 0, '1 to 500'), ('modes.disc', 501, '1 to 500'), ('modes.pad', 6, '7 to 500'),
    ('name', 3, 'write a text')])
def test_value_just_out_of_range(key: str, value: Any, remedy: str) -> None:
    number = value if isinstance(value, str) or key == 'name' else float(value)
    check(refusal(edited({key: value})), f'brake.{key}: is {number!r}', remedy)


@each(('key', 'value', 'named', 'parts'), [
    ('disc.clamp_radius_mm', 81.8, 'disc.clamp_radius', ('leaves 0.1 mm of the top plate',)),
    ('disc.top_plate_thickness_mm', 27.25, 'disc.hat_height', ('leaves 0.05 mm of hat wall',)),
    ('contact.inner_radius_mm', 141.5, 'contact.outer_radius', ('a patch 0.5 mm wide',)),
    ('contact.outer_radius_mm', 149, 'contact.outer_radius', ('149 mm', 'off the disc')),
    ('contact.inner_radius_mm', 80, 'contact.inner_radius', ('80 mm', 'within the hat')),
    ('contact.inner_radius_mm', 142, 'contact.outer_radius', ('142 mm', 'make outer_radius')),
    ('disc.rotor_outer_radius_mm', 89, 'disc.rotor_outer_radius', ('89 mm', 'the larger')),
    ('disc.top_plate_thickness_mm', 28, 'disc.hat_height', ('28 mm', 'the larger')),
    ('disc.clamp_radius_mm', 85, 'disc.hat_wall_thickness', ('7.5 mm', '85 mm', 'thinner')),
    ('disc.clamp_radius_mm', 90, 'disc.hat_wall_outer_radius', ('90 mm', 'the larger')),
    ('disc.hat_wall_thickness_mm', 60, 'disc.hat_wall_thickness', ('60 mm', 'clamp smaller')),
    ('disc.hat_wall_thickness_mm', 90, 'disc.hat_wall_outer_radius', ('90 mm', 'the larger'))])
def test_parts_that_do_not_fit(key: str, value: float, named: str, parts: Any) -> None:
    check(refusal(edited({key: value})), f'brake.{named}', *parts)


@each(('key', 'value', 'part'), [
    ('friction', [0.4], '1 friction coefficients; give as many'),
    ('friction', [0.4] * 6 + [0.0], 'friction[6]: is 0.0; give 0.01 to 1.5'),
    ('friction', DELETED, 'is None; write'),
    ('friction', [], 'is []; write'), ('friction', 0.4, 'is 0.4; write a list'),
    ('temperature_degc', [20, 100, 90, 300, 400, 500, 600], 'do not rise; sort'),
    ('temperature_degc', [20, math.nan], 'temperature_degc[1]: is nan; write a finite number'),
    ('temperature_degc', [-300, 1, 2, 3, 4, 5, 6], 'degc[0]: is -300.0 degC; give -100')])
def test_wrong_friction_table(key: str, value: Any, part: str) -> None:
    check(refusal(edited({f'friction.temperature_table.{key}': value})),
          'brake.friction.temperature_table', part)


@each('key', ['colour', 'disc', 'pads.thickness_mm', 'name', 'k' * 10000])
@each('value', ['red' * 10000, [[1] * 9000] * 9000, 10**4000])
def test_refusals_stay_short(key: str, value: Any) -> None:
    assert len(refusal(edited({key: [value] if key == 'name' else value}))) < 1000
