"""The probability of growth from a cell: growth rates over the inputs' spread, and their sum."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from squeal_core.arrays import ComplexArray, FloatArray
from squeal_core.risk_cell import Blocks, Cell, Family, FRICTION, inside, Spread, STIFFNESS
from squeal_core.risk_rule import Rule

_LEAST = -1e6  # 1/s, of no mode
_LARGEST_STEP = 0.3  # of pressure and speed, over which their effect is taken
_TURN = np.exp(2j * np.pi / 3.0)


@dataclass(frozen=True, eq=False)
class Estimate:
    """What a cell says at a point.

    Parameters
    ----------
    probability : float
        That at least one mode grows [-].
    error : float
        What it changes by as all growth rates change by the cell's errors.
    modes : (m,) array
        Of each of the cell's modes, that it grows [-].
    """

    probability: float
    error: float
    modes: FloatArray


def estimate(cell: Cell, rule: Rule, family: Family, spread: Spread, inputs: Sequence[float],
             band: tuple[float, float], level: float) -> Estimate:
    """Return the probabilities at (speed, pressure, friction), from a cell around them.

    Parameters
    ----------
    cell : Cell
    rule : Rule
    family : Family
    spread : Spread
    inputs : (3,) floats
    band : (2,) floats
        Of the angular frequencies that count [rad/s].
    level : float
        What counts as growth [1/s].
    """
    terms = np.concatenate(cell.monomials(cell.steps(_columns(rule, family, spread, inputs))))
    growths, edges = [], []
    for blocks in cell.blocks:
        grid, aside = _growth(blocks, terms, rule, band if cell.at_edge else None)
        growths.append(grid)
        edges.append(_edge(aside, spread))
    # the last row is that of no mode
    growths.append(np.full((1, rule.parts, rule.friction_points), _LEAST))
    edges.append(np.zeros(1))
    growth, edge = np.concatenate(growths) - level, np.concatenate(edges)
    probability, error = _overall(cell, rule, growth, edge, level)
    return Estimate(probability, error, _each(cell, rule, growth, edge, level))


def _columns(rule: Rule, family: Family, spread: Spread, inputs: Sequence[float]) -> FloatArray:
    """Return coefficients (6, P): contact stiffness by friction, then speed and pressure moved."""
    speed, pressure, friction = inputs
    centre = family.coefficients(speed, pressure, friction)
    line = np.repeat(centre[:, None], rule.friction_nodes, axis=1)
    line[FRICTION] *= 1.0 + spread.friction / friction * rule.friction_steps
    grid = np.repeat(line[:, None, :], rule.parts, axis=1)
    grid[STIFFNESS] *= np.exp(rule.offsets)[:, None]
    aside = [family.coefficients(speed * (1.0 + way * _step(spread.rotor_speed)), pressure,
                                 friction) for way in (-1.0, 1.0)]
    aside += [family.coefficients(speed, pressure * (1.0 + way * _step(spread.pressure)),
                                  friction) for way in (-1.0, 1.0)]
    return np.concatenate([grid.reshape(6, -1), np.stack(aside, axis=1)], axis=1)


def _step(deviation: float) -> float:
    return min(deviation, _LARGEST_STEP)


def _growth(blocks: Blocks, terms: FloatArray, rule: Rule,
            band: tuple[float, float] | None) -> tuple[FloatArray, FloatArray]:
    """Return growth rates over the grid (rows, parts, points), and aside of it (rows, 4)."""
    laid_out, shape = rule.parts * rule.friction_nodes, (-1, rule.parts, rule.friction_points)
    if blocks.size == 1 and band is None:
        growth = blocks.growth_series @ terms
        return _continued(growth[:, :laid_out], rule).reshape(shape), growth[:, laid_out:]
    found = blocks.series @ terms
    grid = _continued(found[:, :laid_out], rule)
    return (inside(_roots(blocks.size, grid), band).reshape(shape),
            inside(_roots(blocks.size, found[:, laid_out:]), band))


def _continued(found: Any, rule: Rule) -> Any:
    """Continue polynomials along friction: (rows, parts * nodes) -> (rows, parts * points)."""
    there = found.reshape(len(found), rule.parts, rule.friction_nodes) @ rule.continuation
    return there.reshape(len(found), -1)


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


def _edge(aside: FloatArray, spread: Spread) -> FloatArray:
    """Return the standard deviation (rows,) by speed and pressure."""
    speed, pressure = (0.5 * (aside[:, i + 1] - aside[:, i]) * max(deviation / _LARGEST_STEP, 1.0)
                       for i, deviation in ((0, spread.rotor_speed), (2, spread.pressure)))
    return np.asarray(np.hypot(speed, pressure))


def _overall(cell: Cell, rule: Rule, growth: FloatArray, edge: FloatArray,
             level: float) -> tuple[float, float]:
    """Return the probability that the least stable mode grows, and its error."""
    there = growth[cell.slots]  # nodes, slots, parts, points
    worst = there.argmax(axis=1)
    least = np.take_along_axis(there, worst[:, None], axis=1)[:, 0]
    width = edge[cell.slots[np.arange(len(worst))[:, None, None], worst]]
    least = np.maximum(least, (cell.others - level)[:, None, None])
    shape = (rule.nodes * rule.parts, rule.friction_points)
    least = least.reshape(shape)
    widths = rule.widths(least, width.reshape(shape))
    off = np.repeat(cell.errors, rule.parts)[:, None]
    coarse, own = least[:, ::2], widths[:, ::2]
    low, high = (float(rule.probability(coarse + way * off, own)) for way in (-1.0, 1.0))
    found = float(rule.probability(least, widths))
    return min(max(found, 0.0), 1.0), max(0.5 * (high - low), 0.0)


def _each(cell: Cell, rule: Rule, growth: FloatArray, edge: FloatArray,
          level: float) -> FloatArray:
    """Return the probability that each of the cell's modes grows."""
    coarse = growth[cell.places, :, ::2]  # modes, nodes, parts, points
    absent = cell.places < 0
    coarse[absent] = (cell.growth[cell.modes][absent] - level)[:, None, None]
    coarse = coarse.reshape(len(coarse), rule.nodes * rule.parts, coarse.shape[-1])
    own = np.repeat(edge[cell.places], rule.parts, axis=1)[..., None]
    return rule.probability(coarse, rule.widths(coarse, own))
