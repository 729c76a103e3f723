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

"""Nastran results: the HDF5 file that `HDF5OUT` gives (MSC Nastran 2018 and later)."""

from collections.abc import Mapping
import importlib.util
import json
import math
import os
from pathlib import Path
import signal
import subprocess
import sys
import tempfile
from typing import Any, TypeAlias

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.bounded_reader import check_readable
from squeal_core.modes.readers.raw import (
    AGAIN,
    assemble,
    IntArray,
    MAX_BYTES,
    MAX_VALUES,
    NodeField,
    RawModes,
    ReaderError,
)

Tables: TypeAlias = Mapping[str, Mapping[str, Any]]

# bottom edges, then vertical ones, then top ones, as Nastran numbers them
HEX = (*range(12), *range(16, 20), *range(12, 16))
WEDGE = (*range(9), *range(12, 15), *range(9, 12))
# element -> kind with corners only, kind with all mid-edge nodes, order of the nodes
ELEMENTS: dict[str, tuple[str, str, tuple[int, ...]]] = {
    'CHEXA': ('hex8', 'hex20', HEX), 'CPENTA': ('wedge6', 'wedge15', WEDGE),
    'CTETRA': ('tet4', 'tet10', tuple(range(10)))}
_CORNERS = {'CHEXA': 8, 'CPENTA': 6, 'CTETRA': 4}
PYRAMIDS = ('CPYRA', 'CPYRAM')
_REMEDY = 'ask Nastran for HDF5OUT with DISPLACEMENT(PLOT) = ALL in SOL 103'
_ELEMENT = '/NASTRAN/INPUT/ELEMENT'
GRID = '/NASTRAN/INPUT/NODE/GRID'
DOMAINS = '/NASTRAN/RESULT/DOMAINS'
VECTORS = '/NASTRAN/RESULT/NODAL/EIGENVECTOR'
VALUES = '/NASTRAN/RESULT/SUMMARY/EIGENVALUE'
_WANTED = {GRID: ['ID', 'CP', 'X', 'CD'], DOMAINS: ['ID', 'MODE'],
           VECTORS: ['ID', 'X', 'Y', 'Z', 'DOMAIN_ID'],
           VALUES: ['MODE', 'EIGEN', 'FREQ', 'MASS'],
           **{f'{_ELEMENT}/{element}': ['EID', 'G'] for element in (*ELEMENTS, *PYRAMIDS)}}
# processor time of the HDF5 library; and how many times that may pass on a busy machine
_PATIENCE_S, _BYTES_PER_S, _BUSY = 10.0, 10e6, 30.0


def read(path: Path) -> RawModes:
    """Read nodes, solid elements, eigenvectors and generalised masses."""
    check_readable(path, MAX_BYTES, ReaderError)
    if importlib.util.find_spec('h5py') is None:
        raise ReaderError(path, 'cannot be read without h5py',
                          "pip install -e '.[readers]' in the checkout")
    with tempfile.TemporaryDirectory() as folder:
        tables = _tables(path, Path(folder) / 'tables.npz')
    return _modes_of(path, tables)


def _tables(path: Path, target: Path) -> Tables:
    """Return tables by name and field, read by a process that a damaged file may end."""
    script = str(Path(__file__).with_name('hdf5_tables.py'))
    patience = math.ceil(_PATIENCE_S + path.stat().st_size / _BYTES_PER_S)
    try:
        run = subprocess.run(
            [sys.executable, '-P', script, str(path), str(target), json.dumps(_WANTED),
             str(8 * MAX_VALUES), str(patience)], capture_output=True,
            timeout=_BUSY * patience, check=False,
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))})
        said = run.stderr.decode('utf-8', errors='replace').strip().split('\n')[-1][:200]
    except subprocess.TimeoutExpired:
        run, said = None, f'the HDF5 library did not end within {_BUSY * patience:.0f} s'
    if run is None or run.returncode:
        if run is not None and run.returncode < 0:
            said = (f'the HDF5 library did not end within {patience} s of processor time'
                    if -run.returncode == signal.SIGXCPU
                    else f'the HDF5 library fell by signal {-run.returncode}')
        if said.startswith('refused: '):
            raise ReaderError(f'{path}, {said.removeprefix("refused: ").partition(" ")[0]}',
                              said.partition(' ')[2].partition(' ')[2],
                              'write all tables into one file, as Nastran does')
        raise ReaderError(path, f'is damaged or no HDF5 file ({said})', AGAIN)
    tables: dict[str, dict[str, Any]] = {}
    with np.load(target, allow_pickle=False) as arrays:
        for name in arrays:
            table, _, field = name.partition('|')
            tables.setdefault(table, {})[field] = arrays[name]
    return tables


