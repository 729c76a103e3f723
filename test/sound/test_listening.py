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

"""Squeal is found in noise at every rate, and what is none is not."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.simulation.microphone import Microphone
from squeal_core.simulation.simulation_files import FULL_SCALE
from squeal_core.sound.listen import listen
from squeal_core.sound.listening import listening_of, read_listening
from squeal_core.sound.listening_settings import LevelScale, ListeningSettings
from squeal_core.sound.measured_files import MeasuredFiles, MeasuredSqueal
from squeal_core.sound.recorded_drive import RecordedDrive
from squeal_core.sound.sound_clock import SoundClock
from squeal_core.sound.sound_file import open_sound
from squeal_core.sound.spectra import a_weighting
from squeal_core.sound.squeal_detection import HeardTone
from squeal_core.sound.tone_sources import BrakingAt, SpeedAt
from support.rows import each
from support.sounds import beeper, horn, sound_of, Squeal, tune, whine, write_wav

RATE = 48_000


def heard(tmp_path: Path, sound: FloatArray, rate: int = RATE, kind: str = 'i2', *,
          settings: ListeningSettings | None = None, brakes: Sequence[str] = (),
          speed: SpeedAt | None = None, braking: BrakingAt | None = None) -> list[HeardTone]:
    """Return events and rejected tones."""
    path = write_wav(tmp_path / 'sound.wav', rate, sound, kind)
    tones = listen(open_sound(path), settings or ListeningSettings()).tones(
        brakes=brakes, speed=speed, braking=braking)
    assert tones is not None
    return tones


def events(tones: Sequence[HeardTone]) -> list[HeardTone]:
    return [tone for tone in tones if not tone.rule]


@each(('rate', 'kind'), [
    (8_000, 'i2'), (11_025, 'i2'), (16_000, 'u1'), (22_050, 'i3'), (32_000, 'f4'), (44_100, 'i3'),
    (48_000, 'i2'), (51_200, 'i3'), (88_200, 'i4'), (96_000, 'i3'), (192_000, 'f8')])
def test_squeal_is_found_at_every_rate(rate: int, kind: str, tmp_path: Path) -> None:
    """At 0 dB: a tone as strong as all the noise in the squeal band."""
    squeal = Squeal(1.0, 2.2, 2600.0, 0.0, glide=90.0)
    tones = heard(tmp_path, sound_of(np.random.default_rng(1), rate, 3.0, [squeal], noise=0.05),
                  rate, kind)
    (event,) = events(tones)
    assert event.start == pytest.approx(1.0, abs=0.04)
    assert event.end == pytest.approx(2.2, abs=0.04)
    assert event.frequency_hz == pytest.approx(2645.0, abs=5.0)
    assert event.frequency_end_hz == pytest.approx(2690.0, abs=8.0)
    assert event.level_db == pytest.approx(
        20.0 * np.log10(0.05 * np.sqrt(2.0)) + 1.3, abs=0.7)  # A(2.6 kHz) = 1.3 dB


def test_beats_and_harmonics_are_one_event_and_several_tones_are_several(tmp_path: Path) -> None:
    squeals = [Squeal(1.0, 3.0, 2000.0, 12.0, beat=3.0, harmonics=(0.3, 0.1)),
               Squeal(2.0, 3.5, 5200.0, 3.0), Squeal(2.4, 3.2, 9100.0, 3.0, glide=-200.0)]
    found = events(heard(tmp_path, sound_of(np.random.default_rng(2), RATE, 4.0, squeals)))
    assert [round(event.frequency_hz, -2) for event in found] == [2000.0, 5200.0, 9000.0]
    assert [event.harmonics for event in found] == [(2, 3), (), ()]
    assert found[0].end - found[0].start == pytest.approx(2.0, abs=0.08)


@each(('tone', 'rule'), [
    (Squeal(1.0, 2.0, 1100.0, 10.0), None),  # out of the band
    (Squeal(1.0, 2.0, 16_600.0, 10.0), None),
    (Squeal(1.0, 2.0, 3000.0, -19.0), None),  # less than 15 dB above its neighbours
    (Squeal(1.0, 1.06, 3000.0, 10.0, rise=0.0), 'duration'),
    (Squeal(1.0, 3.0, 3000.0, 10.0, glide=-900.0), 'glide')])
def test_near_misses_are_no_events(tone: Squeal, rule: str | None, tmp_path: Path) -> None:
    tones = heard(tmp_path, sound_of(np.random.default_rng(3), RATE, 4.0, [tone]))
    assert [found.rule for found in tones] == ([rule] if rule else [])


def test_a_tone_below_the_threshold_is_no_event(tmp_path: Path) -> None:
    sound = sound_of(np.random.default_rng(4), RATE, 3.0, [Squeal(1.0, 2.0, 3000.0, 10.0)])
    usual = ListeningSettings()
    (event,) = events(heard(tmp_path, sound, settings=usual))
    for margin, count in ((-1.0, 1), (1.0, 0)):
        limit = replace(usual, threshold=event.level_db + margin)
        assert len(events(heard(tmp_path, sound, settings=limit))) == count


def test_other_sources_are_rejected_by_their_rules_and_the_squeal_among_them_stays(
        tmp_path: Path) -> None:
    """The squeal is in all four; music hides one that is not louder than it."""
    time = np.arange(16_000 * 14) / 16_000
    speed = np.interp(time, [0.0, 4.0, 12.0], [25.0, 25.0, 5.0])
    rng = np.random.default_rng(5)
    ground = sound_of(rng, 16_000, 14.0, [Squeal(8.0, 9.5, 2950.0, 10.0)], noise=0.003)
    sources = {
        'glide': whine(time, speed, 110.0, 0.02), 'horn': horn(time, 2.0, 3.5, 0.01),
        'alarm': beeper(time, 1.0, 7.2, 0.03),
        'music': np.where(time < 5.0, tune(rng, time, 0.0, 5.0, 0.02), 0.0)}
    for rule, sound in sources.items():
        tones = heard(tmp_path, ground + sound, 16_000)
        assert [round(event.frequency_hz, -1) for event in events(tones)] == [2950.0], rule
        assert rule in {tone.rule for tone in tones}
    tones = heard(tmp_path, ground + sources['glide'], 16_000,
                  speed=lambda at: np.interp(at, time, speed))
    assert {tone.rule for tone in tones} == {'', 'wheel speed'}


def test_partials_that_notes_of_a_slow_tune_have_in_common_are_no_squeal(tmp_path: Path) -> None:
    """G5 and C6 share 3.14 kHz, which is one tone over both; a squeal beside them is another."""
    time = np.arange(16_000 * 4) / 16_000
    ground = sound_of(np.random.default_rng(5), 16_000, 4.0, [Squeal(1.0, 3.0, 3050.0, 10.0)],
                      noise=0.003)
    tune_of_two = sum((time // 2.0 == place) * 0.05 / n * np.sin(2.0 * np.pi * n * pitch * time)
                      for place, pitch in enumerate((784.0, 1046.5)) for n in range(1, 6))
    tones = heard(tmp_path, ground + tune_of_two, 16_000)
    assert [round(event.frequency_hz, -1) for event in events(tones)] == [3050.0]
    assert any(abs(tone.frequency_hz - 3138.0) < 5.0 and tone.end - tone.start > 3.0
               for tone in tones)


def test_a_squeal_that_wobbles_is_one_event_and_two_steady_ones_are_two(tmp_path: Path) -> None:
    """Its frequency moves by more than a line is wide within each window, and turns."""
    time = np.arange(3 * RATE) / RATE
    sound = sound_of(np.random.default_rng(13), RATE, 3.0, [
        Squeal(0.5, 2.5, 7000.0, 6.0), Squeal(0.5, 2.5, 7200.0, 3.0)])
    phase = 2.0 * np.pi * 3000.0 * time - 20.0 * np.cos(2.0 * np.pi * 5.0 * time)  # +-100 Hz
    sound += 0.03 * np.sin(phase) * ((time > 0.5) & (time < 2.5))
    found = events(heard(tmp_path, sound))
    assert sorted(round(event.frequency_hz, -2) for event in found) == [3000.0, 7000.0, 7200.0]
    assert all(event.end - event.start == pytest.approx(2.0, abs=0.08) for event in found)


def test_a_long_tone_without_braking_is_none_and_one_of_a_braking_is(tmp_path: Path) -> None:
    """A whine at constant speed and an alarm of one tone are told by the brakes alone."""
    sound = sound_of(np.random.default_rng(14), RATE, 14.0, [
        Squeal(0.5, 13.5, 3000.0, 10.0), Squeal(6.0, 8.0, 5000.0, 10.0)])
    time = np.arange(0.0, 14.0, 0.1)
    speed, pressure = np.full(time.size, 20.0), np.where((time > 5.5) & (time < 7.9), 1e6, 0.0)
    drive = RecordedDrive('drive', time, speed, pressure)
    assert len(events(heard(tmp_path, sound))) == 2
    tones = heard(tmp_path, sound, braking=drive.braking_at)
    assert [(round(tone.frequency_hz, -2), tone.rule) for tone in tones] == [
        (3000.0, 'no braking'), (5000.0, '')]
    for unknown in (replace(drive, pressure=np.full(time.size, np.nan)),
                    replace(drive, time=time + 100.0)):
        assert len(events(heard(tmp_path, sound, braking=unknown.braking_at))) == 2
    still = replace(drive, speed=np.zeros(time.size))
    assert not events(heard(tmp_path, sound, braking=still.braking_at))


def test_a_tone_that_outlasts_the_braking_is_none(tmp_path: Path) -> None:
    """By 2 s; one that goes on for as long as the brakes are applied is squeal."""
    sound = sound_of(np.random.default_rng(15), 16_000, 12.0, [
        Squeal(1.0, 11.0, 3000.0, 10.0), Squeal(3.0, 10.5, 5000.0, 10.0)])
    time = np.arange(0.0, 12.0, 0.1)
    drive = RecordedDrive('drive', time, np.full(time.size, 20.0),
                          np.where((time > 3.0) & (time < 9.0), 1e6, 0.0))
    tones = heard(tmp_path, sound, 16_000, braking=drive.braking_at)
    assert [(round(tone.frequency_hz, -2), tone.rule) for tone in tones] == [
        (3000.0, 'no braking'), (5000.0, '')]


def test_a_tone_that_goes_on_unchanged_for_half_a_minute_is_none(tmp_path: Path) -> None:
    """Unless its frequency moves, as with the disc's heat, or the brakes were applied so long."""
    sound = sound_of(np.random.default_rng(16), 16_000, 32.5, [
        Squeal(1.0, 31.5, 2000.0, 10.0), Squeal(1.5, 32.0, 3000.0, 10.0, glide=60.0),
        Squeal(2.0, 31.0, 5000.0, 10.0)])

    def rules(braking: BrakingAt | None) -> list[str]:
        return [tone.rule for tone in heard(tmp_path, sound, 16_000, braking=braking)]

    assert rules(None) == ['constant', '', '']
    assert rules(lambda time: np.full(time.size, np.nan)) == ['constant', '', '']
    assert rules(lambda time: np.ones(time.size)) == ['', '', '']


