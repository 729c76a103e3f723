"""The planar mesh of the contact: quadrature in polar coordinates over the pad's sector."""

import numpy as np

from squeal_core.arrays import FloatArray
from squeal_core.brake import Contact
from squeal_core.modal_basis import Quadrature


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
    r, wr = _gauss(contact.inner_radius, contact.outer_radius, panels[0], points)
    t, wt = _gauss(-0.5 * contact.angle, 0.5 * contact.angle, panels[1], points)
    radius, angle = (grid.ravel() for grid in np.meshgrid(r, t, indexing='ij'))
    weight = np.outer(wr * r, wt).ravel()
    return Quadrature(radius, angle, np.full(radius.shape, height), weight)


def _gauss(start: float, stop: float, panels: int, points: int) -> tuple[FloatArray, FloatArray]:
    x, w = np.polynomial.legendre.leggauss(points)
    edges = np.linspace(start, stop, panels + 1)
    half = 0.5 * np.diff(edges)[:, None]
    return (edges[:-1, None] + half * (x + 1.0)).ravel(), (half * w).ravel()
