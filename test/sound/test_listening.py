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
from squeal_core.common.arrays import FloatArray
from squeal_core.sound.listen import listen
from squeal_core.sound.listening_settings import ListeningSettings
from squeal_core.sound.sound_file import SoundFile
from squeal_core.sound.squeal_detection import HeardTone
from squeal_core.sound.tone_sources import SpeedAt
from support.rows import each
from support.sounds import sound_of, Squeal, write_wav

RATE = 48_000


def heard(tmp_path: Path, sound: FloatArray, rate: int = RATE, kind: str = 'i2', *,
          settings: ListeningSettings | None = None, brakes: Sequence[str] = (),
          speed: SpeedAt | None = None) -> list[HeardTone]:
    """Return events and rejected tones."""
    path = write_wav(tmp_path / 'sound.wav', rate, sound, kind)
    tones = listen(SoundFile.open(path), settings or ListeningSettings()).tones(
        brakes=brakes, speed=speed)
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
