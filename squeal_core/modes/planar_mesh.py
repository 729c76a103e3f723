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
The uniform planar-mesh method, for modes that are given at nodes.

K09 section 2: where nodes lie in planes of constant z, modal vectors are carried from the
irregular nodes of each plane to a polar grid, along whose rows they can be differentiated, and
over which integrals are sums. `PlanarModes` does so as the paper prints it (eqs 39-42), or as it
should be; docs/explanation/planar_mesh.md shows the difference.

    rbf_interpolation       irregular nodes of one plane -> any points of it
    layered_interpolation   the stack of planes, and points between two of them
    planar_grid             polar grids, rules of quadrature
    planar_mesh             all together: a `ModalBasis`. Import from here.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
import math

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.layered_interpolation import (
    Layer,
    LayeredBasis,
    LayeredNodes,
    LayeredShapes,
)
from squeal_core.modes.modal_basis import Quadrature, SampledShapes
from squeal_core.modes.nodal_modes import NodalModes
from squeal_core.modes.planar_grid import (
    AS_PRINTED,
    contact_grid,
    Derivative,
    gauss,
    PANEL,
    PlanarGrid,
    polar_grid,
    QuadratureRule,
    sector_quadrature,
)
from squeal_core.modes.rbf_interpolation import local_weights

__all__ = (
    'AS_PRINTED',
    'contact_grid',
    'Derivative',
    'Layer',
    'LayeredBasis',
    'LayeredNodes',
    'LayeredShapes',
    'local_weights',
    'PlanarGrid',
    'PlanarModes',
    'QuadratureRule',
    'sector_quadrature',
)

_SLAB = 3  # Gauss points between two layers


@dataclass(frozen=True, eq=False)
class PlanarModes:
    """
    Modes carried to a uniform planar mesh; a `ModalBasis`.

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

        result, d = at(0.0), self.grid.step
        if self._is_ring and self.grid.derivative == 'forward':
            result[1] = (at(d)[0] - result[0]) / d
        elif self._is_ring and self.grid.derivative == 'central':
            result[1] = (at(d)[0] - at(-d)[0]) / (2.0 * d)
        return result

    def volume_layers(self) -> Iterator[SampledShapes]:
        """Yield samples that together cover the volume, a plane each; K09 eqs (41), (42)."""
        widest = max(layer.outer - layer.inner for layer in self.shapes.layers)
        for (inner, outer), heights, weights in self._planes():
            count = max(PANEL, round(self.grid.radial * (outer - inner) / widest))
            grid = polar_grid(self.grid.across(inner, outer, count), self._row(), 0.0)
            result = self.shapes.at(grid.radius, grid.angle, heights)
            for z, weight, shapes in zip(heights, weights, result, strict=True):
                self._along_rows(shapes)
                yield _sampled(shapes, Quadrature(
                    grid.radius, grid.angle, np.full(grid.radius.shape, z + self.offset),
                    weight * grid.weight))

    def _row(self) -> tuple[FloatArray, FloatArray]:
        if self._is_ring:
            circle = self.grid.step * np.arange(self.grid.around, dtype=float)
            return circle, np.full_like(circle, self.grid.step)
        start, stop = self.shapes.span
        return self.grid.across(start, stop, max(PANEL, round((stop - start) / self.grid.step)))

    def _along_rows(self, shapes: FloatArray) -> None:
        """Replace the shapes' own theta derivative by the grid's."""
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
        """
        Yield annuli, and the heights of planes over each with the thicknesses they stand for.

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
                slabs.setdefault(annulus, []).append(gauss(
                    low.height, high.height, 1, _SLAB if self.grid.rule == 'gauss' else 1))
        for annulus, rules in slabs.items():
            heights, weights = (np.concatenate(part) for part in zip(*rules, strict=True))
            yield annulus, heights, weights


def _sampled(result: FloatArray, points: Quadrature) -> SampledShapes:
    (radial, tangential, normal), (radial_dtheta, tangential_dtheta, normal_dtheta) = result
    return SampledShapes(radial, tangential, normal, radial_dtheta, tangential_dtheta,
                         normal_dtheta, points)
