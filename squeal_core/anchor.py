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
from scipy.linalg.lapack import zgeev

from squeal_core.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.encounters import Encounters
from squeal_core.monomials import Monomials
from squeal_core.operating_point import OperatingPoint

DEGREE = 3
_TINY = 1e-200  # so small that nothing finite over it overflows
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
    encounters : Encounters
        Pairs of roots that the ratio of a block's terms does not show.
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
    encounters: Encounters
    rounding: FloatArray
    mirrored: Any

    @property
    def nbytes(self) -> int:
        """Size in memory [bytes], with what is made of it at first use."""
        bounds = 4 * 4 * self.sizes.size * self.monomials.count
        return int(self.series.nbytes + sum(m.nbytes for m in self.majorants)
                   + self.nearness.nbytes + self.encounters.nbytes + bounds)

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
        single, blocks = self._layout
        roots, errors = [entries[:single]], [remainder[:single]]
        for size, first, rows in blocks:
            part = entries[rows]
            if size == 2:
                _pairs(part, remainder[first], roots, errors)
            else:
                _block(part.reshape(size, size, -1), remainder[first], roots, errors)
        return np.concatenate(roots), np.concatenate(errors)

    @cached_property
    def _layout(self) -> tuple[int, list[tuple[int, Any, slice]]]:
        """Blocks of one root, then for all pairs and for each larger block: which, and where."""
        single, double = np.searchsorted(self.sizes, (2, 3)).tolist()
        place = single + 4 * (double - single)
        found: list[tuple[int, Any, slice]] = []
        if double > single:
            found.append((2, slice(single, double), slice(single, place)))
        for block in range(double, self.sizes.size):
            size = int(self.sizes[block])
            found.append((size, block, slice(place, place + size**2)))
            place += size**2
        return single, found

    def _remainder(self, terms: Sequence[FloatArray]) -> FloatArray:
        """Return the norm of what the series of each block leaves out (blocks, P)."""
        size = np.abs(np.concatenate(terms), dtype=np.float32)
        found = (self._bounds @ size).astype(float)
        near, before, last, final = found.reshape(4, self.sizes.size, -1)
        ratio = np.maximum(final / (last + _TINY), np.sqrt(np.maximum(
            final / (before + _TINY), near)))
        final = np.maximum(final, ratio * last)  # of a veering every other degree vanishes
        left = _SAFETY * final * ratio / np.maximum(1.0 - ratio, 1.0 - _DIVERGENT)
        left[ratio >= _DIVERGENT] = np.inf
        self.encounters.add_to(left, terms[1])
        return np.asarray(left + self.rounding[:, None])

    @cached_property
    def _bounds(self) -> Any:
        """`nearness` and the majorants in one matrix over all terms."""
        starts = np.cumsum([0, *(len(terms) for terms in self.monomials.terms)])
        found = np.zeros((4, self.sizes.size, self.monomials.count), np.float32)
        degrees = (2, *range(self.monomials.degree - 2, self.monomials.degree + 1))
        for part, degree, bound in zip(found, degrees, (self.nearness, *self.majorants),
                                       strict=True):
            part[:, starts[degree]:starts[degree + 1]] = bound
        return found.reshape(-1, self.monomials.count)


def _pairs(entries: ComplexArray, remainder: FloatArray, roots: list[ComplexArray],
           errors: list[FloatArray]) -> None:
    """Append the roots of 2 x 2 blocks: mean +- s, s^2 = half^2 + b c, and their errors."""
    a, b, c, d = entries.reshape(len(remainder), 4, -1).transpose(1, 0, 2)
    mean, half = 0.5 * (a + d), 0.5 * (a - d)
    square = half**2 + b * c
    s = np.sqrt(square)
    change = remainder * (2.0 * (np.abs(half) + np.abs(b) + np.abs(c)) + remainder)
    off = remainder + np.minimum(np.sqrt(change), change / (np.abs(s) + _TINY))
    both = np.empty((2 * len(off), off.shape[1]), complex)
    both[0::2], both[1::2] = mean - s, mean + s
    roots.append(both)
    errors.append(off.repeat(2, axis=0))


def _block(entries: ComplexArray, remainder: FloatArray, roots: list[ComplexArray],
           errors: list[FloatArray]) -> None:
    """Append roots and errors (m, P) of m x m blocks: Bauer and Fike, for each root."""
    size, points = len(entries), entries.shape[-1]
    found, condition = np.empty((size, points), complex), np.empty((size, points))
    for i in range(points):  # LAPACK itself: a quarter of the time of eig and inv on these sizes
        found[:, i], left, right, failed = zgeev(entries[:, :, i])
        condition[:, i] = np.inf if failed else (
            1.0 / (np.abs((left.conj() * right).sum(axis=0)) + _TINY))
    roots.append(found)
    errors.append(size * condition * remainder)


def norms(terms: ComplexArray, sizes: IndexArray) -> FloatArray:
    """Return the Frobenius norm of each block (blocks, terms)."""
    ends = np.cumsum(sizes**2)
    squares = np.add.reduceat(np.abs(terms) ** 2, np.concatenate([[0], ends[:-1]]), axis=1)
    return np.asarray(np.sqrt(squares).T)
