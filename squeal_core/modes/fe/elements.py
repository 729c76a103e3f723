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

"""Solid elements: their functions, their geometry, and the order of their nodes."""

from typing import Any

import numpy as np

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install -e '.[fe]' in the checkout") from error

from squeal_core.common.arrays import FloatArray
from squeal_core.modes.fe.mass import reference_nodes
from squeal_core.modes.nodal_modes import ElementBlock, ModesError

# kind -> element, mesh that carries its geometry, places of its nodes by VTK's numbers
KINDS: dict[str, tuple[Any, Any, FloatArray]] = {
    kind: (element, mesh_type, reference_nodes(kind)) for kind, element, mesh_type in (
        ('tet4', skfem.ElementTetP1, skfem.MeshTet1),
        ('tet10', skfem.ElementTetP2, skfem.MeshTet2),
        ('hex8', skfem.ElementHex1, skfem.MeshHex1),
        ('hex20', skfem.ElementHexS2, skfem.MeshHex2),
        ('hex27', skfem.ElementHex2, skfem.MeshHex2))}


def foreign_mesh(coordinates: FloatArray, block: ElementBlock) -> tuple[
        skfem.Mesh, skfem.Element, Any]:
    """
    Return the mesh of elements given by VTK's numbering, and how its nodes are counted here.

    Parameters
    ----------
    coordinates : (M, 3) array
        [m].
    block : ElementBlock
        E elements of one of `KINDS`.

    Returns
    -------
    mesh : skfem.Mesh
    element : skfem.Element
        The scalar element of `n` nodes.
    nodes : (n, E) int array
        Indices into the coordinates, in the order of the element's own nodes.

    Raises
    ------
    ModesError
        For another kind, or nodes that do not fit it.

    """
    if block.kind not in KINDS:
        raise ModesError(f'elements: kind {block.kind!r} cannot be integrated over; give '
                         f'{", ".join(KINDS)}, or nodes in planar layers and no elements')
    element, mesh_type, places = KINDS[block.kind]
    if block.nodes.ndim != 2 or block.nodes.shape[1] != len(places) or (
            not 0 <= block.nodes.min(initial=0) <= block.nodes.max(initial=0) < len(coordinates)):
        raise ModesError(f'elements: {block.kind} nodes {block.nodes.shape} with numbers from '
                         f'{block.nodes.min(initial=0)} to {block.nodes.max(initial=0)}; give '
                         f'(E, {len(places)}), each from 0 to {len(coordinates) - 1}')
    nodes = block.nodes[:, vtk_order(element)].T
    corners, cells = np.unique(nodes[:element.refdom.nnodes], return_inverse=True)
    linear = _linear(mesh_type)(coordinates[corners].T.copy(),
                                cells.reshape(element.refdom.nnodes, -1))
    if mesh_type is not type(linear):
        linear = bent(linear, mesh_type, np.einsum(
            'np,ane->ape', shapes_at(element, mesh_type.elem.doflocs), coordinates.T[:, nodes]))
    return linear, element(), nodes


def functions(element: skfem.Element, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an element's shapes, (n, P), at local points (3, P), and gradients (n, 3, P)."""
    result = [element.lbasis(local.copy(), i) for i in range(len(element.doflocs))]
    return (np.array([value + 0.0 * local[0] for value, _ in result]),
            np.array([np.asarray(slope) + 0.0 * local for _, slope in result]))


def isoparametric(mesh: skfem.Mesh, element: skfem.Element) -> skfem.Mesh:
    """
    Return the mesh with the geometry that an element can follow.

    Twenty nodes cannot follow a geometry of 27: not even rigid motions would be held.
    """
    if not isinstance(element, skfem.ElementHexS2) or not isinstance(mesh, skfem.MeshHex2):
        return mesh
    edges = [int(np.abs(mesh.elem.doflocs - place).sum(axis=1).argmin())
             for place in element.doflocs]
    return bent(skfem.MeshHex1(mesh.p[:, :mesh.nvertices].copy(), mesh.t), skfem.MeshHex2,
                np.einsum('np,ane->ape', shapes_at(type(element), mesh.elem.doflocs),
                          mesh.doflocs[:, mesh.dofs.element_dofs[edges]]))


def vtk_order(element: Any) -> list[int]:
    """Return VTK's number of each node of an element (or of its type), in the element's order."""
    places = next(row[2] for row in KINDS.values() if np.shape(row[2]) == element.doflocs.shape)
    return [int(np.abs(places - place).sum(axis=1).argmin()) for place in element.doflocs]


def _linear(mesh_type: Any) -> Any:
    return skfem.MeshTet1 if mesh_type.elem.refdom is skfem.refdom.RefTet else skfem.MeshHex1


def shapes_at(element: Any, places: FloatArray) -> FloatArray:
    """Return values (n, P) of an element's functions at local places (P, 3)."""
    return np.array([element().lbasis(places.T.copy(), i)[0] * np.ones(len(places))
                     for i in range(len(element.doflocs))])


def bent(linear: skfem.Mesh, mesh_type: Any, nodes: FloatArray) -> skfem.Mesh:
    """Return the second-order mesh with its nodes at `nodes` (3, n, E)."""
    mesh = mesh_type.from_mesh(linear)
    places = mesh.doflocs.copy()
    places[:, mesh.dofs.element_dofs] = nodes
    return mesh_type(places, mesh.t)
