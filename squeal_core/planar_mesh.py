"""The planar mesh of the contact: quadrature in polar coordinates over the pad's sector."""

import numpy as np

from squeal_core.brake import Contact
from squeal_core.modal_basis import Quadrature


def sector_quadrature(
        contact: Contact, height: float, *, radial: int = 24, angular: int = 48) -> Quadrature:
    """Return a Gauss rule over the contact sector, centred at theta = 0.

    Parameters
    ----------
    contact : Contact
    height : float
        z of the face [m].
    radial, angular : int
        Points in r and theta. The defaults integrate products of K09's modes to about 1e-8
        (docs/convergence.md).
    """
    r, wr = _gauss(contact.inner_radius, contact.outer_radius, radial)
    t, wt = _gauss(-0.5 * contact.angle, 0.5 * contact.angle, angular)
    radius, angle = (grid.ravel() for grid in np.meshgrid(r, t, indexing='ij'))
    weight = np.outer(wr * r, wt).ravel()
    return Quadrature(radius, angle, np.full(radius.shape, height), weight)


def _gauss(start: float, stop: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    x, w = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (stop - start)
    return start + half * (x + 1.0), half * w
