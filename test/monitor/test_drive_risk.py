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

"""The risk over a drive from signals, against the monitor asked tick by tick."""

from dataclasses import replace
import math

import numpy as np
import pytest
from squeal_core import BrakeModel, load_settings, VehicleMonitor
from squeal_core.common import resources
from squeal_core.monitor.inputs.reading import Sample
from squeal_core.monitor.results.drive_risk import drive_risk
from squeal_core.monitor.settings import MonitorSettings
from squeal_core.vehicle.vehicle_model import BrakeSignals
from support.stability_models import fluttering

NAMES = ('front_left', 'front_right', 'rear_left', 'rear_right')
SECOND = 1_000_000_000


@pytest.fixture(scope='module')
def settings() -> MonitorSettings:
    return replace(load_settings(resources.config_folder() / 'monitor.yaml'), rate=2.0,
                   ensemble_size=16.0)


def signals(seconds: float) -> BrakeSignals:
    """Return a stop: braking from 2 s on, the friction of the front higher."""
    time = np.arange(0.0, seconds + 0.05, 0.1)
    speed = np.maximum(60.0 - 6.0 * np.maximum(time - 2.0, 0.0), 0.0)
    four = np.ones(4)
    return BrakeSignals(
        time, 0.3 * speed, NAMES, rotor_speed=speed[:, None] * four,
        pressure=np.where(time > 2.0, 1.5e6, 0.0)[:, None] * [1.0, 1.0, 0.7, 0.7],
        temperature=400.0 + 0.0 * time[:, None] * four,
        friction=(0.4 + 0.005 * time)[:, None] * [1.05, 1.05, 0.95, 0.95])


def test_the_risk_is_the_monitors(settings: MonitorSettings) -> None:
    model, drive = BrakeModel.load('kang2009_damped'), signals(4.0)
    found = drive_risk(model, drive, settings)
    monitor, risks = VehicleMonitor(settings, model), []
    for row, elapsed in enumerate(drive.time.tolist()):
        now = SECOND + round(1e9 * elapsed)
        for column, brake in enumerate(NAMES):
            for signal in ('rotor_speed', 'pressure', 'friction'):
                monitor.receive(brake, signal, Sample(now, float(
                    getattr(drive, signal)[row, column])))
        if row % 5 == 0:  # twice a second
            risks += [one.risk for one in monitor.assess(now) if one.state == 'steady']
    assert 10 < len(risks) == sum(map(math.isfinite, risks))
    assert found.unknown == ''
    assert found.mean_risk == pytest.approx(np.mean(risks), abs=1e-6)
    assert found.peak_risk == pytest.approx(max(risks), abs=1e-6)
    assert found.known_share == 1.0
    assert found.braking_s == pytest.approx(0.5 * len(risks))
    assert found.alarm_s == pytest.approx(0.5 * sum(
        risk >= settings.risk_warning for risk in risks))


def test_without_an_emulator_it_is_said_that_nothing_is_known(settings: MonitorSettings) -> None:
    model = replace(fluttering(6e-3), caliper=BrakeModel.load('kang2009').caliper)
    found = drive_risk(model, signals(3.0), settings)
    assert 'squeal tabulate' in found.unknown
    assert math.isnan(found.mean_risk)


def test_a_drive_without_braking_has_no_risk_and_says_why(settings: MonitorSettings) -> None:
    found = drive_risk(BrakeModel.load('kang2009_damped'), signals(1.5), settings)
    assert 'not applied' in found.unknown
    assert found.braking_s == 0.0
