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
The table file: anchors laid down beforehand, as a .npz of plain arrays and a JSON header.

Only what an anchor cannot find again is in it: norms and places of terms are computed on reading.
Terms that were computed in single precision are kept in it. What is read is bit for bit what was
written. A file that is truncated, altered or of another model is refused in one line.
"""

from collections.abc import Iterator, Mapping, Sequence
import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.brake.operating_point import Coefficients, OperatingPoint
from squeal_core.common.arrays import readonly
from squeal_core.common.errors import short_repr, SquealError, TableFileError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    Arrays,
    content_hash,
    Header,
    read_archive,
    write_archive,
)
from squeal_core.model.brake_model import BrakeModel, OPERATORS, SUPPORTS
from squeal_core.surrogate.block_layout import BlockLayout
from squeal_core.surrogate.coupling_floor import CouplingFloor, LONGEST
from squeal_core.surrogate.monomials import Monomials
from squeal_core.surrogate.pair_remainder import PairRemainder
from squeal_core.surrogate.spectral_expansion import SpectralExpansion

FORMAT = 'squeal_ros table of anchors'
SCHEMA = 3  # 1 and 2, of unreleased versions, had no floor
MAX_ANCHORS = 100_000

_FINE = 2  # degree from which on terms may be of single precision
_POINT = tuple(item.name for item in dataclasses.fields(OperatingPoint))
_KINDS = {  # of each array: all anchors' values one after the other
    'points': '<f8', 'scales': '<f8', 'blocks': '<i4', 'sizes': '<i4', 'first_terms': '<f8',
    'terms': '<f4', 'fine_terms': '<f8', 'nearness': '<f4', 'rounding': '<f8', 'mirrored': '|u1',
    'pairs': '<i4', 'rates': '<f4', 'weights': '<f4', 'order': '<i4', 'owners': '<i4',
    'floor_weights': '<f4', 'floor': '<f4'}
KIND = ArchiveKind(
    noun='table file', contents='anchors', format=FORMAT, schemas=range(SCHEMA, SCHEMA + 1),
    error=TableFileError,
    again='copy it again or lay it down with `squeal tabulate`',
    renew='update squeal_ros or lay the table down again',
    missing=lambda _: 'give the path of a table file, or lay one down with `squeal tabulate`')


def write_table(anchors: Sequence[SpectralExpansion], model: BrakeModel, path: str | Path, *,
                about: Mapping[str, Any] | None = None, overwrite: bool = True) -> None:
    """
    Write anchors of a model; an existing file is replaced only by a whole one.

    Parameters
    ----------
    anchors : sequence of SpectralExpansion
        All of one degree.
    model : BrakeModel
        Modal brake model.
    path : str or Path
        Where the file is.
    about : mapping, optional
        How they were laid down: texts and numbers, for the header.
    overwrite : bool
        Whether an existing file may be replaced.

    Raises
    ------
    TableFileError
        For no anchors, too many, or of several degrees.
    OutputError
        Where the file cannot be written.

    """
    degrees = {anchor.monomials.degree for anchor in anchors}
    if len(degrees) != 1 or len(anchors) > MAX_ANCHORS:
        raise TableFileError(path, f'cannot hold {len(anchors)} anchors of {len(degrees)} degrees',
                             f'give 1 to {MAX_ANCHORS} of one degree')
    header: Header = {'schema': SCHEMA, 'model': model_hash(model),
                      'rows': anchors[0].rows.tolist(), 'degree': degrees.pop(),
                      'anchors': len(anchors), 'about': dict(about or {})}
    write_archive(path, KIND, header, _packed(anchors), overwrite=overwrite)


def read_table(path: str | Path, model: BrakeModel) -> tuple[SpectralExpansion, ...]:
    """
    Read the anchors of a model.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.

    """
    header, arrays = _read(path)
    if header.get('model') != model_hash(model):
        raise TableFileError(path, 'is the table of another model', 'lay one down for this model '
                             'with `squeal tabulate`')
    try:
        return tuple(_unpacked(header, arrays, model))
    except (SquealError, KeyError, IndexError, TypeError, ValueError, OverflowError) as error:
        raise TableFileError(path, f'holds no usable anchors ({short_repr(str(error))})',
                             KIND.again) from None


def read_table_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a table file, checked against its contents."""
    return _read(path)[0]


def model_hash(model: BrakeModel) -> str:
    """Return SHA-256 over the arrays that the roots of a model depend on."""
    names = ('angular_frequencies', 'damping_ratios', *OPERATORS, *SUPPORTS)
    return content_hash({}, {name: array for name in names
                             if (array := getattr(model, name)) is not None})


def _packed(anchors: Sequence[SpectralExpansion]) -> dict[str, Any]:
    """Return the arrays of a file."""
    columns: dict[str, list[Any]] = {name: [] for name in _KINDS}
    for anchor in anchors:
        first = sum(len(terms) for terms in anchor.monomials.terms[:_FINE])
        series = anchor.series.view(float)
        high, met = series[first:], anchor.pair_remainder
        coarse = bool(np.all(high == high.astype(np.float32)))
        values = {
            'points': [getattr(anchor.point, name) for name in _POINT], 'scales': anchor.scales,
            'blocks': [anchor.sizes.size], 'sizes': anchor.sizes,
            'first_terms': series[:first], 'terms': high if coarse else [],
            'fine_terms': [] if coarse else high, 'nearness': anchor.coupling_ratio,
            'rounding': anchor.rounding, 'mirrored': anchor.mirrored,
            'pairs': [met.weights.size, met.order.size, int(coarse)],
            'rates': np.stack([met.rates.real, met.rates.imag]), 'weights': met.weights,
            'order': met.order, 'owners': met.owners, 'floor_weights': anchor.floor.weights,
            'floor': anchor.floor.sizes}
        for name, value in values.items():
            columns[name].append(np.ravel(value))
    return {name: np.concatenate(parts).astype(_KINDS[name]) for name, parts in columns.items()}


