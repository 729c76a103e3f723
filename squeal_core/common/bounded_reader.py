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
Opening of files to read: regular files only, of a bounded size.

A pipe would make a reader wait for ever, a device such as /dev/zero would never end; both are
refused before a byte is read, as is a file that is larger than its format ever is.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import errno
import io
import os
from pathlib import Path
import stat
from typing import BinaryIO

from squeal_core.common.errors import SquealError

ErrorOf = Callable[[object, str, str], SquealError]
"""Constructor of the caller's error from where, what and remedy."""

_KINDS = ((stat.S_ISDIR, 'a folder'), (stat.S_ISCHR, 'a device'), (stat.S_ISBLK, 'a device'),
          (stat.S_ISFIFO, 'a pipe'), (stat.S_ISSOCK, 'a socket'))


def kind_of(mode: int) -> str:
    """Return the kind of a file that is no regular one, in words; '' for a regular file."""
    return next((words for test, words in _KINDS if test(mode)),
                '' if stat.S_ISREG(mode) else 'no regular file')


@contextmanager
def open_bounded(path: str | Path, most_bytes: int, error_of: ErrorOf) -> Iterator[BinaryIO]:
    """
    Open a regular file of at most so many bytes for reading; a link to one will do.

    Parameters
    ----------
    path : path
        Where the file is.
    most_bytes : int
        Size limit.
    error_of : callable
        Makes the error that is raised, of where, what and remedy.

    """
    try:
        # without O_NONBLOCK the opening of a pipe would wait for somebody to write to it
        handle = os.open(path, os.O_RDONLY | getattr(os, 'O_NONBLOCK', 0)
                         | getattr(os, 'O_BINARY', 0))
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        raise _unreadable(path, error, error_of) from None
    try:
        status = os.fstat(handle)
        if kind := kind_of(status.st_mode):
            raise error_of(path, f'is {kind}, no regular file', 'give the path of a file')
        if status.st_size > most_bytes:
            raise too_large(path, status.st_size, most_bytes, error_of)
        with open(handle, 'rb', closefd=False) as file:
            yield file
    finally:
        os.close(handle)


def read_bounded(path: str | Path, most_bytes: int, error_of: ErrorOf) -> bytes:
    """Return the content of a regular file of at most so many bytes."""
    with open_bounded(path, most_bytes, error_of) as file:
        try:
            data = file.read(most_bytes + 1)
        except OSError as error:
            raise _unreadable(path, error, error_of) from None
    if data is None:  # a file of /proc that would wait
        raise _unreadable(path, BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN)), error_of)
    if len(data) > most_bytes:  # the size that it states is not its size
        raise too_large(path, len(data), most_bytes, error_of)
    return data


def read_text_bounded(path: str | Path, most_bytes: int, error_of: ErrorOf, *,
                      encoding: str = 'utf-8', errors: str = 'strict') -> str:
    """Return the text in a regular file of at most so many bytes."""
    try:
        return read_bounded(path, most_bytes, error_of).decode(encoding, errors)
    except UnicodeDecodeError as error:
        raise error_of(path, f'is no {encoding.upper()} text (byte {error.start})',
                       f'save it as {encoding.upper()}') from None


def bounded_lines(file: BinaryIO, most_letters: int, error_of: Callable[[int], SquealError], *,
                  encoding: str = 'utf-8-sig', errors: str = 'strict') -> Iterator[str]:
    """
    Yield the lines of an open file with their ends, none longer than so many characters.

    Parameters
    ----------
    file : binary file
        Opened for reading.
    most_letters : int
        Of one line.
    error_of : callable
        Of the number of a line that is too long: makes the error.
    encoding, errors : str
        As for `bytes.decode`.

    """
    number = 0
    text = io.TextIOWrapper(file, encoding, errors, newline='')
    try:
        while line := text.readline(most_letters + 1):
            number += 1
            if len(line) > most_letters:
                raise error_of(number)
            yield line
    finally:
        if not file.closed:  # whoever reads no further may have closed it
            text.detach()


def check_readable(path: str | Path, most_bytes: int, error_of: ErrorOf) -> int:
    """Return the size [bytes] of a regular file that a library is to open by itself."""
    with open_bounded(path, most_bytes, error_of) as file:
        return os.fstat(file.fileno()).st_size


def too_large(path: object, size: int, most_bytes: int, error_of: ErrorOf) -> SquealError:
    """Return the error of a file that is larger than its format ever is."""
    return error_of(path, f'has {size} bytes, more than the {most_bytes} that are read',
                    'check that this is the file you mean, or make it smaller')


def _unreadable(path: object, error: Exception, error_of: ErrorOf) -> SquealError:
    text = getattr(error, 'strerror', None) or error
    remedy = 'check the path' if isinstance(error, FileNotFoundError) else 'check path and rights'
    return error_of(path, f'cannot be read ({text})', remedy)
