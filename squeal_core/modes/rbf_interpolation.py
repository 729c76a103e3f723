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

"""Interpolation of values at scattered nodes of a plane, theta derivative included."""

import math

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError

_TOLD_APART = 1e-3  # least singular value, to the greatest, of monomials that nodes tell apart
_CHUNK = 4096  # points at a time: 70 MB of interpolation systems


def local_weights(radius: FloatArray, angle: FloatArray, at_radius: FloatArray,
                  at_angle: FloatArray, *, degree: int = 4) -> tuple[csr_matrix, csr_matrix]:
    """
    Return matrices for values and theta derivatives interpolated from scattered nodes.

    Polyharmonic splines rho^5 with polynomials, through the nearest nodes of each point (Bayona
    et al., J. Comput. Phys. 332 (2017) 257-273), in r and arc length r0 (theta - theta0), in
    which bodies of revolution are straight.

    Parameters
    ----------
    radius, angle : (M,) arrays
        Nodes of one plane [m, rad].
    at_radius, at_angle : (P,) arrays
        Radius of the target [m].
    degree : int
        Of polynomials that are held exactly, where nodes tell them apart: values converge with
        h^(degree + 1), derivatives with h^degree.

    Returns
    -------
    values, derivatives : (P, M) sparse arrays

    Raises
    ------
    SquealError
        For points that lie off the nodes.

    """
    places = [np.column_stack([r * np.cos(t), r * np.sin(t)]) for r, t in (
        (radius, angle), (at_radius, at_angle))]
    count = min((degree + 1) * (degree + 2), radius.size)
    distance, near = cKDTree(places[0]).query(places[1], k=count)
    reach = distance[:, -1:]
    if np.any(distance[:, :1] > 0.5 * reach):
        worst = int(np.argmax(distance[:, 0] / reach[:, 0]))
        raise SquealError(
            f'planar mesh: the point at r = {at_radius[worst]:.6g} m, theta = '
            f'{at_angle[worst]:.4g} rad lies off the nodes; check that they cover the contact '
            'and are in the right place and unit')
    turn = angle[near] - at_angle[:, None]
    s = (radius[near] - at_radius[:, None]) / reach
    q = at_radius[:, None] * (turn - 2.0 * math.pi * np.round(turn / (2.0 * math.pi))) / reach
    both = np.concatenate([_stencils(s[i:i + _CHUNK], q[i:i + _CHUNK], degree)
                           for i in range(0, len(s), _CHUNK)])
    both[..., 1] *= at_radius[:, None] / reach
    rows = np.arange(len(s) + 1) * count
    values, derivatives = (csr_matrix((part.ravel(), near.ravel(), rows), (len(s), radius.size))
                           for part in np.moveaxis(both, -1, 0))
    return values, derivatives


def _stencils(s: FloatArray, q: FloatArray, degree: int) -> FloatArray:
    """
    Return weights (P, k, 2) for value and d/dq at the origin of nodes at (s, q), each (P, k).

    Nodes may lie in few rows of constant r, as across a thin wall: then the degree across is
    lowered until they tell the monomials apart, before the total degree is.
    """
    weights, left = np.empty((*s.shape, 2)), np.arange(len(s))
    for total, across in ((i, j) for i in range(degree, -1, -1) for j in range(i, -1, -1)):
        powers = [(i, j) for i in range(across + 1) for j in range(total + 1 - i)]
        if len(powers) > s.shape[1] or not left.size:
            continue
        monomials = np.stack([s[left]**i * q[left]**j for i, j in powers], axis=2)
        sizes = np.linalg.svd(monomials, compute_uv=False)
        good = sizes[:, -1] >= _TOLD_APART * sizes[:, 0]
        weights[left[good]] = _spline(s[left[good]], q[left[good]], monomials[good], powers)
        left = left[~good]
    return weights


def _spline(s: FloatArray, q: FloatArray, monomials: FloatArray,
            powers: list[tuple[int, int]]) -> FloatArray:
    """Solve for the weights of a polyharmonic spline with these monomials (P, k, m)."""
    count, nodes, terms = monomials.shape
    order = min(2 * powers[-1][0] + 2 * powers[-1][1] + 1, 5)
    system = np.zeros((count, nodes + terms, nodes + terms))
    system[:, :nodes, :nodes] = np.hypot(
        s[:, :, None] - s[:, None], q[:, :, None] - q[:, None])**order
    system[:, :nodes, nodes:] = monomials
    system[:, nodes:, :nodes] = monomials.swapaxes(1, 2)
    right, distance = np.zeros((count, nodes + terms, 2)), np.hypot(s, q)
    right[:, :nodes, 0] = distance**order
    right[:, :nodes, 1] = -order * q * distance**max(order - 2, 0)
    right[:, nodes + powers.index((0, 0)), 0] = 1.0
    if (0, 1) in powers:
        right[:, nodes + powers.index((0, 1)), 1] = 1.0
    return np.asarray(np.linalg.solve(system, right)[:, :nodes])
