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

"""Derivatives of eigenvalues over changes of the model itself, per cent of a design parameter."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.eigenvectors import mode_vectors, slope_between
from squeal_core.stability.mode_tracking import follow, Identity, Tracked
from squeal_core.stability.parameter_paths import matrices

STEP = 0.005  # of a parameter: changes of the matrices are central differences over twice this
CHECK = 0.01  # of the eigenvalues that check them
PER_CENT = 0.01


class Variant(NamedTuple):
    """A model, and the operating point that the same driving has in it."""

    model: BrakeModel
    point: OperatingPoint


Vary: TypeAlias = Callable[[float], Variant]
"""Gives the variant with a parameter multiplied by a factor, in the base model's coordinates."""


class MatrixChange(NamedTuple):
    """Derivatives of damping [1/s] and stiffness [1/s^2], (N, N), per unit of ln p."""

    damping: FloatArray
    stiffness: FloatArray


def matrix_change(vary: Vary, step: float = STEP) -> MatrixChange:
    """Return the derivatives of the matrices over ln p, by central differences."""
    high, low = (matrices(*vary(1.0 + side * step)) for side in (1.0, -1.0))
    width = math.log1p(step) - math.log1p(-step)
    return MatrixChange(*((above - below) / width
                          for above, below in zip(high, low, strict=True)))


def eigenvalue_slopes(model: BrakeModel, point: OperatingPoint, eigenvalues: Sequence[complex],
                      changes: Sequence[MatrixChange]) -> ComplexArray:
    """
    Return d lambda / d ln p [1/s], (eigenvalues, changes).

    Notes
    -----
    d lambda = -y^H (lambda dD + dK) x / (y^H (2 lambda + D) x), as in
    `squeal_core.stability.sensitivity`. To first order it does not depend on the coordinates that
    the changed matrices are in, as those of `change_of_basis.aligned`: for dK = K A - A K and
    dD = D A - A D with any A it vanishes.

    """
    result = np.empty((len(eigenvalues), len(changes)), complex)
    damping = model.damping(point)
    for row, eigenvalue in enumerate(eigenvalues):
        vectors = mode_vectors(model, point, eigenvalue)
        x, y = vectors.right, vectors.left.conj()
        scale = slope_between(eigenvalue, x, vectors.left, damping)
        for column, change in enumerate(changes):
            result[row, column] = -(y @ (eigenvalue * (change.damping @ x) + change.stiffness @ x)
                                    ) / scale
    return result


@dataclass(frozen=True)
class ModeFollower:
    """Finds modes of a base model again in variants of it."""

    model: BrakeModel
    point: OperatingPoint
    start: Tracked
    tolerances: Tolerances

    def eigenvalues(self, variant: Variant, identities: Sequence[Identity]) -> ComplexArray:
        """Return the eigenvalue [1/s] of each mode in a variant, NaN where it is lost."""
        ends = [matrices(self.model, self.point), matrices(*variant)]

        def between(way: float) -> tuple[FloatArray, FloatArray]:
            damping, stiffness = ((1.0 - way) * a + way * b for a, b in zip(*ends, strict=True))
            return damping, stiffness

        there = follow(self.model, between, self.start, parts=4.0, tolerances=self.tolerances)
        return np.array([next((mode.eigenvalue for mode in there.of(identity.numbers)), np.nan)
                         for identity in identities])
