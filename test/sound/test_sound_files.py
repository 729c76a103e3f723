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

"""Sound files: all codings alike, lying headers, what is no sound, when it started."""

import datetime
from pathlib import Path
import struct

import numpy as np
import pytest
from squeal_core.common.errors import SquealError
from squeal_core.sound.sound_clock import clock_of_file, clock_of_stamp
from squeal_core.sound.sound_errors import SoundError
from squeal_core.sound.sound_file import open_sound
from support.rows import each
from support.sounds import write_wav

RATE = 8_000
SOUND = 0.8 * np.sin(np.arange(4_001 * 2).reshape(-1, 2) ** 1.5 / 500.0)


def samples(path: Path) -> np.ndarray:
    sound = open_sound(path)
    whole = np.concatenate(list(sound.blocks(1_000)))
    assert whole.shape == (sound.frames, sound.channels)
    return whole


@each('kind', ['u1', 'i2', 'i3', 'i4', 'f4', 'f8'])
@each('magic', [b'RIFF', b'RIFX', b'RF64'])
def test_all_codings_are_read_alike(kind: str, magic: bytes, tmp_path: Path) -> None:
    for extensible in (False, True):
        path = write_wav(tmp_path / 'a.wav', RATE, SOUND, kind, magic=magic,
                         extensible=extensible)
        step = 2.0 ** (1 - 8 * int(kind[1])) if kind[0] != 'f' else 1e-7
        assert np.abs(samples(path) - SOUND).max() <= max(step, 1e-7)
        assert not open_sound(path).notes


@each(('stated', 'frames', 'words'), [
    (10 ** 9, 4_001, 'the file is cut off'), (0, 4_001, 'does not say how long'),
    (0xFFFFFFFF, 4_001, 'does not say how long')])
def test_what_a_lying_header_leaves_is_used_and_stated(stated: int, frames: int, words: str,
                                                       tmp_path: Path) -> None:
    path = write_wav(tmp_path / 'a.wav', RATE, SOUND, 'i3', data_size=stated)
    assert np.abs(samples(path) - SOUND).max() < 1e-6
    (note,) = open_sound(path).notes
    assert words in note
    path.write_bytes(path.read_bytes()[:-7])  # in the middle of a frame
    assert len(samples(path)) == frames - 2


@each(('content', 'words'), [
    (b'', 'is no'), (b'RIFF', 'but no WAVE'), (b'RIFF\x04\0\0\0WAVE', 'ends before its format'),
    (b'hello, this is text' * 50, 'is no'), (bytes(5_000), 'is no'),
    (b'ID3' + bytes(300), 'is no sound'),
    (b'RIFF\0\0\0\0WAVEfmt \x10\0\0\0' + struct.pack('<HHIIHH', 7, 1, 8000, 8000, 1, 8)
     + b'data\x04\0\0\0abcd', 'mu-law'),
    (b'RIFF\0\0\0\0WAVEfmt \x10\0\0\0' + struct.pack('<HHIIHH', 1, 0, 8000, 8000, 1, 8), '0 chan'),
    (b'RIFF\0\0\0\0WAVEfmt \x10\0\0\0' + struct.pack('<HHIIHH', 1, 1, 8000, 8000, 7, 16)
     + b'data', 'frames of 7 bytes'),
    (b'RIFF\x24\0\0\0WAVEfmt \x10\0\0\0' + struct.pack('<HHIIHH', 1, 1, 8000, 16000, 2, 16)
     + b'data\0\0\0\0', 'holds no samples')])
def test_what_is_no_sound_is_one_line(content: bytes, words: str, tmp_path: Path) -> None:
    (tmp_path / 'a.wav').write_bytes(content)
    with pytest.raises(SoundError, match=words) as raised:
        open_sound(tmp_path / 'a.wav')
    assert '\n' not in str(raised.value)


def test_flac_is_read_and_a_damaged_one_as_far_as_it_goes(tmp_path: Path) -> None:
    soundfile = pytest.importorskip('soundfile')
    long = np.tile(SOUND, (40, 1))
    soundfile.write(tmp_path / 'a.flac', long, RATE, subtype='PCM_24')
    assert np.abs(samples(tmp_path / 'a.flac') - long).max() < 1e-6
    data = (tmp_path / 'a.flac').read_bytes()
    (tmp_path / 'b.flac').write_bytes(data[:len(data) // 2])
    sound = open_sound(tmp_path / 'b.flac')
    count = sum(len(block) for block in sound.blocks(1_000))
    assert 0 < count < len(long)
    assert 'missing or damaged' in sound.notes[0]


def test_the_clock_of_a_bext_chunk(tmp_path: Path) -> None:
    """To a second by its text, to a sample by its time reference where both agree."""
    day = (9 * 3600 + 30 * 60) * RATE
    for reference, second in ((day + 2_000, 0.25), (0, 0.0)):
        bext = bytes(320) + b'2026-05-04' + b'09:30:00' + struct.pack('<Q', reference) + bytes(256)
        clock = clock_of_file(open_sound(write_wav(tmp_path / 'a.wav', RATE, SOUND, bext=bext)))
        wanted = datetime.datetime(2026, 5, 4, 9, 30, tzinfo=datetime.UTC).timestamp() + second
        assert (clock.source, clock.offset) == ('bext', pytest.approx(wanted, abs=1e-4))
    assert clock_of_file(open_sound(write_wav(tmp_path / 'b.wav', RATE, SOUND))).shift == 0.0


def test_stamps() -> None:
    assert clock_of_stamp('2026-05-04T09:30:00.250+02:00').offset == clock_of_stamp(
        '1777879800.25').offset
    for text, words in (('2026-05-04T09:30', 'has no zone'), ('yesterday', 'give a time as'),
                        ('1777879800250000000', 'not milli- or nanoseconds')):
        with pytest.raises(SquealError, match=words):
            clock_of_stamp(text)
