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

"""Each reader finds the same modes again, in the layout of every package and its variants."""

from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from squeal_core.modes.fe.mass import EDGES, reference_nodes
from squeal_core.modes.nodal_modes import ElementBlock
from squeal_core.modes.readers import frd, nastran_h5, read_modes, unv
from squeal_core.modes.readers.raw import RawModes
from support.reader_samples import (
    FRD,
    HERTZ,
    IDS,
    module,
    options,
    PAD,
    RAW,
    SAMPLES,
    write_ansys,
    write_sample,
    write_table,
    write_unv,
    write_vtu,
)


@pytest.mark.parametrize('name', SAMPLES)
def test_every_format_gives_the_same_modes(name: str, tmp_path: Path) -> None:
    want = read_modes(FRD, **PAD)
    found = read_modes(write_sample(name, tmp_path), **options(name))
    np.testing.assert_allclose(found.coordinates, want.coordinates, atol=1e-8)
    np.testing.assert_allclose(found.angular_frequencies, want.angular_frequencies, rtol=2e-5)
    np.testing.assert_allclose(found.shapes, want.shapes, atol=2e-5 * np.abs(want.shapes).max())
    assert [block.kind for block in found.elements] == ['hex20'] * SAMPLES[name][2]
    for block in found.elements:
        np.testing.assert_array_equal(block.nodes, want.elements[0].nodes)


def test_the_sample_is_in_si_units() -> None:
    modes = read_modes(FRD, **PAD, density=7820.0, mass_tolerance=1e-4, total_mass=0.473046)
    assert np.hypot(*modes.coordinates[:, :2].T).min() == pytest.approx(0.1, rel=1e-5)
    assert np.count_nonzero(modes.angular_frequencies == 0.0) == 6
    assert modes.angular_frequencies[6] == pytest.approx(2 * np.pi * 3510.11, rel=1e-5)
    assert modes.source == str(FRD)


def test_raw_modes_are_in_the_units_of_the_file() -> None:
    assert isinstance(RAW, RawModes)
    assert np.ptp(RAW.coordinates[:, 2]) == 11.0
    assert RAW.modal_masses is not None
    assert RAW.modal_masses.tolist() == [1.0] * len(HERTZ)


@pytest.mark.parametrize('mark', [', ', ' ; ', '\t', '   '])
def test_separators_of_a_table(mark: str, tmp_path: Path) -> None:
    write_table(tmp_path / 'pad.txt', mark)
    np.testing.assert_allclose(read_modes(tmp_path / 'pad.txt', **PAD).shapes,
                               read_modes(FRD, **PAD).shapes)


@pytest.mark.parametrize('options', [
    {'binary': False}, {'compression': None}, {'compression': 'zlib'}, {'compression': 'lzma'},
    {'compression': None, 'header_type': 'UInt64'},
    {'compression': 'zlib', 'header_type': 'UInt64'}], ids=str)
def test_encodings_of_vtu(options: dict[str, Any], tmp_path: Path) -> None:
    write_vtu(tmp_path / 'pad.vtu', **options)
    np.testing.assert_allclose(
        read_modes(tmp_path / 'pad.vtu', **PAD, modal_mass=1.0).shapes,
        read_modes(FRD, **PAD).shapes)


def test_pyuff_reads_what_this_reads(tmp_path: Path) -> None:
    """The other direction: our layout is one that pyuff knows."""
    pyuff = module('pyuff')
    write_unv(tmp_path / 'pad.unv')
    shapes = [dataset for dataset in pyuff.UFF(str(tmp_path / 'pad.unv')).read_sets()
              if dataset.get('type') == 55]
    assert [dataset['freq'] for dataset in shapes] == pytest.approx(HERTZ, rel=1e-5)
    np.testing.assert_allclose(shapes[-1]['r3'], RAW.shapes[-1, :, 2], rtol=1e-5)


def test_the_example_of_the_manual(tmp_path: Path) -> None:
    manual = Path(__file__).parents[2] / 'docs' / 'howto' / 'modal_results.md'
    example, = re.findall(r'```csv\n(.*?)```', manual.read_text(encoding='utf-8'), re.DOTALL)
    (tmp_path / 'block.csv').write_text(example)
    modes = read_modes(tmp_path / 'block.csv')
    np.testing.assert_allclose(modes.angular_frequencies / (2 * np.pi), [0.0, 5230.5])
    assert modes.shapes[0, :, 2] == pytest.approx(np.full(8, (7850 * 1e-4)**-0.5), rel=1e-4)
    assert modes.shapes[1, :, 2].sum() == 0.0


def test_numbers_that_touch(tmp_path: Path) -> None:
    """Ansys and Fortran leave no blank before a minus that fills its column."""
    write_ansys(tmp_path / 'pad.txt')
    text = (tmp_path / 'pad.txt').read_text()
    glued = re.sub(r'(?<=E.\d\d) +-', '-', text)
    assert glued != text
    (tmp_path / 'glued.txt').write_text(glued)
    told = {**PAD, 'modal_mass': 1.0}
    np.testing.assert_array_equal(read_modes(tmp_path / 'glued.txt', **told).shapes,
                                  read_modes(tmp_path / 'pad.txt', **told).shapes)


