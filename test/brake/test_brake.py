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

"""Brake descriptions: the shipped one number by number, and every way to get one wrong."""

from collections.abc import Iterable
from copy import deepcopy
import dataclasses
from functools import reduce
import math
from operator import attrgetter, getitem
from pathlib import Path
from typing import Any

import pytest
from squeal_core.brake.brake_yaml import parse_brake, read_brake
from squeal_core.brake.dimensions import Brake, Caliper, StiffnessTable
from squeal_core.common.errors import BrakeDescriptionError, SquealError
from squeal_core.common.ranges import ImplausibleWarning
from support.rows import each
import yaml

SHIPPED = Path(__file__).parents[2] / 'config' / 'brakes' / 'kang2009.yaml'
CONTENT = yaml.safe_load(SHIPPED.read_text(encoding='utf-8'))
SECTIONS = ('', 'disc', 'pads', 'contact', 'caliper', 'friction', 'modes')
OPTIONAL = ('title', 'caliper.efficiency')
DELETED = object()


def numeric_keys(mapping: dict[str, Any], prefix: str = '') -> list[str]:
    """Paths of all scalars of the shipped description that carry a source."""
    found = []
    for key, value in mapping.items():
        if isinstance(value, dict):
            found += ([f'{prefix}{key}'] if 'value' in value
                      else numeric_keys(value, f'{prefix}{key}.'))
    return found


NUMBERS = numeric_keys(CONTENT)


def place_of(sections: Iterable[str], content: dict[str, Any]) -> dict[str, Any]:
    return reduce(getitem, sections, content)


def edited(changes: dict[str, Any]) -> dict[str, Any]:
    """Return the shipped description with values at dotted paths replaced, added or deleted."""
    content = deepcopy(CONTENT)
    for path, value in changes.items():
        *sections, key = path.split('.')
        place = place_of(sections, content)
        place[key] = value
        if value is DELETED:
            del place[key]
    return content


def refusal(content: Any, read: Any = parse_brake) -> str:
    with pytest.raises(BrakeDescriptionError) as caught:
        read(content, warn=lambda _: None)
    text = str(caught.value)
    assert len(text.splitlines()) == 1
    assert text.rpartition('; ')[2]
    return text


def check(text: str, *parts: str) -> None:
    assert [part for part in parts if part not in text] == []


@each(('path', 'expected'), [
    ('disc.material.young_modulus', 88.9e9), ('disc.material.density', 7150.0),
    ('disc.material.poisson_ratio', 0.285), ('disc.rotor_thickness', 0.016),
    ('disc.rotor_outer_radius', 0.1483), ('disc.hat_wall_outer_radius', 0.0894),
    ('disc.hat_wall_thickness', 0.0075), ('disc.hat_wall_inner_radius', 0.0819),
    ('disc.hat_height', 0.0273), ('disc.top_plate_thickness', 0.0083),
    ('disc.clamp_radius', 0.0406),
    ('pad.material.young_modulus', 207e9), ('pad.material.density', 7820.0),
    ('pad.material.poisson_ratio', 0.29), ('pad.thickness', 0.011),
    ('contact.inner_radius', 0.100), ('contact.outer_radius', 0.142),
    ('contact.angle', 1.0821041362364843), ('contact.stiffness', 3.5e10),
    ('caliper.piston_area', 2.551758632878e-3), ('caliper.efficiency', 1.0),
    ('friction_law.static', 0.5), ('friction_law.kinetic', 0.32), ('friction_law.decay', 1.0),
    ('damping_ratio', 0.002), ('disc_modes', 52), ('pad_modes', 20)])
def test_shipped_brake_in_si_units(brake: Brake, path: str, expected: float) -> None:
    assert attrgetter(path)(brake) == pytest.approx(expected, rel=1e-12)


def test_shipped_name_and_friction_table(brake: Brake) -> None:
    assert brake.name == 'kang2009'
    assert brake.friction_table is not None
    assert brake.friction_table.temperature == pytest.approx(
        [293.15, 373.15, 473.15, 573.15, 673.15, 773.15, 873.15])
    assert brake.friction_table.friction == (0.38, 0.42, 0.45, 0.44, 0.40, 0.35, 0.30)


