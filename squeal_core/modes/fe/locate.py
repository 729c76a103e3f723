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

"""Location of points in a mesh, also where its elements are long and curved."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error

from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.fe.elements import functions

_NEAR = 32  # elements with the nearest centres, tried first
_CHUNK = 5_000_000  # points times elements looked at together: 40 MB
_BOX = 0.75  # half the box around an element, in sizes of its nodes' box: curves bulge beyond it
_NEWTON_STEPS = 12
_ROUNDING = 1e-9  # on a face, as far as rounding can tell
_OUTSIDE = 1e-2  # how far outside its element a point may lie, in units of the element


@dataclass(frozen=True)
class Cells:
    """
    Elements of one kind.

    Parameters
    ----------
    nodes : (3, n, E) array
        Where they lie [m].
    places : (n, 3) array
        Where they lie in the reference element.
    functions : callable
        Gives values (n, P) and gradients (n, 3, P) at local points (3, P).
    shape : str
        'tet', 'hex' or 'wedge'.

    """

    nodes: FloatArray
    places: FloatArray
    functions: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
    shape: str

    def geometry(self, cells: Any, local: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return places (3, P) of local points, and gradients (3, 3, P) dx_i / d local_j."""
        values, slopes = self.functions(local)
        nodes = self.nodes[:, :, cells]
        return (np.einsum('inp,np->ip', nodes, values),
                np.einsum('inp,njp->ijp', nodes, slopes))

    def outside(self, x: FloatArray) -> FloatArray:
        """Return the distance of local coordinates (3, P) from the element; 0 inside."""
        over = {'tet': x.sum(axis=0), 'hex': x.max(axis=0),
                'wedge': np.maximum(x[0] + x[1], x[2])}[self.shape]
        return np.asarray(np.maximum(np.maximum(-x.min(axis=0), over - 1.0), 0.0))


def locate(mesh: skfem.Mesh, points: FloatArray) -> tuple[Any, FloatArray]:
    """
    Return the element that each point (3, P) lies in, and its local coordinates (3, P).

    Raises
    ------
    SquealError
        For points outside the mesh.

    """
    cells, local, outside = search(cells_of(mesh), points)
    check_found(outside, points)
    return cells, local


def cells_of(mesh: skfem.Mesh) -> Cells:
    """Return the elements of a mesh, with its own geometry."""
    return Cells(mesh.doflocs[:, mesh.dofs.element_dofs], mesh.elem.doflocs,
                 lambda x: functions(mesh.elem(), x),
                 'tet' if mesh.refdom is skfem.refdom.RefTet else 'hex')


def search(cells: Cells, points: FloatArray) -> tuple[Any, FloatArray, FloatArray]:
    """
    Return the element nearest to each point (3, P), local coordinates, and how far outside.

    scikit-fem's own search takes elements by their corners and loses points between a chord and
    its arc; this one inverts the curved geometry. The elements with the nearest centres are tried
    first, then all others whose box holds the point: long ones hide behind many short ones.
    """
    low, high = cells.nodes.min(axis=1), cells.nodes.max(axis=1)
    middle, size = 0.5 * (low + high), _BOX * (high - low)
    number = np.zeros(points.shape[1], dtype=np.int64)
    local, best = np.zeros(points.shape), np.full(points.shape[1], np.inf)
    for at, near in _candidates(cells.nodes.mean(axis=1), points, best):
        where = points[:, at]
        fits = np.ones(near.shape, bool)
        for axis in range(3):
            fits &= np.abs(where[axis][:, None] - middle[axis, near]) <= size[axis, near]
        turn = np.cumsum(fits, axis=1) * fits
        for k in range(1, int(turn.max(initial=0)) + 1):
            rows, columns = np.nonzero((turn == k) & (best[at] > _ROUNDING)[:, None])
            mine, own = at[rows], near[rows, columns]
            x, missed = _invert(cells, points[:, mine], own)
            missed /= np.linalg.norm(size[:, own], axis=0)
            outside = np.where(missed < 1e-9, cells.outside(x), np.inf)
            won = outside < best[mine]
            number[mine[won]], best[mine[won]] = own[won], outside[won]
            local[:, mine[won]] = x[:, won]
    return number, local, best


def _candidates(centres: FloatArray, points: FloatArray,
                best: FloatArray) -> Iterator[tuple[Any, Any]]:
    """
    Yield numbers of points (p,) and of elements to try for each (p, k), nearest ones first.

    What is not found by then (`best`, which the caller updates) gets all elements.
    """
    count = centres.shape[1]
    near = cKDTree(centres.T).query(points.T, k=range(1, min(_NEAR, count) + 1))[1]
    yield np.arange(points.shape[1]), near
    left = np.flatnonzero(best > _ROUNDING)
    step = max(1, _CHUNK // count)
    for start in range(0, left.size, step):
        part = left[start:start + step]
        yield part, np.broadcast_to(np.arange(count), (part.size, count))


def check_found(outside: FloatArray, points: FloatArray) -> None:
    """Raise SquealError for points (3, P) too far outside their elements."""
    lost = np.flatnonzero(outside > _OUTSIDE)
    if lost.size:
        raise SquealError(
            f'{lost.size} of {outside.size} points lie outside the mesh, one at x, y, z = '
            f'{points[:, lost[outside[lost].argmax()]].round(6).tolist()} m; check that the mesh '
            'covers the contact patch and is in the right place and unit')


def inverse(slopes: FloatArray) -> FloatArray:
    """Return d local_j / dx_i (P, j, i) of gradients (3, 3, P); a collapsed edge has none."""
    matrices = slopes.transpose(2, 0, 1)
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.pinv(matrices))


def _invert(cells: Cells, points: FloatArray, own: Any) -> tuple[FloatArray, FloatArray]:
    """
    Return local coordinates by Newton's method, and by how far it missed the points (P,).

    It starts near the node next to each point: long elements bend far.
    """
    nodes = cells.nodes[:, :, own]
    next_to = np.linalg.norm(nodes - points[:, None], axis=0).argmin(axis=0)
    x = (0.8 * cells.places[next_to] + 0.2 * cells.places.mean(axis=0)).T
    for _ in range(_NEWTON_STEPS):
        result, slopes = cells.geometry(own, x)
        step = np.einsum('pji,ip->jp', inverse(slopes), points - result)
        x = np.clip(x + step, -0.5, 1.5)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return np.asarray(x), np.linalg.norm(points - cells.geometry(own, x)[0], axis=0)
