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
Copies tables of an HDF5 file to a .npz file; run as a process of its own.

The HDF5 library overwrites memory or runs in circles on some damaged files. Here that ends this
process, and its parent says in one line that the file is damaged.
"""

import json
import resource
import sys
from typing import Any

import numpy as np


class Refused(Exception):
    """A table that is whole but is not read."""


def copy_tables(source: str, target: str, wanted: dict[str, list[str]], most_bytes: int) -> None:
    """
    Write the fields that are wanted and there, as arrays named `table|field`.

    Raises
    ------
    Refused
        For tables of too many bytes, links, data in other files and fields that are no numbers.

    """
    import h5py
    arrays: dict[str, Any] = {}
    left = most_bytes
    with h5py.File(source, 'r') as file:
        for name, fields in wanted.items():
            table = _table(file, name)
            if table is None:
                continue
            _check_size(name, table, left)
            arrays[f'{name}|'] = np.zeros(0)  # it is there, whatever its fields
            for field in sorted(set(fields) & set(table.dtype.names or ())):
                arrays[f'{name}|{field}'] = _numbers(name, field, table)
                left -= arrays[f'{name}|{field}'].nbytes
    np.savez(target, **arrays)


def _table(file: Any, name: str) -> Any:
    """
    Return a table that lies in this very file, None where there is none of this name.

    A link on the way, and a table whose data lie elsewhere, would read other files, or for ever.
    """
    import h5py
    place, path = file, ''
    for part in name.strip('/').split('/'):
        if not isinstance(place, h5py.Group):
            raise Refused(f'{path} is no group')
        path += f'/{part}'
        if not place.id.links.exists(part.encode()):
            return None
        if place.id.links.get_info(part.encode()).type != h5py.h5l.TYPE_HARD:
            raise Refused(f'{path} is a link to another place or file')
        place = place[part]
    if not isinstance(place, h5py.Dataset):
        raise Refused(f'{name} is no table')
    layout = place.id.get_create_plist()
    if layout.get_external_count() or layout.get_layout() == h5py.h5d.VIRTUAL:
        raise Refused(f'{name} has its data in other files or tables')
    return place


def _check_size(name: str, table: Any, most_bytes: int) -> None:
    """Refuse tables that would take too much memory, before anything is read."""
    if table.shape is None or table.ndim != 1:
        raise Refused(f'{name} has the shape {table.shape}, not one of rows')
    row = table.dtype.itemsize
    for count, what in ((table.shape[0], 'rows'), ((table.chunks or (0,))[0], 'rows a chunk')):
        if count * row > most_bytes:
            raise Refused(f'{name} has {count} {what} of {row} bytes, more than {most_bytes} '
                          'bytes in all')


def _numbers(name: str, field: str, table: Any) -> Any:
    kind = table.dtype[field]
    if kind.base.kind not in 'iuf' or len(kind.shape) > 1:
        raise Refused(f'{name} has {kind} in field {field}')
    values = table.fields(field)[()]
    return values.astype(np.float64 if values.dtype.kind == 'f' else np.int64)


if __name__ == '__main__':
    seconds = int(sys.argv[5])  # of processor time: a busy machine takes none of it
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    try:
        copy_tables(sys.argv[1], sys.argv[2], json.loads(sys.argv[3]), int(sys.argv[4]))
    except Refused as error:
        sys.exit(f'refused: {error}')
    except Exception as error:
        sys.exit(f'{type(error).__name__}: {" ".join(str(error).split())[:120]}')
