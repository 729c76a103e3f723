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

"""Full solutions with numbered modes and slopes of eigenvalues, which an emulator is fitted to."""

from typing import Any, NamedTuple

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.emulator_audit import point_at
from squeal_core.risk.mode_families import ReferenceModes
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.state_space import state_matrix


class TrainingSolutions(NamedTuple):
    """Eigenvalues (P, N) by mode number, slopes (P, N, 6), projections on references (P, N, N)."""

    eigenvalues: ComplexArray
    slopes: ComplexArray
    projections: Any


def solve_points(model: BrakeModel, reference: ReferenceModes,
                 inputs: FloatArray) -> TrainingSolutions:
    """Return the full solutions at inputs (P, 6)."""
    found = [solution_at(model, reference, point_at(model, row)) for row in inputs]
    return TrainingSolutions(*(np.stack(arrays) for arrays in zip(*found, strict=True)))


def solution_at(model: BrakeModel, reference: ReferenceModes,
                point: OperatingPoint) -> TrainingSolutions:
    """Return the full solution at a point."""
    state = state_matrix(model, model.damping(point), model.stiffness(point))
    held = len(state) - model.size
    moving = np.logical_not(model.free_coordinates)
    values, right = np.linalg.eig(state)
    left = np.linalg.inv(right)[:, held:]
    up = np.flatnonzero(values.imag > Tolerances.of(model).oscillation)
    place, velocity = right[:held, up], right[held:, up]
    shapes = np.where(moving[:, None], velocity, 0.0)
    shapes /= np.linalg.norm(shapes, axis=0)
    numbers, columns, projections = reference.numbered(shapes, point.contact_stiffness)
    found = TrainingSolutions(
        np.full(model.size, np.nan, complex), np.full((model.size, 6), np.nan, complex),
        np.zeros((model.size, model.size), np.float32))
    found.eigenvalues[numbers] = values[up][columns]
    found.slopes[numbers] = _slopes(model, point, left[up], place, velocity)[columns]
    found.projections[numbers] = projections[:, columns].T
    return found


def _slopes(model: BrakeModel, q: OperatingPoint, left: ComplexArray, place: ComplexArray,
            velocity: ComplexArray) -> ComplexArray:
    """Return the slopes (n, 6) of eigenvalues along `affine_coefficients`."""
    def by(array: Any, vectors: ComplexArray) -> Any:
        if array is None:
            return np.zeros(len(left), complex)
        return -np.einsum('ij,ji->i', left @ array[:, :], vectors)

    moving = np.logical_not(model.free_coordinates)
    spring, couple = (by(None if array is None else array[:, moving], place)
                      for array in (model.contact_stiffness, model.friction_couple))
    dashpot, dragged = by(model.contact_damping, velocity), by(model.contact_damping_couple,
                                                               velocity)
    stiffness, friction, scale = q.contact_stiffness, q.friction, q.damping_scale
    return np.column_stack([
        by(model.gyroscopic, velocity), by(model.radial_dissipation, velocity),
        by(model.negative_slope, velocity),
        spring + friction * couple + scale * (dashpot + friction * dragged),
        stiffness * (couple + scale * dragged),
        by(model.material_damping, velocity) + stiffness * (dashpot + friction * dragged)])
