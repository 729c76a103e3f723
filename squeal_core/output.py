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

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
import errno
import os
from pathlib import Path
import shutil
import stat
from types import TracebackType
from typing import Self

try:
    import fcntl
except ImportError:  # Windows; leftovers are then told by the process number alone
    fcntl = None  # type: ignore[assignment]

from squeal_core.errors import PlacedError

PARTIAL = '.squeal-part'  # ends the temporary name of what is being written
REPLACED = '.squeal-old'  # and of what it replaces, until all outputs of a run are in place
_PROBE = bytes(65536)  # written ahead of the work: a full disk shows itself
_BAG_SUFFIXES = ('.yaml', '.mcap', '.db3')
_KINDS = ((stat.S_ISDIR, 'a folder'), (stat.S_ISCHR, 'a device'), (stat.S_ISBLK, 'a device'),
          (stat.S_ISFIFO, 'a pipe'), (stat.S_ISSOCK, 'a socket'))


class OutputError(PlacedError):
    """A file or folder that cannot be written."""


def kind_of(mode: int) -> str:
    """Return what a file is that is no regular one, in words; '' for a regular file."""
    return next((words for test, words in _KINDS if test(mode)),
                '' if stat.S_ISREG(mode) else 'no regular file')


def check_target(path: str | Path, *, overwrite: bool = False, folder: bool = False) -> Path:
    """
    Return where an output goes; refuse, before any work, what could not be written there.

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

    Raises
    ------
    OutputError
        One line: which path, what is wrong with it, and the remedy.

    """
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
        if isinstance(error, PlacedError):
            raise
        raise _unwritable(path, error) from None
    return folder


@contextmanager
def output_file(path: str | Path, *, overwrite: bool = False) -> Iterator[Path]:
    """Give the temporary path of one output file, which is renamed when the context ends well."""
    with OutputFiles(overwrite=overwrite) as files:
        yield files.add(path).partial


@dataclass(eq=False)
class Output:
    """
    One output of a run.

    Parameters
    ----------
    target : Path
        Its name in the end, links resolved.
    partial : Path
        Its name until then: an empty file or folder at first.

    """

    target: Path
    partial: Path
    lock: int = field(repr=False, default=-1)
    replaced: Path | None = field(repr=False, default=None)
    committed: bool = field(repr=False, default=False)


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
            output = _reserve(target, folder)
            self._outputs.append(output)
            if probe:
                _probe(output.partial / 'probe' if folder else output.partial)
            return output
        except (OSError, ValueError) as error:  # ValueError: a NUL in the path
            if isinstance(error, PlacedError):
                raise
            raise _unwritable(path, error) from None

    def discard(self) -> None:
        """Remove what was reserved; nothing is committed then."""
        for output in self._outputs:
            _remove(output.partial)
            _release(output)
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
            _synchronise(output.partial)
        try:
            for output in self._outputs:
                _put_in_place(output, self._overwrite, alone=len(self._outputs) == 1)
        except BaseException:
            for output in reversed(self._outputs):
                _put_back(output)
            raise
        for output in self._outputs:
            if output.replaced:
                _remove(output.replaced)
        for folder in {output.target.parent for output in self._outputs}:
            with suppress(OSError):  # not every file system can; the files are in place
                _synchronise_one(folder)


def clear_leftovers(folder: Path) -> None:
    """Remove what killed runs left half-written in a folder, and undo what they half replaced."""
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            name, _, number = path.stem.rpartition('.')
            if path.suffix in (PARTIAL, REPLACED) and name and number.isdecimal() and _ownerless(
                    path, int(number)):
                with suppress(OSError):
                    if path.suffix == REPLACED and not os.path.lexists(folder / name):
                        path.rename(folder / name)
                _remove(path)


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
        raise OutputError(path, 'is a folder that holds more than a bag, so it is not replaced',
                          'remove it or give another name')
    return target


