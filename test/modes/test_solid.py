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

"""Solids on hexahedra and tetrahedra: meshes, modes, sampling, the cache."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skfem
from skfem.helpers import ddot, dot, eye, sym_grad, trace
from squeal_core.brake.dimensions import Brake, Contact, Material, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.common.resources import cache_folder
from squeal_core.model import operators
from squeal_core.modes.fe.eigen import assembled
from squeal_core.modes.fe.locate import cells_of, locate
from squeal_core.modes.fe.mass import modal_masses, reference_nodes
from squeal_core.modes.fe.meshes import hat_disc_mesh, pad_mesh, sector_mesh
from squeal_core.modes.fe.mixed import ElementModes
from squeal_core.modes.fe.solid import at_radius, free_modes, pad_modes, solid_modes, SolidModes
from squeal_core.modes.modal_basis import Quadrature
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes

STEEL = Material(young_modulus=210e9, density=7850.0, poisson_ratio=0.3)
SECTOR = Contact(0.1, 0.142, np.deg2rad(40.0), 1e10)
SECOND_ORDER = {'tet10': (skfem.ElementTetP2, 'tetrahedra'),
                'hex20': (skfem.ElementHexS2, 'hexahedra'),
                'hex27': (skfem.ElementHex2, 'hexahedra')}

# the nodes of one cell as VTK's book numbers them, written out: corners, edges, faces, middle
HEX27 = 0.5 * np.array([
    [0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2],
    [1, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0], [1, 0, 2], [2, 1, 2], [1, 2, 2], [0, 1, 2],
    [0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1],
    [0, 1, 1], [2, 1, 1], [1, 0, 1], [1, 2, 1], [1, 1, 0], [1, 1, 2], [1, 1, 1]])
TET10 = 0.5 * np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2],
                        [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]])
CELLS = {'hex8': HEX27[:8], 'hex20': HEX27[:20], 'hex27': HEX27,
         'tet4': TET10[:4], 'tet10': TET10}
DEGREE = {'hex8': 1, 'tet4': 1, 'hex20': 2, 'hex27': 2, 'tet10': 2}


# ---------------------------------------------------------------- modes of other packages

def foreign_cells(kind: str) -> tuple[FloatArray, Any]:
    """Two cells that share a face, affinely placed off the axis: nodes (M, 3), elements (2, n)."""
    cell = CELLS[kind]
    other = cell * [-1.0, 1.0, 1.0]  # mirrored, so numbered inside out: meshes do hold such
    if kind.startswith('hex'):
        other = cell + [1.0, 0.0, 0.0]
    both = np.vstack([cell, other])
    places, index = np.unique(both.round(6), axis=0, return_inverse=True)
    turn = np.array([[0.9, -0.3, 0.1], [0.2, 1.1, 0.3], [-0.1, 0.2, 0.8]])
    return (places @ turn.T * 0.02 + [0.1, 0.02, 0.0]), index.reshape(2, -1)


def polynomials(degree: int, seed: int) -> Callable[[FloatArray], FloatArray]:
    """Random vector polynomials of total degree: where (..., 3) -> values (2, ..., 3)."""
    rng = np.random.default_rng(seed)
    terms = [t for t in np.ndindex(3, 3, 3) if sum(t) <= degree]
    factors = rng.standard_normal((2, 3, len(terms)))

    def values(where: FloatArray) -> FloatArray:
        scaled = where / 0.1
        monomials = np.stack([np.prod(scaled**np.array(t), axis=-1) for t in terms], axis=-1)
        return np.einsum('mct,...t->m...c', factors, monomials)
    return values


@pytest.mark.parametrize('kind', CELLS)
def test_foreign_modes_are_sampled_by_their_own_elements(kind: str) -> None:
    """Polynomials of an element's degree, and d/dtheta of them, come back to rounding."""
    where, nodes = foreign_cells(kind)
    field = polynomials(DEGREE[kind], 3)
    stray = np.vstack([where, [[9.0, 9.0, 9.0]]])  # a node that no element uses
    modes = SolidModes.from_nodal(NodalModes(
        stray, [1.0, 2.0], field(stray), (ElementBlock(kind, nodes[:1]),
                                          ElementBlock(kind, nodes[1:]))), density=1.0)
    shares = np.random.default_rng(5).dirichlet(np.ones(4), 40)
    inside = np.vstack([shares @ where[element[:4]] for element in nodes])
    r, t = np.hypot(inside[:, 0], inside[:, 1]), np.arctan2(inside[:, 1], inside[:, 0])
    found = modes.sample(Quadrature(r, t, inside[:, 2], r))

    def polar(turn: float) -> FloatArray:
        """Polar components at points turned about the axis."""
        c, s = np.cos(t + turn), np.sin(t + turn)
        x, y, z = np.moveaxis(field(np.column_stack([r * c, r * s, inside[:, 2]])), -1, 0)
        return np.array([c * x + s * y, c * y - s * x, z])

    exact = polar(0.0)
    assert np.allclose([found.radial, found.tangential, found.normal], exact, rtol=0, atol=1e-9)
    # Richardson: the remainder is h^4 / 30 times a fifth derivative of some 10^2
    h = 2e-3
    slope = (8.0 * (polar(h) - polar(-h)) - (polar(2 * h) - polar(-2 * h))) / (12.0 * h)
    assert np.allclose([found.radial_dtheta, found.tangential_dtheta, found.normal_dtheta], slope,
                       rtol=0, atol=1e-8)


