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

"""CalculiX solves the pad of Kang (2009) on a mesh of its own; its modes are those found here."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core.brake.dimensions import Brake
from squeal_core.modes.fe.mass import EDGES
from squeal_core.modes.modal_basis import modal_assurance, Quadrature
from squeal_core.modes.readers import read_modes, ReaderError
from support.calculix import deck, solved

MODES, ELEMENTS = 20, (8, 16, 2)


def mesh_of(brake: Brake) -> tuple[np.ndarray, np.ndarray]:
    """Nodes [mm] of a sector and its C3D20 elements by place of their nodes."""
    contact = brake.contact
    steps = np.array(ELEMENTS)
    corners = np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0],
                        [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]])
    local = np.vstack([corners, corners[np.array(EDGES['hex'])].mean(axis=1).astype(int)])
    origins = 2 * np.stack(np.meshgrid(*map(np.arange, steps), indexing='ij'), -1).reshape(-1, 3)
    grid, nodes = np.unique((origins[:, None] + local).reshape(-1, 3), axis=0, return_inverse=True)
    part = grid / (2 * steps)
    r = contact.inner_radius + part[:, 0] * (contact.outer_radius - contact.inner_radius)
    t = (part[:, 1] - 0.5) * contact.angle
    where = np.stack([r * np.cos(t), r * np.sin(t), part[:, 2] * brake.pad.thickness], axis=1)
    return 1e3 * where, nodes.reshape(-1, 20)


@pytest.fixture(scope='module')
def results(brake: Brake, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return solved(tmp_path_factory.mktemp('calculix'),
                  deck(*mesh_of(brake), brake.pad.material, MODES))


def test_modes_agree(results: Path, brake: Brake, pad: Any) -> None:
    """Frequencies within 0.5 %, MAC above 0.99; the rigid modes span the same space."""
    found = read_modes(results, length_unit='mm', mass_unit='t',
                       density=brake.pad.material.density, mass_tolerance=1e-3)
    x, y, z = found.coordinates.T
    sampled = pad.sample(Quadrature(np.hypot(x, y), np.arctan2(y, x), z, np.ones_like(x)))
    c, s = np.cos(sampled.points.angle), np.sin(sampled.points.angle)
    own = np.stack([c * sampled.radial - s * sampled.tangential,
                    s * sampled.radial + c * sampled.tangential, sampled.normal], axis=2)
    own, theirs = own.reshape(len(own), -1), found.shapes.reshape(MODES, -1)
    np.testing.assert_allclose(found.angular_frequencies[6:], pad.angular_frequencies[6:MODES],
                               rtol=5e-3)
    assert modal_assurance(theirs[6:], own[6:MODES]).diagonal().min() > 0.99
    np.testing.assert_allclose(np.sum(theirs[6:]**2, axis=1), np.sum(own[6:MODES]**2, axis=1),
                               rtol=1e-2)  # the normalisation too
    turn = np.linalg.lstsq(theirs[:6].T, own[:6].T, rcond=None)[0]
    np.testing.assert_allclose(turn @ turn.T, np.eye(6), atol=1e-4)
    np.testing.assert_allclose(turn.T @ theirs[:6], own[:6], atol=1e-4 * np.abs(own[:6]).max())


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('test_readers_calculix.ELEMENTS', (2, 3, 1))


def test_local_results_show_by_their_shapes(coarse: None, brake: Brake, tmp_path: Path) -> None:
    """*TRANSFORM with GLOBAL=NO leaves no mark in the file; with GLOBAL=YES nothing changes."""
    plain = deck(*mesh_of(brake), brake.pad.material, 8)
    turned = plain.replace('*MATERIAL', '*TRANSFORM, NSET=ALL, TYPE=C\n0, 0, 0, 0, 0, 1\n'
                           '*MATERIAL')
    want, found = (read_modes(solved(tmp_path, text), length_unit='mm', mass_unit='t')
                   for text in (plain, turned))
    np.testing.assert_allclose(found.shapes[:6], want.shapes[:6], atol=1e-3)
    local = solved(tmp_path, turned.replace('*NODE FILE', '*NODE FILE, GLOBAL=NO'))
    with pytest.raises(ReaderError, match='is no rigid motion: .* CalculiX GLOBAL=YES'):
        read_modes(local, length_unit='mm', mass_unit='t')


def test_cyclic_symmetry_is_refused(coarse: None, brake: Brake, tmp_path: Path) -> None:
    """Of a sector alone, and of all copies of it, whatever the number of nodal diameters."""
    contact = replace(brake.contact, angle=np.pi / 3.0)
    where, elements = mesh_of(replace(brake, contact=contact))
    angle = np.arctan2(where[:, 1], where[:, 0])
    low, high = (np.flatnonzero(np.abs(angle - side * np.pi / 6.0) < 1e-6) for side in (-1, 1))
    inner = np.flatnonzero(np.abs(np.hypot(*where[:, :2].T) - 100.0) < 1e-6)
    text = deck(where, elements, brake.pad.material, 4, np.setdiff1d(inner, low))
    sides = ''.join(f'*NSET, NSET=N{name}\n' + ''.join(f'{node + 1},\n' for node in nodes)
                    + f'*SURFACE, NAME={name}, TYPE=NODE\nN{name}\n'
                    for name, nodes in (('LOW', low), ('HIGH', high)))
    for copies, diameters in ((1, 0), (6, 2)):
        model = (f'{sides}*TIE, NAME=SIDES, CYCLIC SYMMETRY\nLOW, HIGH\n*CYCLIC SYMMETRY MODEL, '
                 f'N=6, NGRAPH={copies}, TIE=SIDES\n0, 0, 0, 0, 0, 1\n*MATERIAL')
        select = (f'*FREQUENCY\n4\n*SELECT CYCLIC SYMMETRY MODES, NMIN={diameters}, '
                  f'NMAX={diameters}\n')
        path = solved(tmp_path, text.replace('*MATERIAL', model).replace(
            '*FREQUENCY\n4\n', select))
        with pytest.raises(ReaderError, match=rf'cyclic symmetry \(nodal diameters {diameters}'):
            read_modes(path, length_unit='mm', mass_unit='t')
