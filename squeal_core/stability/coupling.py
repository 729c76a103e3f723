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

"""Coupling of modes by friction, and the partner of each mode."""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import eig
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.parameter_paths import matrices, moved
from squeal_core.stability.state_space import state_matrix


class FrictionCoupling:
    """
    Coupling of the modes by friction at an operating point.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Operating point.
    modes : sequence of Mode
        All of the point.

    Notes
    -----
    The second derivative of eigenvalue i over friction is the sum over j of
    2 (y_i^H B x_j) (y_j^H B x_i) / (lambda_i - lambda_j), with vectors of the first-order form, of
    y^H x = 1, and B its derivative. Towards a merging one term grows without bound, that of the
    partner, whatever the shapes of the two are there.

    """

    def __init__(self, model: BrakeModel, point: OperatingPoint, modes: Sequence[Mode]) -> None:
        here, there = (state_matrix(model, *matrices(model, one)) for one in (
            point, moved(model, point, 'friction', point.friction + 1.0)))
        self._roots, left, right = eig(here, left=True)
        left = left / np.einsum('ki,ki->i', left, right.conj())  # y^H x = 1
        self._rates = left.conj().T @ (there - here) @ right
        self._oscillating = [one for one in modes if one.kind in ('flutter', 'stable')]

    def partner(self, mode: Mode) -> Mode | None:
        """Return the oscillating mode through which friction moves another's eigenvalue most."""
        own, eigenvalues, rates = self._place(mode), self._roots, self._rates
        others = [one for one in self._oscillating if one.index != mode.index]
        strengths = [abs(rates[own, i] * rates[i, own] / (eigenvalues[own] - eigenvalues[i]))
                     if i != own else np.inf for i in map(self._place, others)]
        return others[int(np.argmax(strengths))] if others else None

    def _place(self, mode: Mode) -> int:
        return int(np.abs(self._roots - mode.eigenvalue).argmin())
