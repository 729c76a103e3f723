"""Quadrature over the contact, and the uniform planar-mesh method for modes given at nodes.

K09 section 2: where nodes lie in planes of constant z, modal vectors are carried from the
irregular nodes of each plane to a polar grid, along whose rows they can be differentiated, and
over which integrals are sums. `PlanarModes` does so as the paper prints it (eqs 39-42), or as it
should be; docs/planar_mesh.md shows the difference.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
import math
from typing import Any, Literal, Protocol, TypeAlias

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from squeal_core.arrays import FloatArray
from squeal_core.brake import Contact
from squeal_core.errors import SquealError
from squeal_core.modal_basis import ModalBasis, Quadrature, SampledShapes
from squeal_core.nodal_modes import ModesError, NodalModes

Rule: TypeAlias = Literal['gauss', 'midpoint', 'nodes']
Derivative: TypeAlias = Literal['spectral', 'local', 'central', 'forward']

_PANEL = 4  # Gauss points a panel
_SLAB = 3  # Gauss points between two layers
_STACK = 4  # layers that interpolation between layers takes
_TOLD_APART = 1e-3  # least singular value, to the greatest, of monomials that nodes tell apart
_CHUNK = 4096  # points at a time: 70 MB of interpolation systems


def sector_quadrature(contact: Contact, height: float, *, panels: tuple[int, int] = (9, 18),
                      points: int = 4) -> Quadrature:
    """Return a Gauss rule over the contact sector, centred at theta = 0.

    Parameters
    ----------
    contact : Contact
    height : float
        z of the face [m].
    panels : (2,) ints
        Equal parts in r and theta: as many as the pad has elements, for its shapes have kinks
        between them and a Gauss rule wants smoothness (docs/convergence.md).
    points : int
        Gauss points a panel, in each direction.
    """
    return _polar_grid(_gauss(contact.inner_radius, contact.outer_radius, panels[0], points),
                       _gauss(-0.5 * contact.angle, 0.5 * contact.angle, panels[1], points),
                       height)


@dataclass(frozen=True)
class PlanarGrid:
    """How fine a polar grid is, how sums are taken over it and derivatives along its rows.

    Parameters
    ----------
    radial : int
        M_r, points across the widest annulus of a component; fewer across narrower ones.
    around : int
        M_theta, points round the circle; their distance d is the step of differences, too.
    contact : (2,) ints
        Points across the contact sector in r and theta.
    rule : str
        'gauss', of panels of four points; 'midpoint', of equal cells; 'nodes': sums over all
        nodes, those on the edges with full weight, as K09 eqs (40)-(42) print them.
    derivative : str
        In theta: 'spectral', of the trigonometric polynomial through a row; 'local', the shapes'
        own, of what they are interpolated with; 'central' difference; 'forward' difference, K09
        eq. (39). 'spectral' needs whole rows: at points of the contact it is 'local', and in a
        sector all are.

    Raises
    ------
    SquealError
        For a grid too coarse to sum or to differentiate over.
    """

    radial: int = 12
    around: int = 96
    contact: tuple[int, int] = (36, 72)
    rule: Rule = 'gauss'
    derivative: Derivative = 'spectral'

    def __post_init__(self) -> None:
        if min(self.radial, *self.contact) < 2 or self.around < 4:
            raise SquealError(f'planar grid: radial {self.radial}, around {self.around}, contact '
                              f'{self.contact}; give 2 points or more, and 4 around')

    @property
    def step(self) -> float:
        """d = 2 pi / M_theta [rad]."""
        return 2.0 * math.pi / self.around

    def across(self, start: float, stop: float, count: int) -> tuple[FloatArray, FloatArray]:
        """Return points and weights from start to stop by the rule, `count` of them or more."""
        if self.rule == 'gauss':
            return _gauss(start, stop, -(-count // _PANEL), _PANEL)
        if self.rule == 'midpoint':
            return _gauss(start, stop, count, 1)
        step = (stop - start) / (count - 1)
        return start + step * np.arange(count, dtype=float), np.full(count, step)


AS_PRINTED = PlanarGrid(radial=20, around=244, contact=(15, 43), rule='nodes',
                        derivative='forward')


def contact_grid(contact: Contact, height: float, grid: PlanarGrid | None = None) -> Quadrature:
    """Return the grid that disc and pads share over the contact at z [m]; K09 eq. (40)."""
    grid = grid or PlanarGrid()
    return _polar_grid(
        grid.across(contact.inner_radius, contact.outer_radius, grid.contact[0]),
        grid.across(-0.5 * contact.angle, 0.5 * contact.angle, grid.contact[1]), height)


@dataclass(frozen=True)
class Layer:
    """A plane at z = height [m], and the radii of the annulus that is filled there [m]."""

    height: float
    inner: float
    outer: float

    def reaches(self, inner: float, outer: float) -> bool:
        """Tell whether the layer fills all from one radius to the other."""
        slack = 1e-6 * self.outer
        return self.inner <= inner + slack and outer <= self.outer + slack


class LayeredShapes(Protocol):
    """Shapes of modes on a stack of layers."""

    @property
    def modes(self) -> NodalModes | ModalBasis:
        """Where frequencies and names come from."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """From the lowest up."""

    @property
    def span(self) -> tuple[float, float]:
        """First and last angle [rad]; a whole turn apart for a ring."""

    def at(self, radius: FloatArray, angle: FloatArray,
           heights: Iterable[float]) -> Iterator[FloatArray]:
        """Yield at each height r, theta, z components and their own d/dtheta (2, 3, N, P)."""


@dataclass(frozen=True, eq=False)
class LayeredBasis:
    """Exact shapes in the place of interpolated ones: what is left is the grid's own error."""

    modes: ModalBasis
    layers: tuple[Layer, ...]
    span: tuple[float, float] = (0.0, 2.0 * math.pi)

    def at(self, radius: FloatArray, angle: FloatArray,
           heights: Iterable[float]) -> Iterator[FloatArray]:
        for z in heights:
            s = self.modes.sample(Quadrature(radius, angle, np.full(radius.shape, z), radius))
            yield np.array([[s.radial, s.tangential, s.normal],
                            [s.radial_dtheta, s.tangential_dtheta, s.normal_dtheta]])