def test_a_squeal_with_many_harmonics_is_no_horn(tmp_path: Path) -> None:
    squeal = Squeal(1.0, 2.0, 2000.0, 20.0, harmonics=(0.6, 0.5, 0.4, 0.3, 0.3))
    (event,) = heard(tmp_path, sound_of(np.random.default_rng(6), RATE, 3.0, [squeal]))
    assert event.harmonics == (2, 3, 4, 5, 6)
    assert not event.rule


def test_clipped_squeal_is_marked(tmp_path: Path) -> None:
    """At full scale, and at a lower level as before a converter; the one that is not, is not."""
    squeals = [Squeal(0.5, 1.5, 2700.0, 47.0), Squeal(3.0, 4.0, 2700.0, 10.0)]
    sound = sound_of(np.random.default_rng(7), RATE, 4.5, squeals, noise=0.005)
    for most in (1.0, 0.6):
        found = events(heard(tmp_path, np.clip(sound, -most, most)))
        assert [event.is_clipped for event in found] == [True, False]
    assert not any(event.is_clipped for event in heard(tmp_path, 0.1 * sound))


def test_each_tone_of_two_channels_is_at_the_louder_brake(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    near, far = ([Squeal(1.0, 2.0, 2400.0, level), Squeal(1.2, 2.5, 6100.0, 30.0 - level),
                  Squeal(3.0, 3.8, 3300.0, 15.0)] for level in (25.0, 5.0))
    sound = np.column_stack([sound_of(rng, RATE, 4.0, part) for part in (near, far)])
    found = events(heard(tmp_path, sound, brakes=('fl', 'fr')))
    assert [(round(event.frequency_hz, -2), event.brake) for event in found] == [
        (2400.0, 'fl'), (6100.0, 'fr'), (3300.0, '')]


@each(('sound', 'words'), [
    (np.zeros(96_000), 'all samples are equal'), (np.ones(96_000), 'all samples are equal'),
    (np.full(96_000, np.nan), 'no numbers'),
    (2e-5 * np.random.default_rng(9).standard_normal(96_000), 'steps'),
    (np.zeros(1_000), 'shorter than one window')])
def test_of_a_dead_microphone_nothing_is_known(sound: FloatArray, words: str,
                                               tmp_path: Path) -> None:
    kind = 'f4' if np.isnan(sound).any() else 'i2'
    path = write_wav(tmp_path / 'sound.wav', RATE, sound, kind)
    record = listen(open_sound(path), ListeningSettings())
    assert record.tones() is None
    assert words in record.unknown[0]


def test_dropouts_numbers_that_are_none_and_an_offset_cost_only_their_time(tmp_path: Path) -> None:
    sound = 0.4 + sound_of(np.random.default_rng(10), RATE, 6.0, [Squeal(1.0, 2.0, 3000.0, 10.0)])
    sound[3 * RATE:4 * RATE] = 0.0
    sound[5 * RATE] = np.inf
    sound[-1] = np.nan  # beyond the last whole hop
    path = write_wav(tmp_path / 'sound.wav', RATE, sound, 'f4')
    record = listen(open_sound(path), ListeningSettings())
    assert record.heard_share == pytest.approx(1.0 - 1.0 / 6.0, abs=0.05)
    assert record.not_heard == [pytest.approx((3.0, 4.0), abs=0.05),
                                pytest.approx((5.0, 5.0), abs=0.08)]
    assert record.not_heard[1][0] < 5.0 < record.not_heard[1][1]
    assert len(record.notes) == 1
    assert 'channel 1: 2 samples are no usable number' in record.notes[0]
    measured = MeasuredSqueal(record, record.tones(), SoundClock('start', 100.0))
    MeasuredFiles(tmp_path / 'measured.csv').write(measured)
    read = read_listening(tmp_path / 'measured.csv', ())
    assert read.not_heard == listening_of(measured).not_heard
    assert [read.covers('', start, start + 0.5) for start in (102.0, 102.8, 103.5, 104.0)] == [
        True, False, False, True]
    assert [round(tone.frequency_hz) for tone in record.tones() or ()] == [3000]


def test_the_sound_of_a_simulated_brake(kang: BrakeModel, tmp_path: Path) -> None:
    """Truth by another route: modal velocities, Rayleigh's integral, levels of modes."""
    microphone, mode = Microphone.of(kang), kang.names.index('disc (3,0)s')
    hertz = float(kang.angular_frequencies[mode]) / 2.0 / np.pi
    time = np.arange(2 * RATE * 2) / (2 * RATE)
    amplitude = np.where((time > 0.5) & (time < 1.5), 0.02, 1e-7)
    recorder = microphone.listen()
    for part in np.array_split(amplitude * np.sin(2.0 * np.pi * hertz * time), 60):
        velocity = np.zeros((part.size, kang.size))
        velocity[:, mode] = part
        recorder.add(velocity)
    sound = recorder.sound() / FULL_SCALE
    sound += 1e-5 * np.random.default_rng(11).standard_normal(sound.size)
    scale = LevelScale.parse(f'{FULL_SCALE}Pa')
    (event,) = heard(tmp_path, sound, kind='f4', settings=ListeningSettings(scale=scale))
    pressure = abs(microphone.response([hertz])[0, mode]) * 0.02 / np.sqrt(2.0)
    assert event.frequency_hz == pytest.approx(hertz, abs=1.0)
    assert event.level_db == pytest.approx(20.0 * np.log10(pressure / 20e-6) + float(
        a_weighting(np.array([hertz]))[0]), abs=0.2)
    assert (event.start, event.end) == (pytest.approx(0.5, abs=0.03), pytest.approx(1.5, abs=0.03))


@each(('text', 'level'), [  # of a sine of a tenth of full scale
    ('20Pa', 97.0), ('117dB', 97.0), ('100m/s2', 137.0), ('10.19716g', 137.0)])
def test_levels_by_calibration(text: str, level: float, tmp_path: Path) -> None:
    """At 2.5 kHz the A-weighting is 1.3 dB, for sound alone."""
    scale = LevelScale.parse(text)
    time = np.arange(RATE) / RATE
    sound = 0.1 * np.sin(2.0 * np.pi * 2500.0 * time)
    sound += 1e-5 * np.random.default_rng(12).standard_normal(RATE)
    (event,) = heard(tmp_path, sound, kind='f4',
                     settings=ListeningSettings(scale=scale, threshold=0.0))
    assert event.level_db == pytest.approx(level + 1.27 * scale.is_weighted, abs=0.1)
