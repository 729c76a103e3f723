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

"""The probability of growth from a cell: growth rates over the inputs' spread, and their sum."""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.common.arrays import ComplexArray, FloatArray, readonly
from squeal_core.risk.quadrature import TensorQuadrature
from squeal_core.risk.risk_cell import Cell, Family, inside, Spread

_ASIDE = 4  # columns with speed and pressure moved, behind those of the grid
_LARGEST_STEP = 0.3  # of pressure and speed, over which their effect is taken
_TURN = np.exp(2j * np.pi / 3.0)


@dataclass(frozen=True, eq=False)
class Estimate:
    """
    Growth rates at points and over their inputs' spread, and the probabilities they come to.

    Parameters
    ----------
    cell : Cell
        That they are from.
    ways : (P, ways, points, nodes * parts) array
        Growth rate of the modes on each way over friction and contact stiffness, above what
        counts as growth [1/s].
    edges : (P, ways, 1, nodes * parts) array
        Their standard deviation by speed and pressure [1/s].
    others : (nodes * parts,) array
        Growth rate of the least stable of all other modes [1/s].

    """

    cell: Cell
    ways: FloatArray
    edges: FloatArray
    others: FloatArray

    @cached_property
    def overall(self) -> tuple[FloatArray, FloatArray]:
        """
        Probability (P,) that at least one mode grows, and its error (P,).

        The error is what it changes by as all growth rates change by the cell's errors.
        """
        rule, off = self.cell.rule, self.cell.errors_of_parts
        least = self.ways.max(axis=1)
        edge = np.where(self.ways == least[:, None], self.edges, 0.0).max(axis=1)
        least = np.maximum(least, self.others)
        widths = rule.widths(least, edge)
        coarse = least[:, ::2]
        low, high = rule.probability(np.array([coarse - off, coarse + off]), widths[:, ::2])
        found = rule.probability(least, widths)
        return np.clip(found, 0.0, 1.0), np.maximum(0.5 * (high - low), 0.0)

    @cached_property
    def modes(self) -> FloatArray:
        """Probability that each of the cell's modes grows (P, m)."""
        rule, count = self.cell.rule, self.cell.modes.size
        coarse = np.ascontiguousarray(self.ways[:, :count, ::2])
        return rule.probability(coarse, rule.widths(coarse, self.edges[:, :count]))


def estimate(cell: Cell, family: Family, spread: Spread, inputs: ArrayLike,
             band: tuple[float, float], level: float) -> Estimate:
    """
    Return the estimate at points, from a cell around them.

    Parameters
    ----------
    cell : Cell
        Precomputed growth rates.
    family : Family
        Models of the matrices.
    spread : Spread
        Standard deviations of the inputs.
    inputs : (P, 3) array
        Speed [rad/s], pressure [Pa] and friction of each.
    band : (2,) floats
        Of the angular frequencies that count [rad/s].
    level : float
        What counts as growth [1/s].

    """
    places = _coefficients(cell.rule, family, spread, np.asarray(inputs, float))
    points, grid = places.shape[1], cell.rule.continued.shape[1]
    found = cell.series @ cell.terms(places.reshape(6, -1))
    found = found.reshape(-1, places.shape[-1]) @ cell.rule.continued
    growth = _growth(cell, found.reshape(len(cell.series), points * grid), band) - level
    growth = growth.reshape(len(growth), points, grid)
    return Estimate(cell, _by_ways(cell, growth[..., :-_ASIDE], level),
                    _edges(cell, growth[..., -_ASIDE:], spread), cell.others_of_parts - level)


def _coefficients(rule: TensorQuadrature, family: Family, spread: Spread,
                  inputs: FloatArray) -> FloatArray:
    """Return coefficients (6, P, places): contact stiffness by friction, then moved aside."""
    speed, pressure, friction = inputs.T[..., None]
    faster, harder, slipperier, stiffer = _moves(rule, spread)
    return family.coefficients(
        speed * faster, pressure * harder, friction + slipperier, stiffer)


