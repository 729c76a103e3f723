"""Copies tables of an HDF5 file to a .npz file; run as a process of its own.

The HDF5 library overwrites memory or runs in circles on some damaged files. Here that ends this
process, and its parent says in one line that the file is damaged.
"""

import json
import sys
from typing import Any

import numpy as np


def copy_tables(source: str, target: str, wanted: dict[str, list[str]], most_rows: int) -> None:
    """Write the fields that are wanted and there, as arrays named `table|field`.

    Raises
    ------
    ValueError
        For tables of too many rows, links to other files and fields that are no numbers.
    """
    import h5py
    arrays: dict[str, Any] = {}
    with h5py.File(source, 'r') as file:
        for name, fields in wanted.items():
            if name not in file:
                continue
            if isinstance(file.get(name, getlink=True), h5py.ExternalLink):
                raise ValueError(f'{name} is a link to another file')
            table = file[name]
            if table.size > most_rows:
                raise ValueError(f'{name} has {table.size} rows, more than {most_rows}')
            arrays[f'{name}|'] = np.zeros(0)  # it is there, whatever its fields
            for field in set(fields) & set(table.dtype.names or ()):
                arrays[f'{name}|{field}'] = _numbers(name, field, table)
    np.savez(target, **arrays)


def _numbers(name: str, field: str, table: Any) -> Any:
    values = table.fields(field)[()]
    if values.dtype.kind not in 'iuf' or values.ndim > 2:
        raise ValueError(f'{name} has {values.dtype} in field {field}')
    return values.astype(np.float64 if values.dtype.kind == 'f' else np.int64)


if __name__ == '__main__':
    try:
        copy_tables(sys.argv[1], sys.argv[2], json.loads(sys.argv[3]), int(sys.argv[4]))
    except Exception as error:
        sys.exit(f'{type(error).__name__}: {" ".join(str(error).split())[:120]}')