@pytest.mark.parametrize('kind', SECOND_ORDER)
def test_curved_elements_there_and_back(kind: str) -> None:
    """Ours -> nodes -> ours: geometry, shapes, density; and linear fields on curved elements."""
    element, shape = SECOND_ORDER[kind]
    mesh = pad_mesh(SECTOR, 0.0, 0.02, (2, 3, 1), shape=shape, irregularity=0.6)
    ours = solid_modes(mesh, STEEL, 9, element=element())
    nodal = ours.nodal()
    assert [block.kind for block in nodal.elements] == [kind]
    again = SolidModes.from_nodal(nodal)
    assert again.density == pytest.approx(STEEL.density, rel=1e-9)
    rng = np.random.default_rng(0)
    points = Quadrature(rng.uniform(0.105, 0.137, 50), rng.uniform(-0.3, 0.3, 50),
                        rng.uniform(0.0, 0.02, 50), np.ones(50))
    one, other = ours.sample(points), again.sample(points)
    for name in ('radial', 'tangential', 'normal', 'radial_dtheta', 'normal_dtheta'):
        a, b = getattr(one, name), getattr(other, name)
        assert np.abs(a - b).max() < 1e-9 * np.abs(a).max(), name
    x = points.radius * np.cos(points.angle)
    spin = other.radial[2] * np.sin(points.angle) + other.tangential[2] * np.cos(points.angle)
    line = np.polynomial.Polynomial.fit(x, spin, 1)(x)
    assert np.abs(spin - line).max() < 1e-9 * np.abs(spin).max()


def columns_of(kinds: tuple[str, ...], where: FloatArray) -> tuple[ElementBlock, ...]:
    """
    Return a hexahedron of 20 nodes beside two wedges of 15, or linear ones, by places of nodes.

    Two unit cubes along x, the second cut along the diagonal of its base.
    """
    blocks = {}
    for kind in kinds:
        local = reference_nodes(kind)
        cells = [local] if kind.startswith('hex') else [
            local + [1.0, 0.0, 0.0], local * [-1.0, -1.0, 1.0] + [2.0, 1.0, 0.0]]
        blocks[kind] = [[int(np.linalg.norm(where - place, axis=1).argmin()) for place in cell]
                        for cell in cells]
    return tuple(ElementBlock(kind, np.array(nodes)) for kind, nodes in blocks.items())


@pytest.mark.parametrize(('kinds', 'degree'), [(('hex20', 'wedge15'), 2), (('hex8', 'wedge6'), 1),
                                               (('wedge15',), 2)])