def test_every_shipped_number_has_a_source(brake: Brake) -> None:
    assert len(NUMBERS) == 26
    assert set(brake.sources) == {*NUMBERS, 'friction.temperature_table'}
    for key, start in (('disc.density_kg_m3', 'K09 table 1'), ('disc.hat_height_mm', 'fitted'),
                       ('caliper.efficiency', 'assumed'), ('friction.decay_s_m', 'K09 figure 9'),
                       ('contact.stiffness_n_m3', 'K09 table 2'), ('modes.disc', 'assumed'),
                       ('friction.temperature_table', 'assumed; a pad that fades')):
        assert brake.sources[key].startswith(start)


def test_patch_and_caliper_closed_forms(brake: Brake) -> None:
    assert brake.contact.area == pytest.approx(
        math.pi * (0.142**2 - 0.1**2) * 62 / 360, rel=1e-12)
    assert brake.contact.mean_radius == pytest.approx(0.1222, abs=5e-5)
    assert brake.caliper.preload(7.84e5) == pytest.approx(2000.0, abs=1.0)
    assert brake.caliper.preload(0.0) == 0.0
    assert Caliper(2.5e-3, 0.9).preload(1e6) == pytest.approx(2250.0)


@each(('key', 'same', 'value'), [
    *((key, f'{key[:-3]}_m', 1e-3) for key in NUMBERS if key.endswith('_mm')),
    ('contact.angle_deg', 'contact.angle_rad', math.pi / 180),
    ('pads.young_modulus_gpa', 'pads.young_modulus_mpa', 1e3),
    ('pads.young_modulus_gpa', 'pads.young_modulus_pa', 1e9)])
def test_other_units_say_the_same(brake: Brake, key: str, same: str, value: float) -> None:
    section, _, name = key.partition('.')
    other = parse_brake(edited({key: DELETED, same: CONTENT[section][name]['value'] * value}))
    for part in ('disc', 'pad', 'contact', 'caliper'):
        was, now = (flat(dataclasses.astuple(getattr(b, part))) for b in (brake, other))
        assert now == pytest.approx(was, rel=1e-12)


def flat(values: Any) -> list[float]:
    return sum((flat(v) if isinstance(v, tuple) else [v] for v in values if v is not None), [])


def test_plain_numbers_and_texts_of_numbers(brake: Brake) -> None:
    plain = {'pads.thickness_mm': 11, 'contact.stiffness_n_m3': '0.35e11'}
    assert parse_brake(edited(plain)) == brake != parse_brake(edited({'pads.thickness_mm': 12}))
    most = parse_brake(edited({'modes.disc': 500, 'modes.pad': 7}), warn=lambda _: None)
    assert (most.disc_modes, most.pad_modes) == (500, 7)


@each('key', [*OPTIONAL, 'friction.temperature_table'])
def test_what_may_be_left_out(key: str) -> None:
    brake = parse_brake(edited({key: DELETED}))
    assert brake.caliper.efficiency == 1.0
    assert (brake.friction_table is None) == (key == 'friction.temperature_table')


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
    ('contact.outer_radius_mm', 149, 'contact.outer_radius', ('0.149 m', 'off the disc')),
    ('contact.inner_radius_mm', 80, 'contact.inner_radius', ('0.08 m', 'within the hat')),
    ('contact.inner_radius_mm', 142, 'contact.outer_radius', ('0.142 m', 'make outer_radius')),
    ('disc.rotor_outer_radius_mm', 89, 'disc.rotor_outer_radius', ('0.089 m', 'the larger')),
    ('disc.top_plate_thickness_mm', 28, 'disc.hat_height', ('0.028 m', 'the larger')),
    ('disc.clamp_radius_mm', 85, 'disc.hat_wall_thickness', ('0.0075 m', '0.085 m', 'thinner')),
    ('disc.clamp_radius_mm', 90, 'disc.hat_wall_outer_radius', ('0.09 m', 'the larger')),
    ('disc.hat_wall_thickness_mm', 60, 'disc.hat_wall_thickness', ('0.06 m', 'clamp smaller')),
    ('disc.hat_wall_thickness_mm', 90, 'disc.hat_wall_outer_radius', ('0.09 m', 'the larger'))])
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


