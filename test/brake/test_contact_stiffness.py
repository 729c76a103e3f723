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

"""Contact stiffness over pressure: the same wherever an operating point is made."""

from dataclasses import replace
import json
from pathlib import Path

import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.dimensions import StiffnessTable
from squeal_core.monitor.inputs.reading import Sample
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import BrakeMonitor
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.parameter_paths import moved
from squeal_core.studies.sweep import sweep
from squeal_ros.cli.main import main

TABLE = StiffnessTable((2e5, 10e5), (0.2e11, 0.6e11))
SIGNALS = {'rotor_speed': 20.0, 'pressure': 6e5, 'friction': 0.42}
SECOND = 1_000_000_000


@pytest.fixture(scope='module')
def lining(kang: BrakeModel) -> BrakeModel:
    return replace(kang, stiffness_table=TABLE)


def by_hand(model: BrakeModel, pressure: float) -> float:
    assert model.caliper is not None
    p0 = model.caliper.piston_area * pressure / model.contact_area
    return 0.2e11 + 0.4e11 * min(max((p0 - 2e5) / 8e5, 0.0), 1.0)


@pytest.mark.parametrize('pressure', [0.0, 6e5, 12e5, 1e8])
def test_an_operating_point_follows_the_pressure(lining: BrakeModel, pressure: float) -> None:
    point = lining.operating_point(rotor_speed=5.0, pressure=pressure)
    assert point.contact_stiffness == pytest.approx(by_hand(lining, pressure), rel=1e-12)


def test_what_is_given_is_taken(lining: BrakeModel, kang: BrakeModel) -> None:
    given = lining.operating_point(**SIGNALS, contact_stiffness=1e10)
    assert given.contact_stiffness == 1e10
    assert kang.operating_point(**SIGNALS).contact_stiffness == kang.nominal_contact_stiffness


def test_pressure_takes_the_stiffness_along(lining: BrakeModel, kang: BrakeModel) -> None:
    point = OperatingPoint(rotor_speed=5.0, friction=0.4, contact_pressure=4e5,
                           contact_stiffness=2 * 0.3e11)  # twice the table's
    there = moved(lining, point, 'contact_pressure', 8e5)
    assert there == replace(point, contact_pressure=8e5, contact_stiffness=2 * 0.5e11)
    assert moved(kang, point, 'contact_pressure', 8e5) == replace(point, contact_pressure=8e5)


@pytest.mark.parametrize('order', [1, -1])
def test_of_two_axes_the_stiffness_is_what_it_says(lining: BrakeModel, order: int) -> None:
    point = lining.operating_point(**SIGNALS)
    axes = {'contact_pressure': [4e5, 8e5], 'contact_stiffness': [1e10]}
    found = sweep(lining, point, dict(list(axes.items())[::order]))
    assert found.column('contact_stiffness').ravel().tolist() == [1e10, 1e10]
    alone = sweep(lining, point, {'contact_pressure': [4e5, 8e5]})
    assert alone.column('contact_stiffness') == pytest.approx([0.3e11, 0.5e11], rel=1e-12)


def test_the_monitor_assesses_there(lining: BrakeModel) -> None:
    settings = read_settings({'brakes': ['a']})
    watch = BrakeMonitor(settings.brakes[0], settings, lining)
    for name, value in SIGNALS.items():
        watch.receive(name, Sample(SECOND, value))  # type: ignore[arg-type]
    found = watch.assess(SECOND)
    assert found.point is not None
    assert found.point.contact_stiffness == pytest.approx(by_hand(lining, 6e5), rel=1e-12)
    worst = complex_modes(lining, found.point).flutter_in(1250.0, 16000.0)[0]
    # 0.1 1/s: what the engine may be off by
    assert found.growth_rate == pytest.approx(worst.growth_rate, abs=0.1)


def test_the_commands_show_it(lining: BrakeModel, tmp_path: Path,
                              capsys: pytest.CaptureFixture[str]) -> None:
    path = str(tmp_path / 'lining.npz')
    lining.save(path)
    assert main(['info', path]) == 0
    assert 'by table 2e+10 to 6e+10 N/m^3 over 2 to 10 bar' in capsys.readouterr().out
    assert main(['modes', path, '--rotor-speed', '5', '--pressure', '6e5', '--json']) == 0
    point = json.loads(capsys.readouterr().out)['point']
    assert point['contact_stiffness'] == pytest.approx(by_hand(lining, 6e5), rel=1e-12)
