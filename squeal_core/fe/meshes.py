"""Meshes of hat discs, pads and foreign modal results, and where in them points lie.

Generated meshes are of second order, turned from a section of quadrilaterals, with mid-nodes on
the true curves. They can be made irregular on purpose: what is found on them must not depend on
it.
"""

from itertools import permutations
from typing import Any, Literal, TypeAlias

import numpy as np
from scipy.spatial import cKDTree

try:
    import skfem
except ImportError as error:
    raise ImportError(
        "finite element modes need scikit-fem: pip install 'squeal_ros[fe]'") from error

from squeal_core.arrays import FloatArray
from squeal_core.brake import Contact, HatDisc
from squeal_core.errors import SquealError
from squeal_core.fe.axisymmetric import hat_section
from squeal_core.nodal_modes import ElementBlock, ModesError

_CANDIDATES = (16, 64, 256, 1024)  # elements tried for a point, those with the nearest centres
_NEWTON_STEPS = 12
_ROUNDING = 1e-9  # on a face, as far as rounding can tell
_OUTSIDE = 1e-2  # how far outside its element a point may lie, in units of the element

Shape: TypeAlias = Literal['hexahedra', 'tetrahedra']

# corners of the unit cube by VTK's numbers, and the ends of its edges and faces
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0],
                     [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4),
          (0, 4), (1, 5), (2, 6), (3, 7))
_FACES = ((0, 3, 4, 7), (1, 2, 5, 6), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7))
_TET = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
_TET_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def _with_middles(corners: FloatArray, *groups: tuple[tuple[int, ...], ...]) -> FloatArray:
    return np.vstack([corners, *([corners[list(ends)].mean(axis=0) for ends in group]
                                 for group in groups)])


# kind -> element, mesh that carries its geometry, places of its nodes by VTK's numbers
KINDS: dict[str, tuple[Any, Any, FloatArray]] = {
    'tet4': (skfem.ElementTetP1, skfem.MeshTet1, _TET),
    'tet10': (skfem.ElementTetP2, skfem.MeshTet2, _with_middles(_TET, _TET_EDGES)),
    'hex8': (skfem.ElementHex1, skfem.MeshHex1, _CORNERS),
    'hex20': (skfem.ElementHexS2, skfem.MeshHex2, _with_middles(_CORNERS, _EDGES)),
    'hex27': (skfem.ElementHex2, skfem.MeshHex2,
              _with_middles(_CORNERS, _EDGES, _FACES, (tuple(range(8)),)))}


def hat_disc_mesh(disc: HatDisc, *, element_size: float = 0.012, around: int = 48,
                  corner_layers: int = 0, shape: Shape = 'hexahedra', irregularity: float = 0.0,
                  layered: bool = True, seed: int = 0) -> skfem.Mesh:
    """Return a second-order mesh of a hat disc.

    Parameters
    ----------
    disc : HatDisc
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
    """Return a second-order mesh of the contact sector, centred at theta = 0; see `hat_disc_mesh`.

    Parameters
    ----------
    contact : Contact
    bottom, top : float
        z of its faces [m].
    elements : (3,) ints
        Elements in r, theta and z; tetrahedra: six times as many.
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


def foreign_mesh(coordinates: FloatArray, block: ElementBlock) -> tuple[
        skfem.Mesh, skfem.Element, Any]:
    """Return the mesh of elements given by VTK's numbering, and how its nodes are counted here.

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
        linear = _bent(linear, mesh_type, np.einsum(
            'np,ane->ape', _shapes(element, mesh_type.elem.doflocs), coordinates.T[:, nodes]))
    return linear, element(), nodes


def locate(mesh: skfem.Mesh, points: FloatArray) -> tuple[Any, FloatArray]:
    """Return the element that each point (3, P) lies in, and its local coordinates (3, P).

    scikit-fem's own search takes elements by their corners and loses points between a chord and
    its arc; this one inverts the curved geometry. An element is tried only for points within its
    reach, so that long elements do not hide behind short ones.

    Raises
    ------
    SquealError
        For points outside the mesh.
    """
    nodes = mesh.doflocs[:, mesh.dofs.element_dofs]
    centres = nodes.mean(axis=1)
    reach = 1.05 * np.linalg.norm(nodes - centres[:, None], axis=0).max(axis=0)
    tree, tried, left = cKDTree(centres.T), 0, np.arange(points.shape[1])
    cells = np.zeros(points.shape[1], dtype=np.int64)
    local, best = np.zeros(points.shape), np.full(points.shape[1], np.inf)
    for count in _CANDIDATES:
        distance, near = tree.query(points[:, left].T, k=range(tried + 1, count + 1))
        for candidate, far in zip(near.T, distance.T, strict=True):
            mine = np.flatnonzero((far < np.inf) & (best[left] > _ROUNDING))
            mine = mine[far[mine] <= reach[candidate[mine]]]
            at, own = left[mine], candidate[mine]
            x, missed = _invert(mesh, points[:, at], own)
            outside = np.where(missed < 1e-9 * reach[own], _outside(mesh, x), np.inf)
            won = outside < best[at]
            at = at[won]
            cells[at], best[at], local[:, at] = own[won], outside[won], x[:, won]
        left = left[(best[left] > _ROUNDING) & (distance[:, -1] <= reach.max())]
        tried = count
    _check_found(best, points)
    return cells, local


def _check_found(outside: FloatArray, points: FloatArray) -> None:
    lost = np.flatnonzero(outside > _OUTSIDE)
    if lost.size:
        raise SquealError(
            f'{lost.size} of {outside.size} points lie outside the mesh, one at x, y, z = '
            f'{points[:, lost[outside[lost].argmax()]].round(6).tolist()} m; check that the mesh '
            'covers the contact patch and is in the right place and unit')


def functions(element: skfem.Element, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return an element's functions (n, P) at local points (3, P), and gradients (n, 3, P)."""
    found = [element.lbasis(local.copy(), i) for i in range(len(element.doflocs))]
    return (np.array([value + 0.0 * local[0] for value, _ in found]),
            np.array([np.asarray(slope) + 0.0 * local for _, slope in found]))