@each(('text', 'part'), [
    ('', 'is None; write a mapping'), ('- 1', 'is [1]; write a mapping'), ('3', 'is 3; write'),
    ('a: [', 'is not YAML'), ('a: b: c', 'is not YAML'), ('a: \x00', 'is not YAML'),
    ('a: 1\n---\nb: 2', 'is not YAML'), ('? [1]\n: 2', 'is not YAML'), ('<<: 3', 'is not YAML'),
    *((f'name: {value}', 'is not YAML') for value in (
        '2024-13-45', '!!int x', '!!bool x', '!!timestamp x')),
    *((t, 'is not YAML') for t in (f'name: {"1" * 5000}', '[' * 5000)),
    ('a: &x [1]\nb: *x', 'an alias (*) in line 2'), ('a: *x', 'an alias (*) in line 1'),
    ('name: a\n"name": b', "'name' twice in the mapping at line 1"),
    ('a: 1\nb:\n  c: [{3: 1, 3: 1}]', "'3' twice in the mapping at line 3")])
def test_wrong_file(tmp_path: Path, text: str, part: str) -> None:
    bad = tmp_path / 'bad.yaml'
    bad.write_text(text, encoding='utf-8')
    check(refusal(bad, read_brake), 'bad.yaml: ', part)


def test_one_key_or_byte_too_many(tmp_path: Path, brake: Brake) -> None:
    bad = tmp_path / 'bad.yaml'
    for text, part in ((b'name: b\n', ": is not YAML this can read ('name' twice in the mapping"),
                       (b'"a\\nb": 1\n', '.a b: unknown key (value 1); remove')):
        bad.write_bytes(text + SHIPPED.read_bytes())
        check(refusal(bad, read_brake), f'bad.yaml{part}')
    bad.write_bytes(SHIPPED.read_bytes().ljust(10**6, b'#'))
    assert read_brake(bad) == brake
    bad.write_bytes(SHIPPED.read_bytes().ljust(10**6 + 1, b'#'))
    check(refusal(bad, read_brake), 'more than the 1000000 that are read')


def test_files_that_hold_no_text(tmp_path: Path) -> None:
    (tmp_path / 'bad.yaml').write_bytes(b'\xff\xfe\x00\x9d')
    check(refusal(tmp_path / 'bad.yaml', read_brake), 'bad.yaml: is not YAML', 'mend it')
    check(refusal(tmp_path / 'none.yaml', read_brake), 'none.yaml: cannot', 'check the path')
    check(refusal(tmp_path, read_brake), str(tmp_path), 'is a folder', 'give the path')


@each('tag', ['python/object/apply:os.mkdir', 'python/object/new:os.mkdir'])
def test_tags_are_not_executed(tmp_path: Path, tag: str) -> None:
    bad, trap = tmp_path / 'bad.yaml', tmp_path / 'executed'
    bad.write_text(f'name: !!{tag} [{trap}]')
    check(refusal(bad, read_brake), 'is not YAML', tag)
    assert not trap.exists()


@each('key', ['colour', 'disc', 'pads.thickness_mm', 'name', 'k' * 10000])
@each('value', ['red' * 10000, [[1] * 9000] * 9000, 10**4000])
def test_refusals_stay_short(key: str, value: Any) -> None:
    assert len(refusal(edited({key: [value] if key == 'name' else value}))) < 1000


def doubts(changes: dict[str, Any]) -> list[str]:
    """Return what is said of the shipped description with some values replaced."""
    said: list[str] = []
    parse_brake(edited(changes), warn=said.append)
    return said


def test_the_shipped_description_is_not_doubted() -> None:
    assert doubts({}) == []


