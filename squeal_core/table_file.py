"""The table file: anchors laid down beforehand, as a .npz of plain arrays and a JSON header.

Only what an anchor cannot find again is in it: norms and places of terms are computed on reading.
Terms that were computed in single precision are kept in it. What is read is bit for bit what was
written. A file that is truncated, altered or of another model is refused in one line.
"""

from collections.abc import Iterator, Mapping, Sequence
import dataclasses
import json
import math
import os
from pathlib import Path
from typing import Any
import zipfile

import numpy as np

from squeal_core.anchor import Anchor
from squeal_core.arrays import readonly
from squeal_core.block_series import BlockLayout
from squeal_core.brake_model import BrakeModel, OPERATORS, SUPPORTS
from squeal_core.encounters import Encounters
from squeal_core.errors import quoted, SquealError, TableFileError
from squeal_core.model_file import content_hash
from squeal_core.monomials import Monomials
from squeal_core.operating_point import Coefficients, OperatingPoint

FORMAT = 'squeal_ros table of anchors'
SCHEMA = 2  # 1, of unreleased versions, had the entries of pairs as they are
MAX_ANCHORS = 100_000
MAX_BYTES = 1_000_000_000  # of one array

_LAY_AGAIN = 'copy it again or lay it down with `squeal tabulate`'
_FINE = 2  # degree from which on terms may be of single precision
_POINT = tuple(item.name for item in dataclasses.fields(OperatingPoint))
_KINDS = {  # of each array: all anchors' values one after the other
    'points': '<f8', 'scales': '<f8', 'blocks': '<i4', 'sizes': '<i4', 'first_terms': '<f8',
    'terms': '<f4', 'fine_terms': '<f8', 'nearness': '<f4', 'rounding': '<f8', 'mirrored': '|u1',
    'pairs': '<i4', 'rates': '<f4', 'weights': '<f4', 'order': '<i4', 'owners': '<i4'}


def write_table(anchors: Sequence[Anchor], model: BrakeModel, path: str | Path, *,
                about: Mapping[str, Any] | None = None) -> None:
    """Write anchors of a model; an existing file is replaced only by a whole one.

    Parameters
    ----------
    anchors : sequence of Anchor
        All of one degree.
    model : BrakeModel
    path : str or Path
    about : mapping, optional
        How they were laid down: texts and numbers, for the header.

    Raises
    ------
    TableFileError
        For no anchors, too many, or of several degrees, and where the file cannot be written.
    """
    path = Path(path)
    degrees = {anchor.monomials.degree for anchor in anchors}
    if len(degrees) != 1 or len(anchors) > MAX_ANCHORS:
        raise TableFileError(path, f'cannot hold {len(anchors)} anchors of {len(degrees)} degrees',
                             f'give 1 to {MAX_ANCHORS} of one degree')
    arrays = _packed(anchors)
    header = {'format': FORMAT, 'schema': SCHEMA, 'model': model_hash(model),
              'rows': anchors[0].rows.tolist(), 'degree': degrees.pop(),
              'anchors': len(anchors), 'about': dict(about or {})}
    header['hash'] = content_hash(header, arrays)
    partial = path.with_name(f'{path.name}.{os.getpid()}.part')
    try:
        with partial.open('wb') as file:
            np.savez_compressed(file, header=np.array(json.dumps(header)), **arrays)
        partial.replace(path)
    except OSError as error:
        raise TableFileError(path, f'cannot be written ({error.strerror})',
                             'check folder and rights') from None
    finally:
        partial.unlink(missing_ok=True)


def read_table(path: str | Path, model: BrakeModel) -> tuple[Anchor, ...]:
    """Read the anchors of a model.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.
    """
    path = Path(path)
    header, arrays = _read(path)
    if header.get('model') != model_hash(model):
        raise TableFileError(path, 'is the table of another model', 'lay one down for this model '
                             'with `squeal tabulate`')
    try:
        return tuple(_unpacked(header, arrays, model))
    except (SquealError, KeyError, IndexError, TypeError, ValueError, OverflowError) as error:
        raise TableFileError(path, f'holds no usable anchors ({quoted(str(error))})', _LAY_AGAIN
                             ) from None


def read_table_header(path: str | Path) -> dict[str, Any]:
    """Return the header of a table file, checked against its contents."""
    return _read(Path(path))[0]


def model_hash(model: BrakeModel) -> str:
    """Return SHA-256 over the arrays that the roots of a model depend on."""
    names = ('angular_frequencies', 'damping_ratios', *OPERATORS, *SUPPORTS)
    return content_hash({}, {name: array for name in names
                             if (array := getattr(model, name)) is not None})


def _packed(anchors: Sequence[Anchor]) -> dict[str, Any]:
    """Return the arrays of a file."""
    columns: dict[str, list[Any]] = {name: [] for name in _KINDS}
    for anchor in anchors:
        first = sum(len(terms) for terms in anchor.monomials.terms[:_FINE])
        series = anchor.series.view(float)
        high, met = series[first:], anchor.encounters
        coarse = bool(np.all(high == high.astype(np.float32)))
        values = {
            'points': [getattr(anchor.point, name) for name in _POINT], 'scales': anchor.scales,
            'blocks': [anchor.sizes.size], 'sizes': anchor.sizes,
            'first_terms': series[:first], 'terms': high if coarse else [],
            'fine_terms': [] if coarse else high, 'nearness': anchor.nearness,
            'rounding': anchor.rounding, 'mirrored': anchor.mirrored,
            'pairs': [met.weights.size, met.order.size, int(coarse)],
            'rates': np.stack([met.rates.real, met.rates.imag]), 'weights': met.weights,
            'order': met.order, 'owners': met.owners}
        for name, value in values.items():
            columns[name].append(np.ravel(value))
    return {name: np.concatenate(parts).astype(_KINDS[name]) for name, parts in columns.items()}


