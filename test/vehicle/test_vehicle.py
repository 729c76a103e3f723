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

"""Brake signals against energy balances, closed forms and a forward simulation of the vehicle."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from squeal_core.brake.friction import FrictionTable
from squeal_core.common.arrays import FloatArray
from squeal_core.vehicle.drive_cycle import DriveCycle, DriveCycleError, read_drive_cycle
from squeal_core.vehicle.vehicle import Vehicle, VehicleError
from squeal_core.vehicle.vehicle_model import brake_signals, BrakeSignals, read_vehicle

CONFIG = Path(__file__).parents[2] / 'config'
MIDSIZE = CONFIG / 'vehicles' / 'midsize.yaml'

# The vehicle's numbers, written out again so that the tests do not lean on the code they test.
INERTIA = 1600.0 + 4 * 0.815 / 0.336**2
TORQUE_PER_PRESSURE = 2.0 * np.pi / 4.0 * 0.057**2 * 0.1222


def fading(temperature: FloatArray) -> FloatArray:
    """Friction that rises when warm and fades when hot."""
    return np.interp(temperature, [293.0, 373.0, 473.0, 573.0, 773.0],
                     [0.38, 0.42, 0.43, 0.40, 0.33])


def constant(temperature: FloatArray) -> FloatArray:
    return np.full_like(temperature, 0.4)


def resistance(speed: FloatArray) -> FloatArray:
    engine = 200.0 * np.minimum(speed / 3.0, 1.0)
    return 0.5 * 1.2 * 0.808 * speed**2 + 0.007 * 1600.0 * 9.80665 + engine


def torque(signals: BrakeSignals) -> FloatArray:
    return TORQUE_PER_PRESSURE * signals.friction * signals.pressure


@pytest.fixture
def midsize() -> Vehicle:
    return read_vehicle(MIDSIZE)


@pytest.fixture
def stop() -> DriveCycle:
    """From 30 m/s to rest in 10 s, after 5 s at speed and before 5 s at rest."""
    time = np.arange(21.0)
    return DriveCycle('stop', time, np.clip(30.0 - 3.0 * (time - 5.0), 0.0, 30.0))


def cruise(speed: float, duration: float) -> DriveCycle:
    return DriveCycle('cruise', np.array([0.0, duration]), np.array([speed, speed]))


def test_energy_of_a_stop_goes_to_brakes_air_tyres_and_engine(
        midsize: Vehicle, stop: DriveCycle) -> None:
    errors = []
    for rate in (50.0, 100.0):
        signals = brake_signals(stop, replace(midsize, holding_pressure=0.0), fading, rate=rate)
        time, speed = signals.time, signals.vehicle_speed
        drag = resistance(speed) * (speed > 0.0)
        drive = np.clip(INERTIA * np.gradient(speed, time) + drag, 0.0, None)
        brakes = trapezoid((torque(signals) * signals.rotor_speed).sum(axis=1), time)
        supplied = 0.5 * INERTIA * 30.0**2 + trapezoid(drive * speed, time)
        errors.append(abs(brakes + trapezoid(drag * speed, time) - supplied) / supplied)
        assert brakes > 0.8 * 0.5 * INERTIA * 30.0**2  # a hard stop is the brakes' work
    # Trapezoidal rule and central differences at 100 Hz against accelerations that change within
    # 1 s: some (0.01)^2 / 12, falling with the square of the step (kinks disturb the ratio of 4).
    assert errors[1] < 2e-5
    assert errors[1] < errors[0] / 3.0


def test_disc_heat_of_an_adiabatic_stop_in_closed_form(midsize: Vehicle, stop: DriveCycle) -> None:
    vehicle = replace(
        midsize, frontal_drag_area=0.0, rolling_resistance=0.0, engine_drag=0.0, cooling_area=0.0,
        front_brake_share=0.5, friction_factors=(1.0,) * 4, heat_fraction_to_disc=1.0)
    rise = 0.5 * INERTIA * 30.0**2 / (4 * 2750.0)
    coarse, fine = (brake_signals(stop, vehicle, constant, rate=rate).temperature[-1] - 293.15
                    for rate in (50.0, 100.0))
    # Euler-Maclaurin: step^2 / 12 times the jumps of power's slope, 0.85 MW/s, over 733 kJ: 1e-5.
    np.testing.assert_allclose(fine, rise, rtol=1.1e-5)
    np.testing.assert_allclose((coarse - rise) / (fine - rise), 4.0, rtol=0.01)  # second order


def test_cooling_in_closed_form(midsize: Vehicle) -> None:
    signals = brake_signals(cruise(25.0, 600.0), replace(midsize, initial_temperature=600.0),
                            fading)
    conductance = 0.11 * (15.0 + 7.9 * 25.0**0.8)
    decay = np.exp(-signals.time * conductance / 2750.0)
    # Trapezoidal rule: (step / time constant)^2 / 12 = 1e-10 of at most 307 K times 3 constants.
    for brake in range(4):
        np.testing.assert_allclose(
            signals.temperature[:, brake], 293.15 + 306.85 * decay, rtol=0.0, atol=1e-6)
    assert np.all(signals.pressure == 0.0)


def test_temperatures_against_a_step_by_step_march(midsize: Vehicle, stop: DriveCycle) -> None:
    factors, split = np.array(midsize.friction_factors), np.array([0.35, 0.35, 0.15, 0.15])

    def largest_difference(rate: float) -> float:
        signals = brake_signals(stop, midsize, fading, rate=rate)
        power = (torque(signals) * signals.rotor_speed).sum(axis=1)
        power[signals.vehicle_speed < 0.1] = 0.0  # the holding pressure heats no disc
        temperature = np.full(4, 293.15)
        difference = 0.0
        for i, speed in enumerate(signals.vehicle_speed):
            difference = max(difference, np.abs(temperature - signals.temperature[i]).max())
            share = fading(temperature) * factors * split
            loss = 0.11 * (15.0 + 7.9 * speed**0.8) * (temperature - 293.15)
            temperature = temperature + (
                0.9 * power[i] * share / share.sum() - loss) / 2750.0 / rate
        return float(difference)

    coarse, fine = largest_difference(50.0), largest_difference(100.0)
    # The march is explicit Euler, first order: half a step late at the peak of 19 K/s (165 kW).
    assert coarse == pytest.approx(0.5 * 19.0 / 50.0, rel=0.05)
    assert fine == pytest.approx(0.5 * coarse, rel=0.05)


def test_brakes_stop_a_simulated_vehicle_as_the_cycle_says(
        midsize: Vehicle, stop: DriveCycle) -> None:
    signals = brake_signals(stop, midsize, fading, rate=1000.0)
    force = torque(signals).sum(axis=1) / 0.336
    start, end = 6.0, 14.0  # braking throughout: neither drive nor holding pressure

    def slow_down(t: float, v: FloatArray) -> FloatArray:
        return np.asarray(-(np.interp(t, signals.time, force) + resistance(v)) / INERTIA)

    at_start = np.interp(start, signals.time, signals.vehicle_speed)
    run = solve_ivp(slow_down, (start, end), [at_start], rtol=1e-9, atol=1e-9, max_step=0.05,
                    t_eval=np.linspace(start, end, 81))
    expected = np.interp(run.t, signals.time, signals.vehicle_speed)
    # Force is linear between 1 ms samples: error below (1 ms)^2 / 8 * 40 m/s^4 * 8 s = 4e-5 m/s.
    np.testing.assert_allclose(run.y[0], expected, atol=4e-5)


def test_deceleration_on_a_drive_cycle_is_the_torque_over_inertia(midsize: Vehicle) -> None:
    cycle = read_drive_cycle(CONFIG / 'drive_cycles' / 'us06.csv')
    signals = brake_signals(cycle, midsize, fading)
    speed = signals.vehicle_speed
    acceleration = np.gradient(speed, signals.time)
    predicted = -(torque(signals).sum(axis=1) / 0.336 + resistance(speed)) / INERTIA
    braking = (signals.pressure[:, 0] > 0.0) & (speed >= 0.2)
    # Central differences at 100 Hz where jerk jumps between +-14 m/s^3: 0.01 * 28 / 4.
    np.testing.assert_allclose(acceleration[braking], predicted[braking], atol=0.07)
    assert np.median(np.abs(acceleration[braking] - predicted[braking])) < 1e-3


def test_pressure_is_zero_unless_braking(midsize: Vehicle) -> None:
    time = np.array([0.0, 10.0, 20.0, 60.0])
    # Speeding up, then level, then slowing by 0.1 m/s^2: less than the 0.3 m/s^2 of resistance.
    signals = brake_signals(DriveCycle('x', time, np.array([0.0, 20.0, 20.0, 16.0])), midsize,
                            fading)
    moving = signals.time > 0.0
    assert np.all(signals.pressure[moving] == 0.0)
    assert np.all(signals.temperature == pytest.approx(293.15))


def test_vehicle_is_held_at_rest_but_not_when_it_sets_off(
        midsize: Vehicle, stop: DriveCycle) -> None:
    signals = brake_signals(stop, midsize, fading)
    rear = 0.3 / 0.7
    np.testing.assert_allclose(signals.pressure[-1], [5e5, 5e5, 5e5 * rear, 5e5 * rear])
    off = brake_signals(DriveCycle('off', np.array([0.0, 5.0, 10.0]), np.array([0.0, 0.0, 9.0])),
                        midsize, fading)
    at_rest = off.time <= 5.0
    assert np.all(off.pressure[at_rest, 0] == 5e5)
    assert np.all(off.pressure[~at_rest] == 0.0)


def test_front_share_and_friction_factors_split_the_torque(
        midsize: Vehicle, stop: DriveCycle) -> None:
    signals = brake_signals(stop, midsize, constant)
    at = int(10.0 * 100)
    expected = np.array([0.35, 0.35, 0.15, 0.15]) * [1.0, 0.97, 1.02, 0.99]
    # Rounding only: the split is algebra.
    np.testing.assert_allclose(torque(signals)[at] / torque(signals)[at].sum(),
                               expected / expected.sum(), rtol=1e-12)
    np.testing.assert_array_equal(signals.friction[at], 0.4 * np.array([1.0, 0.97, 1.02, 0.99]))
    np.testing.assert_allclose(signals.rotor_speed[at], signals.vehicle_speed[at] / 0.336)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.3, 3.0))
def test_driver_compensates_friction(factor: float) -> None:
    vehicle = replace(read_vehicle(MIDSIZE), holding_pressure=0.0)
    cycle = DriveCycle('stop', np.array([0.0, 2.0, 12.0]), np.array([25.0, 25.0, 0.0]))
    once = brake_signals(cycle, vehicle, fading)
    scaled = brake_signals(cycle, vehicle, lambda t: factor * fading(t))
    # Deceleration fixes total heat: uniform friction changes pressure only. Rounding only.
    np.testing.assert_allclose(scaled.pressure * factor, once.pressure, rtol=1e-9)
    np.testing.assert_allclose(scaled.temperature, once.temperature, rtol=1e-9)


@pytest.mark.parametrize('name', ['us06', 'wltc_3b', 'chicago_trip'])
def test_shipped_cycles_give_plausible_signals(midsize: Vehicle, name: str) -> None:
    cycle = read_drive_cycle(CONFIG / 'drive_cycles' / f'{name}.csv')
    table = FrictionTable(np.array([293.0, 473.0, 773.0]), np.array([0.38, 0.43, 0.33]))
    signals = brake_signals(cycle, midsize, table)
    count = int(cycle.duration * 100) + 1
    assert signals.brakes == ('front_left', 'front_right', 'rear_left', 'rear_right')
    for values in (signals.rotor_speed, signals.pressure, signals.temperature, signals.friction):
        assert values.shape == (count, 4)
        assert np.all(np.isfinite(values))
        assert not values.flags.writeable
    assert np.all(signals.pressure >= 0.0)
    assert 10e5 < signals.pressure.max() < 150e5  # 1 to 3 m/s^2 against a full stop's 100 bar
    assert signals.temperature.min() >= 293.15 - 1e-9
    assert 320.0 < signals.temperature.max() < 800.0
    assert np.all(signals.temperature[:, :2].max(axis=0) > signals.temperature[:, 2:].max(axis=0))
    assert 0.1 < np.mean(signals.pressure[:, 0] > 0.0) < 0.5
    # The brakes cannot give more heat than all the kinetic energy ever lost.
    lost = np.clip(-np.diff(0.5 * INERTIA * cycle.speed**2), 0.0, None).sum()
    heat = trapezoid((torque(signals) * signals.rotor_speed).sum(axis=1), signals.time)
    assert 0.3 * lost < heat < lost


def test_a_drive_is_reproduced_at_any_rate(midsize: Vehicle, stop: DriveCycle) -> None:
    coarse = brake_signals(stop, midsize, fading, rate=20.0)
    fine = brake_signals(stop, midsize, fading, rate=200.0)
    np.testing.assert_allclose(coarse.pressure, fine.pressure[::10], rtol=1e-3, atol=1.0)
    # Trapezoidal rule at 20 Hz: (0.05 s)^2 / 12 times the jumps of dT/dt's slope, 97 K/s^2.
    np.testing.assert_allclose(coarse.temperature, fine.temperature[::10], atol=0.02)


@pytest.mark.parametrize(('friction', 'match'), [
    (lambda t: np.zeros_like(t), r'friction = 0.0 between 293.*positive'),
    (lambda t: np.full_like(t, np.nan), r'friction = nan'),
])
def test_friction_must_be_positive(
        midsize: Vehicle, stop: DriveCycle, friction: Callable[[FloatArray], FloatArray],
        match: str) -> None:
    with pytest.raises(VehicleError, match=match):
        brake_signals(stop, midsize, friction)


def test_unsettled_temperatures_and_bad_rates_are_refused(
        midsize: Vehicle, stop: DriveCycle) -> None:
    with pytest.raises(VehicleError, match=r'did not settle to tolerance = -1.0 K.*raise'):
        brake_signals(stop, midsize, fading, tolerance=-1.0)
    with pytest.raises(DriveCycleError, match=r'rate = 0\.0'):
        brake_signals(stop, midsize, fading, rate=0.0)


def test_shipped_vehicle_is_in_si_units(midsize: Vehicle) -> None:
    assert midsize.piston_diameter == pytest.approx(0.057)
    assert midsize.holding_pressure == pytest.approx(5e5)
    assert midsize.ambient_temperature == pytest.approx(293.15)
    # K09's preload of 2000 N at 7.84 bar, given to three digits; torque of two pads.
    assert midsize.torque_per_pressure * 7.84e5 == pytest.approx(2 * 2000.0 * 0.1222, rel=1e-3)
    # Mass of the rotor plate from its dimensions; specific heat 500 J/(kg K) rounded to 3 digits.
    mass = np.pi * (0.1483**2 - 0.0819**2) * 0.016 * 7150.0
    assert midsize.disc_heat_capacity == pytest.approx(500.0 * mass, rel=5e-3)
