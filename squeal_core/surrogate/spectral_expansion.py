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
in the block, and the block's eigenvalues are those of the small matrix B,

    B = diag(lambda_C) + [E (U + X)]_C,        X (B) - diag(lambda) X = off-block part of E (U + X)

(the Riccati equation of the invariant subspace; Kato, Perturbation Theory for Linear Operators,
ch. II; Stewart and Sun, Matrix Perturbation Theory, ch. V). X and B are power series in z, found
degree by degree: every division is by a difference lambda_c - lambda_r of eigenvalues of different
blocks. What happens inside a block, veering, merging, an exceptional point, is in B exactly; the
series converges as long as no two blocks meet. All eigenvalues are kept, so none can cross unseen.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
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
        Of the blocks' entries, block by block, each row by row.
    mirrored : (n,) bool array
        Eigenvalues whose conjugates are eigenvalues too and are not among the n.

    """

    rows: IndexArray
    centre: FloatArray
    scales: FloatArray
    monomials: Monomials
    sizes: IndexArray
    series: ComplexArray
    mirrored: Any

    def eigenvalues(self, coefficients: FloatArray) -> ComplexArray:
        """Return those at coefficients, (..., n) at (..., 9) [1/s]."""
        terms = self.monomials.at(self.steps(coefficients))
        entries = (terms @ self.series.view(float)).view(complex)
        result = []
        for size, count in self._sizes():
            blocks, entries = np.split(entries, [count * size**2], axis=-1)
            result.append(_of_matrices(blocks.reshape(*blocks.shape[:-1], count, size, size)))
        return np.concatenate(result, axis=-1)

    def steps(self, coefficients: FloatArray) -> FloatArray:
        """Return z (..., v) of coefficients (..., 9)."""
        return (coefficients[..., self.rows] - self.centre) / self.scales

    def truncated(self) -> 'SpectralExpansion':
        """Return the series without its last degree."""
        lower = Monomials(self.monomials.variables, self.monomials.degree - 1)
        return replace(self, monomials=lower, series=self.series[:lower.count])

    def differences(self, eigenvalues: ComplexArray, others: ComplexArray) -> ComplexArray:
        """Return (P, n) eigenvalues less the nearest in the same block of others (P, n)."""
        result, start = [], 0
        for size, count in self._sizes():
            mine, theirs = (each[:, start:start + size * count].reshape(-1, count, size)
                            for each in (eigenvalues, others))
            start += size * count
            apart = mine[..., :, None] - theirs[..., None, :]
            nearest = np.abs(apart).argmin(axis=-1)[..., None]
            result.append(np.take_along_axis(apart, nearest, axis=-1).reshape(
                len(eigenvalues), -1))
        return np.concatenate(result, axis=-1)

    @property
    def starts(self) -> IndexArray:
        """Place of the first eigenvalue of each block."""
        return np.asarray(np.cumsum(self.sizes) - self.sizes)

    def _sizes(self) -> Iterator[tuple[int, int]]:
        """Yield each size of blocks, ascending, and how many there are."""
        sizes, counts = np.unique(self.sizes, return_counts=True)
        yield from zip(sizes.tolist(), counts.tolist(), strict=True)


def _of_matrices(blocks: ComplexArray) -> ComplexArray:
    """Return the eigenvalues (..., m size) of matrices (..., m, size, size)."""
    if blocks.shape[-1] == 1:
        return blocks[..., 0, 0]
    if blocks.shape[-1] == 2:  # for a tenth of the time of LAPACK
        a, b, c, d = np.moveaxis(blocks.reshape(*blocks.shape[:-2], 4), -1, 0)
        mean, half = 0.5 * (a + d), 0.5 * (a - d)
        s = np.sqrt(half * half + b * c)
        result = np.stack([mean - s, mean + s], axis=-1)
    else:
        result = np.linalg.eigvals(blocks)
    return result.reshape(*result.shape[:-2], -1)
