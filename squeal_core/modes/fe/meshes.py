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

"""
Meshes of hat discs and pads.

They are of second order, turned from a section of quadrilaterals, with mid-nodes on the true
curves. They can be made irregular on purpose: what is found on them must not depend on it.
"""

from itertools import permutations
from typing import Any, Literal, TypeAlias

import numpy as np

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error

from squeal_core.brake.dimensions import Contact, HatDisc
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe.axisymmetric import hat_section
from squeal_core.modes.fe.elements import bent, shapes_at

Shape: TypeAlias = Literal['hexahedra', 'tetrahedra']


def hat_disc_mesh(disc: HatDisc, *, element_size: float = 0.012, around: int = 48,
                  corner_layers: int = 0, shape: Shape = 'hexahedra', irregularity: float = 0.0,
                  layered: bool = True, seed: int = 0) -> skfem.Mesh:
    """
    Return a second-order mesh of a hat disc.

    Parameters
    ----------
    disc : HatDisc
        Dimensions and material.
    element_size : float
        Largest element edge in the section [m].
    around : int
        Elements round the circle.
    corner_layers : int
        Geometric layers of elements towards the hat's re-entrant corners.
    shape : str
        'hexahedra', or 'tetrahedra': six to a hexahedron.
    irregularity : float
        How far a node is moved at random, from 0 to about 0.6, in halves of the distance to its
        nearest neighbour; surfaces stay where they are.
    layered : bool
        Leave nodes in their planes of constant z, as the planar-mesh method needs it.
    seed : int
        Of the random moves.

    """
    section = hat_section(disc, element_size, corner_layers)
    angles = np.linspace(0.0, 2.0 * np.pi, around + 1)
    moves = _moves(section, angles, irregularity, layered, seed, closed=True)
    return _turned(section, angles, moves, shape)


def pad_mesh(contact: Contact, bottom: float, top: float, elements: tuple[int, int, int], *,
             shape: Shape = 'hexahedra', irregularity: float = 0.0, layered: bool = True,
             seed: int = 0) -> skfem.Mesh:
    """
    Return a second-order mesh of the contact sector, centred at theta = 0; see `hat_disc_mesh`.

    Parameters
    ----------
    contact : Contact
        Contact patch.
    bottom, top : float
        z of its faces [m].
    elements : (3,) ints
        Elements in r, theta and z; tetrahedra: six times as many.
    shape, irregularity, layered, seed
        As for `hat_disc_mesh`.

    """
    section = skfem.MeshQuad.init_tensor(
        np.linspace(contact.inner_radius, contact.outer_radius, elements[0] + 1),
        np.linspace(bottom, top, elements[2] + 1))
    angles = 0.5 * contact.angle * np.linspace(-1.0, 1.0, elements[1] + 1)
    moves = _moves(section, angles, irregularity, layered, seed, closed=False)
    return _turned(section, angles, moves, shape)


def sector_mesh(contact: Contact, bottom: float, top: float,
                elements: tuple[int, int, int]) -> skfem.MeshHex2:
    """Return regular second-order hexahedra over an annular sector, numbered along r first."""
    box = skfem.MeshHex2.from_mesh(skfem.MeshHex.init_tensor(
        *(np.linspace(0.0, 1.0, n + 1) for n in elements)))
    r = contact.inner_radius + box.doflocs[0] * (contact.outer_radius - contact.inner_radius)
    t = (box.doflocs[1] - 0.5) * contact.angle
    z = bottom + box.doflocs[2] * (top - bottom)
    return skfem.MeshHex2(_cartesian(np.array([r, t, z])), box.t)


