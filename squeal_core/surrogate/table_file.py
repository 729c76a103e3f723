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
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common import resources
from squeal_core.common.arrays import readonly
from squeal_core.common.errors import SquealError, TableFileError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    Arrays,
    content_hash,
    Header,
    is_archive,
    read_archive,
    write_archive,
)
from squeal_core.model.brake_model import BrakeModel, OPERATORS, SUPPORTS
from squeal_core.surrogate.expansion_table import ExpansionTable
from squeal_core.surrogate.table_cell import DEGREE, fit_terms, TableCell, TableTolerances
from squeal_core.surrogate.table_domain import TableDomain

FORMAT = 'squeal_ros table of eigenvalues'
SCHEMA = 4  # 1 to 3 were tables of series, of unreleased versions
MAX_CELLS = 100_000
_OMITTED_DEGREE = 2
_KINDS = {
    'grid': '<i4', 'centres': '<f8', 'halves': '<f8', 'blocks': '<i4', 'sizes': '|u1',
    'series': '<f4', 'bounds': '<f4', 'mirrored': '|u1', 'omitted_modes': '<i4',
    'omitted': '<f4', 'omitted_below': '<f4'}
KIND = ArchiveKind(
    noun='table file', contents='table', format=FORMAT, schemas=range(SCHEMA, SCHEMA + 1),
    error=TableFileError,
    again='copy it again or build it with `squeal tabulate`',
    renew='build the table again with `squeal tabulate`',
    missing=lambda _: 'give the path of a table file, or build one with `squeal tabulate`')


def write_table(table: ExpansionTable, model: BrakeModel, path: str | Path, *,
                overwrite: bool = True) -> None:
    """
    Write the table of a model; an existing file is replaced only by a whole one.

    Raises
    ------
    OutputError
        Where the file cannot be written.

    """
    from squeal_core import __version__  # the package itself imports all packages

    cells = table.cells
    arrays = {
        'grid': table.grid, 'centres': table.centres, 'halves': table.halves,
        'blocks': [cell.sizes.size for cell in cells],
        'sizes': _joined(cell.sizes for cell in cells),
        'series': _joined(cell.series for cell in cells),
        'bounds': _joined(cell.bounds for cell in cells),
        'mirrored': _joined(cell.mirrored for cell in cells),
        'omitted_modes': [cell.omitted.shape[1] for cell in cells],
        'omitted': _joined(cell.omitted for cell in cells),
        'omitted_below': [cell.omitted_below for cell in cells]}
    header: Header = {
        'schema': SCHEMA, 'version': __version__, 'model': model_hash(model),
        'domain': asdict(table.domain), 'tolerances': asdict(table.tolerances),
        'degree': DEGREE, 'about': dict(table.about)}
    write_archive(path, KIND, header, {
        name: np.asarray(values, _KINDS[name]) for name, values in arrays.items()},
        overwrite=overwrite)


def _joined(parts: Any) -> Any:
    return np.concatenate([np.zeros(0), *(np.ravel(part) for part in parts)])


def read_table(path: str | Path, model: BrakeModel) -> ExpansionTable:
    """
    Read the table of a model.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.

    """
    header, arrays = _read(path)
    if header.get('model') != model_hash(model):
        raise TableFileError(path, 'is the table of another model',
                             'build one for this model with `squeal tabulate`')
    try:
        return _table(header, arrays, model)
    except (SquealError, AttributeError, LookupError, TypeError, ValueError,
            OverflowError) as error:
        raise TableFileError(path, f'holds no usable table ({str(error)[:120]})', KIND.again
                             ) from None


