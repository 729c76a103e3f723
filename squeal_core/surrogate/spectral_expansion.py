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
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.surrogate.block_layout import BlockLayout
from squeal_core.surrogate.coupling_floor import CouplingFloor
from squeal_core.surrogate.monomials import Monomials
from squeal_core.surrogate.pair_remainder import PairRemainder

DEGREE = 3
_TINY = 1e-30  # of no consequence, and nothing over it overflows in single precision
_DIVERGENT = 0.8  # ratio of successive degrees from which on a series is not believed
_REACH = 4.9e-7  # part of the largest eigenvalue that the remainder is within reach
_SAFETY = 6.0  # on the remainder of a series; docs/online.md has the errors it covers


@dataclass(frozen=True, eq=False)
class BlockSeries:
    """
    Power series of the blocks of a spectrum around an operating point, without error bounds.

    Parameters
    ----------
    point : OperatingPoint
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

    point: OperatingPoint
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

    def eigenvalues_alone(self, coefficients: FloatArray) -> ComplexArray:
        """Return the eigenvalues alone, for less than `eigenvalues_at` with its errors."""
        _, terms = self._steps_and_terms(coefficients)
        return self.layout.eigenvalues_of((terms @ self._parts).view(complex))

    def partial_sums(self, coefficients: FloatArray) -> list[ComplexArray]:
        """Return the eigenvalues (..., n) of the series up to each degree from 1 on."""
        _, terms = self._steps_and_terms(coefficients)
        ends = np.cumsum([len(of_degree) for of_degree in self.monomials.terms])
        return [self.layout.eigenvalues_of((terms[..., :end] @ self._parts[:end]).view(complex))
                for end in ends[1:].tolist()]

    def eigenvalues_of_blocks(self, blocks: IndexArray, coefficients: FloatArray) -> ComplexArray:
        """Return the eigenvalues (..., m) of some blocks, by ascending index, at coefficients."""
        layout = BlockLayout(self.sizes[blocks])
        rows = np.concatenate([self.layout.block(self.series, block)
                               for block in blocks.tolist()], axis=-1)
        _, terms = self._steps_and_terms(coefficients)
        parts = np.ascontiguousarray(layout.laid_out(rows)).view(float)
        return layout.eigenvalues_of((terms @ parts).view(complex))

    def _steps_and_terms(self, coefficients: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the scaled steps z (..., v) and their products (..., terms)."""
        steps = (coefficients[..., self.rows] - self.centre) / self.scales
        return steps, self.monomials.at(steps)

    @cached_property
    def _parts(self) -> FloatArray:
        """Return the series as real and imaginary parts in turn (terms, 2 entries)."""
        return self.series.view(float)


@dataclass(frozen=True, eq=False)
class SpectralExpansion(BlockSeries):
    """
    Power series of the blocks of a spectrum with bounds of their errors; `BlockSeries` has more.

    Parameters
    ----------
    term_norms : three arrays (blocks, terms of a degree)
        Frobenius norms of the terms of the last three degrees.
    coupling_ratio : (blocks, terms of degree 2) array
        Square of the step over that at which a block meets another, were these two alone.
    pair_remainder : PairRemainder
        Pairs of roots that the ratio of a block's terms does not show.
    floor : CouplingFloor
        Least remainder by couplings over gaps, whatever the terms.
    rounding : (blocks,) array
        Error of the eigensolution at the expansion point [1/s].

    """

    term_norms: tuple[FloatArray, ...]
    coupling_ratio: FloatArray
    pair_remainder: PairRemainder
    floor: CouplingFloor
    rounding: FloatArray

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes], with what is made of it at first use."""
        bounds = 4 * 4 * self.sizes.size * self.monomials.count
        return int(self.series.nbytes + sum(m.nbytes for m in self.term_norms)
                   + self.coupling_ratio.nbytes + self.pair_remainder.nbytes + self.floor.nbytes
                   + bounds)

    @cached_property
    def trust_radius(self) -> FloatArray:
        """
        Step of each coefficient alone (v,) at which the remainder is about 0.1 1/s.

        Or a part of the largest eigenvalue, where that is more.
        """
        degree = self.monomials.degree
        alone = [self.monomials.places[degree][(i,) * degree] for i in range(self.rows.size)]
        largest = self.term_norms[-1][:, alone].max(axis=0)
        remainder = max(0.1, _REACH * float(np.abs(self.series[0]).max(initial=0.0)))
        steps = np.minimum((remainder / np.maximum(largest, 1e-300)) ** (1.0 / degree), 1e3)
        return readonly(steps * self.scales)

    def eigenvalues(self, coefficients: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Return eigenvalues, (n, P) [1/s], and what they may be off by, at coefficients."""
        roots, errors = self.eigenvalues_at(coefficients.T)
        return roots.T, errors.T

    def eigenvalues_at(self, coefficients: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """
        Return the roots (..., n) [1/s] and what they may be off by, at coefficients (..., 9).

        The error is an estimate: the terms of the last degrees, by their norms, continued as a
        geometric series, times the condition of each root within its block. It is infinite where
        the terms do not decrease.
        """
        steps, terms = self._steps_and_terms(coefficients)
        entries = (terms @ self._parts).view(complex)
        remainder = self._remainder(np.abs(terms).astype(np.float32))
        remainder += self.pair_remainder.bound(steps)
        np.maximum(remainder, self.floor.bound(steps), out=remainder)
        remainder += self.rounding
        return self.layout.solved(entries, remainder)

    def _remainder(self, sizes: Any) -> FloatArray:
        """Return the norm of what the series leaves out (..., blocks), from terms' sizes."""
        found = sizes @ self._bounds
        bounds = found.reshape(*found.shape[:-1], 4, -1)
        last, final, near = bounds[..., 1, :], bounds[..., 2, :], bounds[..., 3, :]
        with np.errstate(over='ignore'):  # where terms of less degree vanish
            ratios = final[..., None, :] / bounds[..., :2, :]
            ratio = np.maximum(ratios[..., 1, :], np.sqrt(np.maximum(ratios[..., 0, :], near)))
            final = np.maximum(final, ratio * last)  # of a veering every other degree vanishes
            left = _SAFETY * final * ratio / np.maximum(1.0 - ratio, 1.0 - _DIVERGENT)
        left[ratio >= _DIVERGENT] = np.inf
        return np.asarray(left, float)

    @cached_property
    def _bounds(self) -> Any:
        """Term norms of the last three degrees and `coupling_ratio`, by term (terms, 4 blocks)."""
        starts = np.cumsum([0, *(len(terms) for terms in self.monomials.terms)])
        found = np.zeros((self.monomials.count, 4, self.sizes.size), np.float32)
        degrees = (*range(self.monomials.degree - 2, self.monomials.degree + 1), 2)
        for part, (degree, bound) in enumerate(zip(
                degrees, (*self.term_norms, self.coupling_ratio), strict=True)):
            found[starts[degree]:starts[degree + 1], part] = bound.T
        found[0, :2] += _TINY  # the term 1: they are divided by
        return found.reshape(self.monomials.count, -1)
