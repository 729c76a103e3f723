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

"""Sound files other than WAV, which soundfile (extra `sound`) reads; FLAC above all."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
import re
from typing import Any

from squeal_core.common.bounded_reader import check_readable
from squeal_core.sound.sound_errors import SoundError
from squeal_core.sound.sound_source import MAX_BYTES, Samples, SoundFile


def _soundfile(path: object, named: str) -> Any:
    try:
        import soundfile
    except (ImportError, OSError):  # OSError: its library is not there
        if not named:
            raise SoundError(path, 'is no WAV or FLAC file', 'give a sound file') from None
        raise SoundError(path, f'is a {named} file, which needs soundfile',
                         "pip install -e '.[sound]' in the checkout, or convert it") from None
    return soundfile


@dataclass(frozen=True)
class OtherFile(SoundFile):
    """A file that soundfile reads."""

    @classmethod
    def read_header(cls, path: Path, named: str) -> 'OtherFile':
        check_readable(path, MAX_BYTES, SoundError)
        soundfile = _soundfile(path, named)
        try:
            about = soundfile.info(path)
        except (soundfile.SoundFileError, RuntimeError) as error:
            raise SoundError(path, 'is no sound that can be read '
                             f'({getattr(error, "error_string", error)})',
                             'give a WAV or FLAC file') from None
        if not about.frames:
            raise SoundError(path, 'holds no samples', 'give a recording')
        bits = re.search(r'PCM_S?U?(\d+)', about.subtype)
        coding = f'{about.format}, {f"{bits[1]} bit" if bits else about.subtype.lower()}'
        return cls(path, about.samplerate, about.channels, about.frames, coding,
                   2.0 ** (1 - int(bits[1])) if bits else 0.0)

    def blocks(self, frames: int) -> Iterator[Samples]:
        """Yield samples (n, channels) of full scale 1, at most so many of each channel."""
        soundfile, done = _soundfile(self.path, ''), 0
        try:
            with soundfile.SoundFile(self.path) as file:
                while (block := file.read(frames, dtype='float32', always_2d=True)).size:
                    done += len(block)
                    yield block
        except (soundfile.SoundFileError, RuntimeError):
            pass  # damaged from here on; said below
        if done < self.frames:
            self.notes.append(f'the last {(self.frames - done) / self.rate:.3f} s of '
                              f'{self.duration:.3f} s are missing or damaged')
        if not done:
            raise SoundError(self.path, 'holds no samples that can be read',
                             'give the whole file')
