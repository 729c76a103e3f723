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
The same modes in the layout of every package, for the tests of the readers; no tests here.

The modes are CalculiX's of a coarse pad (test/data/readers/pad.frd: C3D20, mm, t, s). Writers are
those of other projects where there are any, else the layouts are set down here by the manuals.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
import struct
from typing import Any

import numpy as np
import pytest
from squeal_core.modes.readers import frd, read_modes, ReaderError

FRD = Path(__file__).parents[1] / 'data' / 'readers' / 'pad.frd'
RAW = frd.read(FRD)
IDS = 10 + 3 * np.arange(len(RAW.coordinates))  # numbers with gaps
HEX = RAW.elements[0].nodes
HERTZ = [float(f) for f in RAW.frequencies_hz]  # type: ignore[union-attr]
PAD = {'length_unit': 'mm', 'mass_unit': 't'}

# a hexahedron's 20 nodes as ElementBlock numbers them, in the order of other files
ROUND = [0, 8, 1, 9, 2, 10, 3, 11, 16, 17, 18, 19, 4, 12, 5, 13, 6, 14, 7, 15]  # UNV
SIDES_FIRST = [*range(12), *range(16, 20), *range(12, 16)]  # Nastran, CalculiX


def module(name: str) -> Any:
    """Return an optional package, or skip: pyNastran fails by more than ImportError."""
    try:
        return __import__(name, fromlist=['_'])
    except Exception as error:
        pytest.skip(f'{name} cannot be imported: {error}')


def write_frd(path: Path) -> None:
    path.write_bytes(FRD.read_bytes())


def ints(*values: int, width: int = 10) -> str:
    """Return a record of integers, as Fortran writes it."""
    return ''.join(f'{value:{width}d}' for value in values)


def reals(*values: float, width: int = 13, digits: int = 5) -> str:
    """Return a record of real numbers, as Fortran writes it."""
    return ''.join(f'{value:{width}.{digits}E}' for value in values)


def dataset(number: int, *records: str) -> list[str]:
    mark = ints(-1, width=6)
    return [mark, ints(number, width=6), *records, mark]


def write_unv(path: Path) -> None:
    """Nodes in double precision with D exponents, as I-DEAS and Permas write them; 2412; 55."""
    units = f'{5:10d}{"MM (milli newton)":>20}{2:10d}'
    lines = dataset(164, units, reals(1000.0, 1000.0, 1.0, width=25, digits=16),
                    reals(273.15, width=25, digits=16))
    lines.append('free text between datasets')
    nodes = [(ints(number, 1, 1, 11), reals(*point, width=25, digits=16).replace('E', 'D'))
             for number, point in zip(IDS, RAW.coordinates, strict=True)]
    lines += dataset(2411, *(record for node in nodes for record in node))
    records = [ints(900, 21, 1, 1, 7, 2), ints(0, 1, 1), ints(*IDS[:2])]  # a beam
    for k, corners in enumerate(IDS[HEX][:, ROUND]):
        records += [ints(k + 1, 116, 1, 1, 7, 20), ints(*corners[:8]), ints(*corners[8:16]),
                    ints(*corners[16:])]
    lines += dataset(2412, *records)
    for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True)):
        records = [ints(1, 2, 3, 8, 2, 6), ints(2, 4, 1, k + 1), reals(hertz, 1.0, 0.0, 0.0)]
        for number, vector in zip(IDS, shape, strict=True):
            records += [ints(number), reals(*vector, 0.0, 0.0, 0.0)]
        lines += dataset(55, *['NONE'] * 5, *records)
    path.write_text('\n'.join(lines) + '\n')


def write_unv_2414(path: Path) -> None:
    """Nodes in dataset 15, shapes in 2414, as later exports have them."""
    lines = dataset(15, *(ints(number, 0, 0, 8) + reals(*point)
                          for number, point in zip(IDS, RAW.coordinates, strict=True)))
    for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True)):
        records = [ints(1, 2, 2, 8, 2, 3), ints(0, 0, 1, 0, 1, k + 1, 0, 0), ints(0, 0),
                   reals(0.0, hertz, 0.0, 1.0, 0.0, 0.0), reals(*[0.0] * 6)]
        for number, vector in zip(IDS, shape, strict=True):
            records += [ints(number), reals(*vector)]
        lines += dataset(2414, ints(k + 1), 'mode', ints(1), *['NONE'] * 5, *records)
    path.write_text('\n'.join(lines) + '\n')