def test_windows_line_ends(tmp_path: Path) -> None:
    for name in ('unv', 'table', 'ansys', 'abaqus', 'frd'):
        path = write_sample(name, tmp_path)
        before = read_modes(path, **options(name))
        path.write_bytes(path.read_bytes().replace(b'\n', b'\r\n'))
        np.testing.assert_array_equal(read_modes(path, **options(name)).shapes, before.shapes)


def test_nodes_in_any_order_and_nodes_without_results(tmp_path: Path) -> None:
    """A reference node that no mode moves is left out; the order is that of the nodes."""
    write_unv(tmp_path / 'pad.unv')
    lines = (tmp_path / 'pad.unv').read_text().split('\n')
    start = lines.index('  2411') + 1
    pairs = [lines[i:i + 2] for i in range(start, start + 2 * len(IDS), 2)]
    pairs = [*pairs[::-1], [f'{9999:10d}' + pairs[0][0][10:], pairs[0][1]]]
    lines[start:start + 2 * len(IDS)] = sum(pairs, [])
    (tmp_path / 'other.unv').write_text('\n'.join(lines))
    found, want = (read_modes(tmp_path / name, **PAD) for name in ('other.unv', 'pad.unv'))
    np.testing.assert_array_equal(found.coordinates, want.coordinates[::-1])
    np.testing.assert_allclose(found.shapes, want.shapes[:, ::-1], rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(found.coordinates[found.elements[0].nodes],
                                  want.coordinates[want.elements[0].nodes])


def test_vtu_of_today(tmp_path: Path) -> None:
    """Version 2.2, appended raw data, big endian, frequencies in field data: VTK may."""
    blocks, arrays = b'', []

    def array(name: str, kind: str, values: Any, components: int = 1) -> str:
        nonlocal blocks
        data = np.asarray(values, dtype={'Float64': '>f8', 'Int64': '>i8', 'UInt8': 'u1'}[kind])
        offset, blocks = len(blocks), blocks + np.array(
            data.nbytes, '>u8').tobytes() + data.tobytes()
        arrays.append(name)
        return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" '
                f'format="appended" offset="{offset}"/>')

    nodes = RAW.elements[0].nodes
    shapes = [array(f'displacement EigenMode{k + 1}', 'Float64', shape, 3)
              for k, shape in enumerate(RAW.shapes)]
    text = (
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="2.2" byte_order='
        '"BigEndian" header_type="UInt64"><UnstructuredGrid><FieldData>'
        f'{array("frequency_hz", "Float64", HERTZ)}'
        f'{array("modal_mass", "Float64", np.ones(len(HERTZ)))}</FieldData>'
        f'<Piece NumberOfPoints="{len(RAW.coordinates)}" NumberOfCells="{len(nodes)}">'
        f'<PointData>{"".join(shapes)}</PointData>'
        f'<Points>{array("Points", "Float64", RAW.coordinates, 3)}</Points>'
        f'<Cells>{array("connectivity", "Int64", nodes)}'
        f'{array("offsets", "Int64", 20 * np.arange(1, len(nodes) + 1))}'
        f'{array("types", "UInt8", np.full(len(nodes), 25))}</Cells></Piece></UnstructuredGrid>'
        '<AppendedData encoding="raw">_')
    path = tmp_path / 'pad.vtu'
    path.write_bytes(text.encode() + blocks + b'</AppendedData></VTKFile>\n')
    found, want = read_modes(path, **PAD), read_modes(FRD, **PAD)
    np.testing.assert_array_equal(found.shapes, want.shapes)
    np.testing.assert_array_equal(found.elements[0].nodes, nodes)


# Elements in the words of the manuals: corners by number, mid-edge nodes by their two corners.
# Nastran and CalculiX have the corners first, then the middles of bottom, sides and top.
CORNER_FIRST = {
    'tet10': '0 1 2 3 01 12 20 03 13 23', 'tet4': '0 1 2 3', 'wedge6': '0 1 2 3 4 5',
    'hex8': '0 1 2 3 4 5 6 7',
    'wedge15': '0 1 2 3 4 5 01 12 20 03 14 25 34 45 53',
    'hex20': '0 1 2 3 4 5 6 7 01 12 23 30 04 15 26 37 45 56 67 74'}
ROUND_AND_ROUND = {
    'tet10': '0 01 1 12 2 20 03 13 23 3', 'tet4': '0 1 2 3', 'wedge6': '0 1 2 3 4 5',
    'hex8': '0 1 2 3 4 5 6 7',
    'wedge15': '0 01 1 12 2 20 03 14 25 3 34 4 45 5 53',
    'hex20': '0 01 1 12 2 23 3 30 04 15 26 37 4 45 5 56 6 67 7 74'}


