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
Members of NumPy archives (.npz), read with bounds and checks.

Nothing in an archive is believed: its directory is small, its members are stored or deflated, and
each array's own header is compared with the size of its member before a byte of the data is read.
Never a pickle.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
import math
from pathlib import Path
import struct
from typing import Any, BinaryIO
import zipfile

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.bounded_reader import ErrorOf, open_bounded

MAX_BYTES = 500_000_000  # of all arrays of an archive
_MAX_DIRECTORY = 16_384  # bytes of the archive's directory: some two hundred members
_END = struct.Struct('<4s4H2LH')  # end of the directory: without the comment that may follow it
_SIZE_OF_64 = 20


@dataclass(frozen=True)
class ArrayLayout:
    """Shape and type of an array, from its own header."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    @property
    def nbytes(self) -> int:
        """Return the size of the array in memory [bytes]."""
        return math.prod(self.shape) * self.dtype.itemsize


class NpzReader:
    """
    The members of an open archive; `npz_reader` opens one.

    All errors but those of the file system are ValueErrors; a damaged archive makes zipfile, zlib
    and numpy raise others, which the caller takes for damage as well.
    """

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self.names = {name.removesuffix('.npy') for name in archive.namelist()}

    def layout(self, name: str) -> ArrayLayout:
        """Return shape and type of an array, after its member was found large enough for it."""
        with self._open(name) as file:
            version = np.lib.format.read_magic(file)
            read = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                    else np.lib.format.read_array_header_2_0)
            shape, _, dtype = read(file)
        return ArrayLayout(shape, dtype)

    def array(self, name: str) -> NDArray[Any]:
        """Return an array; call it for a layout that was found right only."""
        layout = self.layout(name)
        size = self._archive.getinfo(f'{name}.npy').file_size
        if not layout.nbytes < size <= layout.nbytes + 10_500:  # numpy reads headers up to 10 kB
            raise ValueError(f'{name} states {layout.nbytes} bytes in a member of {size}')
        with self._open(name) as file:
            return np.asarray(np.lib.format.read_array(file, allow_pickle=False))

    def _open(self, name: str) -> Any:
        kind = self._archive.getinfo(f'{name}.npy').compress_type
        if kind not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError(f'{name} is compressed by method {kind}')
        return self._archive.open(f'{name}.npy')


@contextmanager
def npz_reader(path: str | Path, error_of: ErrorOf, most_bytes: int = MAX_BYTES
               ) -> Iterator[NpzReader]:
    """Open an archive after its directory was found to be a small one."""
    with open_bounded(path, most_bytes, error_of) as file:
        _check_directory(file)
        with zipfile.ZipFile(file) as archive:
            yield NpzReader(archive)


def _check_directory(file: BinaryIO) -> None:
    """Refuse files from which zipfile would read a long directory."""
    size = file.seek(0, 2)
    if size < _END.size:
        raise ValueError(f'no archive: {size} bytes')
    file.seek(max(0, size - _END.size - _SIZE_OF_64))
    tail = file.read()
    mark, *_, length, _, comment = _END.unpack(tail[-_END.size:])
    if mark != b'PK\5\6' or comment or tail.startswith(b'PK\6\7'):
        raise ValueError('no archive, or one that is cut short')
    if length > _MAX_DIRECTORY:
        raise ValueError(f'a directory of {length} bytes')
    file.seek(0)
