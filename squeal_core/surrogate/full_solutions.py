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

"""Full solutions that the cells of a table share: each is computed once."""

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import moving_eigenvalues
from squeal_core.surrogate.table_domain import TableDomain

_DIGITS = 9  # of a place in the envelope: neighbours compute it with different rounding


class FullSolutions:
    """
    Eigenvalues at places of an envelope, kept for the cells that meet there.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    domain : TableDomain
        The envelope.

    """

    def __init__(self, model: BrakeModel, domain: TableDomain) -> None:
        self.model, self.domain = model, domain
        self._low, self._width = domain.low, domain.width
        self._kept: dict[tuple[float, ...], ComplexArray] = {}

    def at(self, x: FloatArray, point: OperatingPoint) -> ComplexArray:
        """Return the eigenvalues (n,) at a place x (3,), known ones of free modes left out."""
        key = tuple(np.round((x - self._low) / self._width, _DIGITS).tolist())
        if key not in self._kept:
            self._kept[key] = moving_eigenvalues(self.model, point)
        return self._kept[key]
