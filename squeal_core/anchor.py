"""The whole spectrum near an operating point, as power series of small blocks.

At the anchor the state matrix A = V diag(lambda) W, W = V^-1, is solved with all its vectors.
Nearby A + dA, dA = sum_i dc_i A_i affine in the six coefficients c, so W dA V = sum_i z_i E_i in
scaled steps z_i = dc_i / s_i. Modes that could come near each other within a step are put in one
block. The invariant subspace that continues a block's vectors is V (U + X), X without components
in the block, and the block's roots are those of the small matrix B,

    B = diag(lambda_C) + [E (U + X)]_C,        X (B) - diag(lambda) X = off-block part of E (U + X)

(the Riccati equation of the invariant subspace; Kato, Perturbation Theory for Linear Operators,
ch. II; Stewart and Sun, Matrix Perturbation Theory, ch. V). X and B are power series in z, found
degree by degree: every division is by a difference lambda_c - lambda_r of roots of different
blocks. What happens inside a block, veering, merging, an exceptional point, is in B exactly; the
series converges as long as no two blocks meet. All roots are kept, so none can cross unseen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from squeal_core.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.monomials import Monomials
from squeal_core.operating_point import OperatingPoint

DEGREE = 4
_DIVERGENT = 0.8  # ratio of successive degrees from which on a series is not believed
_SAFETY = 6.0  # on the remainder of a series; docs/online.md has the errors it covers


@dataclass(frozen=True, eq=False)
class Anchor:
    """Power series of the blocks of a spectrum around an operating point.

    Parameters
    ----------
    point : OperatingPoint
    rows : (v,) index array
        Which of the six coefficients the model depends on.
    centre, scales : (v,) arrays
        z = (c - centre) / scales.
    monomials : Monomials
        Of z.
    sizes : (blocks,) index array
        Sizes of the blocks, ascending.
    series : (2 entries, terms) array
        Real, then imaginary parts of the blocks' entries, block by block, row by row.
    majorants : three arrays (blocks, terms of a degree)
        Frobenius norms of the terms of the last three degrees.
    nearness : (blocks, terms of degree 2) array
        Square of the step over that at which a block meets another, were these two alone.
    rounding : (blocks,) array
        Error of the eigensolution at the anchor [1/s].
    mirrored : (n,) bool array
        Roots whose conjugates are roots too and are not among the n.
    """

    point: OperatingPoint
    rows: IndexArray
    centre: FloatArray
    scales: FloatArray
    monomials: Monomials
    sizes: IndexArray
    series: FloatArray
    majorants: tuple[FloatArray, ...]
    nearness: FloatArray
    rounding: FloatArray
    mirrored: Any

    @property
    def nbytes(self) -> int:
        return int(self.series.nbytes + sum(m.nbytes for m in self.majorants))

    @cached_property
    def reach(self) -> FloatArray:
        """Step of each coefficient alone (v,) at which the remainder is about 0.1 1/s."""
        degree = self.monomials.degree
        alone = [self.monomials.places[degree][(i,) * degree] for i in range(self.rows.size)]
        largest = self.majorants[-1][:, alone].max(axis=0)
        steps = np.minimum((0.1 / np.maximum(largest, 1e-300)) ** (1.0 / degree), 1e3)
        return readonly(steps * self.scales)

    def steps(self, coefficients: FloatArray) -> FloatArray:
        """Return z (v, P) of coefficients (6, P)."""
        return (coefficients[self.rows] - self.centre[:, None]) / self.scales[:, None]

    def roots(self, coefficients: FloatArray) -> tuple[ComplexArray, FloatArray]:
        """Return the roots (n, P) [1/s] and what they may be off by, at coefficients (6, P).

        The error is an estimate: the terms of the last degrees, by their norms, continued as a
        geometric series, times the condition of each root within its block. It is infinite where
        the terms do not decrease.
        """
        terms = self.monomials(self.steps(coefficients))
        flat = self.series @ np.concatenate(terms)
        entries = flat[:len(flat) // 2] + 1j * flat[len(flat) // 2:]
        remainder = self._remainder(terms)
        single, double = np.searchsorted(self.sizes, (2, 3))
        roots, errors = [entries[:single]], [remainder[:single]]
        if double > single:
            of_pairs = entries[single:single + 4 * (double - single)]
            _pairs(of_pairs, remainder[single:double], roots, errors)
        place = single + 4 * (double - single)
        for block in range(double, self.sizes.size):
            size = int(self.sizes[block])
            found = _block(entries[place:place + size**2].reshape(size, size, -1),
                           remainder[block])
            roots.append(found[0])
            errors.append(found[1])
            place += size**2
        return np.concatenate(roots), np.concatenate(errors)

    def _remainder(self, terms: Sequence[FloatArray]) -> FloatArray:
        """Return the norm of what the series of each block leaves out (blocks, P)."""
        before, last, final = (m @ np.abs(t) for m, t in zip(self.majorants, terms[-3:],
                                                             strict=True))
        tiny = 1e-300
        ratio = np.maximum(final / (last + tiny), np.sqrt(final / (before + tiny)))
        ratio = np.maximum(ratio, np.sqrt(self.nearness @ np.abs(terms[2])))
        final = np.maximum(final, ratio * last)  # of a veering every other degree vanishes
        with np.errstate(divide='ignore', invalid='ignore'):
            left = np.where(ratio < _DIVERGENT, _SAFETY * final * ratio / (1.0 - ratio), np.inf)
        return left + self.rounding[:, None]


def _pairs(entries: ComplexArray, remainder: FloatArray, roots: list[ComplexArray],
           errors: list[FloatArray]) -> None:
    """Append the roots of 2 x 2 blocks: mean +- s, s^2 = half^2 + b c, and their errors."""
    a, b, c, d = entries.reshape(len(remainder), 4, -1).transpose(1, 0, 2)
    mean, half = 0.5 * (a + d), 0.5 * (a - d)
    square = half**2 + b * c
    s = np.sqrt(square)
    change = remainder * (2.0 * (np.abs(half) + np.abs(b) + np.abs(c)) + remainder)
    with np.errstate(divide='ignore', invalid='ignore'):
        off = remainder + np.minimum(np.sqrt(change), change / np.abs(s))
    off = np.where(np.isfinite(remainder), off, np.inf)
    both = np.stack([mean - s, mean + s], axis=1)
    roots.append(both.reshape(-1, both.shape[-1]))
    errors.append(np.repeat(off, 2, axis=0))


def _block(entries: ComplexArray, remainder: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Return roots and errors (m, P) of m x m blocks: Bauer and Fike, for each root."""
    roots, right = np.linalg.eig(np.moveaxis(entries, -1, 0))
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:  # two vectors are one, to the last bit
        left = np.full_like(right, np.inf)
    condition = np.linalg.norm(left, axis=2) * np.linalg.norm(right, axis=1)
    with np.errstate(invalid='ignore'):
        errors = len(entries) * condition.T * remainder
    return roots.T, np.where(np.isnan(errors), np.inf, errors)
