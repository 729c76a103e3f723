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

"""Short touches of a brake: build-up and risk of all of it do not depend on the rate of ticks."""

import numpy as np
import pytest
from squeal_core import BrakeModel, VehicleMonitor
from squeal_core.monitor.inputs.reading import Sample
from squeal_core.monitor.settings import read_settings

MS = 1_000_000  # ns
BEGIN, END = 600 * MS, 800 * MS


def largest(model: BrakeModel, rate: int, phase: int) -> list[float]:
    """Return the largest build-up and risk of a touch of 0.2 s that begins at a phase [ns]."""
    monitor = VehicleMonitor(read_settings({
        'brakes': ['front'], 'model': 'kang2009_damped', 'rate': float(rate)}), model)
    found, noise = [], np.random.default_rng(0)
    for time in range(0, 1300 * MS, 10 * MS):
        pressed = BEGIN + phase <= time < END + phase
        for signal, value in (('rotor_speed', 40.0), ('pressure', 1.5e6), ('friction', 0.55)):
            shown = value if pressed or signal != 'pressure' else 0.0
            monitor.receive('front', signal, Sample(time, shown * noise.normal(1.0, 1e-3)))
        if time % (1000 // rate * MS) == 0:
            [assessment] = monitor.assess(time)
            found.append((assessment.build_up, assessment.application_risk))
    return [float(value) for value in np.nanmax(found, axis=0)]


def test_rates_of_ticks_agree_on_a_touch() -> None:
    """Wherever the touch falls between ticks; at 100 Hz every fifth tick evaluates the risk."""
    model = BrakeModel.load('kang2009_damped')
    build_up, risk = np.array([[largest(model, rate, phase * MS) for phase in (0, 30, 70)]
                               for rate in (10, 20, 100)]).T
    assert np.ptp(build_up) < 0.3
    assert np.min(build_up) == pytest.approx(2.7, abs=0.5)
    assert np.ptp(risk) < 0.03 < np.min(risk)
