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

"""Solids on hexahedra and tetrahedra: matrices, integrals, modes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skfem
from skfem.helpers import ddot, dot, eye, sym_grad, trace
from squeal_core.brake.dimensions import Material, Pad
from squeal_core.common.errors import SquealError
from squeal_core.model import operators
from squeal_core.modes.fe.eigen import assembled
from squeal_core.modes.fe.meshes import pad_mesh, sector_mesh
from squeal_core.modes.fe.solid import at_radius, pad_modes, solid_modes
from support.solids import SECOND_ORDER, SECTOR, STEEL


@skfem.BilinearForm
def mass_form(u: Any, v: Any, _: Any) -> Any:
    return dot(u, v)


@skfem.BilinearForm
def stiffness_form(u: Any, v: Any, w: Any) -> Any:
    e = sym_grad(u)
    return ddot(w.lame * eye(trace(e), 3) + 2.0 * w.shear * e, sym_grad(v))


@pytest.mark.parametrize('kind', SECOND_ORDER)
def test_matrices_are_those_of_the_forms(kind: str) -> None:
    """Assembled at once, against scikit-fem pair by pair; integrals of curved elements agree."""
    element, shape = SECOND_ORDER[kind]
    mesh = pad_mesh(SECTOR, 0.0, 0.02, (1, 2, 1), shape=shape, irregularity=0.6, layered=False)
    basis = skfem.CellBasis(mesh, skfem.ElementVector(element()), intorder=4 if shape[0] == 't'
                            else 5)
    e, nu = STEEL.young_modulus, STEEL.poisson_ratio
    expected = (stiffness_form.assemble(basis, lame=e * nu / (1 + nu) / (1 - 2 * nu),
                                        shear=e / 2 / (1 + nu)),
                mass_form.assemble(basis) * STEEL.density)
    for found, wanted in zip(assembled(basis, STEEL), expected, strict=True):
        assert abs(found - wanted).max() < 1e-13 * abs(wanted).max()


@pytest.mark.parametrize('kind', SECOND_ORDER)
def test_volume_and_gyroscopic_matrix_of_rigid_motions(kind: str) -> None:
    """Unit masses, the volume, and G = rho int (x^2 + y^2) dV between roll and pitch."""
    element, shape = SECOND_ORDER[kind]
    mesh = pad_mesh(SECTOR, 0.0, 0.02, (2, 6, 1), shape=shape, irregularity=0.5)
    modes = solid_modes(mesh, STEEL, 8, element=element())
    layers = list(modes.volume_layers())
    volume = SECTOR.area * 0.02
    assert sum(s.points.weight.sum() for s in layers) == pytest.approx(volume, rel=1e-5)
    mass = STEEL.density * sum(
        (f * s.points.weight) @ f.T for s in layers for f in (s.radial, s.tangential, s.normal))
    assert np.allclose(mass, np.eye(8), atol=1e-10)
    g = operators.gyroscopic(layers, modes.density)
    weights = np.concatenate([s.points.weight for s in layers])
    r, t, z = (np.concatenate([getattr(s.points, name) for s in layers])
               for name in ('radius', 'angle', 'height'))
    x, y, z = r * np.cos(t), r * np.sin(t), z - 0.01
    total = STEEL.density * weights.sum()
    # about the mass centre, as the rigid modes are: rho int y^2, over sqrt of both inertias
    centre = weights @ x / weights.sum()
    inertia = STEEL.density * np.array([weights @ (y**2 + z**2),
                                        weights @ ((x - centre)**2 + z**2)])
    turned = STEEL.density * (weights @ (x * (x - centre)) + weights @ y**2)
    assert abs(g[4, 5]) == pytest.approx(turned / np.sqrt(inertia.prod()), rel=1e-4)
    assert abs(g[0, 1]) < 1e-10  # slides do not change with theta
    assert abs(g[0, 2]) == pytest.approx(np.sqrt(total) * centre / np.sqrt(
        STEEL.density * weights @ ((x - centre)**2 + y**2)), rel=1e-4)


@pytest.mark.parametrize('kind', SECOND_ORDER)
def test_clamped_bar(kind: str) -> None:
    """
    Without Poisson's ratio a bar's axial quarter wave is that of a string: h^4.

    Serendipity elements hold this rate on parallelepipeds only, so they get a graded mesh
    instead of one with moved nodes.
    """
    element, shape = SECOND_ORDER[kind]
    slack = Material(young_modulus=210e9, density=7850.0, poisson_ratio=0.0)
    length = 0.05
    exact = 0.5 * np.pi / length * np.sqrt(210e9 / 7850.0)
    off = []
    for n in (1, 2, 4):
        along = np.linspace(0.0, 1.0, 2 * n + 1)
        cuts = np.linspace(0.0, 0.02, 3), np.linspace(0.0, 0.03, 3), length * (
            along + 0.1 * np.sin(np.pi * along))
        mesh = (skfem.MeshHex if shape == 'hexahedra' else skfem.MeshTet).init_tensor(*cuts)
        if kind != 'hex20':
            moved = np.setdiff1d(np.arange(mesh.p.shape[1]), mesh.boundary_nodes())
            mesh.p[:, moved] += np.random.default_rng(n).uniform(-2e-3, 2e-3, (3, moved.size)) / n
        found = solid_modes(mesh, slack, 8, element=element(),
                            clamped=lambda x: np.isclose(x[2], 0.0))
        axial = np.abs(found.nodal().shapes[:, :, 2].mean(axis=1)).argmax()
        off.append(found.angular_frequencies[axial] / exact - 1.0)
    assert np.log2(np.divide(off[:-1], off[1:])) == pytest.approx(4.0, abs=0.3)
    assert 0.0 < off[-1] < 3e-6


def test_tetrahedra_and_hexahedra_agree() -> None:
    """A free pad, six modes of it rigid, on irregular meshes of three kinds of elements."""
    regular = pad_modes(Pad(STEEL, 0.02), SECTOR, 10).angular_frequencies[6:]
    for element, shape in SECOND_ORDER.values():
        coarse, fine = (solid_modes(pad_mesh(SECTOR, 0.0, 0.02, size, shape=shape,
                                             irregularity=0.5), STEEL, 10,
                                    element=element()).angular_frequencies
                        for size in ((5, 8, 2), (7, 11, 3)))
        assert np.all(fine[:6] == 0.0)
        assert np.all(coarse[6:] > fine[6:])
        assert np.all(fine[6:] > regular)  # from above
        # 0.3 % are left of tetrahedra's 1 %, 0.06 % of 27 nodes'
        assert fine[6:] == pytest.approx(regular, rel=4e-3 if shape == 'tetrahedra' else 1e-3)


@pytest.mark.parametrize('suffix', ['msh', 'vtu'])
@pytest.mark.parametrize('kind', ['tet10', 'hex27'])
def test_meshes_of_other_programs(kind: str, suffix: str, tmp_path: Path) -> None:
    """Curved elements that Gmsh or VTK would write, loaded by scikit-fem, nodes in their order."""
    meshio = pytest.importorskip('meshio')
    element, shape = SECOND_ORDER[kind]
    ours = solid_modes(pad_mesh(SECTOR, 0.0, 0.02, (2, 3, 1), shape=shape, irregularity=0.4),
                       STEEL, 9, element=element())
    nodal, path = ours.nodal(), str(tmp_path / f'pad.{suffix}')
    meshio.Mesh(nodal.coordinates, [({'tet10': 'tetra10', 'hex27': 'hexahedron27'}[kind],
                                     nodal.elements[0].nodes)]).write(
        path, file_format={'msh': 'gmsh', 'vtu': 'vtu'}[suffix])
    found = solid_modes(skfem.Mesh.load(path), STEEL, 9, element=element())
    assert found.angular_frequencies == pytest.approx(ours.angular_frequencies, rel=1e-10)


def test_nothing_to_hold() -> None:
    with pytest.raises(SquealError, match='no face of the mesh lies where it should be held'):
        solid_modes(sector_mesh(SECTOR, 0.0, 0.02, (1, 2, 1)), STEEL, 2, clamped=at_radius(0.05))
