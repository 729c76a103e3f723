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

"""Text files by line: fixed columns are read strictly, errors name file, line and column."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers.raw import AGAIN, read_bytes, ReaderError


@dataclass(frozen=True, eq=False)
class Text:
    """
    Lines of a file.

    Parameters
    ----------
    path : Path
    lines : list of bytes
        Without their ends.

    """

    path: Path
    lines: list[bytes]

    @classmethod
    def read(cls, path: Path) -> 'Text':
        """Return the lines of a text file; a binary one is refused."""
        data = read_bytes(path)
        if not data.strip():
            raise ReaderError(path, 'is empty', AGAIN)
        if b'\0' in data:
            raise ReaderError(path, f'is no text: byte {data.index(0)} is zero',
                              'export it as text (ASCII)')
        return cls(path, data.splitlines())

    def line(self, index: int) -> bytes:
        """Return a line; past the end of the file there is nothing but an error."""
        if index >= len(self.lines):
            raise ReaderError(f'{self.path}, line {len(self.lines)}', 'is the last line, but the '
                              'file is not complete', 'it was cut short: ' + AGAIN)
        return self.lines[index]

    def error(self, index: int, what: str, remedy: str = AGAIN) -> ReaderError:
        """Return the error that a line deserves."""
        return ReaderError(f'{self.path}, line {index + 1}', what, remedy)

    def wrong(self, index: int, expected: str) -> ReaderError:
        """Return the error of a line with unexpected contents."""
        return self.error(index, f'is {_shown(self.line(index))}, not {expected}')

    def number(self, index: int, start: int, stop: int, kind: Callable[[str], Any] = float) -> Any:
        """Return the number in columns start to stop (from 0) of a line."""
        try:
            return kind(self.line(index)[start:stop].decode('ascii').upper().replace('D', 'E'))
        except ValueError:
            raise self._no_number(index, start, stop) from None

    def fixed(self, rows: range, start: int, width: int, count: int,
              kind: type = float) -> Any:
        """
        Return the numbers (len(rows), count) in columns of equal width.

        Fortran leaves no blank between long numbers, so that splitting at blanks would not do.
        """
        stop = start + width * count
        self.line(max(rows, default=0))
        taken = [self.lines[i] for i in rows]
        table = np.array(taken, dtype=f'S{stop}').view('S1').reshape(-1, stop)[:, start:]
        cells = np.ascontiguousarray(table).view(f'S{width}').reshape(-1, count)
        dtype = np.int64 if kind is int else np.float64
        for text in (cells, np.char.replace(np.char.upper(cells), b'D', b'E')):
            try:
                return text.astype(dtype)
            except (ValueError, OverflowError):
                continue
        raise self._first_bad(rows, start, width, count, kind)

    def _first_bad(self, rows: range, start: int, width: int, count: int,
                   kind: type) -> ReaderError:
        for i in rows:
            for column in range(start, start + width * count, width):
                self.number(i, column, column + width, kind)
        return ReaderError(self.path, 'holds numbers out of range', AGAIN)

    def _no_number(self, index: int, start: int, stop: int) -> ReaderError:
        return self.error(index, f'has {_shown(self.line(index)[start:stop])} in columns '
                          f'{start + 1} to {stop}, not a number')


def _shown(line: bytes) -> str:
    return short_repr(line.decode('ascii', errors='replace'))
