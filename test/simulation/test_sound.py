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


"""What is heard of a transient: the microphone's response, levels, events."""

from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.simulation.levels import ModalLevels, squeal_events
from squeal_core.simulation.microphone import AUDIO_RATE, Microphone, SOUND_SPEED
from squeal_core.simulation.transient import SAMPLE_RATE


@pytest.fixture(scope='module')
def microphone(kang: BrakeModel) -> Microphone:
    return Microphone.of(kang)


def heard(microphone: Microphone, velocity: FloatArray, parts: int) -> FloatArray:
    recorder = microphone.listen()
    for part in np.array_split(velocity, parts):
        recorder.add(part)
    return recorder.sound()


def test_tones_come_as_the_response_says_and_none_is_aliased(
        kang: BrakeModel, microphone: Microphone) -> None:
    """Of 3 kHz, and of 30 kHz, which 48 kHz cannot carry; in blocks of any size."""
    time = np.arange(SAMPLE_RATE // 4) / SAMPLE_RATE
    mode = kang.names.index('disc (3,0)s')
    velocity = np.zeros((time.size, kang.size))
    velocity[:, mode] = np.cos(2.0 * np.pi * 3000.0 * time)
    sound = heard(microphone, velocity, 7)
    assert sound.size == time.size // 2
    assert np.allclose(sound, heard(microphone, velocity, 1), rtol=0, atol=1e-12)
    response = microphone.response([3000.0])[0, mode]
    late = np.arange(sound.size)[2000:-2000] / AUDIO_RATE
    wanted = (response * np.exp(2j * np.pi * 3000.0 * late)).real
    assert np.abs(sound[2000:-2000] - wanted).max() < 1e-6 * abs(response)
    velocity[:, mode] = np.cos(2.0 * np.pi * 30e3 * time)
    assert np.abs(heard(microphone, velocity, 1)[2000:-2000]).max() < 1e-6 * abs(response)


def test_a_piston_sounds_as_rayleigh_has_it(microphone: Microphone) -> None:
    """A ring that moves as one, on its axis: p = rho c v |exp(-ik R_o) - exp(-ik R_i)|."""
    radius, height = np.linspace(0.1, 0.14, 401), 0.5
    width = radius[1] - radius[0]
    middle = radius[:-1] + 0.5 * width
    piston = Microphone(np.ones((400, 1)), 2.0 * np.pi * middle * width,
                        np.hypot(middle, height))
    k = 2.0 * np.pi * 4000.0 / SOUND_SPEED
    inner, outer = np.hypot(radius[[0, -1]], height)
    wanted = 1.2 * SOUND_SPEED * abs(np.exp(-1j * k * outer) - np.exp(-1j * k * inner))
    assert abs(piston.response([4000.0])[0, 0]) == pytest.approx(wanted, rel=1e-4)


def test_both_halves_of_each_doublet_are_heard(kang: BrakeModel, microphone: Microphone) -> None:
    hertz = kang.angular_frequencies / 2.0 / np.pi
    gain = microphone.level(np.maximum(hertz, 1.0), np.eye(kang.size))
    for n in range(1, 8):
        first = kang.names.index(f'disc ({n},0)c')
        pair = gain[first:first + 2]
        assert pair.min() > 0.1 * pair.max()


def test_models_without_a_surface_are_not_heard(kang: BrakeModel) -> None:
    with pytest.raises(ModelError, match='keeps none of its disc'):
        Microphone.of(replace(kang, surface=None))


def test_events_are_times_above_the_threshold_that_no_louder_tone_hides() -> None:
    """
    A tone from 0.2 s, another from 0.5 s with a dip of 50 ms.

    No events: a click of 10 ms, the partner of a doublet, a tone 20 dB below the loudest.
    """
    time = 0.005 + 0.01 * np.arange(150)
    level, hertz = np.full((150, 5, 1), 40.0), np.full((150, 5, 1), 900.0)
    hertz[:, 1], hertz[:, 2], hertz[:, 3], hertz[:, 4] = 2500.0, 3200.0, 2510.0, 5000.0
    level[20:50, 3], level[20:50, 4] = 93.0, 75.0
    level[20:50, 1], level[50:100, 2] = 95.0, 90.0
    level[70:75, 2] = 45.0
    level[130, 1] = 72.0
    events = squeal_events(ModalLevels(time, 0.0 * level, hertz, level), ('front',))
    assert [(event.brake, event.mode, round(event.frequency_hz)) for event in events] == [
        ('front', 2, 2500), ('front', 3, 3200)]
    assert events[0].level_db == pytest.approx(95.0, abs=0.1)
    assert events[0].start == pytest.approx(0.2, abs=0.03)
    assert events[1].start == pytest.approx(0.5, abs=0.03)
    assert events[1].end == pytest.approx(1.0, abs=0.03)
