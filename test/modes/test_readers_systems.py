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

"""Results in other systems, phases, sectors and files: refused in one line, or read alike."""

from collections.abc import Callable
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core.modes.readers import FORMATS, read_modes
from support.reader_samples import (
    dataset,
    FRD,
    ints,
    module,
    options,
    PAD,
    reals,
    refusal,
    write_abaqus,
    write_ansys,
    write_nastran_h5,
    write_sample,
    write_unv_2414,
)

LAYOUTS = 'this layout is not read; these are: NLIST and PRNSOL,U,COMP of Ansys, *NODE lines'


def replaced(path: Path, old: str, new: str) -> Path:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def listing(write: Callable[[Path], None], folder: Path, old: str, new: str) -> str:
    path = folder / 'pad.rpt'
    write(path)
    return refusal(replaced(path, old, new), **PAD, modal_mass=1.0)


def as_complex(path: Path, factor: Callable[[int], complex]) -> Path:
    """Return the shapes of dataset 2414 as complex numbers, each node's times a factor."""
    lines, node = [], -1
    for line in path.read_text().split('\n'):
        if line == ints(1, 2, 2, 8, 2, 3):
            line, node = ints(1, 2, 2, 8, 5, 3), 0
        elif node >= 0 and len(line) == 39:
            values = [float(line[k:k + 13]) * factor(node) for k in (0, 13, 26)]
            line = reals(*(part for value in values for part in (value.real, value.imag)))
            node += 1
        lines.append(line)
    path.write_text('\n'.join(lines))
    return path


def test_real_modes_written_as_complex_read_alike(tmp_path: Path) -> None:
    write_unv_2414(tmp_path / 'pad.unv')
    want = read_modes(tmp_path / 'pad.unv', **PAD)
    for factor in (1.0, 1j, np.exp(0.7j)):
        write_unv_2414(tmp_path / 'pad.unv')
        found = read_modes(as_complex(tmp_path / 'pad.unv', lambda _, f=factor: f), **PAD)
        np.testing.assert_allclose(np.abs(found.shapes), np.abs(want.shapes),
                                   atol=1e-4 * np.abs(want.shapes).max())


def test_complex_modes_are_refused(tmp_path: Path) -> None:
    write_unv_2414(tmp_path / 'pad.unv')
    path = as_complex(tmp_path / 'pad.unv', lambda node: np.exp(0.02j * (node % 7)))
    text = refusal(path, **PAD)
    assert 'has a complex mode: 0.0' in text
    assert text.endswith('; export real normal modes, without damping, friction and rotation')


@pytest.mark.parametrize(('number', 'kind', 'shift', 'read'), [
    (2420, 0, 0.0, True), (2420, 1, 0.0, False), (2420, 0, 5.0, False),
    (18, 0, 0.0, True), (18, 1, 0.0, False), (18, 0, 5.0, False)])
def test_systems_that_a_universal_file_defines(number: int, kind: int, shift: float, read: bool,
                                               tmp_path: Path) -> None:
    """A label means what the file says: also 1, and one that is the global system by its axes."""
    path = tmp_path / 'pad.unv'
    write_unv_2414(path)
    replaced(path, f'{0:10d}{0:10d}{8:10d}', f'{7:10d}{7:10d}{8:10d}')
    assert 'in coordinate systems 7 and 7; the global Cartesian one is read, which [7] is' in (
        refusal(path, **PAD))
    matrix = np.vstack([np.eye(3), [shift, 0.0, 0.0]])
    records = [ints(1), 'part', ints(7, kind, 8), 'system',
               *(reals(*row, width=25, digits=16) for row in matrix)] if number == 2420 else [
        ints(7, kind, 0, 8, 1), 'system', reals(shift, 0, 0, shift + 1.0, 0, 0), reals(0, 0, 1)]
    path.write_text(path.read_text() + '\n'.join(dataset(number, *records)) + '\n')
    if read:
        assert read_modes(path, **PAD).shapes.shape == (9, 89, 3)
    else:
        assert 'in coordinate systems 7 and 7' in refusal(path, **PAD)


def test_listings_in_other_systems(tmp_path: Path) -> None:
    said = listing(write_ansys, tmp_path, 'DSYS=      0', 'DSYS=      1')
    assert 'lists nodes in another coordinate system' in said
    assert said.endswith('; list them after DSYS,0')
    for system in ('COORDINATE SYSTEM    11', 'THE SOLUTION COORDINATE SYSTEM',
                   'THE GLOBAL CYLINDRICAL COORDINATE SYSTEM'):
        said = listing(write_ansys, tmp_path, 'THE GLOBAL COORDINATE SYSTEM', system)
        assert 'lists results in another coordinate system' in said
        assert said.endswith('; list them after RSYS,0')
    assert 'cylindrical or spherical coordinates' in listing(
        write_abaqus, tmp_path, 'nset=PAD', 'nset=PAD, system=C')
    assert 'in a coordinate system of the user' in listing(
        write_abaqus, tmp_path, 'U.U1', 'U.U1 (ASSEMBLY_CSYS-1)')
    assert 'moves its nodes (*INSTANCE)' in listing(
        write_abaqus, tmp_path, '*Element,', '*Instance, name=A\n10., 0., 0.\n*Element,')


