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
Modes of three-dimensional solids, free or clamped, on hexahedra or tetrahedra.

Any mesh of scikit-fem's will do (`skfem.Mesh.load` reads many formats), and so will modes of
another package that come with their elements: both are sampled through the elements' own shape
functions, theta derivatives included. With Cartesian components, d/dtheta of a polar field is
(x d/dy - y d/dx) of its components, so no difference is taken anywhere.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error
from scipy.sparse import coo_matrix
from squeal_core.brake.dimensions import Contact, Material, Pad
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.fe.eigen import assembled, lowest_modes, rigid_shapes, scalar_basis, tables
from squeal_core.modes.fe.elements import foreign_mesh, functions, isoparametric, KINDS, vtk_order
from squeal_core.modes.fe.locate import cells_of, inverse, locate
from squeal_core.modes.fe.meshes import sector_mesh
from squeal_core.modes.fe.mode_cache import content_key, remembered
from squeal_core.modes.fe.polar import polar
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.nodal_modes import ElementBlock, ModesError, NodalModes

RIGID_NAMES = ('slide radial', 'slide tangential', 'spin', 'lift', 'roll', 'pitch')

_CHUNK = 20_000  # quadrature points at a time: 50 MB for 52 modes


def _quiet(_: str) -> None:
    pass


