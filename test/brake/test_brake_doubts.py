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

"""Numbers of a brake description in another unit, refused; unusual ones, doubted."""

from typing import Any

import pytest
from squeal_core.brake.brake_yaml import parse_brake
from squeal_core.common.ranges import ImplausibleWarning
from support.brake_descriptions import DELETED, edited, refusal
from support.rows import each


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
