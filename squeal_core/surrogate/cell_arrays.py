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

"""The cells of a table as a few arrays: ragged in files, padded to one layout for evaluation."""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from squeal_core.common.arrays import FloatArray, readonly
from squeal_core.common.errors import SquealError
from squeal_core.surrogate.table_cell import BlockInvariants, DEGREE, fit_terms, TableCell

MAX_CELLS = 100_000
OMITTED_DEGREE = 2
CELL_KINDS = {
    'blocks': '<i4', 'sizes': '|u1', 'constants': '<f8', 'series': '<f4', 'bounds': '<f4',
    'mirrored': '|u1', 'omitted_modes': '<i4', 'omitted': '<f4', 'omitted_below': '<f4'}


def pack_cells(cells: Sequence[TableCell]) -> dict[str, Any]:
    """Return the arrays of cells, by name."""
    arrays = {
        'blocks': [cell.sizes.size for cell in cells],
        'sizes': _joined(cell.sizes for cell in cells),
        'constants': _joined(cell.series[:1] for cell in cells),
        'series': _joined(cell.series[1:] for cell in cells),
        'bounds': _joined(cell.bounds for cell in cells),
        'mirrored': _joined(cell.mirrored for cell in cells),
        'omitted_modes': [cell.omitted.shape[1] for cell in cells],
        'omitted': _joined(cell.omitted for cell in cells),
        'omitted_below': [cell.omitted_below for cell in cells]}
    return {name: np.asarray(values, CELL_KINDS[name]) for name, values in arrays.items()}


def _joined(parts: Any) -> Any:
    return np.concatenate([np.zeros(0), *(np.ravel(part) for part in parts)])


def check_cell_shapes(shapes: Mapping[str, tuple[int, ...]]) -> None:
    """Refuse arrays that cannot be those of cells, before they are read."""
    cells = shapes['blocks'][:1]
    for name in CELL_KINDS:
        if len(shapes[name]) != 1:
            raise SquealError(f'{name}: shape {shapes[name]}')
    if not cells or cells[0] > MAX_CELLS or not (
            shapes['omitted_modes'] == shapes['omitted_below'] == cells):
        raise SquealError(f'blocks: shape {shapes["blocks"]}')


def unpack_cells(arrays: Mapping[str, Any]) -> tuple[TableCell, ...]:
    """
    Return the cells that `pack_cells` made arrays of.

    Raises
    ------
    ValueError
        For arrays that do not fit each other.

    """
    reader = _Reader(arrays)
    cells = tuple(reader.cell(place) for place in range(len(arrays['blocks'])))
    reader.finish()
    return cells


class _Reader:
    """Takes the values of cells from the arrays, one after the other."""

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = arrays
        self._places = dict.fromkeys(
            ('sizes', 'constants', 'series', 'bounds', 'mirrored', 'omitted'), 0)

    def cell(self, place: int) -> TableCell:
        """Return the next cell, checked."""
        sizes = readonly(self._take('sizes', int(self._arrays['blocks'][place])), np.intp)
        if sizes.size and (sizes.min() < 1 or np.any(np.diff(sizes) < 0)):
            raise ValueError('sizes of blocks do not rise')
        count, omitted = int(sizes.sum()), int(self._arrays['omitted_modes'][place])
        series = np.vstack([
            self._floats('constants', 1, 2 * count),
            self._floats('series', fit_terms(DEGREE).count - 1, 2 * count)])
        return TableCell(
            sizes, readonly(series),
            self._floats('bounds', count), readonly(self._take('mirrored', count), bool),
            self._floats('omitted', fit_terms(OMITTED_DEGREE).count, omitted),
            float(self._arrays['omitted_below'][place]))

    def _floats(self, name: str, *shape: int) -> Any:
        return readonly(self._take(name, int(np.prod(shape))).reshape(shape))

    def _take(self, name: str, count: int) -> Any:
        start = self._places[name]
        values = self._arrays[name][start:start + count]
        if count < 0 or values.size != count or not np.all(np.isfinite(values)):
            raise ValueError(f'{name} has no {count} numbers from {start} on')
        self._places[name] = start + count
        return values

    def finish(self) -> None:
        """Refuse numbers that no cell uses."""
        for name, used in self._places.items():
            if used != self._arrays[name].size:
                raise ValueError(f'{name} has {self._arrays[name].size} numbers, {used} are used')


class CellStack(NamedTuple):
    """
    The arrays of C cells, padded by NaN to one layout of K eigenvalues; the last one is no cell.

    Attributes
    ----------
    layout : BlockInvariants
        As many blocks of each size as the cell that has most of them.
    series : (C + 1, terms, 2 K) array
    bounds : (C + 1, K) array
    mirrored : (C + 1, K) bool array
    omitted : (C + 1, terms of degree 2, modes) array
    omitted_below : (C + 1,) array
    centres, halves : (C + 1, 3) arrays
        As of the table.

    """

    layout: BlockInvariants
    series: FloatArray
    bounds: FloatArray
    mirrored: Any
    omitted: FloatArray
    omitted_below: FloatArray
    centres: FloatArray
    halves: FloatArray


def stack_cells(cells: Sequence[TableCell], centres: FloatArray, halves: FloatArray
                ) -> CellStack:
    """Return the arrays of cells, see `TableCell`, in one layout."""
    layouts = {cell.sizes.tobytes(): cell.layout for cell in cells}
    most: Counter[int] = Counter()
    for one in layouts.values():
        most |= Counter(one.sizes.tolist())  # the larger number of each
    layout = BlockInvariants(np.array(sorted(most.elements()), np.intp))
    places = {key: one.places_in(layout) for key, one in layouts.items()}
    count = len(cells) + 1
    series = np.zeros((count, fit_terms(DEGREE).count, layout.count), complex)
    omitted = np.zeros((count, fit_terms(OMITTED_DEGREE).count,
                        max((cell.omitted.shape[1] for cell in cells), default=0)))
    series[:, 0], omitted[:, 0] = complex(np.nan, np.nan), np.nan
    bounds, mirrored = np.full(series[:, 0].shape, np.nan), np.zeros(series[:, 0].shape, bool)
    for place, cell in enumerate(cells):
        eigenvalues, invariants = places[cell.sizes.tobytes()]
        series[place][:, invariants] = cell.series.view(complex)
        bounds[place, invariants] = cell.bounds
        mirrored[place, eigenvalues] = cell.mirrored
        omitted[place, :, :cell.omitted.shape[1]] = cell.omitted
    below = [*(cell.omitted_below for cell in cells), np.nan]
    nowhere = np.full((1, 3), np.nan)
    return CellStack(layout, series.view(float), bounds, mirrored, omitted, np.array(below),
                     np.concatenate([centres, nowhere]), np.concatenate([halves, nowhere]))
