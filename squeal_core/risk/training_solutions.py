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
Full solutions with numbered modes, and the small matrices that an emulator is fitted to.

The eigenvalues of a cluster of modes are those of a small matrix, the restriction of the state
matrix to the cluster's invariant subspace, written in a fixed basis. However its modes cross, the
matrix is analytic in the coefficients while no other mode meets one of the cluster.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.growth_emulator import points_at
from squeal_core.risk.mode_families import ReferenceModes
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.state_space import state_matrix


class SubspaceMatrix(NamedTuple):
    """Matrices (..., n, n) of invariant subspaces and their slopes (..., D, n, n); NaN: none."""

    values: ComplexArray
    slopes: ComplexArray


class TrainingSolutions(NamedTuple):
    """
    Full solutions at P points.

    Attributes
    ----------
    eigenvalues : (P, N) array
        By mode number, NaN where there is none.
    projections : (P, N, N) array
        Squared projections of modes (second axis) on references.
    clusters : list of SubspaceMatrix
        (P, n, n), with slopes along the six of `affine_coefficients`.

    """

    eigenvalues: ComplexArray
    projections: Any
    clusters: list[SubspaceMatrix]

    @classmethod
    def joined(cls, parts: Sequence['TrainingSolutions']) -> 'TrainingSolutions':
        """Return the solutions of several parts."""
        return cls(np.concatenate([part.eigenvalues for part in parts]),
                   np.concatenate([part.projections for part in parts]),
                   [SubspaceMatrix(*map(np.concatenate, zip(*cluster, strict=True)))
                    for cluster in zip(*(part.clusters for part in parts), strict=True)])


def subspace_matrix(values: ComplexArray, onto: ComplexArray, changes: ComplexArray,
                    members: IndexArray) -> SubspaceMatrix:
    """
    Return the matrix of an invariant subspace in a fixed basis, and its slopes.

    Parameters
    ----------
    values : (..., m) array
        All eigenvalues.
    onto : (..., n, m) array
        Projections of all eigenvectors on the basis.
    changes : (..., D, m, n) array
        Changes of the whole matrix in D directions, in coordinates of its eigenvectors: the
        columns of the members.
    members : (n,) array
        Places of the eigenvalues of the subspace.

    """
    own = onto[..., members]
    back = np.linalg.inv(own)
    matrix = (own * values[..., None, members]) @ back
    apart = values[..., None, members] - values[..., None]
    apart[..., members, :] = np.inf  # within the subspace the basis fixes the vectors
    off = onto * values[..., None, :] - matrix @ onto
    slopes = (onto[..., None, :, :] @ changes
              + off[..., None, :, :] @ (changes / apart[..., None, :, :])) @ back[..., None, :, :]
    return SubspaceMatrix(matrix, slopes)


def part_of(cluster: SubspaceMatrix, eigenvalues: ComplexArray,
            places: IndexArray) -> SubspaceMatrix:
    """
    Return the matrices (P, n, n) of some modes of a cluster.

    Parameters
    ----------
    cluster : SubspaceMatrix
        (P, m, m).
    eigenvalues : (P, m) array
        Of the cluster by number.
    places : (n,) array
        Of the modes among them.

    """
    known: Any = np.isfinite(cluster.values).all(axis=(1, 2))
    shape = (*cluster.slopes.shape[:2], places.size, places.size)
    result = SubspaceMatrix(np.full((shape[0], *shape[2:]), np.nan, np.complex128),
                            np.full(shape, np.nan, np.complex128))
    values, vectors = np.linalg.eig(cluster.values[known])
    order = np.abs(eigenvalues[known][:, :, None] - values[:, None]).argmin(axis=2)
    values = np.take_along_axis(values, order, axis=1)
    vectors = np.take_along_axis(vectors, order[:, None], axis=2)
    changes = (np.linalg.inv(vectors)[:, None] @ cluster.slopes[known]
               @ vectors[:, None][..., places])
    result.values[known], result.slopes[known] = subspace_matrix(
        values, vectors[:, places], changes, places)
    return result


