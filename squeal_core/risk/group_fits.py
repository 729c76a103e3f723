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
Fits small matrices of modes to full solutions, and finds which modes need a common one.

Families that do not couple with others have a matrix of their own. Where its eigenvalues are off,
as the family crosses another one, both get a common matrix, and so on.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.risk.emulator_audit import LARGE, MATTERS
from squeal_core.risk.mode_families import mixing
from squeal_core.risk.training_solutions import part_of, SubspaceMatrix, TrainingSolutions

_ENOUGH = 1.6  # 1/s; fourth-power mean error of growth rates up to which families stay apart
_SLOPE_WEIGHT = 0.3  # of an equation for a slope beside one for a value
_SOFT = 15.0  # 1/s below what matters at which an equation counts half
_OUTLYING = 3.0  # 1/s; what modes numbered the other way round are off by is more
_LEAST = 0.3  # weight of an equation, however fast the modes decay
_RIDGE = 1e-11  # of the largest diagonal entry
_REFITS = 3
_BETTER = 0.8  # of the error, for which a common matrix is worth its cost


class FittedGroup(NamedTuple):
    """
    Families that have a common matrix.

    Attributes
    ----------
    families : tuple of int
        Their indices.
    weights : (T, n, n) array
        Of terms, in the matrix of the families' modes in turn.
    error : float
        Fourth-power mean error of growth rates that matter [1/s].

    """

    families: tuple[int, ...]
    weights: ComplexArray
    error: float


Fit: TypeAlias = Callable[[tuple[int, ...]], FittedGroup]
Mixed: TypeAlias = Callable[[FittedGroup, FittedGroup], float]


def fitted_groups(rows: FloatArray, by_own: FloatArray, training: TrainingSolutions,
                  clusters: Sequence[IndexArray], families: Sequence[IndexArray],
                  count: int, band: FloatArray) -> list[FittedGroup]:
    """
    Return groups of families of the clusters, each with its fit.

    Parameters
    ----------
    rows : (7, P, T) array
        Terms at the points and their slopes by each variable.
    by_own : (P, 6) array
        Slopes of the variables by each own coefficient.
    training : TrainingSolutions
        At the points.
    clusters, families : sequences of arrays
        Places of modes; each family is within a cluster.
    count : int
        Number of families that matter, the first ones.
    band : (2,) floats
        Angular frequencies of the squeal band [rad/s].

    """
    mixed = mixing(training.eigenvalues, training.projections)
    result = []
    for cluster, matrix in zip(clusters, training.clusters, strict=True):
        def fit(group: tuple[int, ...], cluster: IndexArray = cluster,
                matrix: SubspaceMatrix = matrix) -> FittedGroup:
            modes = np.concatenate([families[i] for i in group])
            part = part_of(matrix, training.eigenvalues[:, cluster],
                           np.searchsorted(cluster, modes))
            weights = fit_matrix(rows, by_own, part,
                                 training.eigenvalues[:, modes].real.max(axis=1))
            ours: Any = np.linalg.eigvals(np.tensordot(rows[0], weights, 1))
            return FittedGroup(group, weights, _error(ours, training.eigenvalues, band))

        alone = [fit((i,)) for i, places in enumerate(families) if places[0] in cluster]
        result.extend(_joined(alone, count, fit, lambda a, b: float(mixed[np.ix_(
            np.concatenate([families[i] for i in a.families]),
            np.concatenate([families[i] for i in b.families]))].max())))
    return result


def _joined(groups: list[FittedGroup], count: int, fit: Fit, mixed: Mixed) -> list[FittedGroup]:
    """Return groups of families, joined with some that they mix with where they are off."""
    settled: set[tuple[int, ...]] = set()
    while True:
        off = [group for group in groups if group.error > _ENOUGH
               and min(group.families) < count and group.families not in settled]
        if not off:
            return groups
        worst = max(off, key=lambda group: group.error)
        settled.add(worst.families)
        joined = _with_others(worst, groups, fit, mixed)
        groups = [group for group in groups
                  if group is worst or not {*group.families} <= {*joined.families}]
        groups[[group is worst for group in groups].index(True)] = joined


