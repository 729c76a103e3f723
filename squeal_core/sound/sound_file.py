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

"""Sound files, read block by block: WAV by this package, FLAC and others by soundfile."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from squeal_core.common.bounded_reader import open_bounded
from squeal_core.sound.other_formats import OtherFile
from squeal_core.sound.sound_errors import SoundError
from squeal_core.sound.sound_source import MAX_BYTES, Samples, SoundFile
from squeal_core.sound.wav_header import read_wav_header, WAV_MAGIC

_OTHERS = {b'fLaC': 'FLAC', b'OggS': 'Ogg', b'FORM': 'AIFF', b'ID3': 'MP3', b'caff': 'CAF'}


def open_sound(path: str | Path) -> SoundFile:
    """
    Read the header of a file; its format is taken from its first bytes, not its name.

    Raises
    ------
    SoundError
        One line: what is wrong with the file, and the remedy.

    """
    with open_bounded(path, MAX_BYTES, SoundError) as file:
        magic = file.read(4)
        file.seek(0)
        if magic in WAV_MAGIC:
            return WavFile.read_header(Path(path), file)
    named = next((name for start, name in _OTHERS.items() if magic.startswith(start)), '')
    return OtherFile.read_header(Path(path), named)


@dataclass(frozen=True)
class WavFile(SoundFile):
    """A WAV file."""

    first: int = 0
    sample_type: str = '<i2'

    @classmethod
    def read_header(cls, path: Path, file: object) -> 'WavFile':
        header = read_wav_header(path, file)  # type: ignore[arg-type]
        bits = header.valid_bits
        return cls(path, header.rate, header.channels, header.frames,
                   f'{bits} bit' if bits else f'{8 * int(header.sample_type[2:])} bit float',
                   2.0 ** (1 - bits) if bits else 0.0, header.started, list(header.notes),
                   header.first, header.sample_type)

    def blocks(self, frames: int) -> Iterator[Samples]:
        """Yield samples (n, channels) of full scale 1, at most so many of each channel."""
        width = self.channels * int(self.sample_type[2:])
        left = self.frames
        with open_bounded(self.path, MAX_BYTES, SoundError) as file:
            file.seek(self.first)
            while left > 0:
                data = file.read(min(frames, left) * width)
                count = len(data) // width
                if count == 0:
                    self.notes.append(f'the last {left / self.rate:.3f} s could not be read')
                    return
                left -= count
                yield _decoded(data[:count * width], self.sample_type).reshape(
                    -1, self.channels)


def _decoded(data: bytes, kind: str) -> Samples:
    """Return samples as floats of full scale 1."""
    if kind[1:] == 'i3':
        wide = np.zeros((len(data) // 3, 4), dtype=np.uint8)
        wide[:, slice(1, 4) if kind[0] == '<' else slice(0, 3)] = np.frombuffer(
            data, np.uint8).reshape(-1, 3)
        return _decoded(wide.tobytes(), f'{kind[0]}i4')
    values = np.frombuffer(data, kind)
    if kind[1] == 'f':
        with np.errstate(over='ignore', invalid='ignore'):  # infinite ones are told later
            return values.astype(np.float32)
    if kind[1] == 'u':
        return (values.astype(np.float32) - np.float32(128.0)) / np.float32(128.0)
    return values.astype(np.float32) * np.float32(2.0 ** (1 - 8 * int(kind[2:])))
