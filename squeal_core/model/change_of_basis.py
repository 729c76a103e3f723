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

"""A modal brake model in other coordinates: those of another model's modes, or with added mass."""

from dataclasses import replace
from typing import Any

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.model.matrix_names import OPERATORS

_NEAR = 0.05  # relative distance of frequencies of modes that may be the same one


def in_basis(model: BrakeModel, basis: FloatArray, *, reference: BrakeModel) -> BrakeModel:
    """
    Return a model in the coordinates b of a = T b.

    Parameters
    ----------
    model : BrakeModel
        m modes, coordinates a.
    basis : (m, n) array
        T. Orthogonal columns keep the mass normalisation; others change the mass.
    reference : BrakeModel
        Of n modes: its frequencies and damping ratios stand on the diagonal of the result, names
        and surface are its own. What the matrices have beyond them is in the support matrices.

    """
    stiffness = np.diag(model.angular_frequencies**2)
    if model.support_stiffness is not None:
        stiffness = stiffness + model.support_stiffness
    own = np.diag(reference.angular_frequencies**2), np.diag(reference.structural_damping)
    rest = [basis.T @ array @ basis - diagonal for array, diagonal in zip(
        (stiffness, model.material_damping), own, strict=True)]
    arrays: dict[str, Any] = {name: basis.T @ array @ basis for name in OPERATORS
                              for array in [getattr(model, name)] if array is not None}
    return replace(
        model, angular_frequencies=reference.angular_frequencies,
        damping_ratios=reference.damping_ratios, names=reference.names,
        surface=reference.surface, support_stiffness=rest[0], support_damping=rest[1],
        **arrays)


def _nearness(own: FloatArray, others: FloatArray) -> FloatArray:
    """Return weights (m, n) of pairs of angular frequencies; 1 where both are zero."""
    scale = own[:, None] + others
    apart = np.divide(2.0 * (own[:, None] - others), scale, out=np.zeros_like(scale),
                      where=scale > 0.0)
    return np.asarray(np.exp(-0.5 * (apart / _NEAR)**2))


def aligned(model: BrakeModel, reference: BrakeModel) -> BrakeModel:
    """
    Return a model in coordinates that are as near as possible to those of a similar one.

    Its spectrum stays as it is. Signs of modes, orientations of doublets and the order of modes
    whose frequencies have crossed become those of the reference.

    Parameters
    ----------
    model, reference : BrakeModel
        Both with surface shapes, of the same grid; the model has as many modes or more.

    Raises
    ------
    ModelError
        Where one has no surface shapes, or parts have fewer modes than in the reference.

    Notes
    -----
    The orthogonal Procrustes problem for the shapes on each part's surface: with the singular
    value decomposition U s V^T of S^T S_0 the basis is U V^T. Shapes count the less the farther
    apart their frequencies are: on its surface alone a part's mode may look like one far above.
    Further modes of the model that have no counterpart are left out. Coordinates that no
    stiffness acts on are taken apart from the others, so that they stay exactly free.

    """
    if model.surface is None or reference.surface is None or (
            model.surface.patches != reference.surface.patches):
        raise ModelError('surface: shapes of both models on the same grid are needed to match '
                         'their modes; build them from brake descriptions')
    basis, first = np.zeros((model.size, reference.size)), 0
    for patch in reference.surface.patches:
        rows = slice(first, first + patch.size)
        first = rows.stop
        shapes, wanted = (result.surface.shapes[rows].reshape(3 * patch.size, -1)  # type: ignore
                          for result in (model, reference))
        for free in (True, False):
            columns, own = (np.flatnonzero(result.free_coordinates == free) for result in (
                model, reference))
            columns, own = (places[np.abs(array[:, places]).max(axis=0, initial=0.0) > 0.0]
                            for places, array in ((columns, shapes), (own, wanted)))
            if len(columns) < len(own):
                raise ModelError(f'{patch.name}: has {len(columns)} modes where {len(own)} are '
                                 'to be matched; keep as many')
            likeness = shapes[:, columns].T @ wanted[:, own] * _nearness(
                model.angular_frequencies[columns], reference.angular_frequencies[own])
            u, _, v = np.linalg.svd(likeness, full_matrices=False)
            basis[np.ix_(columns, own)] = u @ v
    return in_basis(model, basis, reference=reference)