def _with_others(worst: FittedGroup, groups: Sequence[FittedGroup], fit: Fit,
                 mixed: Mixed) -> FittedGroup:
    """Return a group joined with as few others as are enough, or best."""
    best = group = worst
    others = [other for other in groups if other is not worst]
    parts, needed = [worst], [worst]
    while others and best.error > _ENOUGH:
        others.sort(key=lambda other: mixed(group, other))
        parts.append(others.pop())
        group = fit(group.families + parts[-1].families)
        if group.error < _BETTER * best.error:
            best, needed = group, [*parts]
    for part in needed[1:-1]:
        fewer = [other for other in needed if other is not part]
        group = fit(tuple(i for other in fewer for i in other.families))
        if group.error <= max(_ENOUGH, best.error):
            best, needed = group, fewer
    return best


def fit_matrix(rows: FloatArray, by_own: FloatArray, matrix: SubspaceMatrix,
               growth: FloatArray) -> ComplexArray:
    """
    Return the weights (T, n, n) of terms that fit a matrix and its slopes.

    Equations count less where all modes decay fast, by the largest growth rate (P,), and where
    they are found to be far off: there modes that cross were numbered the other way round.
    """
    count = matrix.values.shape[-1] ** 2
    slopes = np.moveaxis(matrix.slopes, 1, 0) / by_own.T[:, :, None, None]
    wanted = np.concatenate([matrix.values[None], slopes]).reshape(7, -1, count)
    known = np.isfinite(wanted).all(axis=(0, 2))
    wanted, rows = wanted[:, known], rows[:, known]
    weight = np.maximum(_LEAST, 1.0 / (1.0 + np.maximum(MATTERS - growth[known], 0.0) / _SOFT))
    middle = np.median(wanted[0].real, axis=0) + 1j * np.median(wanted[0].imag, axis=0)
    wanted[0] -= middle
    kinds = np.array([1.0, *6 * [_SLOPE_WEIGHT]])[:, None]
    trusted, weights = weight, np.empty(0, complex)
    for _ in range(_REFITS):
        weights = _least_squares(rows, wanted, kinds * trusted)
        off = np.abs(rows[0] @ weights - wanted[0]).max(axis=1)
        trusted = weight / (1.0 + (off / (4.0 * np.median(off) + _OUTLYING)) ** 2)
    weights[0] += middle  # the first term is 1
    return weights.reshape(len(weights), *matrix.values.shape[1:])


def _least_squares(rows: FloatArray, wanted: ComplexArray, weights: FloatArray) -> Any:
    """Return x (T, n) of least weighted |rows x - wanted|; rows (7, P, T), wanted (7, P, n)."""
    left = (rows * weights[..., None]).reshape(-1, rows.shape[-1])
    right = (wanted * weights[..., None]).reshape(-1, wanted.shape[-1])
    normal = left.T @ left
    normal[np.diag_indices_from(normal)] += _RIDGE * normal.diagonal().max()
    return cho_solve(cho_factor(normal), left.T @ right)


def _error(ours: ComplexArray, truth: ComplexArray, band: FloatArray) -> float:
    """Return the error of growth rates (P, n) that matter, from the nearest true ones (P, N)."""
    distance = np.abs(ours[:, :, None] - truth[:, None])
    nearest = np.nanargmin(distance, axis=2)
    own = np.take_along_axis(truth, nearest, axis=1).real
    counts = (ours.imag >= band[0]) & (ours.imag <= band[1]) & (own < LARGE)
    # a mode on the brink of growing counts in full, one that hardly matters hardly
    importance = np.clip(np.maximum(ours.real, own) / -MATTERS + 1.0, 0.0, 1.0)
    off: FloatArray = np.where(counts, importance * (ours.real - own), 0.0)
    return float(np.sqrt(np.sqrt((off**4).sum() / len(off))))
