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
Universal files (UNV, UFF): nodes 15 and 2411, elements 2412, shapes 55 and 2414, units 164.

The columns are read here, not by pyuff: it keeps no line numbers, passes over a dataset that was
cut short, and reads no number of a Fortran D exponent in dataset 55. The tests hold it against
this reader in both directions.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers.phases import real_shape
from squeal_core.modes.readers.raw import (
    AGAIN,
    assemble,
    IntArray,
    NodeField,
    RawModes,
    ReaderError,
)
from squeal_core.modes.readers.text import Text

_MARK = b'    -1'
_BEAMS = (11, 21, 22, 23, 24)  # their elements take three records
# descriptor -> kind, and where the file has the node that ElementBlock wants next: quadratic
# elements go round the bottom, corner and middle in turn, then up the sides, then round the top
_ROUND = (0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11)
_DESCRIPTORS: dict[int, tuple[str, tuple[int, ...]]] = {
    111: ('tet4', tuple(range(4))), 112: ('wedge6', tuple(range(6))),
    113: ('wedge15', (0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8)),
    115: ('hex8', tuple(range(8))), 116: ('hex20', _ROUND),
    118: ('tet10', (0, 2, 4, 9, 1, 3, 5, 6, 7, 8))}
_SOLIDS = range(101, 120)
_NORMAL_MODE, _DISPLACEMENT = 2, 8
_VECTORS = {2: 3, 3: 6}  # data characteristic -> values a node: translations, and rotations
_REAL, _COMPLEX = (2, 4), (5, 6)  # data types: single, double precision
_GLOBAL = (0, 1)  # coordinate systems that no dataset need define
_EXPORT_GLOBAL = 'export nodes and results in global Cartesian coordinates'


@dataclass
class _Found:
    """Data read so far."""

    nodes: NodeField | None = None
    systems: dict[int, bool] = field(default_factory=dict)  # by label: is it the global one
    placed: IntArray | None = None  # node, and the systems of its coordinates and displacements
    cells: dict[str, list[list[int]]] = field(default_factory=dict)
    fields: list[NodeField] = field(default_factory=list)
    frequencies_hz: list[float] = field(default_factory=list)
    masses: list[float] = field(default_factory=list)
    length_unit_m: float | None = None


def read(path: Path) -> RawModes:
    """Read a universal file; datasets of other numbers are passed over."""
    text, result = Text.read(path), _Found()
    readers = {15: _nodes_15, 2411: _nodes_2411, 2412: _elements, 55: _shape_55, 2414: _shape_2414,
               164: _units, 18: _systems_18, 2420: _systems_2420}
    for number, start, stop in _datasets(text):
        if number in readers:
            readers[number](text, start, stop, result)
    nodes = _global_nodes(path, result)
    masses = result.masses if min(result.masses, default=0.0) > 0.0 else None
    return assemble(path, nodes, result.fields, result.frequencies_hz, result.cells,
                    modal_masses=masses, length_unit_m=result.length_unit_m)


def _datasets(text: Text) -> Iterator[tuple[int, int, int]]:
    """Return the number, first line and end of each dataset: it stands between two lines of -1."""
    marks = [i for i, line in enumerate(text.lines) if line.rstrip() == _MARK]
    if not marks:
        raise ReaderError(text.path, 'has no line of -1 in columns 5 and 6, as each dataset of a '
                          'universal file begins and ends with', 'check the format')
    if len(marks) % 2:
        raise text.error(marks[-1], 'begins a dataset that has no end, or ends one that has no '
                         'beginning', 'the file was cut short or altered: ' + AGAIN)
    for start, stop in zip(marks[::2], marks[1::2], strict=True):
        if stop > start + 1:
            yield text.number(start + 1, 0, 6, int), start + 2, stop


def _keep_nodes(text: Text, start: int, result: _Found, heads: np.ndarray,
                values: np.ndarray, number: int) -> None:
    if result.nodes is not None:
        raise text.error(start - 1, 'begins a second dataset of nodes', 'export one component')
    result.placed = heads[:, :3]
    result.nodes = NodeField(heads[:, 0], values, f'dataset {number} at line {start}')


def _global_nodes(path: Path, result: _Found) -> NodeField:
    """Return the nodes; refuse them and their results in others than the global system."""
    if result.nodes is None or result.placed is None:
        raise ReaderError(path, 'holds no nodes (dataset 15 or 2411)', 'export the nodes as well')
    labels = np.unique(result.placed[:, 1:])
    others = [label for label in labels.tolist()
              if not result.systems.get(label, label in _GLOBAL)]
    bad = np.flatnonzero(np.isin(result.placed[:, 1:], others).any(axis=1))
    if bad.size:
        node, place, shift = result.placed[bad[0]].tolist()
        raise ReaderError(f'{path}, {result.nodes.where}', f'gives node {node} in coordinate '
                          f'systems {place} and {shift}; the global Cartesian one is read, which '
                          f'{short_repr(others)} is not', _EXPORT_GLOBAL)
    return result.nodes


def _systems_2420(text: Text, start: int, stop: int, result: _Found) -> None:
    """Read coordinate systems of six records: label and type; name; three axes, an origin."""
    for i in range(start + 2, stop - 5, 6):
        label, kind = (text.number(i, 10 * k, 10 * k + 10, int) for k in range(2))
        matrix = text.fixed(range(i + 2, i + 6), 0, 25, 3)
        result.systems[label] = kind == 0 and np.allclose(matrix, np.eye(4, 3), atol=1e-9)


