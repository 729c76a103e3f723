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

"""The clock of a sound from a recording of the same drive, and when it is not known."""

import numpy as np
import pytest
from squeal_core.common.arrays import FloatArray
from squeal_core.sound.channel_analysis import ChannelRecord
from squeal_core.sound.recorded_drive import RecordedDrive
from squeal_core.sound.synchronisation import synchronise

STEP = 1024 / 48_000  # s
START = 1.7e9


def drive(rng: np.random.Generator, duration: float, period: float = 0.0) -> RecordedDrive:
    """Return a drive with stops at random, or one like the other every period [s]."""
    time = np.arange(0.0, duration, 0.1)
    speed, pressure, now, gaps = np.full(time.size, 20.0), np.zeros(time.size), 3.0, 15.0
    while now < duration:
        length, low = (4.0, 8.0) if period else (rng.uniform(2.0, 7.0), rng.uniform(0.0, 15.0))
        speed = np.where(time > now, np.interp(
            time, [now, now + length, now + length + 4.0], [20.0, low, 20.0]), speed)
        pressure[(time > now) & (time < now + length)] = 1e5 * (20.0 - low)
        now += period or length + 4.0 + rng.uniform(1.0, gaps)
    return RecordedDrive('drive', START + time, speed, pressure)


def record_of(rng: np.random.Generator, other: RecordedDrive, offset: float,
              duration: float) -> ChannelRecord:
    """Return what is heard from an offset on: road, brakes, microphone, and surfaces of 3 dB."""
    frames = round(duration / STEP)
    time = 2.0 * STEP + STEP * (4.0 * np.arange(frames // 4) + 1.5)
    speed, pressure = (np.interp(START + offset + time, other.time, values)
                       for values in (other.speed, other.pressure))
    power = 1e-9 + 1e-8 * speed ** 2.2 + 2e-12 * (speed * pressure) ** 0.9
    surface = np.repeat(rng.normal(0.0, 1.5, time.size // 60 + 1), 60)[:time.size]
    level = 10.0 * np.log10(power) + surface + rng.normal(0.0, 0.7, time.size)
    flags: FloatArray = np.ones(frames, dtype=bool)
    return ChannelRecord(STEP, 2.0 * STEP, [], level, flags, ~flags, -20.0, True)


def test_the_offset_is_found_within_its_uncertainty() -> None:
    errors = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        other = drive(rng, 400.0)
        offset = rng.uniform(-20.0, 250.0)
        duration = rng.uniform(80.0, 150.0)
        clock = synchronise([record_of(rng, other, offset, duration)], other)
        assert not clock.is_ambiguous, clock.note
        errors.append((clock.offset - START - offset) / clock.uncertainty)
        assert clock.uncertainty < 0.5
    assert np.sqrt(np.mean(np.square(errors))) < 2.0
    assert np.abs(errors).max() < 4.0


def test_alike_stops_and_another_drive_give_no_number() -> None:
    rng = np.random.default_rng(10)
    regular = drive(rng, 400.0, period=20.0)
    clock = synchronise([record_of(rng, regular, 100.0, 100.0)], regular)
    assert clock.is_ambiguous
    assert 'no offset stands out' in clock.note
    for seed in range(2):
        rng = np.random.default_rng(20 + seed)
        clock = synchronise([record_of(rng, drive(rng, 400.0), 100.0, 120.0)], drive(rng, 400.0))
        assert clock.is_ambiguous
        assert np.isnan(clock.offset)
        assert clock.shift == 0.0


def test_claps_at_strokes_of_the_pedal() -> None:
    """At standstill, where nothing rolls: the sound is silent but for claps."""
    rng = np.random.default_rng(30)
    time = np.arange(0.0, 120.0, 0.1)
    strokes = np.sort(rng.uniform(5.0, 55.0, 9))
    pressure = sum(2e6 * ((time > at) & (time < at + 0.4)) for at in strokes)
    other = RecordedDrive('yard', START + time, np.zeros(time.size), np.asarray(pressure))
    record = record_of(rng, other, 0.0, 60.0)
    at = record.time(4.0 * np.arange(record.background.size) + 1.5) + 2.35
    level = -70.0 + rng.normal(0.0, 0.7, at.size)
    for stroke in strokes:
        level[np.abs(at - stroke) < 0.06] += 25.0
    found = synchronise([ChannelRecord(STEP, record.lead, [], level, record.heard,
                                       record.clipped, -20.0, True)], other)
    assert not found.is_ambiguous, found.note
    assert found.offset - START == pytest.approx(2.35, abs=0.12)
    assert 'onsets' in found.note
