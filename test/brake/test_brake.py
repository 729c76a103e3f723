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

"""Brake descriptions: the shipped one number by number; units; what may be left out."""

import dataclasses
import math
from operator import attrgetter
from typing import Any

import pytest
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.brake.dimensions import Brake, Caliper
from support.brake_descriptions import CONTENT, DELETED, edited, NUMBERS, OPTIONAL
from support.rows import each


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
