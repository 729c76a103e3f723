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
The one writer of files: whole or not at all, regular files only, never over one unasked.

An output is written under a temporary name in the folder of its target and renamed when it is
complete and on disk. Several outputs of one run are committed together. The temporary name holds
the process number, so what a killed run left is found and removed by the next one.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
import errno
import os
from pathlib import Path
import stat
from types import TracebackType
from typing import Self

from squeal_core.common.bounded_reader import kind_of
from squeal_core.common.errors import LocatedError
from squeal_core.common.partial_files import (
    clear_leftovers,
    Output,
    OutputError,
    PARTIAL,
    put_back,
    put_in_place,
    release,
    remove,
    reserve,
    synchronise,
    synchronise_one,
    write_probe,
)

_BAG_SUFFIXES = ('.yaml', '.mcap', '.db3')
_RESULT_SUFFIXES = ('.mcap', '.csv', '.parquet', '.json')

__all__ = ['check_target', 'make_folder', 'Output', 'output_file', 'OutputError', 'OutputFiles',
           'named_as', 'PARTIAL']


def check_target(path: str | Path, *, overwrite: bool = False, folder: bool = False,
                 inputs: Iterable[str | Path] = ()) -> Path:
    """
    Return the target of an output; refuse, before any work, one that could not be written.

    A link is followed: what it points to is written and the link stays. Leftovers of killed runs
    in the folder are removed, and a small file is written and removed again, so a missing,
    read-only or full folder is found.

    Parameters
    ----------
    path : path
        Where the file is.
    overwrite : bool
        Whether an existing file (or folder, where the output is one) may be replaced.
    folder : bool
        The output is a folder.
    inputs : iterable of paths
        What the same run reads, which is never replaced; of a folder each file.

    Raises
    ------
    OutputError
        One line: which path, what is wrong with it, and the remedy.

    """
    read = {os.path.realpath(file) for source in map(Path, inputs)
            for file in (source, *(source.iterdir() if source.is_dir() else ()))}
    if read and os.path.realpath(path) in read:
        raise OutputError(path, 'is what this command reads', 'give another name')
    with OutputFiles(overwrite=overwrite) as files:
        target = files.add(path, folder=folder, probe=True).target
        files.discard()
    return target


def make_folder(path: str | Path) -> Path:
    """
    Make a folder for outputs, and those above it, where it is not there yet.

    Raises
    ------
    OutputError
        One line: which path, what is wrong with it, and the remedy.

    """
    folder = Path(path)
    try:
        if folder.exists() and not folder.is_dir():
            raise OutputError(path, 'is no folder', 'give another name')
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        if isinstance(error, LocatedError):
            raise
        raise _unwritable(path, error) from None
    return folder


@contextmanager
def output_file(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Yield the temporary path of one output file, renamed when the context ends well."""
    with OutputFiles(overwrite=overwrite) as files:
        yield files.add(path).partial


@contextmanager
def named_as(path: str | Path) -> Iterator[None]:
    """Raise errors under the name of the requested output where one of its files fails."""
    try:
        yield
    except OutputError as error:
        raise OutputError(path, error.what, error.remedy) from None


class OutputFiles:
    """
    Files and folders that appear under their names together, or not at all.

    A context manager. When the context ends by an error nothing has changed, and an OSError
    becomes an OutputError.

    Parameters
    ----------
    overwrite : bool
        Whether existing targets may be replaced.

    """

    def __init__(self, *, overwrite: bool = False) -> None:
        self._overwrite = overwrite
        self._outputs: list[Output] = []

    def __enter__(self) -> Self:
        return self

    def add(self, path: str | Path, *, folder: bool = False, probe: bool = False) -> Output:
        """
        Reserve an output: check its target and make the empty file or folder to fill.

        Raises
        ------
        OutputError
            For what is no place for it: see `check_target`.

        """
        try:
            target = _target(Path(path), self._overwrite, folder)
            if any(target == other.target for other in self._outputs):
                raise OutputError(path, 'is given for two outputs', 'give each its own name')
            clear_leftovers(target.parent)
            output = reserve(target, folder)
            self._outputs.append(output)
            if probe:
                write_probe(output.partial / 'probe' if folder else output.partial)
            return output
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            if isinstance(error, LocatedError):
                raise
            raise _unwritable(path, error) from None

    def discard(self) -> None:
        """Remove the reserved files; nothing is committed then."""
        for output in self._outputs:
            remove(output.partial)
            release(output)
        self._outputs.clear()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        at: object = ', '.join(str(output.target) for output in self._outputs)
        try:
            if error is None:
                self._commit()
            elif isinstance(error, OSError) and not isinstance(error, BrokenPipeError):
                raise _unwritable(at, error) from None
        except OSError as failure:
            raise _unwritable(at, failure) from None
        finally:
            self.discard()

    def _commit(self) -> None:
        """Rename all; where one cannot be renamed, put back what was there."""
        for output in self._outputs:
            synchronise(output.partial)
        try:
            for output in self._outputs:
                put_in_place(output, self._overwrite, alone=len(self._outputs) == 1)
        except BaseException:
            for output in reversed(self._outputs):
                put_back(output)
            raise
        for output in self._outputs:
            if output.replaced:
                remove(output.replaced)
        for folder in {output.target.parent for output in self._outputs}:
            with suppress(OSError):  # not every file system can; the files are in place
                synchronise_one(folder)


def _target(path: Path, overwrite: bool, folder: bool) -> Path:
    """Return the path an output is renamed to, if one may be there."""
    if path.is_symlink() and not path.exists():
        raise OutputError(path, 'is a link that leads nowhere', 'remove it or give another name')
    target = Path(os.path.realpath(path, strict=path.exists()))
    try:
        mode = target.stat().st_mode
    except FileNotFoundError:
        if not target.parent.is_dir():
            raise OutputError(path, 'is in a folder that does not exist', 'make it first'
                              ) from None
        return target
    kind = kind_of(mode)
    is_folder = stat.S_ISDIR(mode)
    if kind and not (is_folder and folder):
        raise OutputError(path, f'is {kind}, no regular file', 'give the name of a file')
    if not overwrite:
        raise OutputError(path, 'exists', 'give --force to replace it, or another name')
    if is_folder and not _replaceable(target):
        raise OutputError(path, 'is a folder that holds more than a bag or a result, so '
                          'it is not replaced',
                          'remove it or give another name')
    return target


def _replaceable(folder: Path) -> bool:
    """Return whether a folder holds the files of one bag, or of one result, and nothing else."""
    parts = list(folder.iterdir())
    names = {part.name for part in parts}
    suffixes = _BAG_SUFFIXES if 'metadata.yaml' in names else (
        _RESULT_SUFFIXES if 'summary.json' in names else ())
    return all(part.suffix in suffixes and part.is_file() for part in parts)


def _unwritable(where: object, error: Exception) -> OutputError:
    remedies: Sequence[tuple[int, str]] = (
        (errno.ENOSPC, 'make room or write elsewhere'),
        (errno.EDQUOT, 'make room or write elsewhere'),
        (errno.EROFS, 'write elsewhere'), (errno.ENAMETOOLONG, 'give a shorter name'))
    number = getattr(error, 'errno', None)
    return OutputError(where, f'cannot be written ({getattr(error, "strerror", None) or error})',
                       dict(remedies).get(number or 0, 'check folder and rights'))
