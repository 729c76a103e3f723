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
VTU, the XML file of an unstructured grid: one array of vectors at the points for each mode.

Read here, not by meshio: it knows neither the versions that VTK writes today (2.x) nor a bound to
what it unpacks. The tests read what meshio writes.
"""

import base64
from collections.abc import Callable
from dataclasses import dataclass
import lzma
from pathlib import Path
import re
from typing import Any
from xml.etree import ElementTree
import zlib

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers.raw import (
    AGAIN,
    assemble,
    IntArray,
    MAX_VALUES,
    NodeField,
    RawModes,
    read_bytes,
    ReaderError,
)

_TYPES = {f'{kind}{bits}': f'{code}{bits // 8}' for kind, code in (('Int', 'i'), ('UInt', 'u'))
          for bits in (8, 16, 32, 64)} | {'Float32': 'f4', 'Float64': 'f8'}
_CELLS = {10: ('tet4', 4), 12: ('hex8', 8), 13: ('wedge6', 6), 24: ('tet10', 10),
          25: ('hex20', 20), 26: ('wedge15', 15), 29: ('hex27', 27)}
_FLAT = {1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 34}  # points, lines and surfaces: left out
_NUMBERED = re.compile(r'mode[ _#-]*(\d+)', re.IGNORECASE)
_HERTZ = re.compile(r'([-+]?\d+\.?\d*(?:e[-+]?\d+)?)[ _]*Hz\b', re.IGNORECASE)
_APPENDED = re.compile(rb'<AppendedData[^>]*>\s*_')
_MOST_TAGS = 100_000  # of XML; an array has two
# real shapes pack to a tenth at best; a file that states more is damaged, or a bomb
_MOST_RATIO, _MOST_SMALL = 50, 50_000_000
_REMEDY = 'see docs/howto/modal_results.md for the arrays to write'


@dataclass(frozen=True)
class _File:
    """Properties of a file that decoding its arrays needs."""

    path: Path
    order: str  # of bytes: < or >
    header: str  # type of the numbers before a block of data
    unpack: Callable[[bytes, int], bytes] | None
    appended: bytes
    encoded: bool  # appended data in base64
    most: int  # bytes that an array, or all modes, may unpack to

    def error(self, what: str, remedy: str = AGAIN) -> ReaderError:
        return ReaderError(self.path, what, remedy)


def read(path: Path) -> RawModes:
    """Read points, solid cells and the vectors of modes."""
    data = read_bytes(path)
    result = _APPENDED.search(data)
    markup = data[:result.end()] if result else data
    if b'<!DOCTYPE' in markup or b'<!ENTITY' in markup:
        raise ReaderError(path, 'defines entities, which a VTU file has no need of', AGAIN)
    if markup.count(b'<') > _MOST_TAGS:
        raise ReaderError(path, f'has more than {_MOST_TAGS} tags', 'export fewer arrays')
    end = data.rfind(b'</AppendedData>')
    raw = data[result.end():end] if result and end > result.end() else b''
    try:
        root = ElementTree.fromstring(data[:result.end()] + data[end:] if result else data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise ReaderError(path, f'is cut short or no XML ({error})', AGAIN) from None
    try:
        return _read(_file(path, root, raw, len(data)), root)
    except ReaderError:
        raise
    except (KeyError, ValueError, TypeError, IndexError, OverflowError, EOFError, zlib.error,
            lzma.LZMAError) as error:
        raise ReaderError(path, f'is no VTU file this can read ({type(error).__name__}: '
                          f'{str(error)[:100]})',
                          AGAIN) from None


def _unzlib(data: bytes, size: int) -> bytes:
    return zlib.decompressobj().decompress(data, max(size, 1))  # 0 would be no bound


def _unlzma(data: bytes, size: int) -> bytes:
    return lzma.LZMADecompressor().decompress(data, max(size, 1))


def _file(path: Path, root: ElementTree.Element, appended: bytes, size: int) -> _File:
    compressor = root.get('compressor', '')
    unpackers = {'': None, 'vtkZLibDataCompressor': _unzlib, 'vtkLZMADataCompressor': _unlzma}
    if root.tag != 'VTKFile' or root.get('type') != 'UnstructuredGrid':
        raise ReaderError(path,
                          f'is a {root.tag} of type {short_repr(root.get("type"))}, no VTKFile '
                          'of UnstructuredGrid', 'save an unstructured grid (.vtu)')
    if compressor not in unpackers:
        raise ReaderError(path, f'is packed by {short_repr(compressor)}',
                          'save without compression, or with zlib')
    section = root.find('AppendedData')
    return _File(path, '>' if root.get('byte_order') == 'BigEndian' else '<',
                 _TYPES[root.get('header_type', 'UInt32')], unpackers[compressor], appended,
                 section is not None and section.get('encoding') == 'base64',
                 min(8 * MAX_VALUES, _MOST_SMALL + _MOST_RATIO * size))


def _read(file: _File, root: ElementTree.Element) -> RawModes:
    pieces = root.findall('UnstructuredGrid/Piece')
    if len(pieces) != 1:
        raise file.error(f'has {len(pieces)} pieces', 'merge them to one')
    piece = pieces[0]
    count = int(piece.attrib['NumberOfPoints'])
    points = _array(file, piece.find('Points/DataArray'), 3 * count).reshape(-1, 3)
    ids = np.arange(len(points))
    numbers, names, shapes = _modes(file, piece, 3 * count)
    grid = {element.get('Name', ''): element
            for element in root.findall('UnstructuredGrid/FieldData/DataArray')}
    stated = [_HERTZ.search(name) for name in names]
    hertz = [float(result[1]) for result in stated if result]
    frequencies = (hertz if len(hertz) == len(names)
                   else _field(file, grid, 'frequency_hz', numbers))
    return assemble(file.path, NodeField(ids, points.astype(float), 'Points'),
                    [NodeField(ids, shape.reshape(-1, 3).astype(float), f'array {name!r}')
                     for name, shape in zip(names, shapes, strict=True)],
                    frequencies, _cells(file, piece),
                    modal_masses=_field(file, grid, 'modal_mass', numbers))


def _modes(file: _File, piece: ElementTree.Element,
           size: int) -> tuple[list[int], list[str], list[FloatArray]]:
    """Return numbers, names and vectors of the arrays that are named as modes, in order."""
    arrays = {element.get('Name', ''): element for element in piece.findall('PointData/DataArray')
              if element.get('NumberOfComponents') == '3'}
    result = sorted((int(number[1]), name) for name in arrays
                    if (number := _NUMBERED.search(name)))
    numbers = [number for number, _ in result]
    if not result:
        raise file.error('has no array of vectors named as a mode, '
                         f'but {short_repr([*arrays])}', _REMEDY)
    if numbers != list(range(numbers[0], numbers[0] + len(numbers))) or numbers[0] > 1:
        raise file.error(f'has modes {short_repr(numbers)}',
                         'give all modes from 0 or 1, each once')
    if 8 * size * len(result) > file.most:
        raise file.error(f'states {len(result)} modes at {size // 3} points, which so small a '
                         'file cannot hold')
    return numbers, [name for _, name in result], [_array(file, arrays[name], size)
                                                   for _, name in result]


def _field(file: _File, grid: dict[str, ElementTree.Element], name: str,
           numbers: list[int]) -> list[float] | None:
    if name not in grid:
        return None
    return [float(value) for value in _array(file, grid[name], len(numbers))]


def _cells(file: _File, piece: ElementTree.Element) -> dict[str, IntArray]:
    arrays = {element.get('Name'): element for element in piece.findall('Cells/DataArray')}
    count = int(piece.attrib['NumberOfCells'])
    if not count:
        return {}
    types = _array(file, arrays['types'], count)
    ends = _array(file, arrays['offsets'], count).astype(np.int64)
    nodes = _array(file, arrays['connectivity'], None).astype(np.int64)
    sizes = np.diff(ends, prepend=0)
    cells = {}
    for number in np.unique(types).tolist():
        rows = types == number
        kind, size = _CELLS.get(number, ('', 0))
        if kind and np.all(sizes[rows] == size):
            cells[kind] = nodes[(ends[rows] - size)[:, None] + np.arange(size)]
        elif kind or number not in _FLAT:
            raise file.error(f'has a cell of VTK type {number} with {sizes[rows][0]} points, '
                             'which is not known', 'mesh with tetrahedra, hexahedra or wedges')
    return cells


def _array(file: _File, element: ElementTree.Element | None, size: int | None) -> Any:
    """Return the numbers of a DataArray: as many as there must be, or as there are."""
    if element is None:
        raise file.error('lacks its points or their coordinates')
    name, kind = element.get('Name', ''), _TYPES[element.attrib['type']]
    form = element.get('format', 'ascii')
    dtype = np.dtype(file.order + kind)
    if form == 'ascii':
        values = np.array((element.text or '').split(), dtype=dtype)
    elif form == 'binary':
        values = np.frombuffer(_block(file, (element.text or '').strip().encode(), True), dtype)
    else:
        at = int(element.attrib['offset'])
        values = np.frombuffer(_block(file, file.appended[at:], file.encoded), dtype)
    if size is not None and values.size != size:
        raise file.error(f'has {values.size} numbers in array {short_repr(name)}, not {size}')
    return values


def _block(file: _File, data: bytes, encoded: bool) -> bytes:
    """Return one block of data, which begins with its size or a table of sizes."""
    dtype = np.dtype(file.order + file.header)
    if file.unpack is None:
        size = int(np.frombuffer(_take(data, 0, dtype.itemsize, encoded), dtype)[0])
        alone = -(-dtype.itemsize // 3) * 4  # letters of a size that is encoded by itself
        if encoded and data[:alone].endswith(b'='):
            return _take(data[alone:], 0, size, encoded)
        return _take(data, dtype.itemsize, size, encoded)
    count = int(np.frombuffer(_take(data, 0, dtype.itemsize, encoded), dtype)[0])
    table = np.frombuffer(_take(data, 0, dtype.itemsize * (3 + count), encoded), dtype)
    whole, last, packed = int(table[1]), int(table[2]), table[3:].astype(np.int64)
    if whole * count > file.most:
        raise file.error(f'has an array of {whole * count} bytes', 'export fewer modes')
    start = dtype.itemsize * (3 + count)
    if encoded:  # the table is encoded by itself
        data, start = data[-(-start // 3) * 4:], 0
    ends = start + np.cumsum(packed)
    unpacked = [file.unpack(_take(data, int(end - size), int(size), encoded), whole)
                for end, size in zip(ends, packed, strict=True)]
    if unpacked and len(unpacked[-1]) != (last or whole):
        raise file.error('has an array that is not whole')
    return b''.join(unpacked)


def _take(data: bytes, start: int, size: int, encoded: bool) -> bytes:
    if size < 0 or size > 8 * MAX_VALUES:
        raise ValueError(f'a block of {size} bytes')
    if encoded:
        first = start // 3
        chunk = base64.b64decode(data[4 * first:4 * -(-(start + size) // 3)], validate=True)
        taken = chunk[start - 3 * first:][:size]
    else:
        taken = data[start:start + size]
    if len(taken) != size:
        raise ValueError(f'a block of {size} bytes ends after {len(taken)}')
    return taken
