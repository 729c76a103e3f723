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
The table file: one .npz of plain arrays and a JSON header, and where a model's table is kept.

A file that is truncated, altered, of another model or another version is refused in one line.
"""

from collections.abc import Mapping
from dataclasses import asdict
from functools import lru_cache
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common import resources
from squeal_core.common.arrays import readonly
from squeal_core.common.errors import short_repr, SquealError, TableFileError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    content_hash,
    Header,
    is_archive,
    read_archive,
    write_archive,
)
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS, SUPPORTS
from squeal_core.surrogate.cell_arrays import (
    CELL_KINDS,
    check_cell_shapes,
    pack_cells,
    unpack_cells,
)
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_cell import DEGREE, TableTolerances
from squeal_core.surrogate.table_domain import TableDomain

FORMAT = 'squeal_ros table of eigenvalues'
SCHEMA = 5  # 1 to 4 were of unreleased versions
_GRID_KINDS = {'grid': '<i4', 'centres': '<f8', 'halves': '<f8'}
_KINDS = {**_GRID_KINDS, **CELL_KINDS}
KIND = ArchiveKind(
    noun='table file', contents='table', format=FORMAT, schemas=range(SCHEMA, SCHEMA + 1),
    error=TableFileError,
    again='copy it again or build it with `squeal tabulate`',
    renew='build it again with: squeal tabulate MODEL -o TABLE.npz --force',
    missing=lambda _: 'give the path of a table file, or build one with `squeal tabulate`',
    earlier=('squeal_ros table of anchors',))


def write_table(table: ExpansionTable, model: BrakeModel, path: str | Path, *,
                overwrite: bool = True) -> None:
    """
    Write the table of a model; an existing file is replaced only by a whole one.

    Raises
    ------
    OutputError
        Where the file cannot be written.

    """
    arrays = {**pack_cells(table.cells), **{
        name: np.asarray(getattr(table, name), code) for name, code in _GRID_KINDS.items()}}
    header: Header = {
        'schema': SCHEMA, 'version': __version__, 'model': model_hash(model),
        'domain': asdict(table.domain), 'tolerances': asdict(table.tolerances),
        'degree': DEGREE, 'about': dict(table.about)}
    write_archive(path, KIND, header, arrays, overwrite=overwrite)


def read_table(path: str | Path, model: BrakeModel) -> ExpansionTable:
    """
    Read the table of a model.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.

    """
    return _read_table(Path(path), model.size, model_hash(model))


def _read_table(path: Path, modes: int, wanted: str) -> ExpansionTable:
    def kinds(header: Header) -> Mapping[str, str]:
        if header.get('model') != wanted:  # told before anything else is read
            raise TableFileError(path, 'is the table of another model',
                                 'build one for this model with `squeal tabulate`')
        return _KINDS

    header, arrays = read_archive(path, KIND, kinds, _check_shapes)
    try:
        return _table(header, arrays, modes)
    except (SquealError, AttributeError, LookupError, TypeError, ValueError,
            OverflowError) as error:
        raise TableFileError(path, f'holds no usable table ({str(error)[:120]})', KIND.again
                             ) from None


def read_table_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a table file, checked against its contents."""
    return read_archive(path, KIND, lambda _: _KINDS, _check_shapes)[0]


def is_table(path: str | Path) -> bool:
    """Return whether a file is a table file, by its header."""
    return is_archive(path, KIND)


def model_hash(model: BrakeModel) -> str:
    """Return the SHA-256 of all that eigenvalues at a sliding point depend on."""
    names = ('angular_frequencies', 'damping_ratios', *OPERATORS, *SUPPORTS)
    law, table = model.friction_law, model.stiffness_table
    damping = ({'contact_retardation_time': model.contact_retardation_time}
               if model.contact_retardation_time else {})
    return content_hash({
        'friction_law': asdict(law) if law else None,
        'stiffness_table': asdict(table) if table else None,
        **{name: getattr(model, name) for name in (
            'contact_area', 'contact_radius', 'nominal_contact_stiffness')}, **damping},
        {name: array for name in names if (array := getattr(model, name)) is not None})


def _check_shapes(_: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that cannot be those of so many cells, before they are read."""
    check_cell_shapes(shapes)
    if len(shapes['grid']) != 3 or not (
            shapes['centres'] == shapes['halves'] == (*shapes['blocks'], 3)):
        raise SquealError(f'grid: shape {shapes["grid"]}, centres: shape {shapes["centres"]}')


def _table(header: Mapping[str, Any], arrays: Mapping[str, Any],
           modes: int) -> ExpansionTable:
    count = len(arrays['blocks'])
    grid, halves = arrays['grid'], arrays['halves']
    if header['degree'] != DEGREE or not grid.size or not halves.min(initial=1.0) > 0.0 or not (
            grid.min() >= -1 and grid.max() < count):
        raise ValueError('the grid does not fit the cells')
    cells = unpack_cells(arrays)
    if max((cell.layout.count for cell in cells), default=0) > 2 * modes:
        raise ValueError('a cell has more eigenvalues than the model')
    return ExpansionTable(
        domain=TableDomain(**_numbers(header['domain'], TableDomain)),
        tolerances=TableTolerances(**_numbers(header['tolerances'], TableTolerances)),
        modes=modes,
        grid=readonly(grid, np.int32), centres=readonly(arrays['centres']),
        halves=readonly(halves), cells=cells, about=dict(header['about']))


def _numbers(values: Mapping[str, Any], record: type) -> dict[str, Any]:
    """Return the numbers and ranges of a record by name, from a header."""
    result: dict[str, Any] = {}
    for name in record.__annotations__:
        value = values[name]
        numbers = value if isinstance(value, list) else [value]
        if not all(type(number) in (int, float) and not math.isnan(number) for number in numbers):
            raise ValueError(f'{name} is {short_repr(value)}')
        result[name] = tuple(numbers) if isinstance(value, list) else value
    return result


def cached_path(model: BrakeModel) -> Path:
    """Return the path of a model's table in the user's cache, under the model's hash."""
    return resources.cache_folder() / f'table_{model_hash(model)[:16]}_{SCHEMA}.npz'


def find_table(model: BrakeModel) -> tuple[Path, ExpansionTable] | None:
    """Return file and table of a model from the user's cache, else the shipped one, or None."""
    wanted = model_hash(model)
    for path in (cached_path(model), *resources.table_files()):
        try:
            return path, _kept_table(path, _state(path), model.size, wanted)
        except TableFileError:  # none is there, or of another model, or of an earlier version
            continue
    return None


@lru_cache(maxsize=1)
def _kept_table(path: Path, state: tuple[int, ...], modes: int, wanted: str) -> ExpansionTable:
    """Read a table, once for all that look for it as long as the file stays as it is."""
    return _read_table(path, modes, wanted)


def _state(path: Path) -> tuple[int, ...]:
    try:
        status = path.stat()
    except (OSError, ValueError):  # the reader says it
        return ()
    return status.st_ino, status.st_size, status.st_mtime_ns
