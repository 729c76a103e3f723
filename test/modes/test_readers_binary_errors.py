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

"""What HDF5, OP2 and VTU files say of a change in a sample."""

from collections.abc import Callable
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from support.reader_samples import (
    HERTZ,
    module,
    options,
    RAW,
    refusal,
    write_nastran_h5,
    write_op2,
    write_sample,
    write_vtu,
)

GRID = '/NASTRAN/INPUT/NODE/GRID'
HEXA = '/NASTRAN/INPUT/ELEMENT/CHEXA'
VECTORS = '/NASTRAN/RESULT/NODAL/EIGENVECTOR'
VALUES = '/NASTRAN/RESULT/SUMMARY/EIGENVALUE'
DOMAINS = '/NASTRAN/RESULT/DOMAINS'


def changed(field: str, at: Any, value: Any) -> Callable[[np.ndarray], np.ndarray]:
    def change(table: np.ndarray) -> np.ndarray:
        table[field][at] = value
        return table
    return change


def rewritten(folder: Path, name: str, change: Callable[[np.ndarray], np.ndarray] | None) -> Path:
    """Return a sample with one table changed, or gone."""
    path = folder / 'pad.h5'
    write_nastran_h5(path)
    with module('h5py').File(path, 'r+') as file:
        table = file[name][()]
        del file[name]
        if change is not None:
            file[name] = change(table)
    return path


@pytest.mark.parametrize(('name', 'change', 'message'), [
    (GRID, None, rf'holds no table {GRID}; ask Nastran for HDF5OUT with DISPLACEMENT'),
    (VECTORS, None, rf'holds no table {VECTORS}; ask|holds no real normal modes'),
    (VALUES, None, rf'holds no table {VALUES}'),
    (VALUES, lambda t: t[['MODE', 'EIGEN', 'FREQ']].copy(),
     rf'{VALUES}: has no field MASS; ask Nastran'),
    (VALUES, lambda t: t[1:], 'gives no frequency of mode 1; ask Nastran'),
    (DOMAINS, changed('MODE', 2, 1), 'holds modes of more than one subcase; export one'),
    (GRID, changed('CP', 3, 4), 'grid point 19: is given in coordinate systems CP 4, CD 0; the b'),
    (GRID, changed('CD', 0, 2), 'grid point 10: is given in coordinate systems CP 0, CD 2'),
    (GRID, changed('ID', 1, 10), 'table GRID: names node 10 2 times'),
    (GRID, changed('X', 1, np.nan), r'table GRID: has \[nan, nan, nan\] at node 13, which is not'),
    (GRID, lambda t: t[:-1], r'has a hex20 with node \d+, which no mode moves'),
    (VECTORS, lambda t: t[:-1], 'mode 9: moves 88 nodes, the first mode 89'),
    (VECTORS, changed('Z', 5, np.inf), r'mode 1: has \[.*inf\] at node 25, which is not finite'),
    (HEXA, changed('G', (2, 9), 0), 'element 3: is a CHEXA with 11 mid-edge nodes; give elements'),
    (HEXA, changed('G', (2, 0), 7), 'has a hex20 with node 7, which no mode moves or nothing pla'),
    (VALUES, changed('EIGEN', 7, -1.0), r'mode 8 has -\d+\.\d+ Hz; give real normal modes of a'),
    (VALUES, changed('FREQ', 0, 50.0), 'mode 2 has 0.0 Hz after 50.0 Hz'),
    (GRID, lambda t: t['X'].ravel(), f'{GRID}: has no field ID'),
])
def test_nastran_tables(name: str, change: Callable[[np.ndarray], np.ndarray] | None,
                        message: str, tmp_path: Path) -> None:
    path = rewritten(tmp_path, name, change)
    assert re.search(message, refusal(path, **options('nastran_h5')))


def test_pyramids_of_nastran(tmp_path: Path) -> None:
    path = tmp_path / 'pad.h5'
    write_nastran_h5(path)
    with module('h5py').File(path, 'r+') as file:
        file['/NASTRAN/INPUT/ELEMENT/CPYRAM'] = file[HEXA][()]
    assert 'element 1: is a CPYRAM, which is not known; mesh with CTETRA' in refusal(
        path, **options('nastran_h5'))


def test_scalar_points_are_passed_over(tmp_path: Path) -> None:
    def with_scalar_points(table: np.ndarray) -> np.ndarray:
        extra = table[table['ID'] == 10].copy()
        extra['ID'] = 5000
        return np.concatenate([table, extra])

    from squeal_core.modes.readers import read_modes
    path = rewritten(tmp_path, VECTORS, with_scalar_points)
    assert read_modes(path, **options('nastran_h5')).shapes.shape == RAW.shapes.shape


