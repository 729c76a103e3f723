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

"""Files of sweeps: .npz, .json or .csv, plain and never a pickle."""

from array import array
from collections.abc import Mapping
import csv
import io
import json
import math
from pathlib import Path
import sys
from typing import Any

import numpy as np
from squeal_core.common.bounded_reader import read_bounded
from squeal_core.common.errors import LocatedError, short_repr, SquealError
from squeal_core.common.npz_archive import ArchiveKind, Arrays, Header, read_archive, write_archive
from squeal_core.common.npz_reader import MAX_BYTES
from squeal_core.common.output import output_file
from squeal_core.stability.parameter_paths import PARAMETERS
from squeal_core.studies.sweep_record import make_sweep, Sweep

FORMAT = 'squeal_ros sweep'
SCHEMA = 1
UNITS = {'rotor_speed': 'rad/s', 'friction': '-', 'friction_slope': 's/m',
         'contact_pressure': 'Pa', 'contact_stiffness': 'N/m^3', 'eigenvalues': '1/s',
         'frequencies_hz': 'Hz'}
_WANTED = {'points': '<f8', 'growth_rates': '<f8', 'angular_frequencies': '<f8', 'kinds': 'U',
           'identities': 'U'}
_MODES = ('identities', 'kinds', 'growth_rates', 'angular_frequencies')
MAX_TEXT_BYTES = 50_000_000  # of a .json or .csv
_COLUMNS = (*PARAMETERS, 'index', 'identity', 'kind', 'growth_rate_1_s',
            'angular_frequency_rad_s', 'frequency_hz')


class SweepFileError(LocatedError):
    """A file of a sweep that cannot be read or written."""


KIND = ArchiveKind(
    noun='sweep', contents='sweep', format=FORMAT, schemas=range(1, SCHEMA + 1),
    error=SweepFileError,
    again='copy it again or sweep again', renew='update squeal_ros or sweep again',
    missing=lambda _: 'check the path', hashed=False)
_MODE_BYTES = 100  # of one mode at one point in an archive: two numbers and two texts


def check_size(points: int, modes: int) -> None:
    """Refuse a sweep whose record could not be stored, before it is computed."""
    if points * modes * _MODE_BYTES > MAX_BYTES:
        raise SquealError(f'{points} points of {modes} modes are more than a record holds; give '
                          f'at most {MAX_BYTES // _MODE_BYTES // modes} points')


def save_sweep(record: Sweep, path: str | Path, *, overwrite: bool = True) -> None:
    """Write a record to .npz, .json or .csv, by the suffix; whole or not at all."""
    path = Path(path)
    if path.suffix not in RECORDS:
        raise SweepFileError(path, 'is of no kind that is known', 'end it in .npz, .json or .csv')
    header: Header = {'schema': SCHEMA, 'units': UNITS, 'about': record.about,
                      'axes': {name: values.tolist() for name, values in record.axes.items()}}
    arrays: Arrays = {
        'points': record.points, 'growth_rates': record.eigenvalues.real,
        'angular_frequencies': record.eigenvalues.imag, 'kinds': record.kinds,
        'identities': record.identities, 'frequencies_hz': record.frequencies_hz}
    if path.suffix == '.npz':
        write_archive(path, KIND, header, arrays, overwrite=overwrite)
        return
    with output_file(path, overwrite=overwrite) as partial:
        write = _write_json if path.suffix == '.json' else _write_csv
        write(partial, {'format': FORMAT, **header}, arrays)


def load_sweep(path: str | Path) -> Sweep:
    """
    Read a record.

    Raises
    ------
    SweepFileError
        One line: which file, what is wrong with it, and what to do.

    """
    path = Path(path)
    if path.suffix not in RECORDS:
        raise SweepFileError(path, 'is of no kind that is known', 'give a .npz, .json or .csv')
    try:
        if path.suffix == '.npz':
            header, arrays = read_archive(path, KIND, lambda _: _WANTED, _check_shapes)
        else:
            text = read_bounded(path, MAX_TEXT_BYTES, SweepFileError).decode()
            header, arrays = (_read_json if path.suffix == '.json' else _read_csv)(path, text)
        return make_sweep(axes=header['axes'], about=header['about'], **arrays)
    except SweepFileError:
        raise
    except Exception as error:  # whatever a damaged file makes json, csv or numpy say
        raise SweepFileError(
            path, f'is damaged or no sweep ({type(error).__name__}: {str(error)[:120]})',
            KIND.again) from None


def _check_shapes(header: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that are not those of a grid, before they are read."""
    count = math.prod(len(values) for values in header['axes'].values())
    modes = shapes['kinds']
    if shapes['points'] != (count, len(PARAMETERS)) or len(modes) != 2 or modes[0] != count or any(
            shapes[name] != modes for name in _MODES):
        raise SquealError(f'{count} points by the axes, arrays of shapes '
                          f'{", ".join(short_repr(shape) for shape in shapes.values())}')


def _check_header(path: Path, header: Any) -> None:
    if not isinstance(header, dict) or header.get('format') != FORMAT:
        raise ValueError('no record of a sweep')
    schema = header['schema']
    if type(schema) is not int or schema not in KIND.schemas:
        raise SweepFileError(path, f'has schema {short_repr(schema)}; this version reads up to '
                             f'{SCHEMA}', KIND.renew)


def _write_json(path: Path, header: Header, arrays: Arrays) -> None:
    plain = {name: np.asarray(np.where(values == values, values, None)).tolist()  # None for NaN
             for name, values in arrays.items()}
    path.write_text(json.dumps({**header, **plain}, allow_nan=False), encoding='utf-8')


def _read_json(path: Path, text: str) -> tuple[Header, Arrays]:
    whole = json.loads(text)
    _check_header(path, whole)
    return whole, {name: np.array(whole[name], float if kind == '<f8' else str)
                   for name, kind in _WANTED.items()}


def _write_csv(path: Path, header: Header, arrays: Arrays) -> None:
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(f'# {json.dumps(header)}\n')
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(_COLUMNS)
        for place, point in enumerate(arrays['points'].tolist()):
            columns = (arrays[name][place].tolist() for name in (*_MODES, 'frequencies_hz'))
            writer.writerows((*point, i + 1, *values)
                             for i, values in enumerate(zip(*columns, strict=True)))


def _read_csv(path: Path, text: str) -> tuple[Header, Arrays]:
    """Read line by line, so that the first bad one ends it."""
    lines = io.StringIO(text, newline='')
    header = json.loads(lines.readline().removeprefix('#'))
    _check_header(path, header)
    reader = csv.reader(lines)
    columns = tuple(next(reader))
    if columns not in (_COLUMNS, _COLUMNS[:-1]):  # earlier versions wrote no column of Hz
        raise ValueError('other columns')
    numbers, texts = array('d'), []
    for row in reader:
        if len(row) != len(columns):
            raise ValueError(f'line {reader.line_num + 1} has {len(row)} columns')
        numbers.extend(map(float, (*row[:6], *row[8:10])))
        texts.append((sys.intern(row[6]), sys.intern(row[7])))
    size = int(max(numbers[5::8]))
    table = np.frombuffer(numbers).reshape(-1, size, 8)
    identities, kinds = (np.array(column).reshape(-1, size) for column in zip(*texts, strict=True))
    return header, {
        'points': table[:, 0, :5], 'identities': identities, 'kinds': kinds,
        'growth_rates': table[:, :, 6], 'angular_frequencies': table[:, :, 7]}


RECORDS = ('.npz', '.json', '.csv')
"""Suffixes of the files that hold a record."""
