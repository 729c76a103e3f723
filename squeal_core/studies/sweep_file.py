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

"""The record of a sweep, and its files: .npz, .json or .csv, plain and never a pickle."""

from array import array
from collections.abc import Mapping
import csv
from dataclasses import dataclass
import io
import json
import math
from pathlib import Path
import sys
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly, repr_with_shapes
from squeal_core.common.bounded_reader import read_bounded
from squeal_core.common.errors import LocatedError, short_repr, SquealError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    Arrays,
    Header,
    MAX_BYTES,
    read_archive,
    write_archive,
)
from squeal_core.common.output import output_file
from squeal_core.stability.eigensolution import Kind, SQUEAL_BAND
from squeal_core.stability.mode_tracking import PARAMETERS

FORMAT = 'squeal_ros sweep'
SCHEMA = 1
KINDS: tuple[Kind, ...] = get_args(Kind)
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Sweep:
    """
    Modes at the points of a grid; at points not done, NaN and empty texts.

    Parameters
    ----------
    axes : dict
        Values of one or two parameters; the last one runs fastest over the points.
    points : (M, 5) array
        Operating points, columns as `tracking.PARAMETERS`.
    eigenvalues : (M, N) complex array
        In order of index: the root with Im >= 0 of each mode [1/s].
    kinds : (M, N) array of str
    identities : (M, N) array of str
        As '25' or '25/26'; in a sweep that was not tracked the index.
    about : dict
        'model', 'rotation', 'friction_law', 'tracked', 'fast', 'nominal_contact_stiffness',
        'damping_scale' where it is not 1.

    """

    axes: dict[str, FloatArray]
    points: FloatArray
    eigenvalues: ComplexArray
    kinds: NDArray[np.str_]
    identities: NDArray[np.str_]
    about: dict[str, Any]

    __repr__ = repr_with_shapes

    @property
    def done(self) -> NDArray[np.bool_]:
        """Which points were solved, (M,)."""
        return np.asarray(self.kinds[:, 0] != '')

    @property
    def complete(self) -> bool:
        return bool(self.done.all())

    @property
    def shape(self) -> tuple[int, ...]:
        return tuple(len(values) for values in self.axes.values())

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """Which modes grow, (M, N)."""
        return np.isin(self.kinds, ('flutter', 'divergence'))

    @property
    def frequencies_hz(self) -> FloatArray:
        return np.asarray(np.abs(self.eigenvalues.imag) / (2.0 * np.pi))

    def column(self, parameter: str) -> FloatArray:
        """Return a parameter at each point, (M,)."""
        return np.asarray(self.points[:, PARAMETERS.index(parameter)])

    def largest_growth(self, low_hz: float = SQUEAL_BAND[0],
                       high_hz: float = SQUEAL_BAND[1]) -> FloatArray:
        """
        Return the largest growth rate [1/s] of the oscillating modes in a band, as the grid.

        NaN where not done, -inf where no mode is in the band.
        """
        inside = np.isin(self.kinds, ('flutter', 'stable')) & (
            self.frequencies_hz >= low_hz) & (self.frequencies_hz <= high_hz)
        growth = np.where(inside, self.eigenvalues.real, -np.inf).max(axis=1)
        return np.asarray(np.where(self.done, growth, np.nan).reshape(self.shape))

    def of(self, number: int) -> ComplexArray:
        """
        Return the root (M,) of the mode that carries a number; NaN where it was not found.

        Of modes that merged each number gets one, the lowest number the least stable; see
        `merged`.
        """
        found = np.full(len(self.points), complex(np.nan, np.nan))
        for place, text in enumerate(self.names(number).tolist()):
            if text:
                same = self.eigenvalues[place, self.identities[place] == text]
                rank = min(text.split('/').index(str(number)), same.size - 1)
                found[place] = same[np.argsort(-same.real, kind='stable')[rank]]
        return found

    def names(self, number: int) -> NDArray[np.str_]:
        """Return the identity (M,) that holds a number, as '25' or '25/26'; '' where none does."""
        return np.array([next((text for text in dict.fromkeys(row) if str(number) in
                               text.split('/')), '') for row in self.identities.tolist()])

    def merged(self, number: int) -> NDArray[np.bool_]:
        """Return where (M,) a number is one of several that cannot be told apart."""
        return np.char.find(self.names(number), '/') >= 0


def make_sweep(*, axes: Mapping[str, ArrayLike], points: ArrayLike, growth_rates: ArrayLike,
               angular_frequencies: ArrayLike, kinds: ArrayLike, identities: ArrayLike,
               about: dict[str, Any]) -> Sweep:
    """Return a record of arrays that fit together; ValueError where they do not."""
    grid = {name: readonly(values) for name, values in axes.items()}
    places = readonly(points)
    growth = np.asarray(growth_rates, float)
    count = int(np.prod([values.size for values in grid.values()]))
    if not 1 <= len(grid) <= 2 or not set(grid) <= set(PARAMETERS):
        raise ValueError(f'axes are {short_repr(list(grid))}')
    roots = growth + 1j * np.asarray(angular_frequencies, float)
    texts = [readonly(values, str) for values in (kinds, identities)]
    if places.shape != (count, len(PARAMETERS)) or roots.ndim != 2 or len(roots) != count or any(
            text.shape != roots.shape for text in texts) or roots.shape[1] < 1:
        raise ValueError(f'{count} points by the axes, arrays of shapes {places.shape}, '
                         f'{roots.shape}, {texts[0].shape}, {texts[1].shape}')
    if not set(np.unique(texts[0]).tolist()) <= {*KINDS, ''}:
        raise ValueError(f'kinds are {short_repr(np.unique(texts[0]).tolist())}')
    return Sweep(axes=grid, points=places, eigenvalues=readonly(roots, complex), kinds=texts[0],
                 identities=texts[1], about=dict(about))


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
