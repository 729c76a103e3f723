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

"""A small model and monitors of one brake, for tests of the monitor."""

import math
from typing import Any

import numpy as np
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw, FrictionTable
from squeal_core.model.brake_model import BrakeModel
from squeal_core.monitor.setting_specs import Signal
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_monitor import Assessment, BrakeMonitor, Sample

TICK, SECOND = 10_000_000_000, 1_000_000_000
GOOD: dict[Signal, float] = {'rotor_speed': 10.0, 'pressure': 2e6, 'friction': 0.5}
LIMITS = {'rotor_speed': (-400.0, 400.0), 'pressure': (-1.05e5, 3e7), 'friction': (0.01, 1.5)}
SHOWN = {'rotor_speed': ' rad/s, outside its range -400 to 400',
         'pressure': ' Pa, outside its range -105000 to 3e+07',
         'friction': ', outside its range 0.01 to 1.5',
         'temperature': ' K, outside its range 200 to 1500'}
# what the model was validated for; a caliper of 2.5e-3 m^2 makes 4e4 N of 1.6e7 Pa
VALIDATED = {'rotor_speed': (-200.0, 200.0), 'pressure': (-1.05e5, 1.6e7), 'friction': (0.05, 0.9)}
ANY_LEAP = {'wheel_acceleration_peak': 0.0, 'bar_suspected_below': 0.0}
WITH_TABLE = {'a.temperature.topic': '/temperature'}
TABLE_ONLY = {**WITH_TABLE, 'a.friction.topic': ''}
# no cells are made for it, which take longer than a test should
CERTAIN = dict.fromkeys((
    'damping_deviation', 'contact_stiffness_deviation', 'friction_bias_deviation',
    'friction_slope_deviation', 'friction_scatter', 'damping_scatter'), 0.0)
# equal brakes without uncertainty, whose squeal risk is 1 soon after a mode begins to grow
EAGER = {**CERTAIN, 'ensemble_size': 16.0, 'audible_build_up': 1.0,
         'audible_build_up_deviation': 0.0}
NAN = math.nan


def small_model(**changes: Any) -> BrakeModel:
    """Four modes; those at 2000 and 2060 Hz merge at mu = 0.24, others are stable."""
    couple = np.zeros((4, 4))
    couple[2, 3], couple[3, 2] = 2e-3, -2e-3
    shape = np.random.default_rng(0).standard_normal((4, 4))
    return BrakeModel(**{
        'angular_frequencies': 2 * np.pi * np.array([900.0, 1500.0, 2000.0, 2060.0]),
        'contact_stiffness': 1e-5 * (shape @ shape.T), 'friction_couple': couple,
        'gyroscopic': 1e-3 * (shape - shape.T), 'radial_dissipation': 1e-8 * (shape @ shape.T),
        'negative_slope': 1e-6 * (shape @ shape.T), 'nominal_contact_stiffness': 1e10,
        'caliper': Caliper(2.5e-3), 'friction_law': FrictionLaw(),
        'friction_table': FrictionTable(np.array([300.0, 500.0]), np.array([0.5, 0.1])),
        **changes})


MODEL = small_model()


def monitor(model: BrakeModel = MODEL, **parameters: Any) -> BrakeMonitor:
    found = read_settings({'brakes': ['a'], **parameters})
    return BrakeMonitor(found.brakes[0], found, model)


def feed(to: BrakeMonitor, stamp: int = TICK, **values: float) -> BrakeMonitor:
    for signal in to.brake.inputs:
        if signal in values:
            to.receive(signal, Sample(stamp, values[signal]))
    return to


def invalid(signal: str, value: float, age: float = 0.0) -> str:
    return f'{signal} is {value:.6g}{SHOWN[signal]} ({age:.2f} s old)'


def assess(values: dict[Any, float], model: BrakeModel = MODEL, **parameters: Any) -> Assessment:
    return feed(monitor(model, **parameters), **values).assess(TICK)


def check_unknown(found: Assessment, state: str, reason: str) -> None:
    assert (found.state, found.reason, found.is_valid) == (state, reason, False)
    assert (found.modes, found.point) == ((), None)
    assert np.isnan([found.risk, found.growth_rate, found.worst_frequency_hz,
                     found.friction_margin]).all()