def one_element(kind: str, order: str) -> np.ndarray:
    """Places of the nodes of a skewed element, in the order that is given in words."""
    shape = kind.rstrip('0123456789')
    corners = reference_nodes({'tet': 'tet4', 'hex': 'hex8', 'wedge': 'wedge6'}[shape])
    corners = corners @ np.array([[1.0, 0.1, 0.2], [0.0, 0.9, 0.3], [0.1, 0.0, 1.1]])
    return np.array([corners[[int(c) for c in word]].mean(axis=0) for word in order.split()])


def check_order(raw: RawModes, kind: str) -> None:
    """Mid-edge nodes lie between the corners that ElementBlock says they lie between."""
    shape = kind.rstrip('0123456789')
    block, = raw.elements
    assert block.kind == kind
    where = raw.coordinates[block.nodes[0]]
    count = 4 if shape == 'tet' else 8 if shape == 'hex' else 6
    middles = [where[list(ends)].mean(axis=0) for ends in EDGES[shape]]
    np.testing.assert_allclose(where[:count], one_element(kind, CORNER_FIRST[kind])[:count],
                               atol=1e-5)
    if len(where) > count:
        np.testing.assert_allclose(where[count:], middles, atol=1e-5)


@pytest.mark.parametrize(('kind', 'descriptor'), [
    ('tet4', 111), ('wedge6', 112), ('wedge15', 113), ('hex8', 115), ('hex20', 116),
    ('tet10', 118)])
def test_elements_of_unv(kind: str, descriptor: int, tmp_path: Path) -> None:
    places = one_element(kind, ROUND_AND_ROUND[kind])
    n = len(places)
    lines = ['    -1', '  2411']
    for k, place in enumerate(places):
        lines += [f'{k + 1:10d}{0:10d}{0:10d}{0:10d}', ''.join(f'{c:25.16E}' for c in place)]
    lines += ['    -1', '    -1', '  2412', f'{1:10d}{descriptor:10d}{1:10d}{1:10d}{7:10d}{n:10d}']
    lines += [''.join(f'{k + 1:10d}' for k in range(start, min(start + 8, n)))
              for start in range(0, n, 8)]
    lines += ['    -1', '    -1', '    55', *['NONE'] * 5, f'{1:10d}{2:10d}{2:10d}{8:10d}{2:10d}'
              f'{3:10d}', f'{2:10d}{4:10d}{1:10d}{1:10d}', f'{7.0:13.5E}{1.0:13.5E}']
    for k in range(n):
        lines += [f'{k + 1:10d}', f'{k:13.5E}{0.0:13.5E}{0.0:13.5E}']
    path = tmp_path / 'one.unv'
    path.write_text('\n'.join([*lines, '    -1']))
    check_order(unv.read(path), kind)


@pytest.mark.parametrize(('kind', 'number'), [
    ('hex8', 1), ('wedge6', 2), ('tet4', 3), ('hex20', 4), ('wedge15', 5), ('tet10', 6)])
def test_elements_of_frd(kind: str, number: int, tmp_path: Path) -> None:
    places = one_element(kind, CORNER_FIRST[kind])
    n = len(places)
    lines = ['    1C', f'    2C{n:30d}{1:38d}']
    lines += [f' -1{k + 1:10d}' + ''.join(f'{c:12.5E}' for c in place)
              for k, place in enumerate(places)]
    lines += [' -3', f'    3C{1:30d}{1:38d}', f' -1{1:10d}{number:5d}{0:5d}{1:5d}']
    lines += [' -2' + ''.join(f'{k + 1:10d}' for k in range(i, min(i + 10, n)))
              for i in range(0, n, 10)]
    lines += [' -3', f'  100CL  101{7.0:12.5E}{n:12d}{"":20}{2:2d}{1:5d}{"MODAL":10}{1:2d}',
              ' -4  DISP        4    1', ' -5  D1          1    2    1    0']
    lines += [f' -1{k + 1:10d}' + f'{k:12.5E}{0.0:12.5E}{0.0:12.5E}' for k in range(n)]
    path = tmp_path / 'one.frd'
    path.write_text('\n'.join([*lines, ' -3', ' 9999']))
    check_order(frd.read(path), kind)


@pytest.mark.parametrize(('kind', 'element', 'size'), [
    ('hex8', 'CHEXA', 20), ('hex20', 'CHEXA', 20), ('wedge6', 'CPENTA', 15),
    ('wedge15', 'CPENTA', 15), ('tet4', 'CTETRA', 10), ('tet10', 'CTETRA', 10)])
def test_elements_of_nastran(kind: str, element: str, size: int, tmp_path: Path) -> None:
    places = one_element(kind, CORNER_FIRST[kind])
    nodes = np.zeros((1, size), int)
    nodes[0, :len(places)] = np.arange(len(places)) + 1
    found = nastran_h5.by_kind(tmp_path, element, np.array([7]), nodes)
    blocks = tuple(ElementBlock(name, named - 1) for name, named in found.items())
    check_order(RawModes(places, None, places[None], blocks), kind)
