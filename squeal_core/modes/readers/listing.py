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
Node listings as Abaqus and Ansys print them: coordinates, then displacements of each mode.

Ansys: NLIST, and PRNSOL,U,COMP of each mode. Abaqus: the *NODE lines of the input file, and
field output reports of U at nodes, one frame after another. Several outputs may be joined into
one file, in any order; page heads and minima are passed over.
"""

from dataclasses import dataclass, field
from pathlib import Path
import re

import numpy as np
from squeal_core.common.errors import short_repr
from squeal_core.modes.readers.raw import assemble, NodeField, RawModes, ReaderError
from squeal_core.modes.readers.text import Text

# names of columns -> the component that they are; others (USUM, THXY, U.Magnitude) are left out
_COORDINATES = {'X': 0, 'Y': 1, 'Z': 2, 'COORD.COOR1': 0, 'COORD.COOR2': 1, 'COORD.COOR3': 2}
_SHAPES = {'UX': 0, 'UY': 1, 'UZ': 2, 'U.U1': 0, 'U.U2': 1, 'U.U3': 2}
_FRAME = re.compile(r'\bMODE\s+(\d+)\s*:.*?\bFREQ\s*=\s*([-+.\dE]+)')  # Abaqus
_STEP = re.compile(r'\bLOAD STEP=\s*(\d+)\s+SUBSTEP=\s*(\d+)')  # Ansys, and then:
_FREQUENCY = re.compile(r'^\s*FREQ\s*=\s*([-+.\dE]+)')
_TIME = re.compile(r'^\s*TIME\s*=')
_GLUED = re.compile(r'(?<=[\d.])(?=[-+])')  # a full column leaves no blank before a minus
_ROW = re.compile(r'\s*\d+[\s,]')
_NOT_READ = 'this layout is not read'
_LAYOUTS = ('these are: NLIST and PRNSOL,U,COMP of Ansys, *NODE lines and reports of U of Abaqus, '
            'and the table of docs/howto/modal_results.md')
_REMEDY = 'see docs/howto/modal_results.md for what to print'
_PLAIN_NAME = re.compile(r'[A-Z_][A-Z\d_.-]*|@LOC|\d+')
_WHOLE = 'solve the whole ring of 360 degrees without cyclic symmetry, and list its modes'
_REAL = 'list real normal modes, without damping, friction and rotation'
# patterns of lines on nodes or results that are not global, Cartesian, real and whole
_REFUSED: tuple[tuple[re.Pattern[str], str, str], ...] = (
    (re.compile(r'\bDSYS\s*=\s*0*[1-9]\d*'), 'lists nodes in another coordinate system than the '
     'global Cartesian one', 'list them after DSYS,0'),
    (re.compile(r'\bRSYS\s*=\s*(?!0+\b)\w|\bIN (?!(THE )?(GLOBAL (CARTESIAN )?)?'
                r'COORDINATE SYSTEMS?\s*[#=]?\s*(0|$))[A-Z ]*COORDINATE SYSTEM'),
     'lists results in another coordinate system than the global Cartesian one',
     'list them after RSYS,0'),
    (re.compile(r'^\s*\*NODE\b.*\bSYSTEM\s*=\s*[CS]'), 'lists nodes in cylindrical or spherical '
     'coordinates', 'list them in the global Cartesian system'),
    (re.compile(r'^\s*NODE\b.*CSYS'), 'lists results in a coordinate system of the user',
     'report them without a transformation'),
    (re.compile(r'HARMONIC INDEX|\bHRM-INDEX|NODAL DIAMETER|CYCLIC (SYMMETRY|SECTOR|EXPANSION)'),
     'belongs to a cyclic symmetry analysis: a sector, or half of a doublet', _WHOLE),
    (re.compile(r'^\s*(REAL|IMAG\w*) (ONLY|PART|COMPONENT)|^\s*COMPLEX\s*:|'
                r'\bMODE\s+\d+\s*:.*(\bDAMP|\bRE\(|COMPLEX)'),
     'belongs to complex modes', _REAL))
# keywords of Abaqus after which numbers move or turn the nodes: each with its effect
_MOVED = {'*SYSTEM': 'gives nodes in a system of its own', '*INSTANCE': 'moves its nodes'}


@dataclass
class _Section:
    """Columns that are being read: of a table of coordinates or of one mode."""

    columns: tuple[int, ...] = ()
    width: int = 0
    rows: list[list[float]] | None = None


@dataclass
class _Found:
    """Data read so far."""

    coordinates: list[list[float]] = field(default_factory=list)
    modes: dict[tuple[str, ...], list[list[float]]] = field(default_factory=dict)
    frequencies_hz: dict[tuple[str, ...], float] = field(default_factory=dict)
    mode: tuple[str, ...] | None = None
    step: tuple[str, ...] = ()


def read(path: Path) -> RawModes:
    """Read a listing."""
    return read_text(Text.read(path))


def read_text(text: Text) -> RawModes:
    """Read the lines of a listing."""
    result, section = _Found(), _Section()
    for i, raw in enumerate(text.lines):
        line = raw.decode('latin-1').upper()
        if section.rows is not None and _ROW.match(line):
            section.rows.append(_row(text, i, line, section))
        elif line.strip(' ,\t'):
            section = _next(text, i, line, result, section)
    if not result.coordinates:
        raise ReaderError(text.path, f'holds no table of coordinates: {_NOT_READ}', _LAYOUTS)
    if not result.modes:
        raise ReaderError(text.path, 'holds no table of displacements below a frequency: '
                          f'{_NOT_READ}', _LAYOUTS)
    fields = [_field(rows, f'mode {" substep ".join(mode)}')
              for mode, rows in result.modes.items()]
    return assemble(text.path, _field(result.coordinates, 'table of coordinates'), fields,
                    list(result.frequencies_hz.values()), {})


def _field(rows: list[list[float]], where: str) -> NodeField:
    table = np.array(rows).reshape(-1, 4)
    return NodeField(table[:, 0].astype(np.int64), table[:, 1:], where)


def _next(text: Text, i: int, line: str, result: _Found, section: _Section) -> _Section:
    """Return the section after a line that is no row of numbers: begun, ended or unchanged."""
    words = line.replace(',', ' ').split()
    _check_kind(text, i, line)
    if line.partition(',')[0].strip() == '*NODE':  # not *NODE OUTPUT
        return _Section((0, 1, 2), 3, result.coordinates)
    if words[0] == 'NODE' and len(words) > 1 and not words[1].isdigit():
        return _head(text, i, words[1:], result)
    if words[0].startswith('**') or words[0] == 'LABEL' or not line.strip(' -\t'):
        return section
    if step := _STEP.search(line):
        result.step, result.mode = step.groups(), None
    elif frame := _FRAME.search(line):
        _begin(text, i, (frame[1],), frame[2], result)
    elif frequency := _FREQUENCY.search(line):
        _begin(text, i, result.step, frequency[1], result)
    elif _TIME.search(line):
        result.mode = None
    return _Section()


def _check_kind(text: Text, i: int, line: str) -> None:
    """Refuse nodes and results that are not what this reads, by what the line says of them."""
    for pattern, what, remedy in _REFUSED:
        if pattern.search(line):
            raise text.error(i, f'{what} ({short_repr(line.strip())})', remedy)
    keyword = line.partition(',')[0].strip()
    following = text.lines[i + 1].strip() if i + 1 < len(text.lines) else b''
    if keyword in _MOVED and following and not following.startswith(b'*'):
        raise text.error(i, f'{_MOVED[keyword]} ({keyword})',
                         'list the nodes where the results have them, in the global system')


def _begin(text: Text, i: int, mode: tuple[str, ...], frequency: str, result: _Found) -> None:
    """Begin a mode, or a further page of it."""
    value = _number(text, i, frequency)
    if result.frequencies_hz.setdefault(mode, value) != value:
        raise text.error(i, f'gives {value} Hz to mode {" substep ".join(mode)}, which had '
                         f'{result.frequencies_hz[mode]} Hz above', 'join listings of one run')
    result.mode = mode
    result.modes.setdefault(mode, [])


def _head(text: Text, i: int, names: list[str], result: _Found) -> _Section:
    for known in (_COORDINATES, _SHAPES):
        places = {known[name]: k for k, name in enumerate(names) if name in known}
        if len(places) < 3:
            continue
        if not all(_PLAIN_NAME.fullmatch(name) for name in names):
            raise text.error(i, f'has the heading {short_repr(text.line(i).decode("latin-1"))}: '
                             f'{_NOT_READ}', _LAYOUTS)
        if known is _SHAPES and result.mode is None:
            raise text.error(i, 'begins displacements with no frequency above them',
                             'print the results of a modal analysis')
        rows = result.coordinates if known is _COORDINATES else result.modes[result.mode or ()]
        return _Section((places[0], places[1], places[2]), len(names), rows)
    return _Section()


def _row(text: Text, i: int, line: str, section: _Section) -> list[float]:
    words = _GLUED.sub(' ', line).replace(',', ' ').split()
    if not max(section.columns) + 2 <= len(words) <= section.width + 1:
        what = f'has {len(words)} numbers, not {section.width + 1}'
        raise (text.error(i, what, _REMEDY) if section.rows else
               text.error(i, f'{what}: {_NOT_READ}', _LAYOUTS))
    if len(words[0]) > 15:
        raise text.error(i, f'has node number {short_repr(words[0])}', 'number nodes below 1e15')
    return [int(words[0]), *(_number(text, i, words[1 + k]) for k in section.columns)]


def _number(text: Text, i: int, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise text.error(i, f'has {short_repr(word)}, not a number', _REMEDY) from None
