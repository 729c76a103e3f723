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
The rows of boxes of a table that is not finished, a small file each, in a folder beside it.

A row is written as soon as it is built, so a build that was interrupted or killed goes on from
there. The folder's name holds a hash over all that cells depend on.
"""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
import glob
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError, TableFileError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    content_hash,
    Header,
    read_archive,
    write_archive,
)
from squeal_core.common.output import make_folder
from squeal_core.model.brake_model import BrakeModel
from squeal_core.surrogate.cell_arrays import (
    CELL_KINDS,
    check_cell_shapes,
    pack_cells,
    unpack_cells,
)
from squeal_core.surrogate.table_cell import TableCell, TableTolerances
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import model_hash, SCHEMA

Triple = tuple[int, int, int]

_SUFFIX = '.boxes'
_KINDS = {'levels': '<i4', 'places': '<i4', 'given_up': '|u1', **CELL_KINDS}
_KIND = ArchiveKind(
    noun='row of boxes of a table', contents='row', format='squeal_ros row of boxes of a table',
    schemas=range(SCHEMA, SCHEMA + 1), error=TableFileError, again='it is built again',
    renew='it is built again', missing=lambda _: 'it is built again')


@dataclass(frozen=True)
class Leaf:
    """A cell by its level and place along each axis; no contents: it was given up."""

    levels: Triple
    place: Triple
    cell: TableCell | None


@dataclass(frozen=True)
class BuildCheckpoint:
    """
    The finished rows of boxes of one table.

    Parameters
    ----------
    table : Path
        Where the table will be written.
    key : str
        Hash over all that the cells depend on.
    say : callable
        Told in one line what was kept, and what was damaged.

    """

    table: Path
    key: str
    say: Callable[[str], None] = field(default=lambda _: None)

    @classmethod
    def of(cls, table: Path, model: BrakeModel, domain: TableDomain, tolerances: TableTolerances,
           x: FloatArray | None = None, *, say: Callable[[str], None] = lambda _: None
           ) -> 'BuildCheckpoint':
        """Return that of a table of a model, of all of an envelope or of the boxes at places x."""
        from squeal_core import __version__  # the package itself imports all packages

        key = content_hash(
            {'version': __version__, 'schema': SCHEMA, 'model': model_hash(model),
             'domain': asdict(domain), 'tolerances': asdict(tolerances)},
            {} if x is None else {'x': x})
        return cls(table, key, say)

    @property
    def folder(self) -> Path:
        """Return the folder of the rows."""
        return self.table.with_name(f'{self.table.name}.{self.key[:12]}{_SUFFIX}')

    @property
    def count(self) -> int:
        """Return the number of rows that are kept."""
        return sum(1 for _ in self.folder.glob('*.npz'))

    def read(self, rows: int) -> dict[int, list[Leaf]]:
        """Return the leaves of the finished rows, of so many in all, by row."""
        found = {}
        for row in range(rows):
            if self._path(row).exists():
                try:
                    found[row] = self._row(row)
                except TableFileError as error:
                    self.say(str(error))
        if found:
            self.say(f'{len(found)} of {rows} rows of boxes were kept from an earlier build')
        return found

    def keep(self, row: int, leaves: Sequence[Leaf]) -> None:
        """
        Write a finished row.

        Raises
        ------
        OutputError
            Where it cannot be written.

        """
        make_folder(self.folder)
        header: Header = {'schema': SCHEMA, 'key': self.key, 'row': row}
        arrays = {
            'levels': [leaf.levels for leaf in leaves], 'places': [leaf.place for leaf in leaves],
            'given_up': [leaf.cell is None for leaf in leaves],
            **pack_cells([leaf.cell for leaf in leaves if leaf.cell is not None])}
        write_archive(self._path(row), _KIND, header, {
            name: np.asarray(values, _KINDS[name]) for name, values in arrays.items()})

    def remove(self) -> None:
        """Remove the rows, and what builds with other settings left for the same table."""
        pattern = f'{glob.escape(self.table.name)}.*{_SUFFIX}'
        for folder in self.table.parent.glob(pattern):
            with suppress(OSError):
                for path in folder.glob('*.npz*'):
                    path.unlink()
                folder.rmdir()

    def _path(self, row: int) -> Path:
        return self.folder / f'{row}.npz'

    def _row(self, row: int) -> list[Leaf]:
        path = self._path(row)
        header, arrays = read_archive(path, _KIND, lambda _: _KINDS, _check_shapes)
        if (header.get('key'), header.get('row')) != (self.key, row):
            raise TableFileError(path, 'is a row of another table', 'it is built again')
        try:
            cells = iter(unpack_cells(arrays))
            return [Leaf(tuple(levels), tuple(place), None if given_up else next(cells))
                    for levels, place, given_up in zip(*(
                        arrays[name].tolist() for name in ('levels', 'places', 'given_up')),
                        strict=True)]
        except (ValueError, StopIteration) as error:
            raise TableFileError(path, f'holds no usable row ({error})', 'it is built again'
                                 ) from None


def _check_shapes(_: Any, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that do not fit each other before they are read."""
    check_cell_shapes(shapes)
    if not shapes['levels'] == shapes['places'] == (*shapes['given_up'], 3):
        raise SquealError(f'levels: shape {shapes["levels"]}')
