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

"""The file of an operating map: one .npz of plain arrays and a JSON header."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from squeal_core.common.errors import TableFileError
from squeal_core.common.npz_archive import ArchiveKind, Header, read_archive, write_archive
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.operating_map import ARRAYS, OperatingMap
from squeal_core.surrogate.table_file import model_hash

FORMAT = 'squeal_ros operating map'
SCHEMA = 1
_KINDS = {name: '<f4' if name in ('score', 'growth') else '<f8' for name in ARRAYS}
KIND = ArchiveKind(
    noun='operating map', contents='map', format=FORMAT, schemas=range(SCHEMA, SCHEMA + 1),
    error=TableFileError,
    again='copy it again or build it with `squeal tabulate`',
    renew='build it again with `squeal tabulate`',
    missing=lambda _: 'build it with `squeal tabulate`')


def map_path(table: str | Path) -> Path:
    """Return where the operating map of a table file is: beside it."""
    return Path(table).with_suffix('.map')


def write_operating_map(operating_map: OperatingMap, model: BrakeModel, path: str | Path, *,
                        overwrite: bool = True) -> None:
    """
    Write the operating map of a model; an existing file is replaced only by a whole one.

    Raises
    ------
    OutputError
        Where the file cannot be written.

    """
    header: Header = {'schema': SCHEMA, 'model': model_hash(model), **operating_map.header()}
    write_archive(path, KIND, header, operating_map.arrays(), overwrite=overwrite)


def read_operating_map(path: str | Path, model: BrakeModel) -> OperatingMap | None:
    """
    Read the operating map of a model; None where there is no file.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.

    """
    if not Path(path).exists():
        return None
    header, arrays = read_archive(path, KIND, lambda _: _KINDS, _check_shapes)
    if header.get('model') != model_hash(model):
        raise TableFileError(path, 'is the operating map of another model',
                             'build one for this model with `squeal tabulate`')
    try:
        return OperatingMap.of(header, arrays)
    except ValueError as error:
        raise TableFileError(path, f'holds no usable map ({error})', KIND.again) from None


def _check_shapes(_: Any, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that do not fit each other before they are read."""
    axes = tuple(shapes[name][0] if len(shapes[name]) == 1 else -1 for name in ARRAYS[:3])
    if shapes['score'] != axes or shapes['growth'] != axes:
        raise ValueError(f'score: shape {shapes["score"]}, its axes {axes}')
