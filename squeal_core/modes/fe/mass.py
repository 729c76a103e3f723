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

"""Modal masses of nodal shapes, integrated over their elements; needs no scikit-fem."""

from itertools import product
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes

_CUBE: tuple[tuple[int, ...], ...] = tuple(product((0, 1), repeat=3))
_SERENDIPITY = _CUBE + tuple(
    p for axis in range(3) for p in product(*(((2,) if i == axis else (0, 1)) for i in range(3))))
_SIMPLEX = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
_PRISM = tuple((*p, k) for k in (0, 1) for p in ((0, 0), (1, 0), (0, 1)))
# monomials that span the shape functions of a kind, as powers of the local coordinates
_MONOMIALS: dict[str, tuple[tuple[int, ...], ...]] = {
    'tet4': _SIMPLEX,
    'tet10': tuple(p for p in product(range(3), repeat=3) if sum(p) <= 2),
    'hex8': _CUBE,
    'hex20': _SERENDIPITY,
    'hex27': tuple(product(range(3), repeat=3)),
    'wedge6': _PRISM,
    'wedge15': _PRISM + tuple((*p, k) for k in (0, 1) for p in ((2, 0), (1, 1), (0, 2)))
    + tuple((*p, 2) for p in ((0, 0), (1, 0), (0, 1))),
}
_HEX = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
                 [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
_WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
_CORNERS = {'tet': np.array(_SIMPLEX, float), 'hex': _HEX, 'wedge': _WEDGE}
_FACES = ((0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7))

# the two corners that each mid-edge node lies between, in the order of ElementBlock
EDGES: dict[str, tuple[tuple[int, int], ...]] = {
    'tet': ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)),
    'hex': ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4),
            (0, 4), (1, 5), (2, 6), (3, 7)),
    'wedge': ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
}
_POINTS = 4  # Gauss points a direction: exact for quadratic shapes on straight elements


def modal_masses(modes: NodalModes, density: float) -> FloatArray:
    """
    Return the integral of density times the shape squared over the elements, of each mode.

    Parameters
    ----------
    modes : NodalModes
        With elements, of a shape that need not be normalised.
    density : float
        [kg/m^3].

    Returns
    -------
    (N,) array
        [kg] times the unit of the shapes squared: 1 where they are mass normalised.

    Raises
    ------
    ModesError
        For modes without elements, and elements that are turned inside out.

    """
    return np.diag(mass_products(modes.shapes, mass_matrix(modes, density))).copy()


def mass_matrix(modes: NodalModes, density: float) -> Any:
    """
    Return the consistent mass matrix of the nodes, sparse (M, M), for each direction [kg].

    Raises
    ------
    ModesError
        As `modal_masses`.

    """
    if not modes.elements:
        raise ModesError(f'{modes.source or "modes"}: there are no elements to integrate over; '
                         'export them, or state the modal masses')
    return density * sum(_mass_matrix(modes, block) for block in modes.elements)


def mass_products(shapes: FloatArray, mass: Any) -> FloatArray:
    """Return the products (N, N) of shapes (N, M, 3) over a mass matrix (M, M)."""
    return np.asarray(sum(shapes[:, :, axis] @ (mass @ shapes[:, :, axis].T)
                          for axis in range(3)))


def reference_nodes(kind: str) -> FloatArray:
    """Return the local coordinates (n, 3) of the nodes of a kind of element, 0 to 1."""
    shape = kind.rstrip('0123456789')
    if kind not in _MONOMIALS:
        raise ModesError(f'elements of kind {kind} are not known; use one of '
                         f'{", ".join(_MONOMIALS)}')
    corners = _CORNERS[shape]
    middles = corners[np.array(EDGES[shape])].mean(axis=1)
    nodes = np.vstack([corners, middles])
    if kind == 'hex27':
        faces = [corners[list(face)].mean(axis=0) for face in _FACES]
        return np.vstack([nodes, *faces, corners.mean(axis=0)])
    return np.asarray(nodes[:int(kind.removeprefix(shape))])


def _mass_matrix(modes: NodalModes, block: ElementBlock) -> coo_matrix:
    """Return the integrals of products of shape functions [m^3], sparse (M, M)."""
    points, weights = rule(block.kind)
    values, gradients = shape_functions(block.kind, points)
    where = modes.coordinates[block.nodes]
    volume = np.linalg.det(np.einsum('qnd,enx->eqxd', gradients, where, optimize=True))
    if np.any(volume.min(axis=1) * volume.max(axis=1) <= 0.0):
        worst = int(np.argmin(volume.min(axis=1) * volume.max(axis=1)))
        raise ModesError(
            f'{modes.source or "modes"}: {block.kind} number {worst + 1} is flat or turned '
            'inside out; check the mesh and the order of the nodes in its elements')
    local = np.einsum('q,eq,qn,qm->enm', weights, np.abs(volume), values, values, optimize=True)
    n = block.nodes.shape[1]
    rows, columns = np.repeat(block.nodes, n, axis=1), np.tile(block.nodes, (1, n))
    size = len(modes.coordinates)
    return coo_matrix((local.ravel(), (rows.ravel(), columns.ravel())), (size, size)).tocsr()


def shape_functions(kind: str, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return values (Q, n) and gradients (Q, n, 3) of a kind of element at local points (Q, 3)."""
    powers = np.array(_MONOMIALS[kind])
    solve = np.linalg.inv(_monomials(reference_nodes(kind), powers))
    slopes = [powers[:, axis] * _monomials(points, np.maximum(powers - np.eye(3, dtype=int)[axis],
                                                              0)) @ solve for axis in range(3)]
    return _monomials(points, powers) @ solve, np.stack(slopes, axis=2)


def _monomials(points: FloatArray, powers: FloatArray) -> FloatArray:
    return np.asarray(np.prod(points[:, None, :] ** powers, axis=2))


def rule(kind: str) -> tuple[FloatArray, FloatArray]:
    """Return Gauss points (Q, 3) and weights; collapsed from the cube for tetrahedra, wedges."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    a, b, c = (grid.ravel() for grid in np.meshgrid(x, x, x))
    weights = np.prod(np.meshgrid(w, w, w), axis=0).ravel()
    if kind.startswith('hex'):
        return np.stack([a, b, c], axis=1), weights
    if kind.startswith('wedge'):
        return np.stack([a, b * (1 - a), c], axis=1), weights * (1 - a)
    return (np.stack([a, b * (1 - a), c * (1 - a) * (1 - b)], axis=1),
            weights * (1 - a)**2 * (1 - b))
