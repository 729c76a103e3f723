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

"""Vectors and conditions of single eigenvalues."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any
import warnings

import numpy as np
from scipy.linalg import LinAlgWarning, lu_factor, lu_solve
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode

_STEPS = 3  # of inverse iteration


@dataclass(frozen=True)
class ModeVectors:
    """Right and left vectors (N,) of one eigenvalue: Q(lambda) x = 0, y^H Q(lambda) = 0."""

    eigenvalue: complex
    right: ComplexArray
    left: ComplexArray
    backward_error: float


def mode_vectors(model: BrakeModel, point: OperatingPoint, eigenvalue: complex) -> ModeVectors:
    """Return a simple eigenvalue's vectors, by inverse iteration on lambda^2 + lambda D + K."""
    d, k = model.damping(point), model.stiffness(point)
    right, left, pencil = _vectors(eigenvalue, d, k, _STEPS)
    return ModeVectors(eigenvalue, right, left, _backward_error(eigenvalue, d, k, pencil @ right))


def slope_between(eigenvalue: complex, right: ComplexArray, left: ComplexArray,
                  damping: FloatArray) -> complex:
    """Return y^H Q'(lambda) x, Q' = 2 lambda + D: zero where the eigenvalue is no simple one."""
    return complex(left.conj() @ (2.0 * eigenvalue * right + damping @ right))


def _vectors(eigenvalue: complex, d: FloatArray, k: FloatArray,
             steps: int) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """Return right and left vectors, and Q at the eigenvalue."""
    pencil = np.asarray(eigenvalue**2 * np.eye(len(k)) + eigenvalue * d + k, complex)
    with warnings.catch_warnings():
        warnings.simplefilter('ignore', LinAlgWarning)  # singular to rounding, as it should be
        factors = lu_factor(pencil, check_finite=False)
    pivots = np.einsum('ii->i', factors[0])
    exact = pivots == 0.0  # exact to the last bit; of one mode alone the pencil is all zero
    pivots[exact] = np.finfo(float).eps * (_size(eigenvalue, d, k) or 1.0)
    start = np.ones(len(pencil), complex)
    right, left = (_inverse_iteration(factors, start, trans, steps) for trans in (0, 2))
    return right, left, pencil


def _inverse_iteration(factors: Any, vector: ComplexArray, trans: int,
                       steps: int) -> ComplexArray:
    for _ in range(steps):
        vector = lu_solve(factors, vector, trans=trans, check_finite=False)
        vector = vector / np.linalg.norm(vector)
    return vector


def _backward_error(eigenvalue: complex, d: FloatArray, k: FloatArray,
                    residual: ComplexArray) -> float:
    """Relative change of the matrices that would make the eigenvalue exact (Tisseur 2000)."""
    return float(np.linalg.norm(residual) / (_size(eigenvalue, d, k) or 1.0))


def _size(eigenvalue: complex, d: FloatArray, k: FloatArray) -> float:
    """Sum of the sizes of the pencil's terms; in Frobenius norms, as they cost the least."""
    return float(abs(eigenvalue)**2 + abs(eigenvalue) * np.linalg.norm(d) + np.linalg.norm(k))


@dataclass(frozen=True)
class EigenvalueCondition:
    """
    Backward error, condition and error bound of an eigenvalue.

    Parameters
    ----------
    backward_error : float
        Relative change of the matrices that would make the eigenvalue exact.
    condition : float
        Relative change of the eigenvalue over that of the matrices, at most (Tisseur 2000): 1 at
        best, without bound towards a merging. Infinite for an eigenvalue at zero.
    error : float
        Bound of the rounding error of the eigenvalue, to first order [1/s]: the product of both
        and |lambda|.

    """

    backward_error: float
    condition: float
    error: float


def eigenvalue_conditions(model: BrakeModel, point: OperatingPoint,
                          modes: Sequence[Mode]) -> tuple[EigenvalueCondition, ...]:
    """
    Return the conditions of the modes' eigenvalues, from their vectors; some ms a mode.

    Notes
    -----
    For right and left vectors x and y of norm 1 the condition of a simple eigenvalue is
    (|lambda|^2 + |lambda| |D| + |K|) / (|lambda| |y^H (2 lambda + D) x|), here in Frobenius norms.
    F. Tisseur, Backward error and condition of polynomial eigenvalue problems, Linear Algebra
    Appl. 309 (2000), theorems 1 and 5.

    """
    d, k = model.damping(point), model.stiffness(point)
    return tuple(_condition(mode, mode_vectors(model, point, mode.eigenvalue), d, k)
                 for mode in modes)


def _condition(mode: Mode, vectors: ModeVectors, d: FloatArray, k: FloatArray
               ) -> EigenvalueCondition:
    eigenvalue = mode.eigenvalue
    turn = abs(slope_between(eigenvalue, vectors.right, vectors.left, d))
    size = _size(eigenvalue, d, k)
    if mode.kind == 'rigid' or turn == 0.0:
        return EigenvalueCondition(vectors.backward_error, np.inf, np.inf)
    return EigenvalueCondition(vectors.backward_error, float(size / (abs(eigenvalue) * turn)),
                               float(vectors.backward_error * size / turn))
