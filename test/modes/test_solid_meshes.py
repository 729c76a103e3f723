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

"""Meshes of hexahedra and tetrahedra: surfaces, points found in them, layers, seeds."""

from typing import Any

import numpy as np
import pytest
import skfem
from squeal_core.brake.dimensions import Brake
from squeal_core.common.errors import SquealError
from squeal_core.modes.fe.locate import cells_of, locate
from squeal_core.modes.fe.meshes import hat_disc_mesh, pad_mesh
from support.solids import SECTOR


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
