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

"""Modes as read from a file, before units, axis and normalisation, and their checks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray, readonly
from squeal_core.common.bounded_reader import read_bounded
from squeal_core.common.errors import LocatedError, short_repr
from squeal_core.modes.fe.mass import EDGES
from squeal_core.modes.nodal_modes import ElementBlock

MAX_BYTES = 500_000_000  # of a file
MAX_NODES = 2_000_000
MAX_MODES = 2_000
MAX_VALUES = 150_000_000  # modes x nodes x 3: 1.2 GB in double precision
_ABSURD = 1e30  # no coordinate and no shape is as large, in whatever units
_ASIDE = 0.5  # how far a mid-edge node may lie from the middle, in lengths of its edge
AGAIN = 'export it again'

IntArray = NDArray[np.int64]


class ReaderError(LocatedError):
    """Modal results of another package that cannot be used."""


@dataclass(frozen=True, eq=False)
class RawModes:
    """
    Natural modes as a file gives them, in the units and axes of the file.

    Parameters
    ----------
    coordinates : (M, 3) array
        Cartesian [units of the file].
    frequencies_hz : (N,) array or None
        [Hz]; None where the format has no place for them.
    shapes : (N, M, 3) array
        Cartesian, normalised in whatever way.
    elements : tuple of ElementBlock
    modal_masses : (N,) array or None
        Generalised masses that the file states for these shapes [mass unit of the file].
    source : str
        The path, for errors and provenance.
    length_unit_m : float or None
        The file's unit of length [m], where it says so.

    """

    coordinates: FloatArray
    frequencies_hz: FloatArray | None
    shapes: FloatArray
    elements: tuple[ElementBlock, ...] = ()
    modal_masses: FloatArray | None = None
    source: str = ''
    length_unit_m: float | None = None


@dataclass(frozen=True, eq=False)
class NodeField:
    """
    Three values at each of M nodes, named by the numbers that the file gives them.

    Parameters
    ----------
    ids : (M,) int array
    values : (M, 3) array
    where : str
        Place in the file, for errors.

    """

    ids: IntArray
    values: FloatArray
    where: str


def read_bytes(path: Path) -> bytes:
    """Return a whole regular file, if it is there and not too large."""
    return read_bounded(path, MAX_BYTES, ReaderError)


def check_size(where: object, count: int, most: int, what: str) -> None:
    """Refuse a count above the limit of readers."""
    if count > most:
        raise ReaderError(where, f'has {count} {what}, more than the {most} that are read',
                          'export fewer modes, or the nodes near the contact only')


def assemble(path: Path, nodes: NodeField, fields: Sequence[NodeField],
             frequencies_hz: Sequence[float] | FloatArray | None,
             cells: Mapping[str, Sequence[Sequence[int]] | IntArray], *,
             modal_masses: Sequence[float] | FloatArray | None = None,
             length_unit_m: float | None = None) -> RawModes:
    """
    Return raw modes of nodes, fields and cells that name nodes by the file's numbers.

    Nodes that the modes say nothing about, and nodes of no element where there are elements, are
    left out: they carry no part of the component.

    Raises
    ------
    ReaderError
        For nodes that are there twice, without place or without value, for nothing to read, for
        values that are not finite, and for elements whose nodes are in another order.

    """
    if not fields:
        raise ReaderError(path, 'holds no real normal modes', 'export displacements of each mode')
    check_size(path, len(fields), MAX_MODES, 'modes')
    check_size(path, nodes.ids.size, MAX_NODES, 'nodes')
    check_size(path, len(fields) * nodes.ids.size * 3, MAX_VALUES, 'values')
    _check_field(path, nodes)
    kept = _kept(path, nodes, fields[0])
    if any(len(numbers) for numbers in cells.values()):
        named = np.unique(np.concatenate([np.ravel(numbers) for numbers in cells.values()]))
        fields = [_within(field, named) for field in fields]
        kept &= np.isin(nodes.ids, named)
    for field in fields:
        _check_field(path, field)
    ids = nodes.ids[kept]
    where = nodes.values[kept]
    shapes = np.stack([field.values[_places(path, ids, field)] for field in fields])
    blocks = _blocks(path, ids, cells)
    for block in blocks:
        _check_middles(path, ids, where, block)
    return RawModes(
        where, None if frequencies_hz is None else np.array(frequencies_hz, float), shapes, blocks,
        None if modal_masses is None else np.array(modal_masses, float), str(path), length_unit_m)


def _within(field: NodeField, named: IntArray) -> NodeField:
    """Return the part of a field at nodes of elements; a reference point moves as it likes."""
    inside = np.isin(field.ids, named)
    return field if inside.all() else NodeField(field.ids[inside], field.values[inside],
                                                field.where)


def _check_field(path: Path, field: NodeField) -> None:
    if not field.ids.size:
        raise ReaderError(f'{path}, {field.where}', 'names no node', AGAIN)
    numbers, counts = np.unique(field.ids, return_counts=True)
    if counts.max() > 1:
        raise ReaderError(f'{path}, {field.where}', f'names node {numbers[counts.argmax()]} '
                          f'{counts.max()} times', 'export one component, each node once')
    bad = ~(np.abs(field.values) < _ABSURD).all(axis=1)
    if bad.any():
        raise ReaderError(f'{path}, {field.where}',
                          f'has {short_repr(field.values[bad][0].tolist())} '
                          f'at node {field.ids[bad][0]}, which is not finite or absurd', AGAIN)


def _kept(path: Path, nodes: NodeField, field: NodeField) -> NDArray[np.bool_]:
    missing = ~np.isin(field.ids, nodes.ids)
    if missing.any():
        raise ReaderError(f'{path}, {field.where}', f'moves node {field.ids[missing][0]}, which '
                          f'{nodes.where} does not place', 'export all nodes with coordinates')
    return np.isin(nodes.ids, field.ids)


def _places(path: Path, ids: IntArray, field: NodeField) -> IntArray:
    """Return the places of the nodes in a field; it must name just these, in any order."""
    order = np.argsort(field.ids)
    if field.ids.size != ids.size or not np.array_equal(field.ids[order], np.sort(ids)):
        other = np.setxor1d(field.ids, ids)[0]
        raise ReaderError(f'{path}, {field.where}', f'moves {field.ids.size} nodes, the first '
                          f'mode {ids.size} (node {other} differs)',
                          'export the same nodes each mode')
    return np.asarray(order[np.searchsorted(field.ids, ids, sorter=order)])


def _blocks(path: Path, ids: IntArray,
            cells: Mapping[str, Sequence[Sequence[int]] | IntArray]) -> tuple[ElementBlock, ...]:
    """Return elements by place of their nodes."""
    order = np.argsort(ids)
    blocks = []
    for kind, numbers in cells.items():
        named = np.asarray(numbers, dtype=np.int64)
        check_size(path, len(named), 2 * MAX_NODES, f'elements of kind {kind}')
        there = np.isin(named, ids)
        if not there.all():
            raise ReaderError(path, f'has a {kind} with node {named[~there][0]}, which no mode '
                              'moves or nothing places', 'export all nodes of the elements, or '
                              'no elements')
        places = order[np.searchsorted(ids, named, sorter=order)]
        if places.size:
            blocks.append(ElementBlock(kind, readonly(places, np.int64)))
    return tuple(blocks)


def _check_middles(path: Path, ids: IntArray, where: FloatArray, block: ElementBlock) -> None:
    """Refuse an order of nodes that puts mid-edge nodes elsewhere: packages differ in it."""
    edges = np.array(EDGES[block.kind.rstrip('0123456789')])
    corners = int(edges.max()) + 1
    if block.nodes.shape[1] < corners + len(edges):
        return
    start, stop = where[block.nodes[:, edges[:, 0]]], where[block.nodes[:, edges[:, 1]]]
    middles = where[block.nodes[:, corners:corners + len(edges)]]
    aside = np.linalg.norm(middles - 0.5 * (start + stop), axis=2)
    bad = np.argwhere(aside > _ASIDE * np.linalg.norm(stop - start, axis=2))
    if bad.size:
        element, edge = bad[0]
        ends = ids[block.nodes[element, edges[edge]]]
        node = ids[block.nodes[element, corners + edge]]
        raise ReaderError(path, f'has a {block.kind} with node {node} in the place of the middle '
                          f'between nodes {ends[0]} and {ends[1]}, but far from it',
                          'export elements in the order of the format, or none')