def _read(path: str | Path) -> tuple[Header, Arrays]:
    return read_archive(path, KIND, lambda _: _KINDS, _check_shapes)


def _check_shapes(header: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that cannot be those of so many anchors, before they are read."""
    for name, shape in shapes.items():
        if len(shape) != 1:
            raise SquealError(f'{name}: shape {short_repr(shape)}')
    count = header.get('anchors')
    if type(count) is int and shapes['points'] != (len(_POINT) * count,):
        raise SquealError(
            f'points: shape {short_repr(shapes["points"])} of {short_repr(count)} anchors')


class _Reader:
    """Takes values from the arrays one after the other."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = arrays
        self._places = dict.fromkeys(arrays, 0)

    def take(self, name: str, *shape: int) -> Any:
        """Return the next values of an array in a shape."""
        start, count = self._places[name], math.prod(shape)
        values = self._arrays[name][start:start + count]
        if min(shape) < 0 or values.size != count or not np.all(np.isfinite(values)):
            raise ValueError(f'{name} has no {count} numbers from {start} on')
        self._places[name] = start + count
        return values.reshape(shape)

    def finish(self) -> None:
        for name, array in self._arrays.items():
            if self._places[name] != array.size:
                raise ValueError(f'{name} has {array.size} numbers, {self._places[name]} are used')


def _unpacked(header: Mapping[str, Any], arrays: Mapping[str, Any],
              model: BrakeModel) -> Iterator[SpectralExpansion]:
    rows, degree, count = header['rows'], header['degree'], header['anchors']
    # what the model leaves out is not in the table either
    if rows != [i for i, name in enumerate(Coefficients._fields)
                if (array := getattr(model, name)) is not None and np.any(array)]:
        raise ValueError(f'rows are {short_repr(rows)}')
    if type(degree) is not int or not 3 <= degree <= 8 or type(count) is not int or not (
            1 <= count <= MAX_ANCHORS):
        raise ValueError(f'degree {short_repr(degree)} of {short_repr(count)} anchors')
    monomials = Monomials(len(rows), degree)
    roots = 2 * model.size - int(np.count_nonzero(model.free_coordinates))
    reader = _Reader(arrays)
    for _ in range(count):
        yield _anchor(reader, readonly(rows, np.intp), monomials, roots)
    reader.finish()


def _anchor(reader: _Reader, rows: Any, monomials: Monomials, roots: int) -> SpectralExpansion:
    point = OperatingPoint(**dict(zip(_POINT, reader.take('points', len(_POINT)).tolist(),
                                      strict=True)))
    blocks = int(reader.take('blocks', 1)[0])
    sizes = readonly(reader.take('sizes', blocks), np.intp)
    mirrored = readonly(reader.take('mirrored', int(sizes.sum())), bool)
    if sizes.min() < 1 or np.any(np.diff(sizes) < 0) or sizes.sum() + mirrored.sum() != roots:
        raise ValueError(f'{int(sizes.sum())} roots in {blocks} blocks')
    scales = readonly(reader.take('scales', rows.size))
    if np.any(scales <= 0.0):
        raise ValueError('a scale is not positive')
    pairs, listed, coarse = reader.take('pairs', 3).tolist()
    entries = int((sizes**2).sum())
    first = sum(len(terms) for terms in monomials.terms[:_FINE])
    series = readonly(np.concatenate([
        reader.take('first_terms', first, 2 * entries),
        reader.take('terms' if coarse else 'fine_terms', monomials.count - first, 2 * entries)]))
    series = series.view(complex)
    ends = np.cumsum([len(terms) for terms in monomials.terms])
    norms = BlockLayout(sizes).norms
    return SpectralExpansion(
        point=point, rows=rows, centre=readonly(np.array(point.coefficients())[rows]),
        scales=scales, monomials=monomials, sizes=sizes, series=series,
        term_norms=tuple(readonly(norms(series[a:b]).T)
                         for a, b in zip(ends[-4:-1], ends[-3:], strict=True)),
        coupling_ratio=readonly(reader.take('nearness', blocks, len(monomials.terms[2]))),
        pair_remainder=_encounters(reader, pairs, listed, rows.size, blocks, monomials.degree),
        floor=_floor(reader, rows.size, blocks, monomials.degree),
        rounding=readonly(reader.take('rounding', blocks)), mirrored=mirrored)


def _floor(reader: _Reader, variables: int, blocks: int, degree: int) -> CouplingFloor:
    weights = readonly(reader.take('floor_weights', variables))
    sizes = readonly(reader.take('floor', variables + 1, LONGEST - degree, blocks))
    if weights.min(initial=0.0) < 0.0 or sizes.min(initial=0.0) < 0.0:
        raise ValueError('a floor is negative')
    return CouplingFloor(weights, sizes, degree)


def _encounters(reader: _Reader, pairs: int, listed: int, variables: int, blocks: int,
                degree: int) -> PairRemainder:
    real, imaginary = reader.take('rates', 2, variables, 3, pairs).astype(float)
    order, owners = (reader.take(name, listed) for name in ('order', 'owners'))
    inside = [np.all((values >= 0) & (values < most)) for values, most in (
        (order, pairs), (owners, blocks))]
    if not all(inside) or np.any(np.diff(owners) < 0):
        raise ValueError('a pair is of no block')
    return PairRemainder(readonly(real + 1j * imaginary, complex),
                         readonly(reader.take('weights', pairs)), readonly(order, np.intp),
                         readonly(owners, np.intp), blocks, degree)
