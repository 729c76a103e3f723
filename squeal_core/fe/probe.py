"""Values of finite element functions at arbitrary points, also where elements are curved."""

from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree
import skfem

from squeal_core.arrays import FloatArray
from squeal_core.errors import SquealError

_CANDIDATES = 12  # elements with the nearest centres that are tried for a point
_NEWTON_STEPS = 12
_ROUNDING = 1e-9  # on a face, as far as rounding can tell
_OUTSIDE = 1e-2  # how far outside its element a point may lie, in units of the element


def probe_matrix(basis: skfem.CellBasis, points: FloatArray) -> Any:
    """Return the sparse matrix (3 P, dofs) that gives a vector field's values at points (3, P).

    scikit-fem's own search takes elements by their corners and loses points between a chord and
    its arc; this one inverts the curved mapping.

    Raises
    ------
    SquealError
        For points outside the mesh.
    """
    cells, local = _locate(basis, points)
    count = points.shape[1]
    values = np.array([basis.elem.gbasis(basis.mapping, local, k, tind=cells)[0].value
                       for k in range(basis.Nbfun)])
    rows = np.tile(np.arange(3 * count), basis.Nbfun)
    columns = np.repeat(basis.element_dofs[:, None, cells], 3, axis=1)
    return coo_matrix((values.ravel(), (rows, columns.ravel())),
                      shape=(3 * count, basis.N)).tocsr()


def _locate(basis: skfem.CellBasis, points: FloatArray) -> tuple[Any, FloatArray]:
    """Return each point's element and its local coordinates (3, P, 1)."""
    mesh = basis.mesh
    centres = mesh.p[:, mesh.t].mean(axis=1)
    count = min(_CANDIDATES, mesh.nelements)
    _, near = cKDTree(centres.T).query(points.T, k=count)
    cells = np.zeros(points.shape[1], dtype=np.int64)
    local, best = np.zeros((*points.shape, 1)), np.full(points.shape[1], np.inf)
    for candidate in near.reshape(-1, count).T:
        open_ = np.flatnonzero(best > _ROUNDING)
        if open_.size == 0:
            break
        x = _invert(basis.mapping, points[:, open_], candidate[open_])
        outside = _outside(mesh, x[:, :, 0])
        better = outside < best[open_]
        won = open_[better]
        cells[won], best[won], local[:, won] = candidate[won], outside[better], x[:, better]
    if best.max() > _OUTSIDE:
        where = points[:, int(best.argmax())]
        raise SquealError(
            f'{np.count_nonzero(best > _OUTSIDE)} of {best.size} points lie outside the mesh, '
            f'one at x, y, z = {where.round(6).tolist()} m; check that the mesh covers the '
            'contact patch and is in the right place and unit')
    return cells, local


def _invert(mapping: Any, points: FloatArray, cells: FloatArray) -> FloatArray:
    x = np.full((*points.shape, 1), 0.4)
    for _ in range(_NEWTON_STEPS):
        step = np.einsum('ijkl,jkl->ikl', mapping.invDF(x, cells),
                         points[:, :, None] - mapping.F(x, cells))
        x = np.clip(x + step, -0.5, 1.5)
        if np.abs(step).max() < 1e-13:
            break
    return x


def _outside(mesh: skfem.Mesh, x: FloatArray) -> FloatArray:
    """How far local coordinates (3, P) lie outside the reference element; none below zero."""
    over = x.sum(axis=0) if mesh.refdom is skfem.refdom.RefTet else x.max(axis=0)
    return np.asarray(np.maximum(np.maximum(-x.min(axis=0), over - 1.0), 0.0))
