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
The whole spectrum near an operating point, as power series of small blocks.

At the expansion point the state matrix A = V diag(lambda) W, W = V^-1, is solved with its vectors.
Nearby A + dA, dA = sum_i dc_i A_i affine in the coefficients c, so W dA V = sum_i z_i E_i in
scaled steps z_i = dc_i / s_i. Modes that could come near each other within a step are put in one
block. The damping scale stays: spring and dashpot of the contact layer share a coefficient. The
invariant subspace that continues a block's vectors is V (U + X), X without components
in the block, and the block's roots are those of the small matrix B,

    B = diag(lambda_C) + [E (U + X)]_C,        X (B) - diag(lambda) X = off-block part of E (U + X)

(the Riccati equation of the invariant subspace; Kato, Perturbation Theory for Linear Operators,
ch. II; Stewart and Sun, Matrix Perturbation Theory, ch. V). X and B are power series in z, found
degree by degree: every division is by a difference lambda_c - lambda_r of roots of different
blocks. What happens inside a block, veering, merging, an exceptional point, is in B exactly; the
series converges as long as no two blocks meet. All roots are kept, so none can cross unseen.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.surrogate.block_layout import BlockLayout
from squeal_core.surrogate.monomials import Monomials

DEGREE = 3


@dataclass(frozen=True, eq=False)
class SpectralExpansion:
    """
    Power series of the blocks of a spectrum around an operating point.

    It has no error bounds: of a friction couple whose entries form a ring all terms may vanish
    though the eigenvalues move. Users compare it with full solutions.

    Parameters
    ----------
    rows : (v,) index array
        Which of the `Coefficients` vary, at one damping scale.
    centre, scales : (v,) arrays
        z = (c - centre) / scales.
    monomials : Monomials
        Of z.
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.
    series : (terms, entries) complex array
        Of the blocks' entries, laid out as `BlockLayout` has them.
    mirrored : (n,) bool array
        Roots whose conjugates are roots too and are not among the n.

    """

    rows: IndexArray
    centre: FloatArray
    scales: FloatArray
    monomials: Monomials
    sizes: IndexArray
    series: ComplexArray
    mirrored: Any

    @cached_property
    def layout(self) -> BlockLayout:
        """Where in `series` the entries of each block are."""
        return BlockLayout(self.sizes)

    def eigenvalues(self, coefficients: FloatArray) -> ComplexArray:
        """Return the eigenvalues (..., n) [1/s] at coefficients (..., 9)."""
        return self.layout.eigenvalues((self._terms(coefficients) @ self._parts).view(complex))

    def partial_sums(self, coefficients: FloatArray) -> list[ComplexArray]:
        """Return the eigenvalues (..., n) of the series up to each degree from 1 on."""
        terms = self._terms(coefficients)
        ends = np.cumsum([len(of_degree) for of_degree in self.monomials.terms])
        return [self.layout.eigenvalues((terms[..., :end] @ self._parts[:end]).view(complex))
                for end in ends[1:].tolist()]

    def eigenvalues_of_blocks(self, blocks: IndexArray, coefficients: FloatArray) -> ComplexArray:
        """Return the eigenvalues (..., m) of some blocks, by ascending index, at coefficients."""
        layout = BlockLayout(self.sizes[blocks])
        rows = np.concatenate([self.layout.block(self.series, block)
                               for block in blocks.tolist()], axis=-1)
        terms = self._terms(coefficients)
        parts = np.ascontiguousarray(layout.laid_out(rows)).view(float)
        return layout.eigenvalues((terms @ parts).view(complex))

    def _terms(self, coefficients: FloatArray) -> FloatArray:
        """Return the products (..., terms) of scaled steps z."""
        return self.monomials.at((coefficients[..., self.rows] - self.centre) / self.scales)

    @cached_property
    def _parts(self) -> FloatArray:
        """Return the series as real and imaginary parts in turn (terms, 2 entries)."""
        return self.series.view(float)
