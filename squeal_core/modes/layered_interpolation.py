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

"""Mode shapes on a stack of planes: layers of nodes, or exact shapes in their place."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
import math
from typing import Any, Protocol

import numpy as np
from scipy.spatial import cKDTree
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.modal_basis import ModalBasis, Quadrature
from squeal_core.modes.nodal_modes import ModesError, NodalModes
from squeal_core.modes.rbf_interpolation import local_weights

_STACK = 4  # layers that interpolation between layers takes


@dataclass(frozen=True)
class Layer:
    """A plane at z = height [m], and the radii of the annulus that is filled there [m]."""

    height: float
    inner: float
    outer: float

    def reaches(self, inner: float, outer: float) -> bool:
        """Return whether the layer fills all from one radius to the other."""
        slack = 1e-6 * self.outer
        return self.inner <= inner + slack and outer <= self.outer + slack


class LayeredShapes(Protocol):
    """Shapes of modes on a stack of layers."""

    @property
    def modes(self) -> NodalModes | ModalBasis:
        """Return the modes that give frequencies and names."""

    @property
    def layers(self) -> tuple[Layer, ...]:
        """Return the layers, from the lowest up."""

    @property
    def span(self) -> tuple[float, float]:
        """Return the first and last angle [rad]; a whole turn apart for a ring."""

    def at(self, radius: FloatArray, angle: FloatArray,
           heights: Iterable[float]) -> Iterator[FloatArray]:
        """Yield at each height r, theta, z components and their own d/dtheta (2, 3, N, P)."""


@dataclass(frozen=True, eq=False)
class LayeredBasis:
    """Exact shapes in place of interpolated ones: only the grid's own error remains."""

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
    """
    Modes at nodes in planar layers, interpolated in each layer and between layers.

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
        """Return the nodes of each layer, from the lowest up; of nodes in one place the first."""
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
        """Return a whole turn if nodes leave no gap of a radian, else all but the greatest gap."""
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