def _replaceable(folder: Path) -> bool:
    """Return whether a folder holds the files of one bag and nothing else."""
    parts = list(folder.iterdir())
    return not parts or (any(part.name == 'metadata.yaml' for part in parts) and all(
        part.suffix in _BAG_SUFFIXES and part.is_file() for part in parts))


def _reserve(target: Path, folder: bool) -> Output:
    """Make the empty file or folder that is filled, and hold a lock on it."""
    partial = target.with_name(f'{target.name}.{os.getpid()}{PARTIAL}')
    if folder:
        partial.mkdir()
        lock = os.open(partial, os.O_RDONLY)
    else:
        lock = os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
    if fcntl is not None:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return Output(target, partial, lock)


def _probe(path: Path) -> None:
    """Write some bytes to the disk and take them back."""
    with path.open('wb', buffering=0) as file:
        if file.write(_PROBE) != len(_PROBE):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        os.fsync(file.fileno())
        file.truncate(0)


def _put_in_place(output: Output, overwrite: bool, *, alone: bool) -> None:
    """Rename one output; the file that it replaces is kept under another name if need be."""
    target, partial = output.target, output.partial
    there = os.path.lexists(target)
    if there and not overwrite:
        raise OutputError(target, 'exists by now', 'give --force to replace it, or another name')
    if there and not (alone and partial.is_file() and target.is_file()):
        output.replaced = target.with_name(f'{target.name}.{os.getpid()}{REPLACED}')
        target.rename(output.replaced)
    if there and partial.is_file() and output.replaced is None:
        shutil.copymode(target, partial)
    if there or partial.is_dir():
        partial.replace(target)
    else:
        _rename_new(partial, target)
    output.committed = True


def _rename_new(partial: Path, target: Path) -> None:
    """Rename a file, never over one that came into being meanwhile."""
    try:
        os.link(partial, target)
    except FileExistsError:
        raise OutputError(target, 'exists by now', 'give --force to replace it, or another name'
                          ) from None
    except OSError:  # a file system without hard links
        partial.replace(target)
    else:
        partial.unlink()


def _put_back(output: Output) -> None:
    """Undo `_put_in_place`."""
    if output.committed:
        _remove(output.target)
    if output.replaced:
        with suppress(OSError):
            output.replaced.rename(output.target)


def _ownerless(path: Path, process: int) -> bool:
    """Return whether no running process writes a leftover."""
    if os.name != 'posix':
        return False
    if process != os.getpid():
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            pass
        except (OSError, OverflowError):
            return False
        else:
            return False
    return _lockable(path)


def _lockable(path: Path) -> bool:
    """Return whether nobody holds a lock, be it in another container, where numbers differ."""
    try:
        lock = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    finally:
        os.close(lock)
    return True


def _release(output: Output) -> None:
    with suppress(OSError):
        os.close(output.lock)


def _remove(path: Path) -> None:
    """Remove a file or folder if it is there; what cannot be removed hides no earlier error."""
    with suppress(OSError):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _synchronise(path: Path) -> None:
    """Have everything of a file or folder written to the disk."""
    for part in (*path.rglob('*'), path) if path.is_dir() else (path,):
        _synchronise_one(part)


def _synchronise_one(path: Path) -> None:
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EROFS):  # no such thing on this file system
            raise
    finally:
        os.close(handle)


def _unwritable(where: object, error: Exception) -> OutputError:
    remedies: Sequence[tuple[int, str]] = (
        (errno.ENOSPC, 'make room or write elsewhere'),
        (errno.EDQUOT, 'make room or write elsewhere'),
        (errno.EROFS, 'write elsewhere'), (errno.ENAMETOOLONG, 'give a shorter name'))
    number = getattr(error, 'errno', None)
    return OutputError(where, f'cannot be written ({getattr(error, "strerror", None) or error})',
                       dict(remedies).get(number or 0, 'check folder and rights'))
