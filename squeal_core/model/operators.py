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
The six arrays of K09's equation of motion, each an integral over mode shapes.

Every function returns one array without the scalar that multiplies it at an operating point.
Modal coordinates are ordered pad 1 (top) | disc | pad 2 (bottom).
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.modes.modal_basis import SampledShapes


@dataclass(frozen=True)
class ContactFace:
    """
    Relative shapes of pad and disc at the quadrature points of one contact face.

    Parameters
    ----------
    normal, tangential, radial : (N, Q) arrays
        n, t, r of the linearised contact: approach of the surfaces, disc minus pad in the
        tangential and in the radial direction [kg^-1/2].
    spin : (N, Q) array
        e = d_theta phi_r - phi_t of the disc: how its turning tilts the sliding direction.
    radius, weight : (Q,) arrays
        r [m] and area [m^2] of the points.

    """

    normal: FloatArray
    tangential: FloatArray
    radial: FloatArray
    spin: FloatArray
    radius: FloatArray
    weight: FloatArray


def top_face(pad: SampledShapes, disc: SampledShapes, pad2_modes: int) -> ContactFace:
    """Return the face of pad 1 on z = +h/2: columns (-pad 1 | disc | 0)."""
    absent = np.zeros((pad2_modes, disc.normal.shape[1]))
    return ContactFace(
        normal=np.vstack([-pad.normal, disc.normal, absent]),
        tangential=np.vstack([-pad.tangential, disc.tangential, absent]),
        radial=np.vstack([-pad.radial, disc.radial, absent]),
        spin=np.vstack([0.0 * pad.radial, disc.radial_dtheta - disc.tangential, absent]),
        radius=disc.points.radius, weight=disc.points.weight)


def bottom_face(pad: SampledShapes, disc: SampledShapes, pad1_modes: int) -> ContactFace:
    """Return the face of pad 2 on z = -h/2: columns (0 | disc | -pad 2), normal turned round."""
    absent = np.zeros((pad1_modes, disc.normal.shape[1]))
    return ContactFace(
        normal=np.vstack([absent, -disc.normal, pad.normal]),
        tangential=np.vstack([absent, disc.tangential, -pad.tangential]),
        radial=np.vstack([absent, disc.radial, -pad.radial]),
        spin=np.vstack([absent, disc.radial_dtheta - disc.tangential, 0.0 * pad.radial]),
        radius=disc.points.radius, weight=disc.points.weight)


def contact_stiffness(faces: Iterable[ContactFace]) -> FloatArray:
    """A0 = sum int n^T n dA [m^2/kg], symmetric; K09 eq. (A.5)."""
    return _sum((f.normal * f.weight) @ f.normal.T for f in faces)


def friction_couple(faces: Iterable[ContactFace]) -> FloatArray:
    """B0 = sum int t^T n dA [m^2/kg], unsymmetric; K09 eq. (A.6)."""
    return _sum((f.tangential * f.weight) @ f.normal.T for f in faces)


def radial_dissipation(faces: Iterable[ContactFace]) -> FloatArray:
    """R0 = sum int (1/r) r^T r dA [m/kg], symmetric; K09 eq. (A.3)."""
    return _sum((f.radial * f.weight / f.radius) @ f.radial.T for f in faces)


def negative_slope(faces: Iterable[ContactFace]) -> FloatArray:
    """S0 = sum int t^T t dA [m^2/kg], symmetric; K09 eq. (A.4)."""
    return _sum((f.tangential * f.weight) @ f.tangential.T for f in faces)


def follower(faces: Iterable[ContactFace]) -> FloatArray:
    """F0 = sum int (1/r) r^T e dA [m/kg], unsymmetric; K09 eq. (A.7), left out of its results."""
    return _sum((f.radial * f.weight / f.radius) @ f.spin.T for f in faces)


def support(back: SampledShapes, radial: float, tangential: float, normal: float) -> FloatArray:
    """
    Sum over directions of s int phi^T phi dA, symmetric: the support of a pad's back face.

    Parameters
    ----------
    back : SampledShapes
        On the pad's back face, weights in m^2.
    radial, tangential, normal : float
        Stiffness [N/m^3] or damping [N s/m^3] per area; the result is in 1/s^2 or 1/s.

    """
    parts = ((radial, back.radial), (tangential, back.tangential), (normal, back.normal))
    return _sum(s * (phi * back.points.weight) @ phi.T for s, phi in parts)


def gyroscopic(layers: Iterable[SampledShapes], density: float) -> FloatArray:
    """
    G0 = P - P^T [-] of the disc, skew; K09 eq. (38).

    Parameters
    ----------
    layers : iterable of SampledShapes
        Parts that together cover the disc's volume, weights in m^3.
    density : float
        rho [kg/m^3].

    """
    p = density * _sum(
        (s.radial * s.points.weight) @ (s.radial_dtheta - s.tangential).T
        + (s.tangential * s.points.weight) @ (s.tangential_dtheta + s.radial).T
        + (s.normal * s.points.weight) @ s.normal_dtheta.T
        for s in layers)
    return p - p.T


def _sum(parts: Iterable[FloatArray]) -> FloatArray:
    total: FloatArray | None = None
    for part in parts:
        total = part if total is None else total + part
    if total is None:
        raise ValueError('no faces or layers given: there is nothing to integrate over')
    return total
