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

"""Build-up of modes that are followed by frequency, and that of fixed families on drives."""

from collections.abc import Iterator
from itertools import groupby, islice

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.resources import config_folder
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.build_up import nepers, saturation_energy
from squeal_core.risk.emulator_file import find_emulator
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.risk.tracked_build_up import TrackedBuildUp
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from squeal_core.vehicle.vehicle_model import brake_signals, read_vehicle
from support.linear_growth import one_brake

MS = 1_000_000  # ns
CAP = 4e8
FRICTION = 0.45  # at which kang2009_damped squeals in some applications


def roots(*modes: tuple[float, float]) -> FloatArray:
    """Return eigenvalues of modes of growth rates [1/s] and frequencies [Hz]."""
    return np.array([complex(rate, 2.0 * np.pi * frequency) for rate, frequency in modes])


@pytest.fixture
def tracked() -> TrackedBuildUp:
    return TrackedBuildUp(np.array([2000.0, 2100.0]), np.array([60.0, 60.0]))


def test_modes_whose_frequencies_cross_keep_their_build_up(tracked: TrackedBuildUp) -> None:
    """One grows at 10 1/s from 2000 Hz upwards, the other decays from 2065 Hz downwards."""
    for tick in range(1, 16):
        rising, falling = (10.0, 2000.0 + 4.0 * tick), (-50.0, 2065.0 - 4.0 * tick)
        found = tracked.update(tick * 50 * MS, roots(rising, falling), CAP)
        if tick == 6:
            before = found
    assert found[0] == pytest.approx(before[0] + 9 * 0.05 * 10.0, abs=0.1)
    assert found[1] < 0.2


def test_merged_modes_share_their_energy(tracked: TrackedBuildUp) -> None:
    """Of a pair the one that grows is now the upper, now the lower one."""
    for tick in range(1, 11):
        pair = ((20.0, 2000.0), (-90.0, 2000.5)) if tick % 4 < 2 else (
            (-90.0, 2000.0), (20.0, 2000.5))
        found = tracked.update(tick * 50 * MS, roots(*pair), CAP)
    assert found[0] == found[1]
    assert found[0] > 3.0


def test_modes_that_a_table_omits_begin_at_their_floors(tracked: TrackedBuildUp) -> None:
    for tick in range(1, 6):
        found = tracked.update(tick * 50 * MS, roots((20.0, 2000.0)), CAP)
    assert found[0] > 3.0
    assert tracked.update(300 * MS, roots(), CAP).size == 0
    assert tracked.update(350 * MS, roots((20.0, 2000.0)), CAP)[0] < 1.5


def test_a_gap_adds_nothing_and_a_release_ends_all(tracked: TrackedBuildUp) -> None:
    for tick in range(1, 6):
        found = tracked.update(tick * 50 * MS, roots((20.0, 2000.0)), CAP)
    assert tracked.update(1000 * MS, roots((20.0, 2000.0)), CAP) == found
    tracked.release(1050 * MS)
    assert tracked.update(1100 * MS, roots((20.0, 2000.0)), CAP)[0] < 1.5


def applications(model: BrakeModel, drive: str, count: int, rate: float = 10.0
                 ) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield time, rotor speed and pressure of brake applications of the front left brake."""
    folder = config_folder()
    assert model.friction_table is not None
    signals = brake_signals(
        read_drive_cycle(folder / 'drive_cycles' / f'{drive}.csv'),
        read_vehicle(folder / 'vehicles' / 'midsize.yaml'), model.friction_table, rate=rate)
    slides = (signals.pressure[:, 0] >= 1e5) & (signals.rotor_speed[:, 0] >= 2.0)
    runs = (list(places) for on, places in groupby(range(slides.size), slides.__getitem__) if on)
    for own in islice((run for run in runs if 8 <= len(run) <= 60), count):
        yield signals.time[own], signals.rotor_speed[own, 0], signals.pressure[own, 0]


def followed(model: BrakeModel, times: list[int], points: list[OperatingPoint]) -> float:
    """Return the largest build-up by full solutions."""
    build_up, largest = TrackedBuildUp.of(model, points[0]), 0.0
    build_up.release(2 * times[0] - times[1])
    for time, point in zip(times, points, strict=True):
        found = complex_modes(model, point).oscillatory
        frequency = found.imag / (2.0 * np.pi)
        found = found[(frequency >= SQUEAL_BAND[0]) & (frequency <= SQUEAL_BAND[1])]
        cap = float(saturation_energy(point.contact_pressure, point.contact_stiffness))
        largest = max(largest, float(build_up.update(time, found, cap).max()))
    return largest


@pytest.mark.parametrize('drive', ['us06', 'wltc_3b'])
def test_followed_modes_agree_with_fixed_families_on_drives(drive: str) -> None:
    """Of the nominal damped brake; families by the shipped emulator, modes by full solutions."""
    model = BrakeModel.load('kang2009_damped')
    found = find_emulator(model)
    assert found is not None
    risk = SquealRisk(found[1], one_brake())
    largest = []
    for time, speed, pressure in applications(model, drive, 3):
        times = np.round(1e9 * time).astype(int).tolist()
        points = [model.operating_point(rotor_speed=at, pressure=load, friction=FRICTION)
                  for at, load in zip(speed.tolist(), pressure.tolist(), strict=True)]
        growth = risk.growth(speed, [at.contact_pressure for at in points], FRICTION,
                             [at.contact_stiffness for at in points])
        families = ApplicationRisk(risk)
        families.release(2 * times[0] - times[1])
        for tick, at in enumerate(times):
            families.advance(at, growth.at(tick))
        largest.append((float(nepers(families.peak.max())), followed(model, times, points)))
    assert np.diff(largest) == pytest.approx(0.0, abs=0.3), largest
