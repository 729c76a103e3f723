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

"""Drives and schedules recorded without ROS, and what a monitor says of driving backward."""

from dataclasses import replace
import math
from pathlib import Path

import numpy as np
import pytest
from squeal_core.common.resources import config_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.results.history import row_of
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Assessment, Sample, VehicleMonitor
from squeal_core.vehicle.schedule import Schedule, Stop
from squeal_core.vehicle.schedule_drive import drive_schedule
from squeal_core.vehicle.vehicle_model import BrakeSignals, read_vehicle
from squeal_ros.recordings.bags.bag_reader import Bag
from support.commands import answer, squeal

SCHEDULE = """
modules:
- {kind: drag, direction: forward and backward, speed_km_h: 5, pressure_bar: 15, duration_s: 2}
"""


def test_a_schedule_is_recorded_without_ros_and_replayed(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / 'there_and_back.yaml').write_text(SCHEDULE)
    drive = ['drive', str(tmp_path / 'there_and_back.yaml'), '--model', 'kang2009_damped']
    bag = tmp_path / 'bag.mcap'
    code, out, err = squeal(capsys, *drive, '--offline', '--record', str(bag))
    assert (code, out) == (0, f'written: {bag}, 8.4 s of driving\n'), err
    found = answer(capsys, 'replay', str(bag), '-o', str(tmp_path / 'out.mcap'), '--model',
                   'kang2009_damped', '--rate', '5')
    assert found['assessed_share'] == 1.0
    assert not found['findings']
    code, _, err = squeal(capsys, *drive, '--offline', '--record', str(bag))
    assert (code, 'exists; give --force' in err) == (2, True)


@pytest.mark.parametrize(('options', 'text'), [
    (['us06', '--offline'], '--offline: there is no --record; give --record FILE.mcap'),
    (['us06', '--offline', '--record', 'x.mcap', '--wall-time'], '--offline: --wall-time is'),
    (['us06', '--rate', '0'], '--rate: is 0.0; give a positive'),
    (['us06', '--rate', '2000'], '--rate: is 2000; give at most 1000'),
    (['us07'], 'or a shipped schedule (j2521_manner, short) (did you mean us06?)'),
    (['none.yaml'], "'none.yaml': there is no such file, and none of schedules that are shipped")])
def test_options_that_cannot_be(capsys: pytest.CaptureFixture[str], tmp_path: Path,
                                monkeypatch: pytest.MonkeyPatch, options: list[str],
                                text: str) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, err = squeal(capsys, 'drive', *options)
    assert (code, err.count('\n')) == (2, 1)
    assert text in err


def test_offline_records_what_the_player_does(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Compare topics, types, times and what the messages say; padding of live ones is random."""
    pytest.importorskip('rclpy')
    drive = ['drive', 'us06', '--duration', '1', '--speed-up', '10', '--record']
    assert squeal(capsys, *drive, str(tmp_path / 'live.mcap'))[0] == 0
    assert squeal(capsys, *drive, str(tmp_path / 'offline.mcap'), '--offline')[0] == 0
    live, offline = ([(one.topic, one.type_name, one.time, repr(bag.decode(one)[0]))
                      for one in bag.records({
                          topic: next(iter(kinds)) for topic, kinds in bag.types.items()})]
                     for bag in (Bag(tmp_path / f'{name}.mcap') for name in ('live', 'offline')))
    assert len(live) == 11 * 13
    assert live == offline


def assessments(signals: BrakeSignals) -> list[Assessment]:
    monitor = VehicleMonitor(read_settings({
        'brakes': list(signals.brakes), 'ensemble_size': 16.0, 'model': 'kang2009_damped',
        'audit_interval': 30.0}), BrakeModel.load('kang2009_damped'))
    found: list[Assessment] = []
    for step, seconds in enumerate(signals.time):
        now = round((seconds + 1.0) * 1e9)
        for i, brake in enumerate(signals.brakes):
            for signal in ('rotor_speed', 'pressure', 'friction'):
                monitor.receive(brake, signal,  # type: ignore[arg-type]
                                Sample(now, float(getattr(signals, signal)[step, i])))
        found += monitor.assess(now)
    return found


def test_backward_the_monitor_says_what_it_says_forward() -> None:
    """The spectrum is that of (-Omega, -mu), so all figures are, risk and margins among them."""
    model = BrakeModel.load('kang2009_damped')
    assert model.friction_table is not None
    vehicle = read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml')
    stop = Stop('drag', 'drag', 2.0, 0.0, 20e5, math.nan, math.nan, 1.0, 0.0)
    signals = drive_schedule(Schedule('x', (stop,)), vehicle, model.friction_table).signals
    forward = assessments(signals)
    backward = assessments(replace(signals, rotor_speed=-signals.rotor_speed))
    steady = [one for one in forward if one.state == 'steady']
    assert len(steady) > 40
    assert any(one.risk > 0.2 and one.growth_rate > 0.0 for one in steady)
    for one, other in zip(map(row_of, forward), map(row_of, backward), strict=True):
        assert other.rotor_speed_rad_s == -one.rotor_speed_rad_s
        assert other.state == one.state
        for name in ('squeal_risk', 'instability_probability', 'build_up_nepers',
                     'time_to_squeal_s', 'growth_rate_1_s', 'damping_ratio',
                     'worst_frequency_hz', 'friction_margin', 'unstable_frequencies_hz'):
            np.testing.assert_allclose(getattr(other, name), getattr(one, name), rtol=1e-6,
                                       atol=1e-9, err_msg=f'{name} at {one.time_s} s')
