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

"""Nastran results: OP2 files, through pyNastran, which needs numpy below 2."""

from contextlib import redirect_stderr, redirect_stdout
import io
from pathlib import Path
from typing import Any
import warnings

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.bounded_reader import check_readable
from squeal_core.common.errors import in_one_line
from squeal_core.modes.readers.nastran_h5 import by_kind, check_systems, ELEMENTS, PYRAMIDS
from squeal_core.modes.readers.raw import (
    AGAIN,
    assemble,
    IntArray,
    MAX_BYTES,
    NodeField,
    RawModes,
    ReaderError,
)

_GRID_POINT = 1  # type number of a node that lies somewhere
_REMEDY = 'ask Nastran for PARAM,POST,-1 and PARAM,OGEOM,YES in SOL 103'


def read(path: Path) -> RawModes:
    """Read nodes, solid elements, eigenvectors and generalised masses."""
    check_readable(path, MAX_BYTES, ReaderError)
    with warnings.catch_warnings(), redirect_stdout(io.StringIO()), \
            redirect_stderr(io.StringIO()):
        warnings.simplefilter('ignore')  # its own concern; ours go into one line
        model = _load(path)
    vectors = _vectors(path, model)
    nodes = _nodes(path, model)
    fields = _fields(vectors, nodes.ids)
    frequencies, masses = _frequencies(path, model, vectors)
    return assemble(path, nodes, fields, list(frequencies), _cells(path, model),
                    modal_masses=masses)


def _load(path: Path) -> Any:
    try:
        from pyNastran.op2.op2_geom import read_op2_geom
    except Exception as error:  # with numpy 2 it fails by an AttributeError
        raise ReaderError(path, f'cannot be read without pyNastran ({_one_line(error)})',
                          "pip install -e '.[nastran]' in the checkout") from None
    try:
        return read_op2_geom(str(path), combine=False, xref=False, debug=None)
    except (Exception, SystemExit) as error:  # whatever it says of a damaged file
        raise ReaderError(path, f'is damaged or no OP2 file ({_one_line(error)})',
                          AGAIN) from None


def _one_line(error: BaseException) -> str:
    return f'{type(error).__name__}: {in_one_line(error, 120)}'


def _vectors(path: Path, model: Any) -> Any:
    result = list(model.eigenvectors.values())
    if len(result) != 1:
        raise ReaderError(path, f'holds eigenvectors of {len(result)} subcases',
                          'export one subcase of real normal modes, with DISPLACEMENT = ALL')
    if not hasattr(result[0], 'eigns') or np.iscomplexobj(result[0].data):
        raise ReaderError(path, f'holds a {type(result[0]).__name__}, no real eigenvectors',
                          'export real normal modes (SOL 103)')
    return result[0]


def _nodes(path: Path, model: Any) -> NodeField:
    if not model.nodes:
        raise ReaderError(path, 'holds no grid points (table GEOM1)', _REMEDY)
    points = list(model.nodes.values())
    ids = np.array([point.nid for point in points], np.int64)
    check_systems(path, ids, np.array([point.Cp() for point in points]),
                  np.array([point.Cd() for point in points]))
    return NodeField(ids, np.array([point.xyz for point in points], float), 'table GEOM1')


def _fields(vectors: Any, ids: IntArray) -> list[NodeField]:
    numbers, types = vectors.node_gridtype.T
    kept = (types == _GRID_POINT) & np.isin(numbers, ids)
    return [NodeField(numbers[kept].astype(np.int64), shape[kept, :3].astype(float),
                      f'mode {mode}') for mode, shape in zip(vectors.modes, vectors.data,
                                                             strict=True)]


def _frequencies(path: Path, model: Any, vectors: Any) -> tuple[FloatArray, Any]:
    """Return frequencies from eigenvalues [rad^2/s^2], negative for negative ones, and masses."""
    squares = np.array(vectors.eigns, float)
    masses = None
    for table in model.eigenvalues.values():
        if hasattr(table, 'generalized_mass') and np.array_equal(table.mode, vectors.modes):
            masses = np.array(table.generalized_mass, float)
    stated = masses is not None and masses.min() > 0.0
    return np.sign(squares) * np.sqrt(np.abs(squares)) / (2 * np.pi), masses if stated else None


def _cells(path: Path, model: Any) -> dict[str, IntArray]:
    cells: dict[str, list[IntArray]] = {}
    for name in (*ELEMENTS, *PYRAMIDS):
        elements = [e for e in model.elements.values() if e.type == name]
        if not elements:
            continue
        size = max(len(e.node_ids) for e in elements)
        nodes = np.array([[n or 0 for n in e.node_ids] + [0] * (size - len(e.node_ids))
                          for e in elements], np.int64)
        for kind, result in by_kind(path, name, np.array([e.eid for e in elements]),
                                    nodes).items():
            cells.setdefault(kind, []).append(result)
    return {kind: np.vstack(result) for kind, result in cells.items()}