def test_elements_of_several_kinds(kinds: tuple[str, ...], degree: int) -> None:
    """Polynomials on hexahedra and wedges side by side: values, d/dtheta, mass, volume."""
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(3), np.arange(3)), -1).reshape(-1, 3) / 2
    blocks = columns_of(kinds, grid)
    used = np.unique(np.concatenate([block.nodes.ravel() for block in blocks]))
    turn = np.array([[0.9, -0.3, 0.1], [0.2, 1.1, 0.3], [-0.1, 0.2, 0.8]])
    where = grid @ turn.T * 0.02 + [0.1, 0.02, 0.0]
    field = polynomials(degree, 3)
    modes = ElementModes(NodalModes(where[used], [1.0, 2.0], field(where[used]), tuple(
        ElementBlock(block.kind, np.searchsorted(used, block.nodes)) for block in blocks)))
    low = 0.0 if len(kinds) == 2 else 1.0
    rng = np.random.default_rng(0)
    inside = rng.uniform([low, 0.0, 0.0], [2.0, 1.0, 1.0], (60, 3)) @ turn.T * 0.02 + [
        0.1, 0.02, 0.0]
    r, t = np.hypot(inside[:, 0], inside[:, 1]), np.arctan2(inside[:, 1], inside[:, 0])
    found = modes.sample(Quadrature(r, t, inside[:, 2], r))

    def polar(turned: float) -> FloatArray:
        c, s = np.cos(t + turned), np.sin(t + turned)
        x, y, z = np.moveaxis(field(np.column_stack([r * c, r * s, inside[:, 2]])), -1, 0)
        return np.array([c * x + s * y, c * y - s * x, z])

    assert np.allclose([found.radial, found.tangential, found.normal], polar(0.0), rtol=0,
                       atol=1e-9)
    h = 2e-3  # Richardson, as above
    slope = (8.0 * (polar(h) - polar(-h)) - (polar(2 * h) - polar(-2 * h))) / (12.0 * h)
    assert np.allclose([found.radial_dtheta, found.tangential_dtheta, found.normal_dtheta], slope,
                       rtol=0, atol=1e-8)
    layers = list(modes.volume_layers())
    volume = (2.0 - low) * np.linalg.det(turn) * 0.02**3
    assert sum(s.points.weight.sum() for s in layers) == pytest.approx(volume, rel=1e-12)
    masses = sum(np.sum(s.points.weight * f**2, axis=1) for s in layers
                 for f in (s.radial, s.tangential, s.normal))
    assert masses == pytest.approx(modal_masses(modes.modes, 1.0), rel=1e-12)
    with pytest.raises(SquealError, match='points lie outside the mesh'):
        modes.sample(Quadrature(r + 0.1, t, inside[:, 2], r))
    with pytest.raises(ModesError, match='there are no elements'):
        ElementModes(NodalModes(where, [1.0], field(where)[:1]))


def test_collapsed_hexahedra() -> None:
    """A wedge written as a hexahedron with two nodes twice, as Ansys does."""
    places = CELLS['hex8'][[0, 1, 2, 2, 4, 5, 6, 6]]
    where, nodes = np.unique(places * 0.02 + [0.1, 0.02, 0.0], axis=0, return_inverse=True)
    field = polynomials(1, 3)
    modes = SolidModes.from_nodal(NodalModes(where, [1.0, 2.0], field(where), (
        ElementBlock('hex8', nodes.reshape(1, 8)),)), density=1.0)
    inside = np.vstack([np.array([0.6, 0.3, 0.2]) * 0.02 + [0.1, 0.02, 0.0], where])
    r, t = np.hypot(inside[:, 0], inside[:, 1]), np.arctan2(inside[:, 1], inside[:, 0])
    found = modes.sample(Quadrature(r, t, inside[:, 2], r))
    assert np.allclose(found.normal, field(inside)[..., 2], atol=1e-9)


def test_elements_that_cannot_be_used() -> None:
    where, nodes = foreign_cells('hex8')
    modes = NodalModes(where, [1.0], np.ones((1, *where.shape)))
    for blocks, words in (((), 'elements of kinds'),
                          ((ElementBlock('hex8', nodes), ElementBlock('tet4', nodes[:, :4])),
                           'give one kind'),
                          ((ElementBlock('wedge6', nodes[:, :6]),), "kind 'wedge6'"),
                          ((ElementBlock('hex20', nodes),), r'give \(E, 20\)'),
                          ((ElementBlock('hex8', nodes + 6),), 'each from 0 to')):
        with pytest.raises(ModesError, match=words):
            SolidModes.from_nodal(NodalModes(modes.coordinates, [1.0], modes.shapes, blocks))


# ---------------------------------------------------------------- matrices and integrals

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


