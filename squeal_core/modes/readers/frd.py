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

"""CalculiX results: `.frd`, ASCII, as `*NODE FILE` writes them in a `*FREQUENCY` step."""

from dataclasses import dataclass, field
from pathlib import Path

from squeal_core.modes.readers.raw import assemble, NodeField, RawModes, ReaderError
from squeal_core.modes.readers.text import Text

# type number -> kind, and where the file has the node that ElementBlock wants next: bottom edges,
# then vertical ones, then top ones, as CalculiX writes them
_TYPES: dict[int, tuple[str, tuple[int, ...]]] = {
    1: ('hex8', tuple(range(8))), 2: ('wedge6', tuple(range(6))), 3: ('tet4', tuple(range(4))),
    4: ('hex20', (*range(12), *range(16, 20), *range(12, 16))),
    5: ('wedge15', (*range(9), *range(12, 15), *range(9, 12))),
    6: ('tet10', tuple(range(10)))}
_SURFACES = {7: 3, 8: 6, 9: 4, 10: 8, 11: 2, 12: 3}  # nodes of shells and beams, which we skip
_PER_LINE = 10
_NORMAL_MODES = 2
# the file tells neither how many sectors the ring has nor which copy of a mode is spurious: with
# 0 nodal diameters CalculiX 2.20 writes some modes twice
_WHOLE = ('solve the whole ring of 360 degrees, without *CYCLIC SYMMETRY MODEL, and give its .frd '
          'file')
_ASCII = 'write ASCII: it is what *NODE FILE gives'


@dataclass
class _Found:
    """Data read so far."""

    nodes: NodeField | None = None
    cells: dict[str, list[list[int]]] = field(default_factory=dict)
    fields: list[NodeField] = field(default_factory=list)
    frequencies_hz: list[float] = field(default_factory=list)
    masses: list[float] = field(default_factory=list)
    mass: float = 0.0  # of the mode that is next
    diameters: int = -1  # its nodal diameters in a cyclic symmetry step, else -1


def read(path: Path) -> RawModes:
    """Read a `.frd` file; static steps and other results than displacements are passed over."""
    text, result, i = Text.read(path), _Found(), 0
    while (key := text.line(i)[:6].strip()) != b'9999':
        if key == b'2C':
            i = _nodes(text, i, result)
        elif key == b'3C':
            i = _elements(text, i, result)
        elif key == b'100C':
            i = _result(text, i, result)
        else:
            if text.lines[i][:10] == b'    1PSTEP':
                result.mass, result.diameters = 0.0, -1
            elif text.lines[i][:9] == b'    1PHID':
                result.diameters = int(text.number(i, 9, 40, int))
            elif text.lines[i][:8] == b'    1PGM':
                result.mass = text.number(i, 8, 40)
            i += 1
    if result.nodes is None:
        raise ReaderError(path, 'holds no nodes (no block 2C)', 'run CalculiX with *NODE FILE')
    masses = result.masses if min(result.masses, default=0.0) > 0.0 else None
    return assemble(path, result.nodes, result.fields, result.frequencies_hz, result.cells,
                    modal_masses=masses)


def _rows(text: Text, i: int, count: int) -> range:
    """Return the rows of a block, as many as its head states, and check its end."""
    rows = range(i, i + count)
    end = text.line(i + count) if count > 0 else b''
    if end.strip() != b'-3' or any(text.lines[row][:3] != b' -1' for row in rows):
        bad = next((row for row in rows if text.lines[row][:3] != b' -1'), i + count)
        raise text.wrong(bad, f'one of the {count} rows of the block above it, or its end')
    return rows


def _field(text: Text, i: int, count: int, where: str) -> NodeField:
    rows = _rows(text, i, count)
    return NodeField(text.fixed(rows, 3, 10, 1, int)[:, 0], text.fixed(rows, 13, 12, 3), where)


def _long(text: Text, i: int, column: int) -> None:
    if text.line(i)[column:column + 2].strip() != b'1':
        raise text.error(i, f'has format {text.line(i)[column:column + 2].decode("latin-1")!r}; '
                         '1, the long ASCII one, is read', _ASCII)


def _nodes(text: Text, i: int, result: _Found) -> int:
    if result.nodes is not None:
        raise text.error(i, 'begins a second block of nodes', 'give the results of one run')
    _long(text, i, 73)
    count = int(text.number(i, 24, 36, int))
    result.nodes = _field(text, i + 1, count, f'line {i + 1}')
    return i + count + 2


def _elements(text: Text, i: int, result: _Found) -> int:
    _long(text, i, 73)
    count, i = text.number(i, 24, 36, int), i + 1
    for _ in range(count):
        if text.line(i)[:3] != b' -1':
            raise text.wrong(i, f'one of the {count} elements of its block')
        number = text.number(i, 13, 18, int)
        kind, order = _TYPES.get(number, ('', ()))
        size = len(order) or _SURFACES.get(number, 0)
        if not size:
            raise text.error(i, f'has an element of type {number}, which is not known',
                             'mesh with tetrahedra, hexahedra or wedges')
        nodes = _element_nodes(text, i + 1, size)
        if kind:
            result.cells.setdefault(kind, []).append([nodes[place] for place in order])
        i += 1 + -(-size // _PER_LINE)
    if text.line(i).strip() != b'-3':
        raise text.wrong(i, f'the end of a block of {count} elements')
    return i + 1


def _element_nodes(text: Text, i: int, size: int) -> list[int]:
    nodes: list[int] = []
    for start in range(0, size, _PER_LINE):
        line = text.line(i + start // _PER_LINE)
        if line[:3] != b' -2':
            raise text.wrong(i + start // _PER_LINE, 'a line of nodes of an element')
        nodes += (text.number(i + start // _PER_LINE, 3 + 10 * k, 13 + 10 * k, int)
                  for k in range(min(_PER_LINE, size - start)))
    return nodes


def _result(text: Text, i: int, result: _Found) -> int:
    """Read a block of results: kept if it is the displacement of a normal mode."""
    head = i
    count, kind = int(text.number(i, 24, 36, int)), text.number(i, 56, 58, int)
    i += 1
    name = text.line(i)[5:13].strip()
    while text.line(i)[:3] in (b' -4', b' -5'):
        i += 1
    modal = kind == _NORMAL_MODES and text.lines[head][63:73].strip() == b'MODAL'
    if modal and (result.diameters >= 0 or name == b'DISPI'):
        raise text.error(head, 'has a mode of one sector in cyclic symmetry (nodal diameters '
                         f'{max(result.diameters, 0)}, real and imaginary part)', _WHOLE)
    if name != b'DISP' or not modal:
        while text.line(i).strip() != b'-3':
            i += 1
        return i + 1
    _long(text, head, 73)
    result.fields.append(_field(text, i, count, f'line {head + 1}'))
    result.frequencies_hz.append(text.number(head, 12, 24))
    result.masses.append(result.mass)
    return i + count + 1
