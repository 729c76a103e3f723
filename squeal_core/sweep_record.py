"""The record of a sweep, and its files: .npz, .json or .csv, plain and never a pickle."""

from collections.abc import Mapping
import csv
from dataclasses import dataclass
import json
import os
from pathlib import Path
from typing import Any, get_args
import zipfile

import numpy as np
from numpy.typing import ArrayLike, NDArray

from squeal_core.arrays import ComplexArray, FloatArray, readonly, short_repr
from squeal_core.errors import PlacedError, quoted
from squeal_core.stability import Kind
from squeal_core.tracking import PARAMETERS

FORMAT = 'squeal_ros sweep'
SCHEMA = 1
KINDS: tuple[Kind, ...] = get_args(Kind)
UNITS = {'rotor_speed': 'rad/s', 'friction': '-', 'friction_slope': 's/m',
         'contact_pressure': 'Pa', 'contact_stiffness': 'N/m^3', 'eigenvalues': '1/s',
         'frequencies_hz': 'Hz'}
_ARRAYS = {'points': 'f', 'growth_rates': 'f', 'angular_frequencies': 'f', 'kinds': 'U',
           'identities': 'U'}
_COLUMNS = (*PARAMETERS, 'index', 'identity', 'kind', 'growth_rate_1_s',
            'angular_frequency_rad_s', 'frequency_hz')


class SweepFileError(PlacedError):
    """A file of a sweep that cannot be read or written."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Sweep:
    """Modes at the points of a grid; at points not done, NaN and empty texts.

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
        'model', 'rotation', 'friction_law', 'tracked', 'fast', 'nominal_contact_stiffness'.
    """

    axes: dict[str, FloatArray]
    points: FloatArray
    eigenvalues: ComplexArray
    kinds: NDArray[np.str_]
    identities: NDArray[np.str_]
    about: dict[str, Any]

    __repr__ = short_repr

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

    def largest_growth(self, low_hz: float = 1250.0, high_hz: float = 16000.0) -> FloatArray:
        """Return the largest growth rate [1/s] of the oscillating modes in a band, as the grid.

        NaN where not done, -inf where no mode is in the band.
        """
        inside = np.isin(self.kinds, ('flutter', 'stable')) & (
            self.frequencies_hz >= low_hz) & (self.frequencies_hz <= high_hz)
        growth = np.where(inside, self.eigenvalues.real, -np.inf).max(axis=1)
        return np.asarray(np.where(self.done, growth, np.nan).reshape(self.shape))

    def of(self, number: int) -> ComplexArray:
        """Return the root (M,) of the mode that carries a number; NaN where it was not found.

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
        raise ValueError(f'axes are {quoted(list(grid))}')
    roots = growth + 1j * np.asarray(angular_frequencies, float)
    texts = [readonly(values, str) for values in (kinds, identities)]
    if places.shape != (count, len(PARAMETERS)) or roots.ndim != 2 or len(roots) != count or any(
            text.shape != roots.shape for text in texts) or roots.shape[1] < 1:
        raise ValueError(f'{count} points by the axes, arrays of shapes {places.shape}, '
                         f'{roots.shape}, {texts[0].shape}, {texts[1].shape}')
    if not set(np.unique(texts[0]).tolist()) <= {*KINDS, ''}:
        raise ValueError(f'kinds are {quoted(np.unique(texts[0]).tolist())}')
    return Sweep(axes=grid, points=places, eigenvalues=readonly(roots, complex), kinds=texts[0],
                 identities=texts[1], about=dict(about))


def save_sweep(record: Sweep, path: str | Path) -> None:
    """Write a record to .npz, .json or .csv, by the suffix; whole or not at all."""
    path = Path(path)
    if path.suffix not in _FORMATS:
        raise SweepFileError(path, 'is of no kind that is known', 'end it in .npz, .json or .csv')
    partial = path.with_name(f'{path.name}.{os.getpid()}.part')
    header = {'format': FORMAT, 'schema': SCHEMA, 'units': UNITS, 'about': record.about,
              'axes': {name: values.tolist() for name, values in record.axes.items()}}
    try:
        _FORMATS[path.suffix][0](partial, header, {
            'points': record.points, 'growth_rates': record.eigenvalues.real,
            'angular_frequencies': record.eigenvalues.imag, 'kinds': record.kinds,
            'identities': record.identities, 'frequencies_hz': record.frequencies_hz})
        partial.replace(path)
    except OSError as error:
        raise SweepFileError(path, f'cannot be written ({error.strerror})',
                             'check folder and rights') from None
    finally:
        partial.unlink(missing_ok=True)


