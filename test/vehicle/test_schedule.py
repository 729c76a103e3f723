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

"""Schedules of brake applications: heat against closed forms and the vehicle model, errors."""

import copy
from dataclasses import replace
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid
from squeal_core.common.resources import config_folder
from squeal_core.vehicle.drive_cycle import DriveCycle
from squeal_core.vehicle.schedule import (
    Conditioning,
    read_schedule,
    Schedule,
    ScheduleError,
    Stop,
    ZERO_CELSIUS,
)
from squeal_core.vehicle.schedule_drive import drive_schedule, DrivenSchedule
from squeal_core.vehicle.vehicle_model import brake_signals, read_vehicle
import yaml

VEHICLE = read_vehicle(config_folder() / 'vehicles' / 'midsize.yaml')
NAN = math.nan


def friction(temperature: Any) -> Any:
    """Return a friction that fades."""
    return 0.45 - 2e-4 * (temperature - 293.15)


def stop(kind: Any = 'drag', speed: float = 10.0, **values: float) -> Stop:
    return Stop('x', kind, **{'end_speed': 0.0, 'pressure': 20e5, 'deceleration': NAN,
                              'temperature': NAN, 'duration': 20.0, 'pause': 0.0,
                              **values}, speed=speed)


def driven(*stops: Stop, rate: float = 10.0, table: Any = friction,
           **vehicle: float) -> DrivenSchedule:
    return drive_schedule(Schedule('x', stops, Conditioning(longest=600.0)),
                          replace(VEHICLE, **vehicle), table, rate=rate)


@pytest.mark.parametrize('name', ['short', 'j2521_manner'])
def test_shipped_schedules_are_driven_as_they_say(name: str) -> None:
    said: list[str] = []
    schedule = read_schedule(config_folder() / 'schedules' / f'{name}.yaml', warn=said.append)
    assert not said
    if name == 'short':
        found = drive_schedule(schedule, VEHICLE, friction)
        assert found.signals.time[-1] < 180.0
    else:
        assert len(schedule.stops) == 226
        found = drive_schedule(replace(schedule, stops=schedule.stops[::15]), VEHICLE, friction)
    signals = found.signals
    for one in found.stops:
        first, last = round(one.start * 10.0), round(one.end * 10.0)
        front = signals.temperature[first, :2].mean()
        assert math.isnan(one.stop.temperature) or abs(front - one.stop.temperature) < 1.5
        assert signals.vehicle_speed[first] == pytest.approx(one.stop.speed)
        assert signals.pressure[last].max() == pytest.approx(0.0, abs=1.0)
        if not math.isnan(one.stop.pressure):
            assert signals.pressure[first:last, 0].max() == pytest.approx(
                one.stop.pressure, rel=0.01)
    assert {1.0, -1.0} == {math.copysign(1.0, one.stop.speed) for one in found.stops}
    # a rotor that turns is pressed by its own waviness: no sensor would be called stuck
    turns = signals.rotor_speed[1:, 0] != 0.0
    still = np.diff(signals.pressure[:, 0]) == 0.0
    assert signals.pressure[1:, 0][turns & still].max() < 1.0


def test_a_drag_heats_discs_as_the_closed_form_says() -> None:
    """C dT/dt = P - hA (T - T_air), P and hA constant: an exponential."""
    found = driven(stop(duration=60.0), table=lambda t: 0.4 + 0.0 * t, initial_temperature=293.15)
    signals, (one,) = found.signals, found.stops
    first, last = round(one.start * 10.0) + 10, round(one.end * 10.0) - 10
    force = VEHICLE.torque_per_pressure / VEHICLE.wheel_radius * 20e5 * np.array(
        VEHICLE.friction_factors) * 0.4 * VEHICLE.pressure_split
    loss = float(VEHICLE.cooling(np.array(10.0)))
    end = VEHICLE.ambient_temperature + VEHICLE.heat_fraction_to_disc * force * 10.0 / loss
    decay = math.exp(-loss / VEHICLE.disc_heat_capacity * (last - first) / 10.0)
    np.testing.assert_allclose(
        signals.temperature[last], end + (signals.temperature[first] - end) * decay, rtol=1e-6)
    assert signals.temperature[last, 0] > 400.0


@pytest.mark.parametrize('by', [{'pressure': 15e5, 'deceleration': NAN},
                                {'pressure': NAN, 'deceleration': 3.0}])
def test_a_stop_turns_the_energy_of_the_vehicle_into_heat(by: dict[str, float]) -> None:
    found = driven(stop('deceleration', 25.0, end_speed=2.0, **by), rate=200.0,
                   still_air_cooling=0.0, moving_air_cooling=0.0)
    signals, (one,) = found.signals, found.stops
    first, last = round(one.start * 200.0), round(one.end * 200.0)
    speed = signals.vehicle_speed[first:last + 1]
    resistance = trapezoid(VEHICLE.resistance(speed) * speed, dx=1.0 / 200.0)
    energy = 0.5 * VEHICLE.inertia * (speed[0]**2 - speed[-1]**2) - resistance
    heat = VEHICLE.disc_heat_capacity * (
        signals.temperature[last] - signals.temperature[first]).sum()
    assert heat == pytest.approx(VEHICLE.heat_fraction_to_disc * energy, rel=2e-3)
    assert speed[-1] < 2.0 < speed[round(-0.6 * 200.0)]
    if by['deceleration'] == 3.0:
        assert (speed[200] - speed[400]) == pytest.approx(3.0)