def solve_points(model: BrakeModel, reference: ReferenceModes, inputs: FloatArray,
                 clusters: Sequence[IndexArray] = (), stiffness: float | None = None
                 ) -> TrainingSolutions:
    """
    Return the full solutions at inputs (P, 6).

    Parameters
    ----------
    model : BrakeModel
        The model that is solved.
    reference : ReferenceModes
        Its modes at mu = 0, by which the solutions' modes are known.
    inputs : (P, 6) array
        As of `points_at`.
    clusters : sequence of arrays
        Places of modes by number.
    stiffness : float, optional
        k_c whose reference shapes are the clusters' basis; the nominal one where None [N/m^3].

    """
    shapes = reference.at(stiffness or model.nominal_contact_stiffness)
    return TrainingSolutions.joined([
        solution_at(model, reference, point, clusters, shapes)
        for point in points_at(model, inputs)])


def solution_at(model: BrakeModel, reference: ReferenceModes, point: OperatingPoint,
                clusters: Sequence[IndexArray] = (), shapes: FloatArray | None = None
                ) -> TrainingSolutions:
    """Return the full solution at a point, with matrices of clusters on shapes (N, N)."""
    state = state_matrix(model, model.damping(point), model.stiffness(point))
    held = len(state) - model.size
    values, right = np.linalg.eig(state)
    up = np.flatnonzero(values.imag > Tolerances.of(model).oscillation)
    own = np.where(model.free_coordinates[:, None], 0.0, right[held:, up])
    own /= np.linalg.norm(own, axis=0)
    numbers, columns, projections = reference.numbered(own, point.contact_stiffness)
    result = TrainingSolutions(np.full((1, model.size), np.nan, complex),
                               np.zeros((1, model.size, model.size), np.float32), [])
    result.eigenvalues[0, numbers] = values[up][columns]
    result.projections[0, numbers] = projections[:, columns].T
    where = np.full(model.size, -1)
    where[numbers] = up[columns]
    wanted = np.concatenate(clusters) if clusters else np.empty(0, int)
    members = where[wanted]
    forces = _forces(model, point, right[:held, members], right[held:, members])
    changes = np.linalg.inv(right)[:, held:] @ forces if clusters else forces
    for cluster in clusters:
        count = len(cluster)
        if shapes is None or where[cluster].min() < 0:
            matrix = SubspaceMatrix(np.full((count, count), np.nan, complex),
                                    np.full((6, count, count), np.nan, complex))
        else:
            matrix = subspace_matrix(values, shapes[:, cluster].T @ right[held:],
                                     changes[:, :, np.isin(wanted, cluster)], where[cluster])
        result.clusters.append(SubspaceMatrix(*(array[None] for array in matrix)))
    return result


def _forces(model: BrakeModel, q: OperatingPoint, place: ComplexArray,
            velocity: ComplexArray) -> ComplexArray:
    """Return the accelerations (6, N, n) of modes by a unit of each of `affine_coefficients`."""
    def by(array: Any, vectors: ComplexArray) -> Any:
        return np.zeros_like(velocity) if array is None else -(array[:, :] @ vectors)

    moving = np.logical_not(model.free_coordinates)
    spring, couple = (by(None if array is None else array[:, moving], place)
                      for array in (model.contact_stiffness, model.friction_couple))
    dashpot, dragged = by(model.contact_damping, velocity), by(model.contact_damping_couple,
                                                               velocity)
    stiffness, friction, scale = q.contact_stiffness, q.friction, q.damping_scale
    return np.stack([
        by(model.gyroscopic, velocity), by(model.radial_dissipation, velocity),
        by(model.negative_slope, velocity),
        spring + friction * couple + scale * (dashpot + friction * dragged),
        stiffness * (couple + scale * dragged),
        by(model.material_damping, velocity) + stiffness * (dashpot + friction * dragged)])
