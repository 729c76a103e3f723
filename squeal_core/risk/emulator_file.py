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

"""The file of a growth emulator: one .npz of plain arrays and a JSON header, and where it is."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
import math
from pathlib import Path
from typing import Any

import numpy as np
from squeal_core.common import resources
from squeal_core.common.arrays import readonly
from squeal_core.common.errors import SquealError, TableFileError
from squeal_core.common.npz_archive import (
    ArchiveKind,
    Arrays,
    Header,
    is_archive,
    read_archive,
    write_archive,
)
from squeal_core.common.version import __version__
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_records import EmulatorDomain, EmulatorError
from squeal_core.risk.growth_emulator import GrowthEmulator, INPUTS
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.risk.polynomial_basis import PolynomialBasis
from squeal_core.risk.small_matrices import CommonMatrix
from squeal_core.surrogate.table_file import model_hash

FORMAT = 'squeal_ros growth emulator'
SCHEMA = 2
SUFFIX = '.growth.npz'
_MOST_DEGREE = 20
_KINDS = {'weights': '<f4', 'common_weights': '<f4', 'exponents': '<i4', 'scales': '<f8',
          'low': '<f8', 'high': '<f8', 'domain_low': '<f8', 'domain_high': '<f8'}
KIND = ArchiveKind(
    noun='growth emulator', contents='emulator', format=FORMAT, schemas=range(SCHEMA, SCHEMA + 1),
    error=TableFileError,
    again='copy it again or build it with `squeal tabulate --growth-only`',
    renew='build it again with: squeal tabulate MODEL --growth-only',
    missing=lambda _: 'build it with `squeal tabulate --growth-only`')


def emulator_path(table: str | Path) -> Path:
    """Return the path of a table file's emulator: beside it; its own path as it is."""
    path = Path(table)
    return path if path.name.endswith(SUFFIX) else path.with_suffix(SUFFIX)