def geometry(mesh: skfem.Mesh, cells: Any, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return places (3, P) of local points, and their gradients (3, 3, P) dx_i / d local_j."""
    values, slopes = functions(mesh.elem(), local)
    nodes = mesh.doflocs[:, mesh.dofs.element_dofs[:, cells]]
    return (np.einsum('inp,np->ip', nodes, values),
            np.einsum('inp,njp->ijp', nodes, slopes))


def _invert(mesh: skfem.Mesh, points: FloatArray, cells: Any) -> tuple[FloatArray, FloatArray]:
    """Return local coordinates by Newton's method, and by how far it missed the points (P,).

    It starts near the node next to each point: long elements bend far.
    """
    nodes = mesh.doflocs[:, mesh.dofs.element_dofs[:, cells]]
    next_to = np.linalg.norm(nodes - points[:, None], axis=0).argmin(axis=0)
    places = mesh.elem.doflocs
    x = (0.8 * places[next_to] + 0.2 * places.mean(axis=0)).T
    for _ in range(_NEWTON_STEPS):
        found, slopes = geometry(mesh, cells, x)
        step = np.linalg.solve(slopes.transpose(2, 0, 1), (points - found).T[..., None])[..., 0].T
        x = np.clip(x + step, -0.5, 1.5)
        if np.abs(step).max(initial=0.0) < 1e-13:
            break
    return np.asarray(x), np.linalg.norm(points - geometry(mesh, cells, x)[0], axis=0)


def _outside(mesh: skfem.Mesh, x: FloatArray) -> FloatArray:
    """How far local coordinates (3, P) lie outside the reference element; none below zero."""
    over = x.sum(axis=0) if mesh.refdom is skfem.refdom.RefTet else x.max(axis=0)
    return np.asarray(np.maximum(np.maximum(-x.min(axis=0), over - 1.0), 0.0))


def isoparametric(mesh: skfem.Mesh, element: skfem.Element) -> skfem.Mesh:
    """Return the mesh with the geometry that an element can follow.

    Twenty nodes cannot follow a geometry of 27: not even rigid motions would be held.
    """
    if not isinstance(element, skfem.ElementHexS2) or not isinstance(mesh, skfem.MeshHex2):
        return mesh
    edges = [int(np.abs(mesh.elem.doflocs - place).sum(axis=1).argmin())
             for place in element.doflocs]
    return _bent(skfem.MeshHex1(mesh.p[:, :mesh.nvertices].copy(), mesh.t), skfem.MeshHex2,
                 np.einsum('np,ane->ape', _shapes(type(element), mesh.elem.doflocs),
                           mesh.doflocs[:, mesh.dofs.element_dofs[edges]]))


def vtk_order(element: Any) -> list[int]:
    """Return VTK's number of each node of an element (or of its type), in the element's order."""
    places = next(row[2] for row in KINDS.values() if np.shape(row[2]) == element.doflocs.shape)
    return [int(np.abs(places - place).sum(axis=1).argmin()) for place in element.doflocs]


def _linear(mesh_type: Any) -> Any:
    return skfem.MeshTet1 if mesh_type.elem.refdom is skfem.refdom.RefTet else skfem.MeshHex1


def _shapes(element: Any, places: FloatArray) -> FloatArray:
    """Values (n, P) of an element's functions at local places (P, 3)."""
    return np.array([element().lbasis(places.T.copy(), i)[0] * np.ones(len(places))
                     for i in range(len(element.doflocs))])


def _bent(linear: skfem.Mesh, mesh_type: Any, nodes: FloatArray) -> skfem.Mesh:
    """Return the second-order mesh with its nodes at `nodes` (3, n, E)."""
    mesh = mesh_type.from_mesh(linear)
    places = mesh.doflocs.copy()
    places[:, mesh.dofs.element_dofs] = nodes
    return mesh_type(places, mesh.t)


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
    """Least distance of each node of the section to a neighbour along r or z."""
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
    linear, bent = ((skfem.MeshHex1, skfem.MeshHex2) if shape == 'hexahedra'
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
    middles = _shapes(linear.elem, bent.elem.doflocs)
    return _bent(linear(points, cells), bent,
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