@lru_cache(maxsize=32)
def _moves(rule: TensorQuadrature, spread: Spread) -> FloatArray:
    """Return factors of speed, pressure and stiffness, and steps of friction (4, places)."""
    grid = rule.friction_moves.size
    found = np.ones((4, grid + _ASIDE))
    found[0, grid:grid + 2] += np.array([-1.0, 1.0]) * _step(spread.rotor_speed)
    found[1, grid + 2:] += np.array([-1.0, 1.0]) * _step(spread.pressure)
    found[2, :grid], found[2, grid:] = spread.friction * rule.friction_moves, 0.0
    found[3, :grid] = rule.stiffness_moves
    return readonly(found)


def _step(deviation: float) -> float:
    return min(deviation, _LARGEST_STEP)


def _growth(cell: Cell, found: FloatArray, band: tuple[float, float]) -> FloatArray:
    """Return growth rates (rows, points) from what the cell's series give (series, points)."""
    growths, place = [found[:cell.alone]], 0
    real, imaginary = np.split(found[cell.alone:], 2)
    for blocks in cell.blocks:
        if cell.alone and blocks.size == 1:
            continue
        entries = real[place:place + len(blocks.series)] + 1j * (
            imaginary[place:place + len(blocks.series)])
        place += len(blocks.series)
        growths.append(inside(_roots(blocks.size, entries), band if cell.at_edge else None))
    return np.concatenate(growths)


def _by_ways(cell: Cell, grid: FloatArray, level: float) -> FloatArray:
    """Lay rows along the stiffness: (rows, P, grid) -> (P, ways, points, nodes * parts)."""
    found = np.empty((grid.shape[1], len(cell.constant), cell.rule.friction_points,
                      cell.constant.shape[-1]))
    found[...] = cell.constant - level
    for point, of_point in enumerate(found):
        of_point.ravel()[cell.spots] = grid[:, point]
    return found


def _edges(cell: Cell, aside: FloatArray, spread: Spread) -> FloatArray:
    """Return the standard deviation by speed and pressure (P, ways, 1, nodes * parts)."""
    found = np.zeros((aside.shape[1], len(cell.constant), cell.others.size))
    reach = 0.5 * np.maximum(np.array((spread.rotor_speed, spread.pressure)) / _LARGEST_STEP, 1.0)
    faster, harder = np.moveaxis((aside[..., 1::2] - aside[..., ::2]) * reach, -1, 0)
    found[:, cell.tracks, cell.nodes] = np.hypot(faster, harder).T
    return cell.over_parts(found)[:, :, None]


def _roots(size: int, entries: ComplexArray) -> ComplexArray:
    """Return the roots (n size, P) of blocks, the least stable last, of entries (n size^2, P)."""
    points = entries.shape[1]
    if size == 1:
        return entries
    if size == 2:
        a, b, c, d = entries.reshape(-1, 4, points).transpose(1, 0, 2)
        mean, half = 0.5 * (a + d), np.sqrt(0.25 * (a - d) ** 2 + b * c)
        return np.stack([mean - half, mean + half], axis=1).reshape(-1, points)
    if size == 3:
        return _cubic(entries.reshape(-1, 9, points))
    matrices = entries.reshape(-1, size, size, points).transpose(0, 3, 1, 2)
    return _by_growth(np.linalg.eigvals(matrices).transpose(0, 2, 1))


def _cubic(entries: ComplexArray) -> ComplexArray:
    """Return the roots (3 n, P) of 3 x 3 matrices (n, 9, P), by Cardano's formula."""
    a, b, c, d, e, f, g, h, i = entries.transpose(1, 0, 2)
    mean = (a + e + i) / 3.0
    a, e, i = a - mean, e - mean, i - mean
    p = a * e + a * i + e * i - b * d - c * g - f * h  # x^3 + p x = determinant
    half = 0.5 * (a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))
    root = np.sqrt(half**2 + (p / 3.0) ** 3)
    cancels = (half.conj() * root).real < 0.0
    cube = (half + np.where(cancels, -root, root)) ** (1.0 / 3.0)
    third = -p / 3.0 / np.where(cube == 0.0, 1.0, cube)
    return _by_growth(np.stack(
        [mean + _TURN**k * cube + _TURN**-k * third for k in range(3)], axis=1))


def _by_growth(roots: Any) -> ComplexArray:
    """Return roots (n, size, P) as (n size, P), the least stable of each n last."""
    place = np.argsort(roots.real, axis=1, kind='stable')
    return np.asarray(np.take_along_axis(roots, place, axis=1).reshape(-1, roots.shape[-1]))