def _systems_18(text: Text, start: int, stop: int, result: _Found) -> None:
    """Read systems of four records: label and type; name; origin, a point on x, one in xz."""
    for i in range(start, stop - 3, 4):
        label, kind = (text.number(i, 10 * k, 10 * k + 10, int) for k in range(2))
        origin_x, on_xz = text.fixed(range(i + 2, i + 3), 0, 13, 6), text.fixed(
            range(i + 3, i + 4), 0, 13, 3)
        across = [*origin_x[0, :3], *origin_x[0, 4:], on_xz[0, 1]]
        result.systems[label] = bool(kind == 0 and np.allclose(across, 0.0, atol=1e-9)
                                     and origin_x[0, 3] > 0.0 and on_xz[0, 2] > 0.0)


def _nodes_15(text: Text, start: int, stop: int, result: _Found) -> None:
    rows = range(start, stop)
    _keep_nodes(text, start, result, text.fixed(rows, 0, 10, 4, int),
                text.fixed(rows, 40, 13, 3), 15)


def _nodes_2411(text: Text, start: int, stop: int, result: _Found) -> None:
    if (stop - start) % 2:
        raise text.error(stop - 1, 'ends dataset 2411 in the middle of a node')
    _keep_nodes(text, start, result, text.fixed(range(start, stop, 2), 0, 10, 4, int),
                text.fixed(range(start + 1, stop, 2), 0, 25, 3), 2411)


def _units(text: Text, start: int, stop: int, result: _Found) -> None:
    factor = text.number(start + 1, 0, 25)
    if not 1e-6 < factor < 1e6:
        raise text.error(start + 1, f'gives {factor} units of length to a metre')
    result.length_unit_m = 1.0 / factor


def _elements(text: Text, start: int, stop: int, result: _Found) -> None:
    i = start
    while i < stop:
        descriptor, size = text.number(i, 10, 20, int), text.number(i, 50, 60, int)
        kind, order = _DESCRIPTORS.get(descriptor, ('', tuple(range(size))))
        if (not kind and descriptor in _SOLIDS) or size != len(order) or not size:
            raise text.error(i, f'has an element of descriptor {descriptor} with {size} nodes, '
                             'which is not known', 'mesh with tetrahedra, hexahedra or wedges')
        i += 2 if descriptor in _BEAMS else 1
        if kind:
            nodes = [text.number(i + k // 8, 10 * (k % 8), 10 * (k % 8) + 10, int)
                     for k in range(size)]
            result.cells.setdefault(kind, []).append([nodes[place] for place in order])
        i += -(-size // 8)
    if i != stop:
        raise text.error(stop, 'ends dataset 2412 in the middle of an element')


def _shape_55(text: Text, start: int, stop: int, result: _Found) -> None:
    layout = _mode_layout(text, start + 5)
    if layout:
        result.frequencies_hz.append(text.number(start + 7, 0, 13))
        result.masses.append(text.number(start + 7, 13, 26))
        _keep_shape(text, start, range(start + 8, stop), layout, result, 55)


def _shape_2414(text: Text, start: int, stop: int, result: _Found) -> None:
    at_nodes = text.number(start + 2, 0, 10, int) == 1
    layout = _mode_layout(text, start + 8) if at_nodes else None
    if layout:
        result.frequencies_hz.append(text.number(start + 11, 13, 26))
        result.masses.append(text.number(start + 11, 39, 52))
        _keep_shape(text, start, range(start + 13, stop), layout, result, 2414)


def _mode_layout(text: Text, i: int) -> tuple[int, bool] | None:
    """
    Return the number of values a node and whether they are complex, by the record of the data.

    None for what is no mode shape.
    """
    _, analysis, vector, quantity, kind, width = (
        text.number(i, 10 * k, 10 * k + 10, int) for k in range(6))
    if analysis in (3, 7):
        raise text.error(i, f'has complex modes (analysis type {analysis}, data type {kind})',
                         'export real normal modes')
    if analysis != _NORMAL_MODE or quantity not in (_DISPLACEMENT, 0, 1):
        return None
    if kind not in (*_REAL, *_COMPLEX):
        raise text.error(i, f'has data type {kind}, not real or complex numbers '
                         f'({", ".join(map(str, (*_REAL, *_COMPLEX)))})', 'export real numbers')
    if _VECTORS.get(vector) != width:
        raise text.error(i, f'has {width} values a node of data characteristic {vector}, not 3 '
                         'translations, or 3 with 3 rotations', 'export displacement vectors')
    return int(width), kind in _COMPLEX


def _keep_shape(text: Text, start: int, rows: range, layout: tuple[int, bool], result: _Found,
                number: int) -> None:
    """Keep a shape: a record of the node, then its values, six a record; complex ones as pairs."""
    width, is_complex = layout
    records = 1 + -(-width * (1 + is_complex) // 6)
    if len(rows) % records:
        raise text.error(rows.stop - 1, f'ends dataset {number} in the middle of a node')
    ids = text.fixed(rows[::records], 0, 10, 1, int)[:, 0]
    # the three translations are in the first record of values
    values = text.fixed(rows[1::records], 0, 13, 6 if is_complex else width)
    where = f'dataset {number} at line {start}'
    if is_complex:
        values = real_shape(values[:, ::2] + 1j * values[:, 1::2], f'{text.path}, {where}')
    result.fields.append(NodeField(ids, values[:, :3], where))
