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

"""
The header of a WAV file: RIFF, RIFX, RF64 and BW64, plain and WAVE_FORMAT_EXTENSIBLE.

Lengths in headers are often wrong: a recorder that lost its power leaves 0, a stream 0xFFFFFFFF,
a full disk a length beyond the end. What is there is used, and a note says what is missing.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import datetime
import os
import re
import struct
from typing import BinaryIO, NamedTuple

from squeal_core.sound.sound_errors import SoundError

WAV_MAGIC = (b'RIFF', b'RIFX', b'RF64', b'BW64')
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_TAGS = {2: 'ADPCM', 6: 'A-law', 7: 'mu-law', 0x11: 'IMA ADPCM', 0x55: 'MP3'}
_STREAMING = 0xFFFFFFFF
_MOST_CHUNKS, _MOST_CHANNELS = 10_000, 256
_RATES = (2_000, 2_000_000)  # Hz
_BEXT = 346  # bytes of a bext chunk up to its time reference


class ClockTime(NamedTuple):
    """Start of a file as it states it: a time without zone, and its resolution [s]."""

    time: datetime.datetime
    resolution: float


@dataclass(frozen=True)
class WavHeader:
    """
    Place and kind of the samples of a WAV file.

    Parameters
    ----------
    rate, channels : int
        [Hz] and [-].
    sample_type : str
        Of numpy, with byte order; `<i3` and `>i3` for 24 bits.
    valid_bits : int
        Of a sample; 0 for floats.
    first, frames : int
        Byte of the first sample; samples of each channel.
    started : ClockTime, optional
        Of a `bext` chunk.
    notes : tuple of str
        What of the header does not fit the file.

    """

    rate: int
    channels: int
    sample_type: str
    valid_bits: int
    first: int
    frames: int
    started: ClockTime | None
    notes: tuple[str, ...]


class _Chunk(NamedTuple):
    name: bytes
    first: int
    size: int


def read_wav_header(path: object, file: BinaryIO) -> WavHeader:
    """
    Read up to the samples of an open file that begins as a WAV file does.

    Raises
    ------
    SoundError
        For a file without format or samples, or of a coding that is not read.

    """
    end = os.fstat(file.fileno()).st_size
    magic, riff_size, kind = struct.unpack('4sI4s', file.read(12).ljust(12, b'\0'))
    order = '>' if magic == b'RIFX' else '<'
    if kind != b'WAVE':
        raise SoundError(path, f'is a {magic.decode()} file, but no WAVE', 'give a WAV file')
    if order == '>':
        riff_size = int.from_bytes(riff_size.to_bytes(4, 'little'), 'big')
    form = started = None
    long_size = 0
    for chunk in _chunks(file, order, end):
        file.seek(chunk.first)
        if chunk.name == b'ds64':
            long_size = struct.unpack('<8xQ', file.read(16).ljust(16, b'\0'))[0]
        elif chunk.name == b'fmt ':
            form = _format(path, file.read(min(chunk.size, 40)), order)
        elif chunk.name == b'bext' and form:
            started = _started(file.read(_BEXT), form[0])
        elif chunk.name == b'data' and form:
            size = long_size if chunk.size == _STREAMING and long_size else chunk.size
            unfinished = size == 0 and riff_size + 8 <= chunk.first
            return _header(path, form, started, chunk.first, end,
                           _STREAMING if unfinished else size)
    raise SoundError(path, 'ends before its ' + ('samples' if form else 'format'),
                     'give the whole file')


def _chunks(file: BinaryIO, order: str, end: int) -> Iterator[_Chunk]:
    place = 12
    for _ in range(_MOST_CHUNKS):
        file.seek(place)
        head = file.read(8)
        if len(head) < 8:
            return
        name, size = struct.unpack(f'{order}4sI', head)
        yield _Chunk(name, place + 8, size)
        place += 8 + size + size % 2
        if place > end:
            return


def _format(path: object, data: bytes, order: str) -> tuple[int, int, str, int]:
    """Return rate, channels, type of a sample and its valid bits."""
    if len(data) < 16:
        raise SoundError(path, f'has a format of {len(data)} bytes', 'give a WAV file')
    tag, channels, rate, _, frame, bits = struct.unpack(f'{order}HHIIHH', data[:16])
    valid = bits
    if tag == _EXTENSIBLE and len(data) >= 26:
        valid, tag = struct.unpack(f'{order}H4xH', data[18:26])
    if not (1 <= channels <= _MOST_CHANNELS and _RATES[0] <= rate <= _RATES[1]):
        raise SoundError(path, f'has {channels} channels at {rate} Hz', f'give 1 to '
                         f'{_MOST_CHANNELS} channels at {_RATES[0]} to {_RATES[1]} Hz')
    width = (bits + 7) // 8
    kinds = {(_PCM, 1): 'u1', (_PCM, 2): 'i2', (_PCM, 3): 'i3', (_PCM, 4): 'i4',
             (_FLOAT, 4): 'f4', (_FLOAT, 8): 'f8'}
    if (tag, width) not in kinds:
        raise SoundError(path, f'is coded as {_TAGS.get(tag, f"format {tag:#06x}")} of {bits} '
                         'bits', 'convert it to PCM of 16, 24 or 32 bits, or floats')
    if frame != width * channels:
        raise SoundError(path, f'has frames of {frame} bytes for {channels} channels of {bits} '
                         'bits', 'write it again')
    return (rate, channels, order + kinds[tag, width],
            0 if tag == _FLOAT else valid if 0 < valid <= bits else bits)


def _header(path: object, form: tuple[int, int, str, int], started: ClockTime | None,
            first: int, end: int, size: int) -> WavHeader:
    rate, channels, sample_type, _ = form
    frame = channels * int(sample_type[2:])
    there, notes = end - first, []
    if size == _STREAMING:
        notes.append('the header does not say how long the sound is, as of a recording that was '
                     'not closed; all that is there is used')
    elif size > there:
        missing = (size - there) / frame / rate
        notes.append(f'the last {missing:.3f} s of {size / frame / rate:.3f} s are missing: the '
                     'file is cut off')
    frames = min(size, there) // frame
    if frames == 0:
        raise SoundError(path, 'holds no samples', 'give a recording')
    return WavHeader(*form, first, frames, started, tuple(notes))


def _started(data: bytes, rate: int) -> ClockTime | None:
    """Return the origination time of a bext chunk, finer where its time reference agrees."""
    text = data[320:338].decode('ascii', 'replace')
    numbers = re.fullmatch(r'(\d{4}).(\d\d).(\d\d)(\d\d).(\d\d).(\d\d)', text)
    if not numbers:
        return None
    try:
        time = datetime.datetime(*map(int, numbers.groups()))  # type: ignore[arg-type]
    except ValueError:
        return None
    if len(data) == _BEXT:
        since = datetime.timedelta(seconds=struct.unpack('<Q', data[338:346])[0] / rate) \
            if struct.unpack('<Q', data[338:346])[0] < 86_400 * rate else None
        midnight = datetime.datetime.combine(time.date(), datetime.time())
        if since and abs((midnight + since - time).total_seconds()) <= 2.0:
            return ClockTime(midnight + since, 1.0 / rate)
    return ClockTime(time, 1.0)