def load_sweep(path: str | Path) -> Sweep:
    """Read a record.

    Raises
    ------
    SweepFileError
        One line: which file, what is wrong with it, and what to do.
    """
    path = Path(path)
    if path.suffix not in _FORMATS:
        raise SweepFileError(path, 'is of no kind that is known', 'give a .npz, .json or .csv')
    try:
        header, arrays = _FORMATS[path.suffix][1](path)
        if header.get('format') != FORMAT:
            raise ValueError('no record of a sweep')
        schema = header['schema']
        if type(schema) is not int or not 1 <= schema <= SCHEMA:
            raise SweepFileError(
                path, f'has schema {quoted(schema)}; this version reads up to {SCHEMA}',
                'update squeal_ros or sweep again')
        return make_sweep(axes=header['axes'], about=header['about'], **arrays)
    except OSError as error:
        raise SweepFileError(path, f'cannot be read ({error.strerror})',
                             'check path and rights') from None
    except SweepFileError:
        raise
    except Exception as error:  # whatever a damaged file makes zipfile, json or csv say
        raise SweepFileError(
            path, f'is damaged or no sweep ({type(error).__name__}: {str(error)[:120]})',
            'copy it again or sweep again') from None


def _write_npz(path: Path, header: dict[str, Any], arrays: dict[str, Any]) -> None:
    with path.open('wb') as file:
        np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)


def _read_npz(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    if not zipfile.is_zipfile(path):
        path.open('rb').close()  # says why, where it is not there
        raise ValueError('no archive')
    with np.load(path, allow_pickle=False) as archive:
        arrays = {name: archive[name] for name in _ARRAYS}
        if any(arrays[name].dtype.kind != kind for name, kind in _ARRAYS.items()):
            raise ValueError('arrays of other types')
        return json.loads(str(archive['header'])), arrays


def _write_json(path: Path, header: dict[str, Any], arrays: dict[str, Any]) -> None:
    plain = {name: np.asarray(np.where(values == values, values, None)).tolist()  # None for NaN
             for name, values in arrays.items()}
    path.write_text(json.dumps({**header, **plain}, allow_nan=False), encoding='utf-8')


def _read_json(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    whole = json.loads(path.read_text(encoding='utf-8'))
    return whole, {name: np.array(whole[name], float if kind == 'f' else str)
                   for name, kind in _ARRAYS.items()}


def _write_csv(path: Path, header: dict[str, Any], arrays: dict[str, Any]) -> None:
    with path.open('w', encoding='utf-8', newline='') as file:
        file.write(f'# {json.dumps(header)}\n')
        writer = csv.writer(file, lineterminator='\n')
        writer.writerow(_COLUMNS)
        modes = ('identities', 'kinds', 'growth_rates', 'angular_frequencies', 'frequencies_hz')
        for place, point in enumerate(arrays['points'].tolist()):
            columns = (arrays[name][place].tolist() for name in modes)
            writer.writerows((*point, i + 1, *values)
                             for i, values in enumerate(zip(*columns, strict=True)))


def _read_csv(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    with path.open(encoding='utf-8', newline='') as file:
        header = json.loads(file.readline().removeprefix('#'))
        reader = csv.reader(file)
        columns = tuple(next(reader))
        if columns not in (_COLUMNS, _COLUMNS[:-1]):  # earlier versions wrote no column of Hz
            raise ValueError('other columns')
        rows = list(reader)
    size = max(int(row[5]) for row in rows)
    table = np.array(rows).reshape(-1, size, len(columns))
    return header, {
        'points': table[:, 0, :5].astype(float), 'identities': table[:, :, 6],
        'kinds': table[:, :, 7], 'growth_rates': table[:, :, 8].astype(float),
        'angular_frequencies': table[:, :, 9].astype(float)}


_FORMATS = {'.npz': (_write_npz, _read_npz), '.json': (_write_json, _read_json),
            '.csv': (_write_csv, _read_csv)}
RECORDS = tuple(_FORMATS)
"""Suffixes of the files that hold a record."""
