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

"""Stiffness and mass of an elastic solid, and its lowest modes by shift-invert."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import eigsh, LinearOperator, splu

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error

from squeal_core.brake.dimensions import Material
from squeal_core.common.arrays import FloatArray

_TELL_EVERY = 25  # solves between two words of progress


def scalar_basis(basis: skfem.CellBasis) -> skfem.CellBasis:
    """Return the element's own functions at points that integrate the product of any two."""
    element = basis.elem.elem
    linear = type(element) in (skfem.ElementTetP1, skfem.ElementHex1)
    tetrahedra = element.refdom is skfem.refdom.RefTet
    order = (2 if linear else 4) if tetrahedra else (3 if linear else 5)
    return skfem.CellBasis(basis.mesh, element, mapping=basis.mapping, intorder=order)


def tables(plain: skfem.CellBasis) -> tuple[FloatArray, FloatArray]:
    """Return values (n, E, Q) and gradients (n, 3, E, Q) of the element's functions."""
    fields = [row[0] for row in plain.basis]
    shape = plain.dx.shape
    return (np.array([np.broadcast_to(f.value, shape) for f in fields]),
            np.array([np.broadcast_to(f.grad, (3, *shape)) for f in fields]))


def assembled(basis: skfem.CellBasis, material: Material) -> tuple[Any, Any]:
    """
    Return stiffness [N/m] and mass [kg] of a vector basis, sparse (dofs, dofs).

    All element matrices are made at once, not by pairs of functions.
    """
    e, nu = material.young_modulus, material.poisson_ratio
    lame, shear = e * nu / (1 + nu) / (1 - 2 * nu), e / 2 / (1 + nu)
    plain = scalar_basis(basis)
    values, gradients = tables(plain)
    count, _, cells, points = gradients.shape
    g = gradients.transpose(2, 0, 1, 3).reshape(cells, -1, points)
    products = ((g * plain.dx[:, None]) @ g.swapaxes(1, 2)).reshape(cells, count, 3, count, 3)
    stiffness = lame * products + shear * products.transpose(0, 1, 4, 3, 2)
    laplace = shear * np.einsum('ekili->ekl', products)
    v = values.swapaxes(0, 1)
    masses = material.density * ((v * plain.dx[:, None]) @ v.swapaxes(1, 2))
    mass = np.zeros_like(stiffness)
    for axis in range(3):
        stiffness[:, :, axis, :, axis] += laplace
        mass[:, :, axis, :, axis] = masses
    return gathered(basis, stiffness), gathered(basis, mass)


def gathered(basis: skfem.CellBasis, blocks: FloatArray) -> Any:
    """Return the sparse (dofs, dofs) matrix of element matrices (E, functions, functions)."""
    dofs = basis.element_dofs.T
    rows = np.broadcast_to(dofs[:, :, None], (*dofs.shape, dofs.shape[1]))
    matrix = coo_matrix((blocks.ravel(), (rows.ravel(), rows.swapaxes(1, 2).ravel())),
                        shape=(basis.N, basis.N)).tocsc()
    matrix.eliminate_zeros()
    return matrix


def rigid_shapes(basis: skfem.CellBasis, mass: Any) -> FloatArray:
    """
    Return mass-normalised translations and rotations about the mass centre, as `RIGID_NAMES`.

    They are linear in the coordinates, so their values at the nodes hold them exactly.
    """
    dofs, where = basis.split_indices(), basis.doflocs

    def field(**components: FloatArray) -> FloatArray:
        values = np.zeros(basis.N)
        for axis, component in components.items():
            values[dofs['xyz'.index(axis)]] = component
        return values

    unit = np.ones(dofs[0].size)
    slide = [field(**{axis: unit}) for axis in 'xyz']
    x, y, z = (where[i, dofs[i]] - (s @ (mass @ field(**{'xyz'[i]: where[i, dofs[i]]})))
               / (s @ (mass @ s)) for i, s in enumerate(slide))
    shapes = np.array([slide[0], slide[1], field(x=-y, y=x), slide[2],
                       field(y=-z, z=y), field(z=-x, x=z)])
    return np.linalg.solve(np.linalg.cholesky(shapes @ (mass @ shapes.T)), shapes)


def lowest_modes(stiffness: Any, mass: Any, shift: float, rigid: FloatArray, count: int,
                 progress: Callable[[str], None]) -> tuple[FloatArray, FloatArray]:
    """
    Return the lowest modes by shift-invert on the complement of the rigid ones.

    These cannot leak in. The factorisation is ordered for a symmetric matrix and takes no pivots:
    a fraction of the time and the memory of the usual one.

    Parameters
    ----------
    stiffness, mass : sparse (n, n) arrays
        Stiffness matrix.
    shift : float
        Below the lowest eigenvalue [rad^2/s^2].
    rigid : (R, n) array
        Mass-normalised rigid modes; none where R is 0.
    count : int
        Number of modes, those in `rigid` left out.
    progress : callable
        Told in a few words what is being done.

    Returns
    -------
    squares : (count,) array
        Rising eigenvalues [rad^2/s^2].
    shapes : (count, n) array
        Mass normalised [kg^-1/2].

    """
    progress('factorising')
    factor = splu((stiffness - shift * mass).tocsc(), permc_spec='MMD_AT_PLUS_A',
                  diag_pivot_thresh=0.0, options={'SymmetricMode': True})
    solves = iter(range(1, 1_000_000))

    def solve(b: FloatArray) -> FloatArray:
        if (done := next(solves)) % _TELL_EVERY == 0:
            progress(f'{done} solves for {count} modes')
        x: FloatArray = factor.solve(b - mass @ (rigid.T @ (rigid @ b)))
        return np.asarray(x - rigid.T @ (rigid @ (mass @ x)))

    inverse = LinearOperator(mass.shape, matvec=solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    start -= rigid.T @ (rigid @ (mass @ start))
    squares, shapes = eigsh(stiffness, count, mass, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], shapes.T[order]