# ---------------------------------------------------------------- meshes

@pytest.mark.parametrize('shape', ['hexahedra', 'tetrahedra'])
def test_irregular_hat_keeps_its_surfaces(shape: Any, brake: Brake) -> None:
    meshes = [hat_disc_mesh(brake.disc, around=n, element_size=0.03, shape=shape, irregularity=i)
              for n, i in ((12, 0.0), (12, 0.5), (24, 0.5))]
    d = brake.disc
    inner, plate = d.hat_wall_inner_radius, d.top_plate_thickness
    volume = np.pi * ((d.rotor_outer_radius**2 - inner**2) * d.rotor_thickness
                      + (d.hat_wall_outer_radius**2 - inner**2) * (d.hat_height - plate)
                      + (d.hat_wall_outer_radius**2 - d.clamp_radius**2) * plate)
    off = []
    for mesh in meshes:
        basis = skfem.CellBasis(mesh, mesh.elem(), intorder=5)
        assert basis.mapping.detDF(basis.quadrature[0]).min() > 0.0
        off.append(abs(basis.dx.sum() / volume - 1.0))
        corners = mesh.p[:, np.unique(mesh.facets[:, mesh.boundary_facets()])]
        radius = np.hypot(corners[0], corners[1])
        on = [np.isclose(radius, r) for r in (
            d.clamp_radius, inner, d.hat_wall_outer_radius, d.rotor_outer_radius)]
        half = 0.5 * d.rotor_thickness
        on += [np.isclose(corners[2], z) for z in (
            -half, half, half + d.hat_height - plate, half + d.hat_height)]
        assert np.all(np.any(on, axis=0))
    assert off[0] < 2e-4
    assert off[1] / off[2] > 10.0  # mid-nodes on the arcs: h^4, on random meshes more or less
    assert not np.allclose(meshes[0].doflocs, meshes[1].doflocs)


@pytest.mark.parametrize('shape', ['hexahedra', 'tetrahedra'])
def test_points_are_found_in_long_and_crooked_elements(shape: Any, brake: Brake) -> None:
    """Fifty times as long as thick, bent by four thicknesses: each holds what is put into it."""
    mesh = hat_disc_mesh(brake.disc, around=16, corner_layers=1, irregularity=0.5, shape=shape)
    cells = np.random.default_rng(0).integers(0, mesh.nelements, 800)
    shares = np.random.default_rng(1).dirichlet(np.ones(4), cells.size).T[:3]
    points, _ = cells_of(mesh).geometry(cells, shares)  # in tetrahedra, and in hexahedra
    found, local = locate(mesh, points)
    again, slopes = cells_of(mesh).geometry(found, local)
    assert np.abs(again - points).max() < 1e-12
    assert np.array_equal(found, cells)
    h = 1e-6  # central differences: h^2 and 1e-16 / h
    for axis in range(3):
        step = h * np.eye(3)[:, axis:axis + 1]
        expected = (cells_of(mesh).geometry(found, local + step)[0]
                    - cells_of(mesh).geometry(found, local - step)[0]) / (2.0 * h)
        assert np.allclose(slopes[:, axis], expected, atol=1e-9)
    with pytest.raises(SquealError, match=r'1 of 2 points lie outside the mesh.*0\.5, 0\.0, 0\.0'):
        locate(mesh, np.column_stack([points[:, 0], [0.5, 0.0, 0.0]]))


def test_tetrahedra_fit_together(brake: Brake) -> None:
    """Six to a hexahedron, whose faces they cut in two, inside and out."""
    hexahedra, tetrahedra = (hat_disc_mesh(brake.disc, around=8, element_size=0.03, shape=shape)
                             for shape in ('hexahedra', 'tetrahedra'))
    assert tetrahedra.nelements == 6 * hexahedra.nelements
    assert tetrahedra.boundary_facets().size == 2 * hexahedra.boundary_facets().size


def test_layers_are_kept_or_not() -> None:
    heights = [np.unique(pad_mesh(SECTOR, 0.0, 0.02, (3, 4, 2), irregularity=0.5,
                                  layered=layered).doflocs[2].round(9)).size
               for layered in (True, False)]
    assert heights[0] == 5
    assert heights[1] > 50