def write_pyuff(path: Path) -> None:
    pyuff = module('pyuff')
    x, y, z = RAW.coordinates.T
    zero = np.zeros(len(IDS), int)
    sets: list[dict[str, Any]] = [{
        'type': 15, 'node_nums': IDS, 'def_cs': zero, 'disp_cs': zero, 'color': zero,
        'x': x, 'y': y, 'z': z}]
    sets += [{'type': 55, 'analysis_type': 2, 'data_ch': 2, 'spec_data_type': 8, 'load_case': 1,
              'mode_n': k + 1, 'freq': hertz, 'modal_m': 1.0, 'node_nums': IDS,
              'r1': shape[:, 0], 'r2': shape[:, 1], 'r3': shape[:, 2]}
             for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True))]
    pyuff.UFF(str(path)).write_sets(sets, mode='overwrite')


def write_nastran_h5(path: Path) -> None:
    """MSC Nastran's tables, by its schema."""
    h5py = module('h5py')
    n, m = RAW.shapes.shape[:2]
    grid = np.zeros(m, [('ID', 'i8'), ('CP', 'i8'), ('X', 'f8', 3), ('CD', 'i8'), ('PS', 'i8'),
                        ('SEID', 'i8'), ('DOMAIN_ID', 'i8')])
    grid['ID'], grid['X'] = IDS, RAW.coordinates
    hexa = np.zeros(len(HEX), [('EID', 'i8'), ('PID', 'i8'), ('G', 'i8', 20), ('DOMAIN_ID', 'i8')])
    hexa['EID'], hexa['G'] = np.arange(len(HEX)) + 1, IDS[HEX][:, SIDES_FIRST]
    domains = np.zeros(n + 1, [('ID', 'i8'), ('SUBCASE', 'i8'), ('STEP', 'i8'), ('ANALYSIS', 'i8'),
                               ('TIME_FREQ_EIGR', 'f8'), ('EIGI', 'f8'), ('MODE', 'i8')])
    domains['ID'], domains['SUBCASE'] = np.arange(n + 1) + 1, 1
    domains['ANALYSIS'][1:], domains['MODE'][1:] = 2, np.arange(n) + 1
    components = ('X', 'Y', 'Z', 'RX', 'RY', 'RZ')
    vectors = np.zeros(n * m, [('ID', 'i8'), *((c, 'f8') for c in components),
                               ('DOMAIN_ID', 'i8')])
    vectors['ID'], vectors['DOMAIN_ID'] = np.tile(IDS, n), np.repeat(domains['ID'][1:], m)
    for k, name in enumerate('XYZ'):
        vectors[name] = RAW.shapes[:, :, k].ravel()
    values = np.zeros(n, [('MODE', 'i8'), ('ORDER', 'i8'), ('EIGEN', 'f8'), ('OMEGA', 'f8'),
                          ('FREQ', 'f8'), ('MASS', 'f8'), ('STIFF', 'f8'), ('DOMAIN_ID', 'i8')])
    values['MODE'], values['FREQ'], values['MASS'] = np.arange(n) + 1, HERTZ, 1.0
    with h5py.File(path, 'w') as file:
        for name, table in (('INPUT/NODE/GRID', grid), ('INPUT/ELEMENT/CHEXA', hexa),
                            ('RESULT/DOMAINS', domains), ('RESULT/NODAL/EIGENVECTOR', vectors),
                            ('RESULT/SUMMARY/EIGENVALUE', values)):
            file.create_dataset(f'/NASTRAN/{name}', data=table, compression='gzip')


