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

"""What how-to pages show runs: settings are accepted, code computes what the page says."""

from pathlib import Path
import re
from typing import Any

from markdown_it import MarkdownIt
import pytest
from squeal_core import BrakeModel, load_settings
from squeal_core.common.resources import config_folder
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, read_vehicle

HOWTO = Path(__file__).parents[2] / 'docs' / 'howto'


def blocks(page: str, language: str) -> list[str]:
    """Return the code blocks of a page without captions."""
    tokens = MarkdownIt().parse((HOWTO / page).read_text(encoding='utf-8'))
    return [re.sub(r'^:caption: .*\n\n?', '', token.content) for token in tokens
            if token.info in (language, f'{{code-block}} {language}')]


def test_settings_with_a_constant_friction(tmp_path: Path) -> None:
    (text,) = blocks('missing_sensors.md', 'yaml')
    (tmp_path / 'settings.yaml').write_text(text, encoding='utf-8')
    settings = load_settings(tmp_path / 'settings.yaml')
    assert [(set(brake.inputs), brake.constant_friction) for brake in settings.brakes] == [
        ({'rotor_speed', 'pressure'}, 0.40)] * 2


def test_the_heat_balance_is_that_of_the_drive_player() -> None:
    (text,) = blocks('missing_sensors.md', 'python')
    code: dict[str, Any] = {}
    exec(text, code)
    vehicle = read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml')
    table = BrakeModel.load('kang2009_damped').friction_table
    assert table is not None
    cycle = read_drive_cycle(config_folder() / 'drive_cycles' / 'us06.csv')
    drive = brake_signals(cycle, vehicle, table, rate=10.0)
    temperature = vehicle.initial_temperature
    for speed, pressure in zip(drive.rotor_speed[:-1, 0], drive.pressure[:-1, 0], strict=True):
        temperature = code['next_temperature'](temperature, speed, pressure, 0.1)
    assert temperature > vehicle.initial_temperature + 50.0
    assert temperature == pytest.approx(drive.temperature[-1, 0], abs=2.0)