def _moves(section: skfem.MeshQuad, angles: FloatArray, irregularity: float, layered: bool,
           seed: int, *, closed: bool) -> FloatArray:
    """Return random moves (3, nodes of the section, angles) in r, theta, z that keep surfaces."""
    count = angles.size - closed
    reach = np.zeros((3, section.p.shape[1], count))
    free = _free_to_move(section)
    for axis, row in ((0, 0), (2, 1)):
        reach[axis] = (free[row] * _spacing(section, row))[:, None]
    reach[1] = angles[1] - angles[0]
    if not closed:
        reach[1][:, [0, -1]] = 0.0
    if layered:
        reach[2] = 0.0
    moves = 0.5 * irregularity * reach * np.random.default_rng(seed).uniform(
        -1.0, 1.0, reach.shape)
    return np.concatenate([moves, moves[:, :, :1]], axis=2) if closed else moves


def _free_to_move(section: skfem.MeshQuad) -> Any:
    """Return a mask (2, nodes): along r unless on an edge of constant r, along z likewise."""
    free = np.ones(section.p.shape, bool)
    ends = section.facets[:, section.boundary_facets()]
    along = np.abs(np.diff(section.p[:, ends], axis=1))[:, 0]
    for row in (0, 1):
        free[row, ends[:, along[row] < along[1 - row]]] = False
    return free


def _spacing(section: skfem.MeshQuad, row: int) -> FloatArray:
    """Return the least distance of each node of the section to a neighbour along r or z."""
    ends = section.facets
    along = np.abs(np.diff(section.p[:, ends], axis=1))[:, 0]
    least = np.full(section.p.shape[1], np.inf)
    mine = along[row] > along[1 - row]
    for end in ends:
        np.minimum.at(least, end[mine], along[row, mine])
    return least


def _turned(section: skfem.MeshQuad, angles: FloatArray, moves: FloatArray,
            shape: Shape) -> skfem.Mesh:
    """Turn a section about the axis; nodes of the last angle are those of the first on a ring."""
    linear, curved = ((skfem.MeshHex1, skfem.MeshHex2) if shape == 'hexahedra'
                      else (skfem.MeshTet1, skfem.MeshTet2))
    flat, step = section.p.shape[1], angles.size - 1
    cube = skfem.refdom.RefHex.p.T.astype(int)  # along r, theta, z: right-handed
    corners = section.t[[{(0, 0): 0, (0, 1): 1, (1, 1): 2, (1, 0): 3}[a, c] for a, _, c in cube]]
    node = np.repeat(corners, step, axis=1)
    turn = cube[:, 1:2] + np.tile(np.arange(step), corners.shape[1])
    where = moves[:, node, turn]
    where += [section.p[0, node], angles[turn], section.p[1, node]]
    around = step if np.isclose(angles[-1] - angles[0], 2.0 * np.pi) else step + 1
    cells = node + flat * (turn % around)
    if shape == 'tetrahedra':
        cells, where = (np.concatenate([a[..., four, :] for four in _kuhn(cube)], axis=-1)
                        for a in (cells, where))
    points = np.zeros((3, int(cells.max()) + 1))
    points[:, cells] = _cartesian(where)
    middles = shapes_at(linear.elem, curved.elem.doflocs)
    return bent(linear(points, cells), curved,
                _cartesian(np.einsum('np,ane->ape', middles, where)))


def _kuhn(cube: Any) -> list[list[int]]:
    """Return six tetrahedra on the cube's diagonal, whose faces match those of its neighbours."""
    number = {tuple(place): i for i, place in enumerate(cube.tolist())}
    tetrahedra = []
    for axes in permutations(range(3)):
        steps = np.cumsum(np.vstack([np.zeros(3, int), np.eye(3, dtype=int)[list(axes)]]), axis=0)
        four = [number[tuple(place)] for place in steps.tolist()]
        right_handed = axes[0] == (axes[2] + 1) % 3
        tetrahedra.append(four if right_handed else [four[i] for i in (1, 0, 2, 3)])
    return tetrahedra


def _cartesian(polar: FloatArray) -> FloatArray:
    r, t, z = polar
    return np.array([r * np.cos(t), r * np.sin(t), z])