@dataclass(frozen=True, eq=False)
class LayeredNodes:
    """Modes at nodes in planar layers, interpolated in each layer and between layers.

    Parameters
    ----------
    modes : NodalModes
    tolerance : float
        How far from its plane a node may lie; nodes nearer to each other count as one [m].

    Raises
    ------
    ModesError
        For nodes that do not lie in at least two planes of six nodes or more.
    """

    modes: NodalModes
    tolerance: float = 1e-5

    def __post_init__(self) -> None:
        heights = [self.modes.coordinates[members, 2] for members in self._members]
        fewest, thickest = min(z.size for z in heights), max(np.ptp(z) for z in heights)
        if len(heights) < 2 or fewest < 6 or thickest > 5.0 * self.tolerance:
            raise ModesError(
                f'{self.modes.source or "modes"}: nodes lie at {len(heights)} heights, {fewest} '
                f'of them at the one with the fewest, up to {thickest:.2g} m apart in z, so not '
                'in planar layers; mesh the part in layers of constant z, or export elements too')

    @cached_property
    def _members(self) -> tuple[Any, ...]:
        """The nodes of each layer, from the lowest up; of nodes in one place the first."""
        where = self.modes.coordinates
        pairs = cKDTree(where).query_pairs(self.tolerance, output_type='ndarray')
        alone = np.setdiff1d(np.arange(len(where)), pairs.max(axis=1, initial=-1))
        order = alone[np.argsort(where[alone, 2], kind='stable')]
        steps = np.diff(where[order, 2])
        return tuple(np.split(order, np.flatnonzero(steps > self.tolerance) + 1))

    @cached_property
    def layers(self) -> tuple[Layer, ...]:
        return tuple(Layer(float(p[:, 2].mean()), float(r.min()), float(r.max()))
                     for p in (self.modes.coordinates[members] for members in self._members)
                     for r in [np.hypot(p[:, 0], p[:, 1])])

    @cached_property
    def span(self) -> tuple[float, float]:
        """A whole turn where nodes leave no gap of a radian, else all but the greatest gap."""
        angle = np.sort(np.arctan2(self.modes.coordinates[:, 1], self.modes.coordinates[:, 0]))
        gaps = np.diff(angle, append=angle[0] + 2.0 * math.pi)
        widest = int(gaps.argmax())
        if gaps[widest] < 1.0:
            return 0.0, 2.0 * math.pi
        start = float(angle[(widest + 1) % angle.size])
        return start, start + 2.0 * math.pi - float(gaps[widest])

    def at(self, radius: FloatArray, angle: FloatArray,
           heights: Iterable[float]) -> Iterator[FloatArray]:
        reach = [k for k, layer in enumerate(self.layers)
                 if layer.reaches(radius.min(), radius.max())]
        known: dict[int, FloatArray] = {}
        for z in heights:
            total = np.zeros((2, 3, len(self.modes.names), radius.size))
            for i, share in _between(np.array([self.layers[k].height for k in reach]), z):
                if i not in known:
                    known[i] = self._within(reach[i], radius, angle)
                total += share * known[i]
            yield total

    def _within(self, k: int, radius: FloatArray, angle: FloatArray) -> FloatArray:
        """Interpolate in layer k: polar components and theta derivatives (2, 3, N, P)."""
        x, y, _ = self.modes.coordinates[self._members[k]].T
        weights = local_weights(np.hypot(x, y), np.arctan2(y, x), radius, angle)
        shapes = self.modes.shapes[:, self._members[k]]
        (u, v, w), (du, dv, dw) = ([(a @ shapes[:, :, i].T).T for i in range(3)] for a in weights)
        c, s = np.cos(angle), np.sin(angle)
        radial, tangential = c * u + s * v, c * v - s * u
        return np.array([[radial, tangential, w],
                         [c * du + s * dv + tangential, c * dv - s * du - radial, dw]])