@each(('changes', 'key', 'words'), [
    # numbers in another unit than that of their key, where nothing sensible could follow
    ({'disc.rotor_thickness_mm': 0.016}, 'disc.rotor_thickness_mm', '0.016 m would be 16 mm'),
    ({'pads.thickness_mm': 0.011}, 'pads.thickness_mm', '0.011 m would be 11 mm'),
    ({'disc.clamp_radius_mm': 0.0406}, 'disc.clamp_radius_mm', '0.0406 m would be 40.6 mm'),
    ({'disc.young_modulus_gpa': 0.11}, 'disc.young_modulus_gpa', 'give 1 to 1000 GPa'),
    ({'disc.young_modulus_gpa': 88900}, 'disc.young_modulus_gpa', '88900 MPa would be 88.9 GPa'),
    ({'pads.young_modulus_gpa': 207e9}, 'pads.young_modulus_gpa', 'Pa would be 207 GPa'),
    ({'disc.density_kg_m3': 7.15}, 'disc.density_kg_m3', '7.15 g/cm^3 would be 7150 kg/m^3'),
    ({'disc.density_kg_m3': 7.15e-9}, 'disc.density_kg_m3', 't/mm^3 would be 7150 kg/m^3'),
    ({'contact.stiffness_n_m3': 35}, 'contact.stiffness_n_m3', '35 N/mm^3 would be 3.5e+10'),
    ({'contact.angle_deg': DELETED, 'contact.angle_rad': 62}, 'contact.angle_rad',
     '62 deg would be 1.08'),
    ({'caliper.efficiency': 95}, 'caliper.efficiency', '95 % would be 0.95'),
    ({'friction.static': 42}, 'friction.static', '42 % would be 0.42'),
    ({'caliper.piston_diameter_mm': 0.057}, 'caliper.piston_diameter_mm', 'would be 57 mm'),
    ({'friction.temperature_table.friction': [38, 42, 45, 44, 40, 35, 30]},
     'friction.temperature_table.friction[0]', '38 % would be 0.38')])
def test_numbers_in_another_unit_are_refused(changes: dict[str, Any], key: str,
                                             words: str) -> None:
    text = refusal(edited(changes))
    assert text.startswith(f'brake.{key}: is ')
    assert words in text


@each(('changes', 'key', 'words'), [
    ({'disc.rotor_outer_radius_mm': 480}, 'disc.rotor_outer_radius_mm',
     'if it is the diameter, the radius is 240 mm'),
    ({'contact.angle_deg': 1.0821}, 'contact.angle_deg', '1.0821 rad would be 61.9'),
    ({'pads.young_modulus_gpa': 0.207}, 'pads.young_modulus_gpa', 'usual is 0.3 to 250 GPa'),
    ({'damping_ratio': 0.2}, 'damping_ratio', '0.2 % would be 0.002'),
    ({'damping_ratio': 0}, 'damping_ratio', 'usual is 0.0001 to 0.05'),
    ({'friction.static': 0.3, 'friction.kinetic': 0.5}, 'friction.static', 'swap them'),
    ({'friction.decay_s_m': 0}, 'friction.decay_s_m', 'never comes to kinetic'),
    ({'disc.clamp_radius_mm': 77}, 'disc.clamp_radius', 'leaves 4.9 mm of the top plate'),
    ({'contact.outer_radius_mm': 110}, 'contact.outer_radius', 'usual 0.75 to 1'),
    ({'friction.temperature_table.temperature_degc': [293, 373, 473, 573, 673, 773, 873]},
     'friction.temperature_table.temperature_degc', '293 K would be 19.85 degC'),
    ({'contact.stiffness_table': {'source': 's', 'contact_pressure_pa': [2, 8, 40],
                                  'stiffness_n_m3': [2e10, 3e10, 8e10]}},
     'contact.stiffness_table.contact_pressure_pa[0]', '2 bar would be 200000 Pa'),
    ({'contact.stiffness_table': {'source': 's', 'contact_pressure_bar': [2, 8],
                                  'stiffness_n_m3': [8e10, 2e10]}},
     'contact.stiffness_table', 'stiffness falls with pressure'),
    ({'modes.disc': 2}, 'modes.disc', 'usual is 8 to 300'),
    ({'pads.support': {'axial_stiffness_n_m3': 35}}, 'pads.support.axial_stiffness_n_m3',
     '35 N/mm^3 would be 3.5e+10')])
def test_unusual_numbers_are_doubted_once_with_what_was_meant(changes: dict[str, Any], key: str,
                                                              words: str) -> None:
    own = [text for text in doubts(changes) if text.startswith(f'brake.{key}: ')]
    assert len(own) == 1
    assert words in own[0]


def test_a_reader_that_is_told_nothing_warns() -> None:
    with pytest.warns(ImplausibleWarning, match=r'brake\.damping_ratio: is 0\.2; usual is'):
        parse_brake(edited({'damping_ratio': 0.2}))
