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

"""With which mode another one couples by friction."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eig
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.parameter_paths import matrices, moved
from squeal_core.stability.state_space import state_matrix


def coupling_partner(model: BrakeModel, point: OperatingPoint, mode: Mode,
                     modes: Sequence[Mode]) -> Mode | None:
    """
    Return the oscillating mode through which friction moves a mode's eigenvalue most.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    mode : Mode
        A mode at the point, which oscillates.
    modes : sequence of Mode
        All of the point.

    Notes
    -----
    The second derivative of eigenvalue i over friction is the sum over j of
    2 (y_i^H B x_j) (y_j^H B x_i) / (lambda_i - lambda_j), with vectors of the first-order form, of
    y^H x = 1, and B its derivative. Towards a merging one term grows without bound, that of the
    partner, whatever the shapes of the two are there.

    """
    here, there = (state_matrix(model, *matrices(model, one)) for one in (
        point, moved(model, point, 'friction', point.friction + 1.0)))
    roots, left, right = eig(here, left=True)
    left = left / np.einsum('ki,ki->i', left, right.conj())  # y^H x = 1
    rates = left.conj().T @ (there - here) @ right
    own = int(np.abs(roots - mode.eigenvalue).argmin())
    others = [one for one in modes if one.index != mode.index and one.kind in (
        'flutter', 'stable')]
    places = [int(np.abs(roots - one.eigenvalue).argmin()) for one in others]
    strengths = [abs(rates[own, i] * rates[i, own] / (roots[own] - roots[i]))
                 if i != own else np.inf for i in places]
    return others[int(np.argmax(strengths))] if others else None
