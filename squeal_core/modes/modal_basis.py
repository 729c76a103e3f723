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

"""Modes of a component: frequencies, names and mass-normalised shapes that can be sampled."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes


@dataclass(frozen=True)
class Quadrature:
    """
    Points in cylindrical coordinates with the area or volume that each stands for.

    Parameters
    ----------
    radius, angle, height, weight : (Q,) arrays
        r [m], theta [rad], z [m]; weight [m^2] or [m^3], the Jacobian r included.

    """

    radius: FloatArray
    angle: FloatArray
    height: FloatArray
    weight: FloatArray

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        for name in ('radius', 'angle', 'height', 'weight'):
            object.__setattr__(self, name, readonly(getattr(self, name)))


@dataclass(frozen=True)
class SampledShapes:
    """
    Mode shapes at quadrature points, in polar components.

    Parameters
    ----------
    radial, tangential, normal : (N, Q) arrays
        phi_r, phi_t, phi_z [kg^-1/2].
    radial_dtheta, tangential_dtheta, normal_dtheta : (N, Q) arrays
        Their derivatives in theta [kg^-1/2 rad^-1].
    points : Quadrature

    """

    radial: FloatArray
    tangential: FloatArray
    normal: FloatArray
    radial_dtheta: FloatArray
    tangential_dtheta: FloatArray
    normal_dtheta: FloatArray
    points: Quadrature

    __repr__ = repr_with_shapes


class ModalBasis(Protocol):
    """Interface of all sources of modes."""

    @property
    def angular_frequencies(self) -> FloatArray:
        """Natural frequencies (N,), rising [rad/s]."""

    @property
    def names(self) -> tuple[str, ...]:
        """Return a name for each of the N modes."""

    def sample(self, points: Quadrature) -> SampledShapes:
        """Return the shapes at points of the component."""

    def volume_layers(self) -> Iterator[SampledShapes]:
        """Yield samples that together integrate over the component's volume."""


def modal_assurance(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the MAC of two sets of shapes given as rows (N, Q) and (M, Q): (N, M) in 0..1."""
    cross = first @ second.T
    norms = np.outer(np.sum(first**2, axis=1), np.sum(second**2, axis=1))
    return np.asarray(cross**2 / norms)


def keep_whole_doublets(frequencies: FloatArray, count: int, *, tolerance: float = 1e-6) -> int:
    """
    Return the least number of modes >= count after which no doublet is cut in two.

    Parameters
    ----------
    frequencies : (M,) array
        Rising, M > count where a partner may follow.
    count : int
        How many are wanted.
    tolerance : float
        Relative gap under which neighbours are a doublet.

    """
    gap = tolerance * frequencies[count - 1]
    while count < frequencies.size and frequencies[count] - frequencies[count - 1] <= gap:
        count += 1
    return count