def _modes_of(path: Path, tables: Tables) -> RawModes:
    grid = _table(path, tables, GRID)
    check_systems(path, grid['ID'], grid['CP'], grid['CD'])
    modes, frequencies, masses = _modes(path, tables)
    vectors = _table(path, tables, VECTORS)
    lying = np.isin(vectors['ID'], grid['ID'])  # scalar points lie nowhere
    values = np.stack([vectors[axis] for axis in 'XYZ'], axis=-1)
    fields = []
    for number, domain in modes:
        rows = lying & (vectors['DOMAIN_ID'] == domain)
        fields.append(NodeField(vectors['ID'][rows], values[rows], f'mode {number}'))
    return assemble(path, NodeField(grid['ID'], grid['X'].reshape(-1, 3), 'table GRID'), fields,
                    frequencies, _cells(path, tables), modal_masses=masses)


def check_systems(path: Path, ids: IntArray, places: IntArray, shifts: IntArray) -> None:
    """Refuse grid points in other coordinate systems than the basic one."""
    bad = np.flatnonzero((places != 0) | (shifts != 0))
    if bad.size:
        at = bad[0]
        raise ReaderError(f'{path}, grid point {ids[at]}', f'is given in coordinate systems '
                          f'CP {places[at]}, CD {shifts[at]}; the basic one (0) is read',
                          'leave CP and CD of the grid points blank')


def _table(path: Path, tables: Tables, name: str) -> Mapping[str, Any]:
    """Return a table of the file, after its fields were checked."""
    if name not in tables:
        raise ReaderError(path, f'holds no table {name}', _REMEDY)
    missing = [field for field in _WANTED[name] if field not in tables[name]]
    if missing:
        raise ReaderError(f'{path}, {name}', f'has no field {missing[0]}', _REMEDY)
    return tables[name]


def _modes(path: Path, tables: Tables) -> tuple[list[tuple[int, int]], FloatArray, Any]:
    """Return mode numbers with the domains of their shapes; frequencies; generalised masses."""
    domains, result = _table(path, tables, DOMAINS), _table(path, tables, VALUES)
    held = np.isin(domains['ID'], _table(path, tables, VECTORS)['DOMAIN_ID'])
    order = np.argsort(domains['MODE'][held], kind='stable')
    numbers, ids = domains['MODE'][held][order], domains['ID'][held][order]
    if any(np.unique(modes).size != modes.size for modes in (numbers, result['MODE'])):
        raise ReaderError(path, 'holds modes of more than one subcase',
                          'export one subcase of normal modes')
    missing = numbers[~np.isin(numbers, result['MODE'])]
    if missing.size:
        raise ReaderError(path, f'gives no frequency of mode {missing[0]}', _REMEDY)
    rows = np.argsort(result['MODE'])
    rows = rows[np.searchsorted(result['MODE'], numbers, sorter=rows)]
    hertz = np.where(result['EIGEN'] < 0.0, -1.0, 1.0)[rows] * result['FREQ'][rows]
    masses = result['MASS'][rows]
    stated = masses.size and masses.min() > 0.0
    modes = list(zip(numbers.tolist(), ids.tolist(), strict=True))
    return modes, hertz, masses if stated else None


def _cells(path: Path, tables: Tables) -> dict[str, IntArray]:
    cells: dict[str, IntArray] = {}
    for element in (*ELEMENTS, *PYRAMIDS):
        name = f'{_ELEMENT}/{element}'
        if name in tables:
            table = _table(path, tables, name)
            cells |= by_kind(path, element, table['EID'], table['G'])
    return cells


def by_kind(path: Path, element: str, numbers: IntArray, nodes: IntArray) -> dict[str, IntArray]:
    """Sort elements by whether they have mid-edge nodes; 0 stands for one that is not there."""
    if element in PYRAMIDS:
        raise ReaderError(f'{path}, element {numbers[0]}', f'is a {element}, which is not known',
                          'mesh with CTETRA, CHEXA or CPENTA')
    linear, quadratic, order = ELEMENTS[element]
    corners = _CORNERS[element]
    middles = (nodes[:, corners:] > 0).sum(axis=1)
    some = np.flatnonzero((middles > 0) & (middles < len(order) - corners))
    if some.size:
        raise ReaderError(f'{path}, element {numbers[some[0]]}', f'is a {element} with '
                          f'{middles[some[0]]} mid-edge nodes', 'give elements all or none')
    sorted_nodes = {linear: nodes[middles == 0][:, :corners]}
    if nodes.shape[1] == len(order):
        sorted_nodes[quadratic] = nodes[middles > 0][:, order]
    return {kind: result for kind, result in sorted_nodes.items() if len(result)}
