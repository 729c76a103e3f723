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
Files and folders under temporary names: reserved, put in place, put back, leftovers removed.

The temporary name holds the process number, and a lock is held on the file, so what a killed
process left is told from what a running one writes.
"""

from contextlib import suppress
from dataclasses import dataclass, field
import errno
import os
from pathlib import Path
import shutil

try:
    import fcntl
except ImportError:  # Windows; leftovers are then told by the process number alone
    fcntl = None  # type: ignore[assignment]

from squeal_core.common.errors import LocatedError

PARTIAL = '.squeal-part'  # ends the temporary name of what is being written
REPLACED = '.squeal-old'  # and of what it replaces, until all outputs of a run are in place
_PROBE = bytes(65536)  # written ahead of the work: a full disk shows itself


class OutputError(LocatedError):
    """A file or folder that cannot be written."""


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


def reserve(target: Path, folder: bool) -> Output:
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


def write_probe(path: Path) -> None:
    """Write some bytes to the disk and take them back."""
    with path.open('wb', buffering=0) as file:
        if file.write(_PROBE) != len(_PROBE):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        os.fsync(file.fileno())
        file.truncate(0)


def put_in_place(output: Output, overwrite: bool, *, alone: bool) -> None:
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


def put_back(output: Output) -> None:
    """Undo `put_in_place`."""
    if output.committed:
        remove(output.target)
    if output.replaced:
        with suppress(OSError):
            output.replaced.rename(output.target)


def clear_leftovers(folder: Path) -> None:
    """Remove half-written files of killed runs in a folder, and undo their half replacements."""
    with suppress(OSError):
        for path in sorted(folder.iterdir()):
            name, _, number = path.stem.rpartition('.')
            if path.suffix in (PARTIAL, REPLACED) and name and number.isdecimal() and _ownerless(
                    path, int(number)):
                with suppress(OSError):
                    if path.suffix == REPLACED and not os.path.lexists(folder / name):
                        path.rename(folder / name)
                remove(path)


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


def release(output: Output) -> None:
    """Release the lock on an output."""
    with suppress(OSError):
        os.close(output.lock)


def remove(path: Path) -> None:
    """Remove a file or folder if it is there; what cannot be removed hides no earlier error."""
    with suppress(OSError):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def synchronise(path: Path) -> None:
    """Flush a file, or all of a folder, to disk."""
    for part in (*path.rglob('*'), path) if path.is_dir() else (path,):
        synchronise_one(part)


def synchronise_one(path: Path) -> None:
    """Flush a file or folder to disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in (errno.EINVAL, errno.EROFS):  # no such thing on this file system
            raise
    finally:
        os.close(handle)
