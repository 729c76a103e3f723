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
Solved modes kept on disk, under a hash of all that they depend on; no pickle.

An entry that cannot be read, or is not what its name says, counts as absent and is written anew.
A cache that cannot be written costs a warning, not the result.
"""

from collections.abc import Callable
import hashlib
from pathlib import Path
from typing import TypeAlias
import warnings

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelFileError
from squeal_core.common.npz_reader import npz_reader
from squeal_core.common.output import output_file, OutputError

Solution: TypeAlias = tuple[FloatArray, FloatArray]

_SCHEME = 1  # raise it when the same inputs come to give other modes
_ARRAYS = ('angular_frequencies', 'shapes')


def content_key(**parts: ArrayLike | str) -> str:
    """Return a hash of named arrays, numbers and texts: names, types, shapes and every bit."""
    digest = hashlib.sha256(f'{_SCHEME}'.encode())
    for name, part in sorted(parts.items()):
        array = np.ascontiguousarray(part)
        digest.update(f'|{name}|{array.dtype.str}|{array.shape}|'.encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def remembered(folder: str | Path | None, key: str, shape: tuple[int, int],
               compute: Callable[[], Solution]) -> Solution:
    """
    Return frequencies (N,) and shapes (N, unknowns) from the cache, or compute and keep them.

    Parameters
    ----------
    folder : path, optional
        Of the cache; None: compute, keep nothing.
    key : str
        From `content_key`.
    shape : (2,) ints
        N and the number of unknowns.
    compute : callable
        Gives the two arrays.

    """
    if folder is None:
        return compute()
    path = Path(folder) / f'modes-{key[:32]}.npz'
    result = _read(path, key, shape)
    if result is None:
        result = compute()
        try:
            _write(path, key, result)
        except (OSError, OutputError) as error:
            warnings.warn(f'modes are not cached: {error}', RuntimeWarning, stacklevel=2)
    return result


def _read(path: Path, key: str, shape: tuple[int, int]) -> Solution | None:
    size = 8 * shape[0] * (shape[1] + 1)
    try:
        with npz_reader(path, ModelFileError, size + 10_000) as entry:
            layouts = [entry.layout(name) for name in _ARRAYS]
            if ([layout.shape for layout in layouts] != [shape[:1], shape]
                    or any(layout.dtype != np.float64 for layout in layouts)
                    or entry.layout('key').nbytes > 4 * len(key)
                    or str(entry.array('key')) != key):
                return None
            frequencies, shapes = (entry.array(name) for name in _ARRAYS)
    except Exception:  # not there, or damaged in whatever way: it is computed anew
        return None
    finite = np.isfinite(frequencies).all() and np.isfinite(shapes).all()
    return (frequencies, shapes) if finite else None


def _write(path: Path, key: str, solution: Solution) -> None:
    """Write the entry so that whoever reads at the same time sees all or nothing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with output_file(path, overwrite=True) as partial, partial.open('wb') as file:
        np.savez(file, key=np.array(key), angular_frequencies=solution[0], shapes=solution[1])
