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

"""Polar grids over the contact and over planes of a component: their points and weights."""

from dataclasses import dataclass
import math
from typing import Literal, TypeAlias

import numpy as np
from squeal_core.brake.dimensions import Contact
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.modes.modal_basis import Quadrature

QuadratureRule: TypeAlias = Literal['gauss', 'midpoint', 'nodes']
Derivative: TypeAlias = Literal['spectral', 'local', 'central', 'forward']

PANEL = 4  # Gauss points a panel


@dataclass(frozen=True)
class PlanarGrid:
    """
    Resolution of a polar grid, its quadrature, and its derivatives along rows.

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
    rule: QuadratureRule = 'gauss'
    derivative: Derivative = 'spectral'

    def __post_init__(self) -> None:
        if min(self.radial, *self.contact) < 2 or self.around < 4:
            raise SquealError(f'planar grid: radial {self.radial}, around {self.around}, contact '
                              f'{self.contact}; give 2 points or more, and 4 around')

    @property
    def step(self) -> float:
        """Return d = 2 pi / M_theta [rad]."""
        return 2.0 * math.pi / self.around

    def across(self, start: float, stop: float, count: int) -> tuple[FloatArray, FloatArray]:
        """Return points and weights from start to stop by the rule, `count` of them or more."""
        if self.rule == 'gauss':
            return gauss(start, stop, -(-count // PANEL), PANEL)
        if self.rule == 'midpoint':
            return gauss(start, stop, count, 1)
        step = (stop - start) / (count - 1)
        return start + step * np.arange(count, dtype=float), np.full(count, step)


AS_PRINTED = PlanarGrid(radial=20, around=244, contact=(15, 43), rule='nodes',
                        derivative='forward')


def contact_grid(contact: Contact, height: float, grid: PlanarGrid | None = None) -> Quadrature:
    """Return the grid that disc and pads share over the contact at z [m]; K09 eq. (40)."""
    grid = grid or PlanarGrid()
    return polar_grid(
        grid.across(contact.inner_radius, contact.outer_radius, grid.contact[0]),
        grid.across(-0.5 * contact.angle, 0.5 * contact.angle, grid.contact[1]), height)


def sector_quadrature(contact: Contact, height: float, *, panels: tuple[int, int] = (9, 18),
                      points: int = 4) -> Quadrature:
    """
    Return a Gauss rule over the contact sector, centred at theta = 0.

    Parameters
    ----------
    contact : Contact
        Contact patch.
    height : float
        z of the face [m].
    panels : (2,) ints
        Equal parts in r and theta: as many as the pad has elements, for its shapes have kinks
        between them and a Gauss rule wants smoothness (docs/explanation/convergence.md).
    points : int
        Gauss points a panel, in each direction.

    """
    return polar_grid(gauss(contact.inner_radius, contact.outer_radius, panels[0], points),
                      gauss(-0.5 * contact.angle, 0.5 * contact.angle, panels[1], points),
                      height)


def polar_grid(across: tuple[FloatArray, FloatArray], along: tuple[FloatArray, FloatArray],
               height: float) -> Quadrature:
    """Return the tensor grid of rules (points, weights) in r and theta, Jacobian included."""
    (r, wr), (t, wt) = across, along
    radius, angle = (grid.ravel() for grid in np.meshgrid(r, t, indexing='ij'))
    return Quadrature(radius, angle, np.full(radius.shape, height), np.outer(wr * r, wt).ravel())


def gauss(start: float, stop: float, panels: int, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    edges = np.linspace(start, stop, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * w).ravel()