def write_emulator(path: str | Path, emulator: GrowthEmulator, model: BrakeModel, *,
                   overwrite: bool = True) -> None:
    """
    Write the emulator of a model; an existing file is replaced only by a whole one.

    Raises
    ------
    OutputError
        Where the file cannot be written.

    """
    basis, domain = emulator.basis, emulator.domain
    common = np.concatenate([np.empty((len(basis.exponents), 0)), *(
        matrix.weights for matrix in emulator.common)], axis=1)
    arrays = {'weights': emulator.weights, 'common_weights': common,
              'exponents': basis.exponents, 'scales': basis.scales, 'low': basis.low,
              'high': basis.high, 'domain_low': domain.low, 'domain_high': domain.high}
    header: Header = {
        'schema': SCHEMA, 'version': __version__, 'model': model_hash(model),
        'inputs': list(INPUTS), 'steepest': domain.steepest, 'error': asdict(emulator.error),
        'families': [asdict(family) for family in emulator.every],
        'common': [{'piece': matrix.piece, 'families': matrix.families.tolist(),
                    'modes': math.isqrt(matrix.weights.shape[1] // 2)}
                   for matrix in emulator.common]}
    write_archive(path, KIND, header, {name: np.asarray(array, _KINDS[name])
                                       for name, array in arrays.items()}, overwrite=overwrite)


def read_emulator(path: str | Path, model: BrakeModel) -> GrowthEmulator:
    """
    Read the emulator of a model.

    Raises
    ------
    TableFileError
        One line: which file, what is wrong with it, and what to do.

    """
    header, arrays = _read(path)
    if header.get('model') != model_hash(model):
        raise TableFileError(path, 'is the growth emulator of another model',
                             'build one for this model with `squeal tabulate --growth-only`')
    return _usable(path, header, arrays, model)


def _usable(path: str | Path, header: Header, arrays: Arrays, model: BrakeModel) -> GrowthEmulator:
    try:
        return _emulator(header, arrays, model)
    except (AttributeError, LookupError, TypeError, ValueError, OverflowError) as error:
        raise TableFileError(path, f'holds no usable emulator ({str(error)[:120]})', KIND.again
                             ) from None


def read_emulator_header(path: str | Path) -> dict[str, Any]:
    """Return the header of an emulator file, checked against its contents, and its domain."""
    header, arrays = _read(path)
    return {**header, 'low': arrays['domain_low'].tolist(), 'high': arrays['domain_high'].tolist(),
            'terms': len(arrays['exponents']), 'pieces': len(arrays['weights']),
            'piece_ends': [*arrays['low'][:, 3].tolist(), float(arrays['high'][-1, 3])]}


def is_emulator(path: str | Path) -> bool:
    """Return whether a file is an emulator file, by its header."""
    return is_archive(path, KIND)


def cached_emulator_path(model: BrakeModel) -> Path:
    """Return the path of a model's emulator in the user's cache, under the model's hash."""
    return resources.cache_folder() / f'growth_{model_hash(model)[:16]}_{SCHEMA}{SUFFIX}'


def find_emulator(model: BrakeModel) -> tuple[Path, GrowthEmulator] | None:
    """Return file and emulator of a model from the user's cache, else as shipped, or None."""
    wanted = model_hash(model)
    for path in (cached_emulator_path(model), *resources.table_files(SUFFIX)):
        try:
            header, arrays = _read(path)
        except TableFileError:  # none is there, or one of an earlier version
            continue
        if header.get('model') == wanted:
            return path, _usable(path, header, arrays, model)
    return None


def named_emulator(path: str, model: BrakeModel) -> GrowthEmulator | None:
    """Return the emulator in a file, or where none is named the one that is found."""
    if path:
        return read_emulator(path, model)
    result = find_emulator(model)
    return result and result[1]


def _read(path: str | Path) -> tuple[Header, Arrays]:
    return read_archive(path, KIND, lambda _: _KINDS, _check_shapes)


def _check_shapes(_: Header, shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that do not fit each other before they are read."""
    pieces, terms = shapes['weights'][:1], shapes['weights'][1:2]
    if (len(shapes['weights']) != 3 or not all(pieces) or shapes['exponents'] != (*terms, 6)
            or len(shapes['common_weights']) != 2 or shapes['common_weights'][:1] != terms
            or shapes['scales'] != (3,)
            or any(shapes[name] != (*pieces, 6) for name in ('low', 'high'))
            or any(shapes[name] != (6,) for name in ('domain_low', 'domain_high'))):
        raise SquealError(f'weights: shape {shapes["weights"]}, exponents: {shapes["exponents"]}')


def _emulator(header: Mapping[str, Any], arrays: Mapping[str, Any],
              model: BrakeModel) -> GrowthEmulator:
    families = tuple(ModeFamily(
        tuple(map(int, item['numbers'])), float(item['frequency_hz']), float(item['decay_rate']),
        float(item.get('largest_growth', math.inf))) for item in header['families'])
    exponents, scales = arrays['exponents'], arrays['scales']
    sizes = [len(item.numbers) for item in families]
    if sizes != sorted(sizes) or not {*sizes} <= {1, 2} or list(header['inputs']) != list(
            INPUTS) or not sizes or arrays['weights'].shape[2] != 2 * sum(
                size**2 for size in sizes):
        raise ValueError('the families do not fit the weights')
    common = tuple(_common(header['common'], arrays, sizes))
    if not exponents.size or exponents.min() < 0 or exponents.max() > _MOST_DEGREE:
        raise ValueError(f'degrees {exponents.min(initial=0)} to {exponents.max(initial=0)}')
    if not all(np.isfinite(array).all() for array in arrays.values()) or not (
            (arrays['low'] < arrays['high']).all() and (scales > 0.0).all()):
        raise ValueError('numbers that are not finite, or scales that are not positive')
    return GrowthEmulator(
        model, families,
        EmulatorDomain(readonly(arrays['domain_low']), readonly(arrays['domain_high']),
                       float(header['steepest'])),
        PolynomialBasis(readonly(exponents, np.intp), readonly(scales), readonly(arrays['low']),
                        readonly(arrays['high'])),
        arrays['weights'].astype(float), common, EmulatorError(**header['error']))


def _common(items: Any, arrays: Mapping[str, Any], sizes: Sequence[int]
            ) -> Iterator[CommonMatrix]:
    """Yield the common matrices of families of these sizes."""
    weights, start = arrays['common_weights'].astype(float), 0
    for item in items:
        piece, modes = int(item['piece']), int(item['modes'])
        places = [*map(int, item['families'])]
        if not (0 <= piece < len(arrays['weights']) and places == sorted({*places})
                and 0 <= min(places) <= max(places) < len(sizes)
                and sum(sizes[place] for place in places) <= modes):
            raise ValueError(f'families {places} of {modes} modes in piece {piece}')
        end = start + 2 * modes * modes
        if end > weights.shape[1]:
            break
        yield CommonMatrix(piece, readonly(places, np.intp), readonly(weights[:, start:end]))
        start = end
    if start != weights.shape[1]:
        raise ValueError('the common matrices do not fit their weights')
