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

"""Modes of other packages, sampled by the elements that they were solved on."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.fe.mass import modal_masses, reference_nodes
from squeal_core.modes.fe.meshes import pad_mesh
from squeal_core.modes.fe.mixed import ElementModes
from squeal_core.modes.fe.solid import solid_modes, SolidModes
from squeal_core.modes.modal_basis import Quadrature
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes
from support.solids import SECOND_ORDER, SECTOR, STEEL

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


def quadrature(where: FloatArray) -> Quadrature:
    """Points (Q, 3), weighted by their radius."""
    r, t = np.hypot(where[:, 0], where[:, 1]), np.arctan2(where[:, 1], where[:, 0])
    return Quadrature(r, t, where[:, 2], r)


def assert_sampled(modes: SolidModes | ElementModes, field: Callable[[FloatArray], FloatArray],
                   inside: FloatArray) -> None:
    """Modes sampled at points (Q, 3) are a field, and d/dtheta of it."""
    points = quadrature(inside)
    r, t, found = points.radius, points.angle, modes.sample(points)

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
    assert_sampled(modes, field, inside)


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
    assert_sampled(modes, field, inside)
    points = quadrature(inside)
    layers = list(modes.volume_layers())
    volume = (2.0 - low) * np.linalg.det(turn) * 0.02**3
    assert sum(s.points.weight.sum() for s in layers) == pytest.approx(volume, rel=1e-12)
    masses = sum(np.sum(s.points.weight * f**2, axis=1) for s in layers
                 for f in (s.radial, s.tangential, s.normal))
    assert masses == pytest.approx(modal_masses(modes.modes, 1.0), rel=1e-12)
    with pytest.raises(SquealError, match='points lie outside the mesh'):
        modes.sample(replace(points, radius=points.radius + 0.1))
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