def test_a_stop_is_that_of_the_vehicle_model() -> None:
    signals = driven(stop('deceleration', 25.0, pressure=NAN, deceleration=3.0, end_speed=5.0),
                     rate=100.0).signals
    again = brake_signals(DriveCycle('x', signals.time, np.maximum(signals.vehicle_speed, 0.0)),
                          VEHICLE, friction)
    pressed = signals.pressure[:, 0] > 0.9 * signals.pressure.max()
    np.testing.assert_allclose(signals.rotor_speed[pressed], again.rotor_speed[pressed])
    np.testing.assert_allclose(signals.pressure[pressed], again.pressure[pressed], rtol=0.03)
    np.testing.assert_allclose(signals.temperature[pressed], again.temperature[pressed], atol=0.5)


def test_backward_is_forward_with_the_rotors_turning_the_other_way() -> None:
    one, other = (driven(stop(speed=sign * 3.0), stop('deceleration', sign * 10.0)).signals
                  for sign in (1.0, -1.0))
    np.testing.assert_array_equal(one.rotor_speed, -other.rotor_speed)
    np.testing.assert_allclose(one.pressure, other.pressure, rtol=2.1 * 0.005, atol=1.0)  # ripple
    np.testing.assert_array_equal(one.temperature, other.temperature)
    assert other.rotor_speed.min() < -25.0


MODULE = {'kind': 'drag', 'speed_km_h': 10, 'pressure_bar': [5, 10], 'duration_s': 5}


@pytest.mark.parametrize(('change', 'text'), [
    ({'kind': 'dragg'}, "s.yaml.modules[1].kind: is 'dragg'; give one of: drag, deceleration ("),
    ({'kind': None}, 's.yaml.modules[1].kind: is missing'),
    ({'speed_km_h': 400}, 'modules[1].speed_km_h: is 400.0 km/h; give 0.36 to 360 km/h'),
    ({'speed_km_h': [10, 'x']}, "modules[1].speed_km_h[1]: is 'x'; write a number"),
    ({'speed_km_h': None, 'speed_kmh': 10}, 'speed_kmh: has a wrong unit suffix (value 10); use '),
    ({'pressure_bar': [5, 5e5]}, 'modules[1].pressure_bar[1]: is 500000.0 bar; give 0.5 to 300 '
     'bar (500000 Pa would be 5 bar)'),
    ({'direction': 'backwards'}, "direction: is 'backwards'; give one of: forward, backward, for"),
    ({'duration_s': None}, 'modules[1].duration_s: is missing; add duration_s or duration_min'),
    ({'repetitions': 0}, 'modules[1].repetitions: is 0.0'),
    ({'repetitions': 1.5}, 'modules[1].repetitions: is 1.5; write a whole number'),
    ({'temperature_degc': 900}, 'modules[1].temperature_degc: is 900.0 degC; give -50 to 800'),
    ({'deceleration_m_s2': 2}, 'modules[1].deceleration_m_s2: unknown key (value 2)'),
    ({'kind': 'deceleration', 'end_speed_km_h': 10}, 'end_speed: is 10 km/h; give less than spe'),
    ({'repetitions': 1000, 'speed_km_h': [10] * 11}, 's.yaml: has 22002 brake applications')])
def test_errors_name_the_key(tmp_path: Path, change: dict[str, Any], text: str) -> None:
    path = tmp_path / 's.yaml'
    module = {key: value for key, value in {**MODULE, **change}.items() if value is not None}
    path.write_text(yaml.safe_dump({'modules': [copy.deepcopy(MODULE), module]}))
    with pytest.raises(ScheduleError) as caught:
        read_schedule(path)
    assert text in str(caught.value)


@pytest.mark.parametrize(('text', 'said'), [
    ('# nothing yet\n', 's.yaml: is empty; write keys and values'),
    ('source: bench\n', 's.yaml.modules: is missing; write a list')])
def test_an_empty_schedule(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / 's.yaml'
    path.write_text(text)
    with pytest.raises(ScheduleError) as caught:
        read_schedule(path)
    assert said in str(caught.value)


def test_unusual_values_are_doubted(tmp_path: Path) -> None:
    path = tmp_path / 's.yaml'
    path.write_text(yaml.safe_dump({'modules': [{**MODULE, 'pressure_bar': 200}]}))
    said: list[str] = []
    assert read_schedule(path, warn=said.append).stops[0].pressure == pytest.approx(200e5)
    assert 's.yaml.modules[0].pressure_bar: is 200.0 bar; usual is 1 to 120 bar' in said[0]


@pytest.mark.parametrize(('degc', 'text'), [
    (20.0, 'temperature_degc = 20 is within 1 K of ambient'),
    (600.0, 'not reached from .* degC within conditioning.longest_s = 600')])
def test_start_temperatures_out_of_reach(degc: float, text: str) -> None:
    with pytest.raises(ScheduleError, match=text):
        driven(stop(temperature=degc + ZERO_CELSIUS), heat_fraction_to_disc=0.1)