@dataclass(frozen=True, eq=False)
class PlanarModes:
    """Modes carried to a uniform planar mesh; a `ModalBasis`.

    Parameters
    ----------
    shapes : LayeredShapes
    grid : PlanarGrid
    offset : float
        How far the solid stands above its layers [m]: equal pads share one solution.
    """

    shapes: LayeredShapes
    grid: PlanarGrid = field(default_factory=PlanarGrid)
    offset: float = 0.0

    @classmethod
    def from_nodal(cls, nodal: NodalModes, grid: PlanarGrid | None = None) -> 'PlanarModes':
        """Return the modes of another package, given at nodes in planar layers."""
        return cls(LayeredNodes(nodal), grid or PlanarGrid())

    @property
    def angular_frequencies(self) -> FloatArray:
        return self.shapes.modes.angular_frequencies

    @property
    def names(self) -> tuple[str, ...]:
        return self.shapes.modes.names

    @property
    def _is_ring(self) -> bool:
        start, stop = self.shapes.span
        return math.isclose(stop - start, 2.0 * math.pi)

    def sample(self, points: Quadrature) -> SampledShapes:
        """Return the shapes at points, with theta derivatives by the grid's rule."""
        result = np.empty((2, 3, len(self.names), points.radius.size))
        for z in np.unique(points.height):
            here = points.height == z
            result[..., here] = self._on_plane(
                points.radius[here], points.angle[here], float(z) - self.offset)
        return _sampled(result, points)

    def _on_plane(self, radius: FloatArray, angle: FloatArray, z: float) -> FloatArray:
        def at(shift: float) -> FloatArray:
            return next(iter(self.shapes.at(radius, angle + shift, [z])))

        found, d = at(0.0), self.grid.step
        if self._is_ring and self.grid.derivative == 'forward':
            found[1] = (at(d)[0] - found[0]) / d
        elif self._is_ring and self.grid.derivative == 'central':
            found[1] = (at(d)[0] - at(-d)[0]) / (2.0 * d)
        return found

    def volume_layers(self) -> Iterator[SampledShapes]:
        """Yield samples that together cover the volume, a plane each; K09 eqs (41), (42)."""
        widest = max(layer.outer - layer.inner for layer in self.shapes.layers)
        for (inner, outer), heights, weights in self._planes():
            count = max(_PANEL, round(self.grid.radial * (outer - inner) / widest))
            grid = _polar_grid(self.grid.across(inner, outer, count), self._row(), 0.0)
            found = self.shapes.at(grid.radius, grid.angle, heights)
            for z, weight, shapes in zip(heights, weights, found, strict=True):
                self._along_rows(shapes)
                yield _sampled(shapes, Quadrature(
                    grid.radius, grid.angle, np.full(grid.radius.shape, z + self.offset),
                    weight * grid.weight))

    def _row(self) -> tuple[FloatArray, FloatArray]:
        if self._is_ring:
            circle = self.grid.step * np.arange(self.grid.around, dtype=float)
            return circle, np.full_like(circle, self.grid.step)
        start, stop = self.shapes.span
        return self.grid.across(start, stop, max(_PANEL, round((stop - start) / self.grid.step)))

    def _along_rows(self, shapes: FloatArray) -> None:
        """Put the grid's theta derivative in the place of the shapes' own."""
        if not self._is_ring or self.grid.derivative == 'local':
            return
        rows, d = shapes.reshape(2, 3, len(self.names), -1, self.grid.around), self.grid.step
        if self.grid.derivative == 'spectral':
            order = 1j * np.arange(self.grid.around // 2 + 1)
            order[(self.grid.around + 1) // 2:] = 0.0  # the sawtooth has no derivative at nodes
            rows[1] = np.fft.irfft(order * np.fft.rfft(rows[0]), self.grid.around)
        else:
            back = 1 if self.grid.derivative == 'central' else 0
            rows[1] = (np.roll(rows[0], -1, -1) - np.roll(rows[0], back, -1)) / ((1 + back) * d)

    def _planes(self) -> Iterator[tuple[tuple[float, float], FloatArray, FloatArray]]:
        """Yield annuli, and the heights of planes over each with the thicknesses they stand for.

        As printed, a layer stands for what lies between it and the next; the last one for as
        much as the one before.
        """
        layers = self.shapes.layers
        slabs: dict[tuple[float, float], list[tuple[FloatArray, FloatArray]]] = {}
        if self.grid.rule == 'nodes':
            z = np.array([layer.height for layer in layers])
            for layer, step in zip(layers, np.diff(z, append=2.0 * z[-1] - z[-2]), strict=True):
                yield (layer.inner, layer.outer), np.array([layer.height]), np.array([step])
            return
        for low, high in pairwise(layers):
            annulus = max(low.inner, high.inner), min(low.outer, high.outer)
            if annulus[0] < annulus[1]:
                slabs.setdefault(annulus, []).append(_gauss(
                    low.height, high.height, 1, _SLAB if self.grid.rule == 'gauss' else 1))
        for annulus, rules in slabs.items():
            heights, weights = (np.concatenate(part) for part in zip(*rules, strict=True))
            yield annulus, heights, weights


def local_weights(radius: FloatArray, angle: FloatArray, at_radius: FloatArray,
                  at_angle: FloatArray, *, degree: int = 4) -> tuple[csr_matrix, csr_matrix]:
    """Return what interpolates from scattered nodes, and what differentiates that in theta.

    Polyharmonic splines rho^5 with polynomials, through the nearest nodes of each point (Bayona
    et al., J. Comput. Phys. 332 (2017) 257-273), in r and arc length r0 (theta - theta0), in
    which bodies of revolution are straight.

    Parameters
    ----------
    radius, angle : (M,) arrays
        Nodes of one plane [m, rad].
    at_radius, at_angle : (P,) arrays
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
    """Weights (P, k, 2) for value and d/dq at the origin of nodes at (s, q), each (P, k).

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


def _between(heights: FloatArray, z: float) -> list[tuple[int, float]]:
    """Return layers and their shares in the polynomial through those next to z."""
    slack = 1e-6 * np.ptp(heights) if heights.size > 1 else 0.0
    if heights.size < 2 or not heights[0] - slack <= z <= heights[-1] + slack:
        raise SquealError(
            f'planar mesh: z = {z:.6g} m does not lie between layers of nodes that reach so far '
            'in and out; check that they cover the contact and are in the right place and unit')
    first = max(0, min(int(np.searchsorted(heights, z)) - _STACK // 2, heights.size - _STACK))
    near = heights[first:first + _STACK]
    shares = [math.prod((z - b) / (a - b) for b in near if b != a) for a in near]
    return [(first + i, share) for i, share in enumerate(shares) if share]


def _sampled(found: FloatArray, points: Quadrature) -> SampledShapes:
    (radial, tangential, normal), (radial_dtheta, tangential_dtheta, normal_dtheta) = found
    return SampledShapes(radial, tangential, normal, radial_dtheta, tangential_dtheta,
                         normal_dtheta, points)


def _polar_grid(across: tuple[FloatArray, FloatArray], along: tuple[FloatArray, FloatArray],
                height: float) -> Quadrature:
    """Return the tensor grid of rules (points, weights) in r and theta, Jacobian included."""
    (r, wr), (t, wt) = across, along
    radius, angle = (grid.ravel() for grid in np.meshgrid(r, t, indexing='ij'))
    return Quadrature(radius, angle, np.full(radius.shape, height), np.outer(wr * r, wt).ravel())


def _gauss(start: float, stop: float, panels: int, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    edges = np.linspace(start, stop, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * w).ravel()
