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

"""What a table keeps of one cell of its envelope, and how well it has to know it."""

from dataclasses import dataclass
from functools import cache, cached_property
import math
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.stability.state_space import frequency_scale
from squeal_core.surrogate.block_invariants import BlockInvariants
from squeal_core.surrogate.monomials import Monomials

DEGREE = 4  # of the fit: 35 terms
_GROWTH = 4.9e-7  # of the model's largest frequency: ten times what counts as growth
_MATTERS = 2.47e-5  # of the model's largest frequency: decay rate of modes that do not matter


@cache
def fit_terms(degree: int) -> Monomials:
    """Return the polynomial terms of the cell coordinates."""
    return Monomials(3, degree)


@dataclass(frozen=True, kw_only=True)
class TableTolerances:
    """
    What a table has to know, and how well.

    Parameters
    ----------
    growth : float
        Largest error of an eigenvalue [1/s].
    decay : float
        Largest error of a mode that decays, as a fraction of its decay rate, where that is more.
    matters : float
        Modes whose growth rate stays below this throughout a cell are omitted from it [1/s].
    band : (2,) floats
        Band in which the least stable mode is always kept, whatever its growth rate [Hz].

    """

    growth: float = 0.1
    decay: float = 0.02
    matters: float = -5.0
    band: tuple[float, float] = (1250.0, 16000.0)

    def __post_init__(self) -> None:
        low, high = self.band
        if not (0.0 < self.growth < math.inf and 0.0 <= self.decay < math.inf
                and -math.inf < self.matters < math.inf and 0.0 <= low < high):
            raise SquealError(f'{self}: give finite tolerances above 0 and a rising band')

    @classmethod
    def of(cls, model: BrakeModel, *, growth: float | None = None) -> 'TableTolerances':
        """Return tolerances relative to the model's spectrum; 0.1 and -5 1/s for K09's."""
        scale = frequency_scale(model)
        if not scale:
            return cls() if growth is None else cls(growth=growth)
        return cls(growth=_GROWTH * scale if growth is None else growth,
                   matters=-_MATTERS * scale)

    def allowed(self, roots: Any) -> Any:
        """Return the largest error of each eigenvalue [1/s]."""
        return np.maximum(self.growth, -self.decay * roots.real)


@dataclass(frozen=True, eq=False)
class TableCell:
    """
    Blocks of eigenvalues in a cell, as polynomials of its coordinates u in [-1, 1]^3.

    Parameters
    ----------
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.
    series : (terms, 2 n) array
        Real and imaginary part of the blocks' invariants; the first row in double precision.
    bounds : (n,) array
        Of the errors of the invariants.
    mirrored : (n,) bool array
        Eigenvalues whose conjugates are not among them.
    omitted : (terms of degree 2, modes) array
        Angular frequency of the omitted modes [rad/s].
    omitted_below : float
        Growth rate that the omitted modes stay below [1/s].

    """

    sizes: IndexArray
    series: FloatArray
    bounds: FloatArray
    mirrored: Any
    omitted: FloatArray
    omitted_below: float

    @cached_property
    def layout(self) -> BlockInvariants:
        return BlockInvariants(self.sizes)

    def at(self, terms: FloatArray) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """
        Return eigenvalues (..., n), error bounds (..., n), frequencies of omitted modes.

        Parameters
        ----------
        terms : (..., terms) array
            Of the cell coordinates, as `fit_terms` has them.

        """
        values = (terms[..., None, :] @ self._all)[..., 0, :]  # bit for bit those of each alone
        ends = 2 * self.layout.count
        roots, errors = self.layout.eigenvalues(values[..., :ends].view(complex), self.bounds)
        return roots, errors, values[..., ends:]

    @cached_property
    def _all(self) -> FloatArray:
        lacking = len(self.series) - len(self.omitted)
        return np.concatenate([self.series, np.pad(self.omitted, ((0, lacking), (0, 0)))], axis=1)


def not_known(roots: ComplexArray, errors: FloatArray, mirrored: Any, omitted_below: Any,
              tolerances: TableTolerances, limits: Tolerances) -> Any:
    """
    Tell which of the eigenvalues (..., n) of cells are not known well enough.

    Those are modes that matter with errors above the tolerance, and pairs that became real.
    """
    failing = (errors > tolerances.allowed(roots)) & (roots.real + errors > omitted_below)
    return failing | (mirrored & (roots.imag <= limits.oscillation))


def verdict_within_error(roots: ComplexArray, errors: FloatArray, tolerances: Tolerances) -> Any:
    """Tell which verdicts hang on the errors."""
    return np.abs(roots.real - tolerances.growth) <= errors