def _read(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    try:
        with zipfile.ZipFile(path) as archive:
            header = json.loads(str(_read_array(path, archive, 'header', 'U')))
            _check_header(path, header)
            arrays = {name: _read_array(path, archive, name, kind)
                      for name, kind in _KINDS.items()}
    except FileNotFoundError:
        raise TableFileError(path, 'does not exist', 'give the path of a table file, or lay one '
                             'down with `squeal tabulate`') from None
    except OSError as error:
        raise TableFileError(path, f'cannot be read ({error.strerror})', 'check path and rights'
                             ) from None
    except TableFileError:
        raise
    except Exception as error:  # whatever a damaged archive makes zipfile, zlib or numpy say
        raise TableFileError(
            path, f'is damaged or no table file ({type(error).__name__}: {str(error)[:120]})',
            _LAY_AGAIN) from None
    if content_hash(header, arrays) != header['hash']:
        raise TableFileError(path, 'was altered: its contents do not match its hash', _LAY_AGAIN)
    return header, arrays


def _read_array(path: Path, archive: zipfile.ZipFile, name: str, kind: str) -> Any:
    """Read one array after its own header was checked: nothing large is allocated unchecked."""
    if f'{name}.npy' not in archive.namelist():
        raise TableFileError(path, f'has no {name}, so it is no table file', _LAY_AGAIN)
    with archive.open(f'{name}.npy') as file:
        version = np.lib.format.read_magic(file)
        read = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                else np.lib.format.read_array_header_2_0)
        shape, _, dtype = read(file)
    size = math.prod(shape) * dtype.itemsize
    # what is stored compressed is not a thousandth of what it was: zlib's best
    most = min(MAX_BYTES, 1100 * archive.getinfo(f'{name}.npy').compress_size)
    right = (dtype.kind == 'U' and shape == ()) if kind == 'U' else (
        dtype == np.dtype(kind) and len(shape) == 1)
    if not right or size > most:
        raise TableFileError(path, f'{name} is an array {shape} of {dtype} and '
                             f'{size / 1e6:.1f} MB, which no table has', _LAY_AGAIN)
    with archive.open(f'{name}.npy') as file:
        return np.lib.format.read_array(file, allow_pickle=False)


def _check_header(path: Path, header: Any) -> None:
    if not isinstance(header, dict) or header.get('format') != FORMAT:
        raise TableFileError(path, 'is no table of anchors', _LAY_AGAIN)
    schema = header.get('schema')
    if type(schema) is not int or schema != SCHEMA:
        raise TableFileError(path, f'has schema {quoted(schema)}; this version reads '
                             f'{SCHEMA}', 'update squeal_ros or lay the table down again')
    if not isinstance(header.get('hash'), str):
        raise TableFileError(path, 'has no hash', _LAY_AGAIN)


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
              model: BrakeModel) -> Iterator[Anchor]:
    rows, degree, count = header['rows'], header['degree'], header['anchors']
    # what the model leaves out is not in the table either
    if rows != [i for i, name in enumerate(Coefficients._fields)
                if (array := getattr(model, name)) is not None and np.any(array)]:
        raise ValueError(f'rows are {quoted(rows)}')
    if type(degree) is not int or not 3 <= degree <= 8 or type(count) is not int or not (
            1 <= count <= MAX_ANCHORS):
        raise ValueError(f'degree {quoted(degree)} of {quoted(count)} anchors')
    monomials = Monomials(len(rows), degree)
    roots = 2 * model.size - int(np.count_nonzero(model.free_coordinates))
    reader = _Reader(arrays)
    for _ in range(count):
        yield _anchor(reader, readonly(rows, np.intp), monomials, roots)
    reader.finish()


def _anchor(reader: _Reader, rows: Any, monomials: Monomials, roots: int) -> Anchor:
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
    return Anchor(
        point=point, rows=rows, centre=readonly(np.array(point.coefficients())[rows]),
        scales=scales, monomials=monomials, sizes=sizes, series=series,
        majorants=tuple(readonly(norms(series[a:b]).T)
                        for a, b in zip(ends[-4:-1], ends[-3:], strict=True)),
        nearness=readonly(reader.take('nearness', blocks, len(monomials.terms[2]))),
        encounters=_encounters(reader, pairs, listed, rows.size, blocks, monomials.degree),
        rounding=readonly(reader.take('rounding', blocks)), mirrored=mirrored)


def _encounters(reader: _Reader, pairs: int, listed: int, variables: int, blocks: int,
                degree: int) -> Encounters:
    real, imaginary = reader.take('rates', 2, variables, 3, pairs).astype(float)
    order, owners = (reader.take(name, listed) for name in ('order', 'owners'))
    inside = [np.all((values >= 0) & (values < most)) for values, most in (
        (order, pairs), (owners, blocks))]
    if not all(inside) or np.any(np.diff(owners) < 0):
        raise ValueError('a pair is of no block')
    return Encounters(readonly(real + 1j * imaginary, complex),
                      readonly(reader.take('weights', pairs)), readonly(order, np.intp),
                      readonly(owners, np.intp), blocks, degree)