def test_a_fall_of_the_hdf5_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It takes its own process with it, not ours; nor does it keep us waiting for ever."""
    path = tmp_path / 'pad.h5'
    write_nastran_h5(path)
    for script, message in (('kill -ABRT $$', 'the HDF5 library fell by signal 6'),
                            ('ulimit -S -t $7; while :; do :; done',
                             'the HDF5 library did not end within 1 s of processor time'),
                            ('exec sleep 30', 'the HDF5 library did not end within 1 s')):
        program = tmp_path / 'python'
        program.write_text(f'#!/bin/sh\n{script}\n')
        program.chmod(0o755)
        with monkeypatch.context() as patch:
            patch.setattr('sys.executable', str(program))
            patch.setattr('squeal_core.modes.readers.nastran_h5._PATIENCE_S', 0.9)
            if 'sleep' in script:
                patch.setattr('squeal_core.modes.readers.nastran_h5._BUSY', 1.0)
            assert refusal(path, **options('nastran_h5')) == (
                f'is damaged or no HDF5 file ({message}); export it again')


def test_op2_with_other_systems_and_without_nodes(tmp_path: Path) -> None:
    path = tmp_path / 'pad.op2'
    write_op2(path)
    data = path.read_bytes()
    at = data.index(b'GEOM1')
    grid = data.index(np.array([13, 0], '<i4').tobytes(), at)
    path.write_bytes(data[:grid + 20] + np.array([3], '<i4').tobytes() + data[grid + 24:])
    assert 'grid point 13: is given in coordinate systems CP 0, CD 3' in refusal(
        path, **options('op2'))
    lama = data.index(b'LAMA    ') - 16
    path.write_bytes(data[:lama] + data[-12:])
    assert 'holds eigenvectors of 0 subcases; export one' in refusal(path, **options('op2'))
    write_op2(path, geometry=False)
    assert 'holds no grid points (table GEOM1); ask' in refusal(path, **options('op2'))


def vtu(folder: Path, old: str, new: str) -> str:
    path = folder / 'pad.vtu'
    write_vtu(path, binary=False)
    text = path.read_text()
    found = re.sub(old, new, text, count=1)
    assert found != text
    path.write_text(found)
    return refusal(path, **options('vtu'))


@pytest.mark.parametrize(('old', 'new', 'message'), [
    ('UnstructuredGrid"', 'PolyData"', "is a VTKFile of type 'PolyData', no VTKFile of Unstruc"),
    ('</VTKFile>', '', 'is cut short or no XML'),
    ('(?s)(<Piece.*</Piece>)', r'\1\1', 'has 2 pieces; merge them to one'),
    ('NumberOfPoints="89"', 'NumberOfPoints="90"', "has 267 numbers in array 'Points', not 270"),
    ('NumberOfPoints="89"', 'NumberOfPoints="x"', 'is no VTU file this can read'),
    ('type="Int64" Name="connec', 'type="Int63" Name="connec', "read .KeyError: 'Int63'"),
    ('Name="mode_3_', 'Name="mode_5_', r'has modes \[1, 2, 4, 5, 5, 6, \.\.\.\]; give all modes'),
    ('_0.0Hz', '_0.0', 'does not state frequencies; give frequencies_hz'),
    ('<VTKFile', '<!DOCTYPE x [<!ENTITY a "b">]><VTKFile', 'defines entities'),
    ('<VTKFile', '<VTKFile compressor="vtkLZ4DataCompressor"', "is packed by 'vtkLZ4DataCo"),
])
def test_vtu_files(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert re.search(message, vtu(tmp_path, old, new))


@pytest.mark.parametrize(('kind', 'nodes', 'message'), [
    ('pyramid', 5, 'has a cell of VTK type 14 with 5 points, which is not known; mesh with tetra'),
    ('triangle', 3, None)])
def test_other_cells_of_vtu(kind: str, nodes: int, message: str | None, tmp_path: Path) -> None:
    """Solids that are not known are refused, skins of shells left out."""
    from squeal_core.modes.readers import read_modes
    meshio = module('meshio')
    modes = {f'mode_{k}_{f!r}Hz': s
             for k, (f, s) in enumerate(zip(HERTZ, RAW.shapes, strict=True))}
    mesh = meshio.Mesh(RAW.coordinates, [(kind, RAW.elements[0].nodes[:, :nodes])],
                       point_data=modes)
    path = tmp_path / 'pad.vtu'
    meshio.vtu.write(str(path), mesh)
    if message is None:
        assert read_modes(path, **options('vtu')).elements == ()
    else:
        assert message in refusal(path, **options('vtu'))


def test_vtu_without_modes(tmp_path: Path) -> None:
    meshio = module('meshio')
    mesh = meshio.Mesh(RAW.coordinates, [('hexahedron20', RAW.elements[0].nodes)],
                       point_data={'U': RAW.shapes[0]})
    meshio.vtu.write(str(tmp_path / 'pad.vtu'), mesh)
    assert "has no array of vectors named as a mode, but ['U']; see docs/howto/mod" in refusal(
        tmp_path / 'pad.vtu', **options('vtu'))


def test_vtu_that_would_unpack_to_more_than_memory(tmp_path: Path) -> None:
    """The size before a block is not believed beyond the bound."""
    path = write_sample('vtu', tmp_path)
    import base64
    text = path.read_text()
    head = re.search(r'Name="Points"[^>]*>\s*([A-Za-z0-9+/=]{24,})', text)
    assert head is not None
    sizes = np.frombuffer(base64.b64decode(head[1][:24])[:12], '<u4').copy()
    sizes[1] = 2**32 - 1
    forged = base64.b64encode(sizes.tobytes() + base64.b64decode(head[1][:24])[12:]).decode()
    path.write_text(text.replace(head[1][:24], forged, 1))
    assert re.search('has an array of 4294967295 bytes|is no VTU', refusal(path, **options('vtu')))
