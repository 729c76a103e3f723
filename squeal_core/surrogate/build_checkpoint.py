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

"""Finished rows of boxes of an unfinished table."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.checkpoint import Checkpoint
from squeal_core.common.errors import SquealError, TableFileError
from squeal_core.common.npz_archive import ArchiveKind, Arrays, content_hash, Header
from squeal_core.common.version import __version__
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

PerAxis = tuple[int, int, int]


@dataclass(frozen=True)
class Leaf:
    """A cell by its level and place along each axis; no contents: it was given up."""

    levels: PerAxis
    place: PerAxis
    cell: TableCell | None


class BuildCheckpoint(Checkpoint[Sequence[Leaf]]):
    """The finished rows of boxes of one table, by number."""

    kind = ArchiveKind(
        noun='row of boxes of a table', contents='row',
        format='squeal_ros row of boxes of a table', schemas=range(SCHEMA, SCHEMA + 1),
        error=TableFileError, again='it is built again', renew='it is built again',
        missing=lambda _: 'it is built again')
    whole, suffix = 'table', '.boxes'
    kept = '{found} of {total} rows of boxes were kept from an earlier build'
    wanted = {'levels': '<i4', 'places': '<i4', 'given_up': '|u1', **CELL_KINDS}

    @classmethod
    def of(cls, table: Path, model: BrakeModel, domain: TableDomain, tolerances: TableTolerances,
           x: FloatArray | None = None, *, say: Callable[[str], None] = lambda _: None
           ) -> 'BuildCheckpoint':
        """Return that of a table of a model, of all of an envelope or of the boxes at places x."""
        key = content_hash(
            {'version': __version__, 'schema': SCHEMA, 'model': model_hash(model),
             'domain': asdict(domain), 'tolerances': asdict(tolerances)},
            {} if x is None else {'x': x})
        return cls(table, key, say)

    def check_shapes(self, header: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Refuse arrays that do not fit each other before they are read."""
        check_cell_shapes(shapes)
        if not shapes['levels'] == shapes['places'] == (*shapes['given_up'], 3):
            raise SquealError(f'levels: shape {shapes["levels"]}')

    def pack(self, part: Sequence[Leaf]) -> tuple[Header, Mapping[str, Any]]:
        """Return the header and the arrays that hold the leaves of a row."""
        arrays = {
            'levels': [leaf.levels for leaf in part], 'places': [leaf.place for leaf in part],
            'given_up': [leaf.cell is None for leaf in part],
            **pack_cells([leaf.cell for leaf in part if leaf.cell is not None])}
        return {}, {name: np.asarray(values, self.wanted[name])
                    for name, values in arrays.items()}

    def unpack(self, header: Header, arrays: Arrays) -> list[Leaf]:
        """Return the leaves of a row."""
        cells = iter(unpack_cells(arrays))
        return [Leaf(tuple(levels), tuple(place), None if given_up else next(cells))
                for levels, place, given_up in zip(*(
                    arrays[name].tolist() for name in ('levels', 'places', 'given_up')),
                    strict=True)]