def test_same_seed_same_mesh() -> None:
    one, same, other = (pad_mesh(SECTOR, 0.0, 0.02, (2, 2, 1), irregularity=0.5, seed=seed).doflocs
                        for seed in (1, 1, 2))
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)


# ---------------------------------------------------------------- modes

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


# ---------------------------------------------------------------- cache

def bar(cache: Path | None, told: list[str], material: Material = STEEL,
        count: int = 3) -> SolidModes:
    return solid_modes(sector_mesh(SECTOR, 0.0, 0.02, (2, 3, 1)), material, count,
                       clamped=at_radius(0.1), cache=cache, progress=told.append)


def test_solved_once(tmp_path: Path) -> None:
    told: list[str] = []
    first = bar(tmp_path / 'new', told)
    assert told[0] == f'assembling {first.basis.N} unknowns'
    assert 'factorising' in told
    told.clear()
    second = bar(tmp_path / 'new', told)
    assert told == []
    assert np.array_equal(first.shapes, second.shapes)
    assert np.array_equal(first.angular_frequencies, second.angular_frequencies)
    assert len(list((tmp_path / 'new').iterdir())) == 1


@pytest.mark.parametrize('change', ['material', 'count', 'mesh', 'held', 'element'])
def test_whatever_modes_depend_on_is_in_the_key(change: str, tmp_path: Path) -> None:
    def solve(*changes: str) -> None:
        mesh = sector_mesh(SECTOR, 0.0, 0.021 if 'mesh' in changes else 0.02, (2, 2, 1))
        solid_modes(mesh, Material(210e9, 7851.0, 0.3) if 'material' in changes else STEEL,
                    4 if 'count' in changes else 3, cache=tmp_path,
                    clamped=at_radius(0.142 if 'held' in changes else 0.1),
                    element=skfem.ElementHexS2() if 'element' in changes else None)

    solve()
    solve(change)
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize('damage', ['empty', 'cut', 'flipped', 'text', 'pickle', 'other', 'nan'])
def test_damaged_entries_are_written_anew(damage: str, tmp_path: Path) -> None:
    told: list[str] = []
    first = bar(tmp_path, told)
    entry, = tmp_path.iterdir()
    sound = entry.read_bytes()
    with np.load(entry) as found:
        parts = dict(found)
    if damage in ('empty', 'cut', 'text'):
        entry.write_bytes({'empty': b'', 'cut': sound[:len(sound) // 2], 'text': b'modes'}[damage])
    elif damage == 'flipped':
        middle = len(sound) // 2
        entry.write_bytes(sound[:middle] + bytes([sound[middle] ^ 1]) + sound[middle + 1:])
    else:
        parts |= {'pickle': {'shapes': np.array([{}], object)}, 'other': {'key': np.array('x')},
                  'nan': {'shapes': parts['shapes'] * np.nan}}[damage]
        np.savez(entry, **parts)
    told.clear()
    again = bar(tmp_path, told)
    assert 'factorising' in told
    assert np.array_equal(first.shapes, again.shapes)
    told.clear()
    bar(tmp_path, told)
    assert told == []
    assert list(tmp_path.iterdir()) == [entry]


def test_a_cache_that_cannot_be_written_costs_nothing_but_itself(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    with pytest.warns(RuntimeWarning, match='modes are not cached'):
        assert bar(tmp_path / 'file' / 'folder', []).angular_frequencies.size == 3


def test_free_modes_are_cached_too(tmp_path: Path) -> None:
    basis = skfem.CellBasis(sector_mesh(SECTOR, 0.0, 0.02, (2, 3, 1)),
                            skfem.ElementVector(skfem.ElementHex2()), intorder=1)
    told: list[str] = []
    first = free_modes(basis, STEEL, 8, cache=tmp_path, progress=told.append)
    assert told
    told.clear()
    assert np.array_equal(first.shapes, free_modes(
        basis, STEEL, 8, cache=tmp_path, progress=told.append).shapes)
    assert not told


def test_where_the_cache_is(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path))
    assert cache_folder() == tmp_path / 'squeal_ros'
    monkeypatch.delenv('XDG_CACHE_HOME')
    monkeypatch.setenv('HOME', str(tmp_path))
    assert cache_folder() == tmp_path / '.cache' / 'squeal_ros'