def test_listings_of_complex_and_of_cyclic_modes(tmp_path: Path) -> None:
    assert 'belongs to a cyclic symmetry analysis' in listing(
        write_ansys, tmp_path, 'LOAD CASE=   0', 'LOAD CASE=   0\n  HARMONIC INDEX= 2')
    assert 'belongs to complex modes' in listing(
        write_ansys, tmp_path, '  THE FOLLOWING', '  IMAG ONLY\n  THE FOLLOWING')
    assert 'belongs to complex modes' in listing(
        write_abaqus, tmp_path, '(cycles/time)', '(cycles/time) Effective damping ratio = 0.01')


def test_other_layouts(tmp_path: Path) -> None:
    path = tmp_path / 'nodes.txt'
    for heading in ('Node Number\tX Location (mm)\tY Location (mm)\tZ Location (mm)\tUX (mm)',
                    'Knotennummer\tX-Koordinate\tY-Koordinate\tZ-Koordinate\tVerformung',
                    'Node Number X Y Z'):
        path.write_text(f'{heading}\n1\t0.0\t0.0\t0.0\t0.1\n2\t100.0\t0.0\t0.0\t0.2\n')
        assert LAYOUTS in refusal(path)


def test_cyclic_symmetry_of_calculix(tmp_path: Path) -> None:
    """By the nodal diameters of a mode, and by the imaginary part of its displacement."""
    for old, new in (('1PHID                         -1', '1PHID                          2'),
                     (' -4  DISP ', ' -4  DISPI')):
        path = tmp_path / 'pad.frd'
        path.write_bytes(FRD.read_bytes())
        said = refusal(replaced(path, old, new), **PAD)
        assert 'in cyclic symmetry (nodal diameters ' in said
        assert 'solve the whole ring of 360 degrees' in said


def test_a_node_of_no_element_does_not_count(tmp_path: Path) -> None:
    """A reference point far off, which moves as it likes: it leaves no trace."""
    path = tmp_path / 'pad.frd'
    lines = FRD.read_text().split('\n')
    count = next(line for line in lines if line.startswith('    2C'))[24:36]
    more = [line.replace(count, f'{int(count) + 1:12d}')
            if line.startswith(('    2C', '  100CL')) else line for line in lines]
    out: list[str] = []
    blocks = 0
    for line in more:
        if line == ' -3' and blocks != 1:  # not at the end of the elements
            out.append(f' -1{9999:10d} 9.00000E+02 9.00000E+02 9.00000E+02')
        blocks += line == ' -3'
        out.append(line)
    path.write_text('\n'.join(out))
    found, want = read_modes(path, **PAD), read_modes(FRD, **PAD)
    np.testing.assert_array_equal(found.coordinates, want.coordinates)
    np.testing.assert_array_equal(found.shapes, want.shapes)


def _external(file: Any, path: str, h5py: Any) -> None:
    rows = file[path][()]
    del file[path]
    file.create_dataset(path, shape=rows.shape, dtype=rows.dtype, external=[
        ('raw.bin', 0, rows.nbytes)])


def _virtual(file: Any, path: str, h5py: Any) -> None:
    table = file[path]
    layout = h5py.VirtualLayout(table.shape, table.dtype)
    layout[:] = h5py.VirtualSource('other.h5', path, table.shape, dtype=table.dtype)
    del file[path]
    file.create_virtual_dataset(path, layout)


def _large(file: Any, path: str, h5py: Any) -> None:
    kind = file[path].dtype
    del file[path]
    file.create_dataset(path, shape=(10**9,), dtype=kind, chunks=(1000,), compression='gzip')


def _linked(link: str) -> Callable[[Any, str, Any], None]:
    def change(file: Any, path: str, h5py: Any) -> None:
        above = path.rpartition('/')[0]
        file.move(above, '/elsewhere')
        file[above] = (h5py.SoftLink('/elsewhere') if link == 'soft'
                       else h5py.ExternalLink('other.h5', above))
    return change


@pytest.mark.parametrize(('change', 'message'), [
    (_linked('soft'), 'is a link to another place or file'),
    (_linked('external'), 'is a link to another place or file'),
    (_external, 'has its data in other files'), (_virtual, 'has its data in other files'),
    (_large, 'has 1000000000 rows of 64 bytes, more than')])
def test_tables_that_lie_elsewhere_or_are_too_large(
        change: Callable[[Any, str, Any], None], message: str, tmp_path: Path) -> None:
    h5py = module('h5py')
    path = tmp_path / 'pad.h5'
    write_nastran_h5(path)
    with h5py.File(path, 'r+') as file:
        change(file, '/NASTRAN/RESULT/NODAL/EIGENVECTOR', h5py)
    assert message in refusal(path, **options('nastran_h5'))


def test_a_pipe_is_no_file_of_any_format(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe')
    for form in FORMATS:
        assert 'is a pipe' in refusal(tmp_path / 'pipe', format=form)
    assert write_sample('frd', tmp_path).exists()