def write_op2(path: Path, *, geometry: bool = True) -> None:
    """By pyNastran, which leaves the table of eigenvalues (LAMA) out: it is put in its place."""
    geom = module('pyNastran.op2.op2_geom')
    vectors = module('pyNastran.op2.tables.oug.oug_eigenvectors').RealEigenvectorArray
    model = geom.OP2Geom(debug=None, mode='msc')
    model.date = (1, 2, 2003)
    for number, point in zip(IDS.tolist(), RAW.coordinates if geometry else [], strict=geometry):
        model.add_grid(number, point)
    for k, nodes in enumerate(IDS[HEX][:, SIDES_FIRST].tolist() if geometry else []):
        model.add_chexa(k + 1, 1, nodes)
    n, m = RAW.shapes.shape[:2]
    squares = (2 * np.pi * np.array(HERTZ))**2
    both = np.concatenate([RAW.shapes, np.zeros_like(RAW.shapes)], axis=2).astype('f4')
    points = np.stack([IDS, np.ones(m, int)], axis=1)
    table = vectors.add_modal_case('OUGV1', points, both, 1, np.arange(n) + 1, squares, HERTZ)
    table.table_code = 7
    model.eigenvectors[1] = table
    model.write_op2(str(path), nastran_format='msc')
    data = path.read_bytes()
    at = data.index(b'OUGV1   ') - 16
    path.write_bytes(data[:at] + _lama(squares) + data[at:])


def _lama(squares: np.ndarray) -> bytes:
    """Fortran records: a name, two heads, then seven words for each mode."""
    def record(payload: bytes) -> bytes:
        words = struct.pack('<3i', 4, len(payload) // 4, 4)
        return words + struct.pack('<i', len(payload)) + payload + struct.pack('<i', len(payload))

    def marks(*values: int) -> bytes:
        return b''.join(struct.pack('<3i', 4, value, 4) for value in values)

    head = struct.pack('<50i', 22, 6, 0, 1, *[0] * 46) + b' ' * 384
    rows = b''.join(struct.pack('<2i5f', k + 1, k + 1, s, s**0.5, f, 1.0, s)
                    for k, (s, f) in enumerate(zip(squares, HERTZ, strict=True)))
    return (record(b'LAMA    ') + marks(-1) + record(struct.pack('<7i', 102, 0, 0, 0, 512, 0, 0))
            + marks(-2, 1, 0) + record(b'LAMA    ' + struct.pack('<5i', 1, 2, 3, 0, 1))
            + marks(-3, 1, 0) + record(head) + marks(-4, 1, 0) + record(rows)
            + marks(-5, 1, 0, 0))


def write_table(path: Path, mark: str = ', ') -> None:
    lines = ['# a pad', mark.join(['frequency_hz', *map(repr, HERTZ)]),
             mark.join(['modal_mass', *['1'] * len(HERTZ)]),
             mark.join(['node', 'x', 'y', 'z', *(f'{c}_{k + 1}' for k in range(len(HERTZ))
                                                 for c in ('ux', 'uy', 'uz'))]), '']
    lines += [mark.join(map(repr, [number, *point, *shape]))
              for number, point, shape in zip(IDS.tolist(), RAW.coordinates.tolist(),
                                              np.hstack(RAW.shapes).tolist(), strict=True)]
    path.write_text('\n'.join(lines) + '\n')


def write_ansys(path: Path) -> None:
    """NLIST and PRNSOL,U,COMP, with a new page every 30 nodes."""
    lines = [' LIST ALL SELECTED NODES.   DSYS=      0', ' SORT TABLE ON  NODE  NODE  NODE', '']
    pages = list(pairwise([*range(0, len(IDS), 30), len(IDS)]))
    for start, stop in pages:
        lines += ['', '    NODE        X             Y             Z           THXY    THYZ  '
                  '  THZX']
        lines += [ints(IDS[i], width=9) + reals(*RAW.coordinates[i], width=16, digits=8)
                  + '    0.00    0.00    0.00' for i in range(start, stop)]
    for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True)):
        for start, stop in pages:
            lines += ['', ' PRINT U    NODAL SOLUTION PER NODE', '',
                      '  ***** POST1 NODAL DEGREE OF FREEDOM LISTING *****', '',
                      f'  LOAD STEP=     1  SUBSTEP={k + 1:6d}',
                      f'   FREQ=  {hertz:10.5G}    LOAD CASE=   0', '',
                      '  THE FOLLOWING DEGREE OF FREEDOM RESULTS ARE IN THE GLOBAL COORDINATE '
                      'SYSTEM', '', '    NODE       UX           UY           UZ           USUM']
            lines += [ints(IDS[i], width=8) + reals(*shape[i], np.linalg.norm(shape[i]))
                      for i in range(start, stop)]
        lines += ['', ' MAXIMUM ABSOLUTE VALUES', ' NODE         10         13         16    19',
                  ' VALUE   0.93214E-02 0.93214E-02 0.93214E-02 0.93214E-02']
    path.write_text('\n'.join(lines) + '\n')