@dataclass(frozen=True)
class SolidModes:
    """
    Modes of a solid on a mesh in Cartesian coordinates; a `ModalBasis`.

    Parameters
    ----------
    basis : skfem.CellBasis
        Of the vector element.
    angular_frequencies : (N,) array
        Rising [rad/s]; the rigid modes' are exactly zero.
    shapes : (N, dofs) array
        Mass normalised [kg^-1/2].
    names : tuple of str
    density : float
        rho [kg/m^3].
    offset : float
        How far the solid stands above its mesh [m]: equal pads share one solution.

    """

    basis: skfem.CellBasis
    angular_frequencies: FloatArray
    shapes: FloatArray
    names: tuple[str, ...]
    density: float
    offset: float = 0.0

    @classmethod
    def from_nodal(cls, nodal: NodalModes, *, density: float | None = None) -> 'SolidModes':
        """
        Return modes of another package, sampled through the elements they came with.

        Parameters
        ----------
        nodal : NodalModes
            With elements of one kind of `elements.KINDS`.
        density : float, optional
            rho [kg/m^3]; where None, what makes the shapes mass normalised on average.

        Raises
        ------
        ModesError
            For no elements, elements of several kinds or of one that is not known.

        """
        kinds = sorted({block.kind for block in nodal.elements})
        if len(kinds) != 1:
            raise ModesError(f'{nodal.source or "modes"}: elements of kinds {kinds}; give one '
                             'kind, or nodes in planar layers and no elements')
        mesh, element, nodes = foreign_mesh(nodal.coordinates, ElementBlock(
            kinds[0], np.vstack([block.nodes for block in nodal.elements])))
        basis = _vector_basis(mesh, element)
        shapes = np.zeros((len(nodal.names), basis.N))
        for axis in range(3):
            shapes[:, basis.element_dofs[axis::3]] = nodal.shapes[:, nodes, axis]
        if density is None:
            unit = assembled(basis, Material(1.0, 1.0, 0.0))[1]
            density = len(shapes) / float(np.sum(shapes * (unit @ shapes.T).T))
        return cls(basis, nodal.angular_frequencies, shapes, nodal.names, density)

    def nodal(self) -> NodalModes:
        """Return the same modes at the mesh's nodes, elements in VTK's order."""
        plain = skfem.CellBasis(self.basis.mesh, self.basis.elem.elem, intorder=1)
        shapes = np.empty((len(self.names), plain.N, 3))
        for axis in range(3):
            shapes[:, plain.element_dofs, axis] = self.shapes[:, self.basis.element_dofs[axis::3]]
        nodes = np.empty_like(plain.element_dofs.T)
        nodes[:, vtk_order(plain.elem)] = plain.element_dofs.T
        kind = next(kind for kind, row in KINDS.items() if isinstance(plain.elem, row[0]))
        return NodalModes(plain.doflocs.T + [0.0, 0.0, self.offset], self.angular_frequencies,
                          shapes, (ElementBlock(kind, nodes),), self.names)

    def sample(self, points: Quadrature) -> SampledShapes:
        """Return the shapes and their theta derivatives at points of the solid."""
        x, y = points.radius * np.cos(points.angle), points.radius * np.sin(points.angle)
        mesh = self.basis.mesh
        cells, local = locate(mesh, np.vstack([x, y, points.height - self.offset]))
        values, slopes = functions(self.basis.elem.elem, local)
        gradients = np.einsum('pji,njp->nip', inverse(cells_of(mesh).geometry(cells, local)[1]),
                              slopes)
        dofs = self.basis.element_dofs[:, cells]
        return polar(self._at(dofs, values),
                     self._at(dofs, x * gradients[:, 1] - y * gradients[:, 0]), points)

    def _at(self, dofs: Any, values: FloatArray) -> FloatArray:
        """Return Cartesian components (3, N, P) from function values (n, P) and dofs (3n, P)."""
        count, points = values.shape
        rows = np.tile(np.arange(points), count)
        return np.array([(coo_matrix((values.ravel(), (rows, dofs[axis::3].ravel())),
                                     shape=(points, self.basis.N)).tocsr() @ self.shapes.T).T
                         for axis in range(3)])

    def volume_layers(self) -> Iterator[SampledShapes]:
        """Yield samples at the elements' quadrature points, which together cover the volume."""
        plain = scalar_basis(self.basis)
        values, gradients = tables(plain)
        where, weights = plain.global_coordinates().value, plain.dx
        turned = where[0] * gradients[:, 1] - where[1] * gradients[:, 0]
        step = max(1, _CHUNK // weights.shape[1])
        for start in range(0, len(weights), step):
            part = slice(start, start + step)
            x, y, z = where[:, part].reshape(3, -1)
            points = Quadrature(np.hypot(x, y), np.arctan2(y, x), z + self.offset,
                                weights[part].ravel())
            own = self.shapes[:, self.basis.element_dofs[:, part]]
            field, rotated = (np.array([
                np.einsum('mke,keq->meq', own[:, axis::3], table[:, part], optimize=True).reshape(
                    len(own), -1) for axis in range(3)]) for table in (values, turned))
            yield polar(field, rotated, points)


def solid_modes(mesh: skfem.Mesh, material: Material, count: int, *,
                clamped: Callable[[FloatArray], Any] | None = None,
                element: skfem.Element | None = None, cache: str | Path | None = None,
                progress: Callable[[str], None] = _quiet) -> SolidModes:
    """
    Return the `count` lowest modes of a solid.

    Parameters
    ----------
    mesh : skfem.Mesh
        Hexahedra or tetrahedra, Cartesian, the axis of rotation along z through the origin [m].
    material : Material
        Of all elements.
    count : int
        Number of modes; of a free solid the six rigid ones are the first.
    clamped : callable, optional
        Tells of points (3, ...) on the surface whether they are held, as `at_radius(r)` does: a
        face is, if its corners are. Free where None.
    element : skfem.Element, optional
        Scalar element; where None, of ten nodes for tetrahedra and 27 for hexahedra.
    cache : path, optional
        Folder that keeps solutions (`resources.cache_folder()`); None keeps none.
    progress : callable
        Told in a few words what is being done.

    Raises
    ------
    SquealError
        Where no face of the mesh is clamped that should be.

    """
    element = element or (skfem.ElementTetP2() if mesh.refdom is skfem.refdom.RefTet
                          else skfem.ElementHex2())
    basis = _vector_basis(isoparametric(mesh, element), element)
    if clamped is None:
        return free_modes(basis, material, count, cache=cache, progress=progress)
    held = _held(basis, clamped)
    free = np.setdiff1d(np.arange(basis.N), held)

    def solve() -> tuple[FloatArray, FloatArray]:
        progress(f'assembling {basis.N} unknowns')
        stiffness, mass = (a[free][:, free] for a in assembled(basis, material))
        squares, shapes = lowest_modes(stiffness, mass, 0.0, np.zeros((0, free.size)), count,
                                       progress)
        whole = np.zeros((count, basis.N))
        whole[:, free] = shapes
        return np.sqrt(squares), whole

    frequencies, shapes = remembered(
        cache, _key(basis, material, count, held), (count, basis.N), solve)
    return SolidModes(basis, frequencies, shapes, tuple(f'mode {i + 1}' for i in range(count)),
                      material.density)


def at_radius(radius: float, *, tolerance: float = 1e-4) -> Callable[[FloatArray], Any]:
    """Return a test whether points (3, ...) lie at a radius [m], to a relative tolerance."""
    return lambda x: np.abs(np.hypot(x[0], x[1]) - radius) <= tolerance * radius


def pad_modes(pad: Pad, contact: Contact, count: int, *,
              elements: tuple[int, int, int] = (9, 18, 3),
              cache: str | Path | None = None) -> SolidModes:
    """
    Return the `count` lowest modes of a free pad over the contact sector.

    Parameters
    ----------
    pad : Pad
        Dimensions and material.
    contact : Contact
        The sector the pad fills, centred at theta = 0; its lower face lies at z = 0.
    count : int
        Number of modes, the six rigid ones included.
    elements : (3,) ints
        Number of elements in r, theta and z.
    cache : path, optional
        Folder that keeps solutions (`resources.cache_folder()`); None keeps none.

    """
    mesh = sector_mesh(contact, 0.0, pad.thickness, elements)
    return free_modes(skfem.CellBasis(mesh, skfem.ElementVector(skfem.ElementHex2()), intorder=5),
                      pad.material, count, cache=cache)


def free_modes(basis: skfem.CellBasis, material: Material, count: int, *,
               cache: str | Path | None = None,
               progress: Callable[[str], None] = _quiet) -> SolidModes:
    """Return the `count` lowest modes of a free solid: six rigid ones, then flexible ones."""
    def solve() -> tuple[FloatArray, FloatArray]:
        progress(f'assembling {basis.N} unknowns')
        stiffness, mass = assembled(basis, material)
        rigid = rigid_shapes(basis, mass)
        # below zero, where a free solid has no mode and the matrix can be factorised
        shift = -1e-4 * stiffness.diagonal().mean() / mass.diagonal().mean()
        squares, flexible = lowest_modes(stiffness, mass, shift, rigid, count - 6, progress)
        return np.concatenate([np.zeros(6), np.sqrt(squares)]), np.vstack([rigid, flexible])

    frequencies, shapes = remembered(
        cache, _key(basis, material, count, np.zeros(0, int)), (count, basis.N), solve)
    return SolidModes(basis, frequencies, shapes, solid_names(count), material.density)


def solid_names(count: int) -> tuple[str, ...]:
    """Return the names of modes of a free body: the rigid ones, then the flexible ones."""
    return RIGID_NAMES + tuple(f'flexible {i}' for i in range(1, count - len(RIGID_NAMES) + 1))


def _vector_basis(mesh: skfem.Mesh, element: skfem.Element) -> skfem.CellBasis:
    """Unknowns only: at more than one point an element its tables would take most memory."""
    return skfem.CellBasis(mesh, skfem.ElementVector(element), intorder=1)


def _held(basis: skfem.CellBasis, clamped: Callable[[FloatArray], Any]) -> Any:
    mesh = basis.mesh
    faces = mesh.boundary_facets()
    faces = faces[np.all(clamped(mesh.p[:, mesh.facets[:, faces]]), axis=0)]
    if faces.size == 0:
        raise SquealError('clamped: no face of the mesh lies where it should be held; check the '
                          'place and the unit of the mesh')
    return basis.get_dofs(faces).all()


def _key(basis: skfem.CellBasis, material: Material, count: int, held: Any) -> str:
    return content_key(
        element=type(basis.elem.elem).__name__, places=basis.mesh.doflocs, cells=basis.mesh.t,
        held=held, count=count, material=[
            material.young_modulus, material.density, material.poisson_ratio])
