"""Pad modes from a three-dimensional solid: free, quadratic hexahedra, six exact rigid modes."""

from dataclasses import dataclass
from typing import Any

import numpy as np

try:
    import skfem
    from skfem.helpers import ddot, dot, eye, sym_grad, trace
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install 'squeal_ros[fe]'") from error
from scipy.sparse.linalg import eigsh, LinearOperator, splu

from squeal_core.arrays import FloatArray
from squeal_core.brake import Contact, Material, Pad
from squeal_core.fe.probe import probe_matrix
from squeal_core.modal_basis import Quadrature, SampledShapes

RIGID_NAMES = ('slide radial', 'slide tangential', 'spin', 'lift', 'roll', 'pitch')


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _mass(u: Any, v: Any, _: Any) -> Any:
    return dot(u, v)


@skfem.BilinearForm  # type: ignore[untyped-decorator]
def _stiffness(u: Any, v: Any, w: Any) -> Any:
    e, f = sym_grad(u), sym_grad(v)
    return ddot(w.lame * eye(trace(e), 3) + 2.0 * w.shear * e, f)


@dataclass(frozen=True)
class SolidModes:
    """Modes of a solid on a mesh in Cartesian coordinates; a `ModalBasis`.

    Parameters
    ----------
    basis : skfem.CellBasis
    angular_frequencies : (N,) array
        Rising [rad/s]; the rigid modes' are exactly zero.
    shapes : (N, dofs) array
        Mass normalised [kg^-1/2].
    names : tuple of str
    offset : float
        How far the solid stands above its mesh [m]: equal pads share one solution.
    """

    basis: skfem.CellBasis
    angular_frequencies: FloatArray
    shapes: FloatArray
    names: tuple[str, ...]
    offset: float = 0.0

    def sample(self, points: Quadrature) -> SampledShapes:
        """Return the shapes at points; theta derivatives are not needed of a pad and are NaN."""
        c, s = np.cos(points.angle), np.sin(points.angle)
        probe = probe_matrix(self.basis, np.vstack(
            [points.radius * c, points.radius * s, points.height - self.offset]))
        x, y, z = (probe @ self.shapes.T).T.reshape(len(self.names), 3, -1).swapaxes(0, 1)
        unknown = np.full(x.shape, np.nan)
        return SampledShapes(c * x + s * y, c * y - s * x, z, unknown, unknown, unknown, points)


def pad_modes(pad: Pad, contact: Contact, count: int, *,
              elements: tuple[int, int, int] = (9, 18, 3)) -> SolidModes:
    """Return the `count` lowest modes of a free pad over the contact sector.

    Parameters
    ----------
    pad : Pad
    contact : Contact
        The sector the pad fills, centred at theta = 0; its lower face lies at z = 0.
    count : int
        Number of modes, the six rigid ones included.
    elements : (3,) ints
        Number of elements in r, theta and z.
    """
    mesh = sector_mesh(contact, 0.0, pad.thickness, elements)
    return free_modes(skfem.CellBasis(mesh, skfem.ElementVector(skfem.ElementHex2()), intorder=5),
                      pad.material, count)


def free_modes(basis: skfem.CellBasis, material: Material, count: int) -> SolidModes:
    """Return the `count` lowest modes of a free solid: six rigid ones, then flexible ones."""
    e, nu = material.young_modulus, material.poisson_ratio
    mass = _mass.assemble(basis) * material.density
    stiffness = _stiffness.assemble(
        basis, lame=e * nu / (1 + nu) / (1 - 2 * nu), shear=e / 2 / (1 + nu))
    rigid = _rigid_shapes(basis, mass)
    squares, flexible = _flexible(stiffness, mass, rigid, count - 6)
    names = RIGID_NAMES + tuple(f'flexible {i}' for i in range(1, count - 5))
    return SolidModes(basis, np.concatenate([np.zeros(6), np.sqrt(squares)]),
                      np.vstack([rigid, flexible]), names)


def sector_mesh(contact: Contact, bottom: float, top: float,
                elements: tuple[int, int, int]) -> skfem.MeshHex2:
    """Return second-order hexahedra over an annular sector, mid-nodes on the true curve."""
    box = skfem.MeshHex2.from_mesh(skfem.MeshHex.init_tensor(
        *(np.linspace(0.0, 1.0, n + 1) for n in elements)))
    r = contact.inner_radius + box.doflocs[0] * (contact.outer_radius - contact.inner_radius)
    t = (box.doflocs[1] - 0.5) * contact.angle
    z = bottom + box.doflocs[2] * (top - bottom)
    return skfem.MeshHex2(np.vstack([r * np.cos(t), r * np.sin(t), z]), box.t)


def _rigid_shapes(basis: skfem.CellBasis, mass: Any) -> FloatArray:
    """Mass-normalised translations and rotations about the mass centre, in `RIGID_NAMES` order.

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


def _flexible(stiffness: Any, mass: Any, rigid: FloatArray,
              count: int) -> tuple[FloatArray, FloatArray]:
    """Shift-invert below zero on the complement of the rigid modes: they cannot leak in."""
    scale = stiffness.diagonal().mean() / mass.diagonal().mean()
    shift = -1e-4 * scale
    factor = splu((stiffness - shift * mass).tocsc(), permc_spec='MMD_AT_PLUS_A',
                  diag_pivot_thresh=0.0, options={'SymmetricMode': True})

    def solve(b: FloatArray) -> FloatArray:
        x: FloatArray = factor.solve(b - mass @ (rigid.T @ (rigid @ b)))
        return np.asarray(x - rigid.T @ (rigid @ (mass @ x)))

    inverse = LinearOperator(mass.shape, matvec=solve, dtype=float)
    start = np.random.default_rng(0).standard_normal(mass.shape[0])
    start -= rigid.T @ (rigid @ (mass @ start))
    squares, shapes = eigsh(stiffness, count, mass, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(squares)
    return squares[order], shapes.T[order]