def write_abaqus(path: Path) -> None:
    """Nodes of the input file, and a field output report of each frame."""
    lines = ['*Heading', '** a pad', '*Node, nset=PAD']
    lines += [f'{number:7d}, ' + ', '.join(f'{c:13.8g}' for c in point)
              for number, point in zip(IDS, RAW.coordinates, strict=True)]
    lines += ['*Element, type=C3D20', '1, 10, 13, 16, 19, 22, 25, 28, 31']
    for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True)):
        value = (2 * np.pi * hertz)**2
        lines += ['*' * 80, 'Field Output Report, written Fri Jan  2 03:04:05 2015', '',
                  'Source 1', '---------', '', '   ODB: pad.odb', '   Step: Step-1',
                  f'   Frame: Mode {k + 1:9d}: Value = {value:11.5G} Freq = {hertz:11.7G} '
                  '(cycles/time)', '', 'Loc 1 : Nodal values from source 1', '',
                  'Output sorted by column "Node Label".', '',
                  'Field Output reported at nodes for part: PART-1-1', '',
                  f'{"Node":>16}' + ''.join(f'{name:>16}' for name in (
                      'U.Magnitude', 'U.U1', 'U.U2', 'U.U3')),
                  f'{"Label":>16}' + f'{"@Loc 1":>16}' * 4, '-' * 80]
        lines += [ints(number, width=16)
                  + reals(np.linalg.norm(vector), *vector, width=16, digits=6)
                  for number, vector in zip(IDS, shape, strict=True)]
        lines += ['', '', '  Minimum     12.E-03    -12.E-03', '      At Node              31', '']
    path.write_text('\n'.join(lines) + '\n')


def write_vtu(path: Path, **options: Any) -> None:
    meshio = module('meshio')
    arrays = {f'mode_{k + 1}_{hertz!r}Hz': shape
              for k, (hertz, shape) in enumerate(zip(HERTZ, RAW.shapes, strict=True))}
    mesh = meshio.Mesh(RAW.coordinates, [('hexahedron20', HEX)],
                       point_data={'other': RAW.coordinates[:, 0], **arrays})
    meshio.vtu.write(str(path), mesh, **options)


# name of a sample -> its suffix, how it is written, whether it holds elements and modal masses
SAMPLES: dict[str, tuple[str, Callable[[Path], None], bool, bool]] = {
    'frd': ('.frd', write_frd, True, True), 'unv': ('.unv', write_unv, True, True),
    'unv_2414': ('.unv', write_unv_2414, False, True),
    'pyuff': ('.uff', write_pyuff, False, True),
    'nastran_h5': ('.h5', write_nastran_h5, True, True), 'op2': ('.op2', write_op2, True, True),
    'table': ('.csv', write_table, False, True), 'ansys': ('.txt', write_ansys, False, False),
    'abaqus': ('.rpt', write_abaqus, False, False), 'vtu': ('.vtu', write_vtu, True, False)}


def write_sample(name: str, folder: Path) -> Path:
    """Return the path of a sample that was written to a folder."""
    suffix, write, _, _ = SAMPLES[name]
    path = folder / f'{name}{suffix}'
    write(path)
    return path


def options(name: str) -> dict[str, Any]:
    """Return what a reader must be told about a sample."""
    return PAD if SAMPLES[name][3] else {**PAD, 'modal_mass': 1.0}


def refusal(path: Path, **told: Any) -> str:
    """Return the one line that a file gives; its path is cut off."""
    with pytest.raises(ReaderError) as caught:
        read_modes(path, **told)
    text = str(caught.value)
    assert text.startswith(str(path))
    assert '\n' not in text
    assert '; ' in text
    assert len(text) < 400 + len(str(path))
    return text.removeprefix(str(path)).removeprefix(': ').removeprefix(', ')
