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

"""How far the eigenvalues of an expansion are from full solutions."""

from dataclasses import dataclass

import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.surrogate.spectral_expansion import SpectralExpansion


@dataclass(frozen=True, eq=False)
class Deviation:
    """
    How far eigenvalues of an expansion are from those of full solutions.

    Parameters
    ----------
    off : float
        Largest distance, in tolerances.
    each : (n,) array
        Error of growth of each eigenvalue [1/s]; -1: not known.

    """

    off: float
    each: FloatArray

    @classmethod
    def none(cls, expansion: SpectralExpansion) -> 'Deviation':
        """Return that of no comparison."""
        return cls(0.0, np.full(int(expansion.sizes.sum()), -1.0))

    def with_(self, other: 'Deviation') -> 'Deviation':
        """Return the worse of two, root by root."""
        return Deviation(max(self.off, other.off), np.maximum(self.each, other.each))

    @property
    def growth(self) -> float:
        """Return the largest error of growth [1/s]."""
        return float(self.each.max(initial=0.0))

    def of_each(self, expansion: SpectralExpansion) -> FloatArray:
        """Return the error of each root, of a block the largest; of all where not known."""
        starts = np.cumsum(expansion.sizes) - expansion.sizes
        worst = np.repeat(np.maximum.reduceat(self.each, starts), expansion.sizes)
        return np.where(worst < 0.0, self.growth, worst)
