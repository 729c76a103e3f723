"""The probability of growth from a cell: growth rates over the inputs' spread, and their sum."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.risk_cell import Cell, Family, inside, Spread
from squeal_core.risk_rule import Rule

_ASIDE = 4  # columns with speed and pressure moved, behind those of the grid
_LARGEST_STEP = 0.3  # of pressure and speed, over which their effect is taken
_TURN = np.exp(2j * np.pi / 3.0)


@dataclass(frozen=True, eq=False)
class Estimate:
    """Growth rates at a point and over its inputs' spread, and the probabilities they come to.

    Parameters
    ----------
    cell : Cell
        That they are from.
    ways : (ways, points, nodes * parts) array
        Growth rate of the modes on each way over friction and contact stiffness, above what
        counts as growth [1/s].
    edges : (ways, 1, nodes * parts) array
        Their standard deviation by speed and pressure [1/s].
    others : (nodes * parts,) array
        Growth rate of the least stable of all other modes [1/s].
    """

    cell: Cell
    ways: FloatArray
    edges: FloatArray
    others: FloatArray

    @cached_property
    def overall(self) -> tuple[float, float]:
        """Probability that at least one mode grows, and its error.

        The error is what it changes by as all growth rates change by the cell's errors.
        """
        rule, off = self.cell.rule, self.cell.errors_of_parts
        least = self.ways.max(axis=0)
        edge = np.where(self.ways == least, self.edges, 0.0).max(axis=0)
        least = np.maximum(least, self.others)
        widths = rule.widths(least, edge)
        ends = np.array([least[::2] - off, least[::2] + off])
        low, high = rule.probability(ends, widths[::2]).tolist()
        found = float(rule.probability(least, widths))
        return min(max(found, 0.0), 1.0), max(0.5 * (high - low), 0.0)

    @cached_property
    def modes(self) -> FloatArray:
        """Probability that each of the cell's modes grows (m,)."""
        rule, count = self.cell.rule, self.cell.modes.size
        coarse = np.ascontiguousarray(self.ways[:count, ::2])
        return rule.probability(coarse, rule.widths(coarse, self.edges[:count]))


def estimate(cell: Cell, family: Family, spread: Spread, inputs: Sequence[float],
             band: tuple[float, float], level: float) -> Estimate:
    """Return the estimate at (speed, pressure, friction), from a cell around them.

    Parameters
    ----------
    cell : Cell
    family : Family
    spread : Spread
    inputs : (3,) floats
    band : (2,) floats
        Of the angular frequencies that count [rad/s].
    level : float
        What counts as growth [1/s].
    """
    found = cell.series @ cell.terms(_columns(cell.rule, family, spread, inputs))
    growth = _growth(cell, found @ cell.rule.continued, band) - level
    return Estimate(cell, _by_ways(cell, growth[:, :-_ASIDE], level),
                    _edges(cell, growth[:, -_ASIDE:], spread), cell.others_of_parts - level)


def _columns(rule: Rule, family: Family, spread: Spread, inputs: Sequence[float]) -> FloatArray:
    """Return coefficients (6, P): contact stiffness by friction, then speed and pressure moved."""
    speed, pressure, friction = inputs
    grid = family.coefficients(
        speed, pressure, friction + spread.friction * rule.friction_moves, rule.stiffness_moves)
    faster, harder = _step(spread.rotor_speed), _step(spread.pressure)
    aside = [family.coefficients(speed * (1.0 + way * faster), pressure, friction)
             for way in (-1.0, 1.0)]
    aside += [family.coefficients(speed, pressure * (1.0 + way * harder), friction)
              for way in (-1.0, 1.0)]
    return np.concatenate([grid, np.array(aside).T], axis=1)


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
    """Lay rows out along the contact stiffness: (rows, grid) -> (ways, points, nodes * parts)."""
    found = np.empty((len(cell.constant), cell.rule.friction_points, cell.constant.shape[-1]))
    found[...] = cell.constant - level
    found.ravel()[cell.spots] = grid
    return found


def _edges(cell: Cell, aside: FloatArray, spread: Spread) -> FloatArray:
    """Return the standard deviation by speed and pressure (ways, 1, nodes * parts)."""
    found = np.zeros((len(cell.constant), cell.others.size))
    reach = 0.5 * np.maximum(np.array((spread.rotor_speed, spread.pressure)) / _LARGEST_STEP, 1.0)
    faster, harder = ((aside[:, 1::2] - aside[:, ::2]) * reach).T
    found[cell.tracks, cell.nodes] = np.hypot(faster, harder)
    return cell.over_parts(found)[:, None]


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
