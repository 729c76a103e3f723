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

"""Vehicle files: refused with what is wrong and what was meant; unusual numbers doubted."""

from pathlib import Path

import pytest
from squeal_core.vehicle.vehicle import VehicleError
from squeal_core.vehicle.vehicle_model import read_vehicle

MIDSIZE = Path(__file__).parents[2] / 'config' / 'vehicles' / 'midsize.yaml'


@pytest.mark.parametrize(('old', 'new', 'parts'), [
    ('mass_kg: 1600.0', '', ["key 'mass_kg' is missing", 'add a line']),
    ('mass_kg: 1600.0', 'mass: 1600.0', ["unknown key 'mass' = 1600.0", 'mass_kg']),
    ('mass_kg: 1600.0', 'mass_kg: 16.0', ['mass_kg = 16 is out of range', '100 to 100000']),
    ('mass_kg: 1600.0', 'mass_kg: heavy', ["mass_kg = 'heavy' is no number", 'decimal']),
    ('mass_kg: 1600.0', 'mass_kg: true', ['mass_kg = True is no number']),
    ('mass_kg: 1600.0', 'mass_kg:', ['mass_kg = None is no number']),
    ('mass_kg: 1600.0', 'mass_kg: .nan', ['mass_kg = nan is out of range']),
    ('mass_kg: 1600.0', 'mass_kg: [', ['line']),
    ('mass_kg: 1600.0', 'mass_kg: 1600.0\nmass_kg: 1600.0', ["'mass_kg' twice"]),
    ('mass_kg: 1600.0', 'mass_kg: &m 1600.0\nx: *m', ['an alias (*)']),
    ('diameter_mm: 57.0', 'diameter_mm: 0.057', ['piston_diameter_mm = 0.057', '5 to 200']),
    ('[1.0, 0.97, 1.02, 0.99]', '[1.0, 0.97, x, 0.99]', ["friction_factors[2] = 'x'"]),
    ('[1.0, 0.97, 1.02, 0.99]', '[1.0, 0.97, 1.02, -1]', ['friction_factors[3] = -1', '0.1 to']),
    ('[1.0, 0.97, 1.02, 0.99]', '[1.0, 0.97, 1.02]', ['friction_factors = [1.0', 'give four']),
    ('[1.0, 0.97, 1.02, 0.99]', '1.0', ['friction_factors = 1.0 is no list', 'brackets']),
    ('front_right, rear', 'front_left, rear', ['brakes = ', 'different']),
])
def test_error_names_file_key_value_and_remedy(
        tmp_path: Path, old: str, new: str, parts: list[str]) -> None:
    text = MIDSIZE.read_text(encoding='utf-8')
    assert old in text
    path = tmp_path / 'bad.yaml'
    path.write_text(text.replace(old, new), encoding='utf-8')
    with pytest.raises(VehicleError) as caught:
        read_vehicle(path)
    for part in ['bad.yaml', *parts]:
        assert part in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_file_that_is_no_mapping_is_refused(tmp_path: Path) -> None:
    path = tmp_path / 'empty.yaml'
    path.write_text('', encoding='utf-8')
    with pytest.raises(VehicleError, match=r'empty\.yaml: None is no vehicle'):
        read_vehicle(path)


@pytest.mark.parametrize(('old', 'new', 'words'), [
    ('mass_kg: 1600.0', 'mass_kg: 200.0', 'mass_kg = 200; usual is 300 to 40000'),
    ('front_brake_share: 0.7', 'front_brake_share: 0.2', 'front_brake_share = 0.2; usual'),
    ('ambient_temperature_degc: 20.0', 'ambient_temperature_degc: 70.0', 'usual is -40 to 55'),
    ('0.97, 1.02', '0.4, 1.02', 'friction_factors[1] = 0.4; usual is 0.5 to 2')])
def test_unusual_numbers_are_doubted(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = tmp_path / 'odd.yaml'
    path.write_text(MIDSIZE.read_text(encoding='utf-8').replace(old, new), encoding='utf-8')
    said: list[str] = []
    read_vehicle(path, warn=said.append)
    assert len(said) == 1
    assert words in said[0]


@pytest.mark.parametrize(('old', 'new', 'words'), [
    ('mass_kg: 1600.0', 'mass_kg: 1.6', '1.6 t would be 1600'),
    ('wheel_radius_m: 0.336', 'wheel_radius_m: 336', '336 mm would be 0.336'),
    ('effective_radius_mm: 122.2', 'effective_radius_mm: 0.1222', '0.1222 m would be 122.2'),
    ('front_brake_share: 0.7', 'front_brake_share: 70', '70 % would be 0.7'),
    ('ambient_temperature_degc: 20.0', 'ambient_temperature_degc: 293.15', 'K would be 20'),
    ('effective_radius_mm: 122.2', 'effective_radius_mm: 350', 'no less than wheel_radius_m')])
def test_refusals_name_the_unit_that_was_meant(tmp_path: Path, old: str, new: str,
                                               words: str) -> None:
    path = tmp_path / 'bad.yaml'
    path.write_text(MIDSIZE.read_text(encoding='utf-8').replace(old, new), encoding='utf-8')
    with pytest.raises(VehicleError) as caught:
        read_vehicle(path)
    assert words in str(caught.value)
