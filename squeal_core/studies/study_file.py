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

"""Files of studies: .npz, which is read again, and .csv and .json for other programs."""

from collections.abc import Iterator
import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common.arrays import readonly
from squeal_core.common.errors import LocatedError, short_repr, SquealError
from squeal_core.common.json_values import plain
from squeal_core.common.npz_archive import ArchiveKind, Header, read_archive, write_archive
from squeal_core.common.output import output_file
from squeal_core.studies.study_record import SOURCES, Study

FORMAT = 'squeal_ros study'
SCHEMA = 1
RECORDS = ('.npz', '.json', '.csv')
"""Suffixes of the files that hold a study."""
_ROWS = 10_000  # written at a time
_WHOLE = ('mode', 'squeal_modes', 'flutter_modes', 'divergent_modes', 'merged_with')


class StudyFileError(LocatedError):
    """A file of a study that cannot be read or written."""


KIND = ArchiveKind(
    noun='study', contents='study', format=FORMAT, schemas=range(1, SCHEMA + 1),
    error=StudyFileError, again='copy it again or compute it again',
    renew='update squeal_ros or compute it again', missing=lambda _: 'check the path')


def save_study(study: Study, path: str | Path, *, overwrite: bool = True) -> None:
    """Write a study to .npz, .json or .csv, by the suffix; whole or not at all."""
    path = Path(path)
    if path.suffix not in RECORDS:
        raise StudyFileError(path, 'is of no kind that is known', 'end it in .npz, .json or .csv')
    header: Header = {'schema': SCHEMA, 'about': plain(study.about),
                      'axes': {name: values.tolist() for name, values in study.axes.items()},
                      'columns': list(study.columns)}
    if path.suffix == '.npz':
        write_archive(path, KIND, header, {'values': np.array(list(study.columns.values()))},
                      overwrite=overwrite)
        return
    with output_file(path, overwrite=overwrite) as partial:
        if path.suffix == '.json':
            rows = {'format': FORMAT, **header, 'points': list(rows_of(study))}
            partial.write_text(json.dumps(plain(rows), allow_nan=False), encoding='utf-8')
        else:
            _write_csv(study, {'format': FORMAT, **header}, partial)


def load_study(path: str | Path) -> Study:
    """
    Read a study from .npz.

    Raises
    ------
    StudyFileError
        One line: which file, what is wrong with it, and what to do.

    """
    header, arrays = read_archive(path, KIND, lambda _: {'values': '<f8'}, _check_shapes)
    try:
        return Study(
            axes={name: readonly(values) for name, values in header['axes'].items()},
            columns=dict(zip(header['columns'], map(readonly, arrays['values']), strict=True)),
            about=header['about'])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise StudyFileError(Path(path), f'holds no usable study ({error})', KIND.again) from None


def _check_shapes(header: Header, shapes: Any) -> None:
    try:
        count = int(np.prod([len(values) for values in header['axes'].values()]))
        wanted = len(header['columns']), count
        known = 'source' in header['columns']
    except (KeyError, TypeError, AttributeError):
        raise SquealError('it has no axes') from None
    if shapes['values'] != wanted or not known:
        raise SquealError(f'{count} points by the axes, array of shape '
                          f'{short_repr(shapes["values"])}')


def row_names(study: Study) -> list[str]:
    """Return the names in a row: of parameters, `brake.` before that of a figure, and figures."""
    return [*(f'brake.{name}' if name in study.columns else name for name in study.axes),
            *study.columns]


def rows_of(study: Study) -> Iterator[dict[str, Any]]:
    """Yield the points one by one: parameters and figures by name, None where there is none."""
    columns = dict(zip(row_names(study), [*study.places().values(), *study.columns.values()],
                       strict=True))
    whole = [name for name in study.columns if name.startswith(_WHOLE)]
    for start in range(0, study.size, _ROWS):
        part = {name: values[start:start + _ROWS].tolist() for name, values in columns.items()}
        for values in zip(*part.values(), strict=True):
            row: dict[str, Any] = {name: None if value != value else value
                                   for name, value in zip(part, values, strict=True)}
            row.update((name, int(row[name])) for name in whole if row[name] is not None)
            yield {**row, 'source': SOURCES[row['source']]}


def _write_csv(study: Study, header: Header, path: Path) -> None:
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(f'# {json.dumps(header)}\n')
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(row_names(study))
        writer.writerows(row.values() for row in rows_of(study))