def read_table_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a table file, checked against its contents."""
    return _read(path)[0]


def is_table(path: str | Path) -> bool:
    """Tell whether a file is a table file, by its header."""
    return is_archive(path, KIND)


def model_hash(model: BrakeModel) -> str:
    """Return SHA-256 over what the eigenvalues at a sliding point depend on."""
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


def _read(path: str | Path) -> tuple[Header, Arrays]:
    return read_archive(path, KIND, lambda _: _KINDS, _check_shapes)


def _check_shapes(_: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that cannot be those of so many cells, before they are read."""
    cells = shapes['blocks'][:1]
    want = {'grid': 3, 'centres': 2, 'halves': 2}
    for name, shape in shapes.items():
        if len(shape) != want.get(name, 1):
            raise SquealError(f'{name}: shape {shape}')
    if not cells or cells[0] > MAX_CELLS or not (
            shapes['omitted_modes'] == shapes['omitted_below'] == cells
            and shapes['centres'] == shapes['halves'] == (*cells, 3)):
        raise SquealError(f'blocks: shape {shapes["blocks"]}')


def _table(header: Mapping[str, Any], arrays: Mapping[str, Any],
           model: BrakeModel) -> ExpansionTable:
    count = len(arrays['blocks'])
    grid, halves = arrays['grid'], arrays['halves']
    if header['degree'] != DEGREE or not grid.size or not halves.min(initial=1.0) > 0.0 or not (
            grid.min() >= -1 and grid.max() < count):
        raise ValueError('the grid does not fit the cells')
    reader = _Reader(arrays)
    cells = [reader.cell(place) for place in range(count)]
    reader.finish()
    tolerances = dict(header['tolerances'])
    tolerances['band'] = tuple(tolerances['band'])
    domain: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in header['domain'].items()}
    return ExpansionTable(
        domain=TableDomain(**domain), tolerances=TableTolerances(**tolerances), modes=model.size,
        grid=readonly(grid, np.int32), centres=readonly(arrays['centres']),
        halves=readonly(halves), cells=tuple(cells), about=dict(header['about']))


class _Reader:
    """Takes the values of cells from the arrays, one after the other."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = arrays
        self._places = dict.fromkeys(('sizes', 'series', 'bounds', 'mirrored', 'omitted'), 0)

    def cell(self, place: int) -> TableCell:
        """Return the next cell, checked."""
        sizes = readonly(self._take('sizes', int(self._arrays['blocks'][place])), np.intp)
        if sizes.size and (sizes.min() < 1 or np.any(np.diff(sizes) < 0)):
            raise ValueError('sizes of blocks do not rise')
        count, omitted = int(sizes.sum()), int(self._arrays['omitted_modes'][place])
        return TableCell(
            sizes, self._floats('series', fit_terms(DEGREE).count, 2 * count),
            self._floats('bounds', count), readonly(self._take('mirrored', count), bool),
            self._floats('omitted', fit_terms(_OMITTED_DEGREE).count, omitted),
            float(self._arrays['omitted_below'][place]))

    def _floats(self, name: str, *shape: int) -> Any:
        return readonly(self._take(name, int(np.prod(shape))).reshape(shape))

    def _take(self, name: str, count: int) -> Any:
        start = self._places[name]
        values = self._arrays[name][start:start + count]
        if count < 0 or values.size != count or not np.all(np.isfinite(values)):
            raise ValueError(f'{name} has no {count} numbers from {start} on')
        self._places[name] = start + count
        return values

    def finish(self) -> None:
        """Refuse numbers that no cell uses."""
        for name, used in self._places.items():
            if used != self._arrays[name].size:
                raise ValueError(f'{name} has {self._arrays[name].size} numbers, {used} are used')


def cached_path(model: BrakeModel) -> Path:
    """Return where the user's cache has the table of a model, under the model's hash."""
    return resources.cache_folder() / f'table_{model_hash(model)[:16]}_{SCHEMA}.npz'


def find_table_file(model: BrakeModel) -> Path | None:
    """Return the table file of a model that is shipped or in the user's cache, or None."""
    wanted = model_hash(model)
    for path in (*_shipped(), cached_path(model)):
        try:
            if read_table_header(path).get('model') == wanted:
                return path
        except TableFileError:  # none is there, or one of an earlier version
            continue
    return None


def _shipped() -> list[Path]:
    return [resources.find('tables', name, '.npz') for name in resources.names('tables', '.npz')]
