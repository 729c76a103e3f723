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
Growth rates around an operating point at many contact stiffnesses, ready for a risk.

Along the contact stiffness modes come near each other and pass; along speed, pressure and friction
they do so much less. A cell has one anchor (`spectral_expansion`) at each of a row of contact
stiffnesses, and of each keeps what can matter: modes of the squeal band that may turn from decay
to growth by the inputs' spread. Laid out as one array they cost a risk one matrix product.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray, readonly
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.quadrature import TensorQuadrature
from squeal_core.surrogate.monomials import Monomials

STIFFNESS = [3, 4]  # of the six coefficients: those in proportion to the contact stiffness
FRICTION = [1, 2, 4, 5]  # and to friction

_SPEED, _PRESSURE = 0.25, 0.3  # logarithms of speed and pressure that a cell covers either way
_LOW_PRESSURE = 1e5  # Pa that it covers at any pressure
_FRICTION = 0.03  # that it covers, apart from the deviation
_NONE = -1e6  # 1/s, of no mode


@dataclass(frozen=True)
class Spread:
    """Standard deviations: of friction, and of pressure and speed as parts of their value."""

    friction: float
    pressure: float
    rotor_speed: float


@dataclass(frozen=True)
class Family:
    """
    Coefficients and operating points of a model over speed, pressure and friction.

    Friction has its slope in proportion, as `BrakeModel.operating_point` has it.
    """

    model: BrakeModel

    def coefficients(self, speed: FloatArray | float, pressure: FloatArray | float,
                     friction: FloatArray | float,
                     factor: FloatArray | float = 1.0) -> FloatArray:
        """
        Return, as (6, ...), those at speeds [rad/s] and pressures [Pa] above zero.

        Those of `point`, at as many of each as there are.
        """
        model, law, table = self.model, self.model.friction_law, self.model.stiffness_table
        pressed = self._contact_pressure * pressure
        load = pressed * friction
        stiffness = factor * (model.nominal_contact_stiffness if table is None else table(pressed))
        slope = law.relative_slope(model.contact_radius * speed) if law else 0.0
        found = np.empty((6, *np.broadcast_shapes(
            *(np.shape(values) for values in (speed, load, stiffness)))))
        for row, value in enumerate((speed, load / speed, slope * load, stiffness,
                                     friction * stiffness, load)):
            found[row] = value
        return found

    @cached_property
    def _contact_pressure(self) -> float:
        """Contact pressure over brake pressure."""
        return self.model.contact_pressure(1.0)

    def point(self, speed: float, pressure: float, friction: float,
              factor: float) -> OperatingPoint:
        """Return the point, its contact stiffness times a factor."""
        point = self.model.operating_point(rotor_speed=speed, pressure=pressure,
                                           friction=friction)
        return replace(point, contact_stiffness=factor * point.contact_stiffness)


@dataclass(frozen=True)
class Box:
    """Ranges of speed [rad/s], pressure [Pa] and friction, (3,) each."""

    low: FloatArray
    high: FloatArray

    def widened(self, spread: Spread, deviations: float) -> 'Box':
        """Return the box with what values in it may be off by."""
        relative = deviations * np.array([spread.rotor_speed, spread.pressure])
        low, high = self.low.copy(), self.high.copy()
        low[:2] *= np.maximum(1.0 - relative, 0.1)
        high[:2] *= 1.0 + relative
        low[2] -= deviations * spread.friction
        high[2] += deviations * spread.friction
        return Box(low, high)

    @property
    def corners(self) -> list[tuple[float, ...]]:
        """Return the eight corners."""
        return list(product(*zip(self.low.tolist(), self.high.tolist(), strict=True)))


def box_around(inputs: Sequence[float], part: float = 1.0) -> Box:
    """Return the range that a cell at (speed, pressure, friction) covers, times `part`."""
    speed, pressure, friction = inputs
    wide, high = np.exp(part * _SPEED), np.exp(part * _PRESSURE)
    less = max(pressure - part * _LOW_PRESSURE, 0.1 * pressure)
    return Box(
        readonly([speed / wide, min(pressure / high, less), friction - part * _FRICTION]),
        readonly([speed * wide, max(pressure * high, pressure + part * _LOW_PRESSURE),
                  friction + part * _FRICTION]))


@dataclass(frozen=True, eq=False)
class Blocks:
    """Blocks of one size: at which node (n,), modes (n, size), series (n size^2, terms)."""

    size: int
    nodes: IndexArray
    labels: IndexArray
    series: ComplexArray


@dataclass(frozen=True, eq=False)
class Cell:
    """
    What a risk needs around an operating point.

    Parameters
    ----------
    inputs : (3,) array
        Speed [rad/s], pressure [Pa] and friction of the centre.
    box : Box
        Where it holds.
    spread : Spread
        For which it holds.
    rule : TensorQuadrature
        By which growth is summed.
    rows, centre, scales, monomials
        As of `SpectralExpansion`, at the nominal contact stiffness.
    blocks : tuple of Blocks
        Those that may change sign.
    others : (nodes,) array
        Growth rate of the least stable of the others, at the centre [1/s].
    growth : (modes, nodes) array
        Of each mode at the centre [1/s], as `inside` has it; -1e3 where it was lost.
    roots : (modes,) array
        Of all modes at the centre [1/s]; a mode's label is its place in it.
    slopes : (modes, v) array
        Their change with z.
    at_edge : bool
        Whether a mode may enter or leave the squeal band.
    errors : (nodes,) array
        Of growth rates near zero by a full solve at a corner of the box, the largest [1/s].
    level : float
        Growth rate that counts as unstable [1/s].

    """

    inputs: FloatArray
    box: Box
    spread: Spread
    rule: TensorQuadrature
    rows: IndexArray
    centre: FloatArray
    scales: FloatArray
    monomials: Monomials
    blocks: tuple[Blocks, ...]
    others: FloatArray
    growth: FloatArray
    roots: ComplexArray
    slopes: ComplexArray
    at_edge: bool
    errors: FloatArray
    level: float = 0.0

    @property
    def nbytes(self) -> int:
        return sum(2 * b.series.nbytes for b in self.blocks) + self.growth.nbytes

    @cached_property
    def nodes(self) -> IndexArray:
        """Node of each mode that may change sign (rows,)."""
        return readonly(np.concatenate(
            [np.zeros(0), *(np.repeat(b.nodes, b.size) for b in self.blocks)]), np.intp)

    @cached_property
    def labels(self) -> IndexArray:
        """Mode of each row (rows,)."""
        return readonly(np.concatenate(
            [np.zeros(0), *(b.labels.ravel() for b in self.blocks)]), np.intp)

    @cached_property
    def modes(self) -> IndexArray:
        """Labels of modes that may grow within the spread (m,)."""
        certain = np.flatnonzero(self.growth.max(axis=1, initial=-np.inf) > self.level)
        found = np.unique(np.concatenate([self.labels, certain]))
        return readonly(found[found >= 0], np.intp)

    @cached_property
    def tracks(self) -> IndexArray:
        """
        Way along the contact stiffness that each row is on (rows,).

        The first ways are those of `modes`; behind them come rows that no mode was found for,
        as many ways as the node with most of them needs.
        """
        found = np.searchsorted(self.modes, self.labels)
        for node in range(self.others.size):
            lost = np.flatnonzero((self.nodes == node) & (self.labels < 0))
            found[lost] = self.modes.size + np.arange(lost.size)
        return readonly(found, np.intp)

    @cached_property
    def constant(self) -> FloatArray:
        """Growth rate (ways, 1, nodes * parts) of each way where it has no row."""
        ways = max(int(self.tracks.max(initial=-1)) + 1, self.modes.size, 1)
        found = np.full((ways, self.others.size), _NONE)
        found[:self.modes.size] = self.growth[self.modes]
        return readonly(self.over_parts(found)[:, None])

    @cached_property
    def spots(self) -> IndexArray:
        """Where the rows (rows, points * parts) are among (ways, points, nodes * parts), flat."""
        points, parts = self.rule.friction_points, self.rule.parts
        place = (self.tracks[:, None, None], np.arange(points)[:, None],
                 self.nodes[:, None, None], np.arange(parts))
        shape = (len(self.constant), points, self.others.size, parts)
        return readonly(np.ravel_multi_index(place, shape).reshape(-1, points * parts), np.intp)

    def over_parts(self, values: FloatArray) -> FloatArray:
        """Return (..., nodes * parts) of values (..., nodes)."""
        return np.repeat(values, self.rule.parts, axis=-1)

    @cached_property
    def others_of_parts(self) -> FloatArray:
        return readonly(self.over_parts(self.others))

    @cached_property
    def errors_of_parts(self) -> FloatArray:
        return readonly(self.over_parts(self.errors))

    @cached_property
    def alone(self) -> int:
        """Rows that are one entry, whose growth rate alone counts: the first ones."""
        return sum(b.nodes.size for b in self.blocks if b.size == 1 and not self.at_edge)

    @cached_property
    def series(self) -> FloatArray:
        """Of the growth rates of these rows; then real, then imaginary parts of the others'."""
        entries = np.concatenate([np.zeros((0, self.monomials.count), complex),
                                  *(b.series for b in self.blocks)])
        return readonly(np.concatenate([entries.real, entries.imag[self.alone:]]))

    def terms(self, coefficients: FloatArray) -> FloatArray:
        """Return the monomials (terms, P) of coefficients (6, P), the same for all nodes."""
        return self.monomials.at(self.steps(coefficients).T).T

    def roots_near(self, coefficients: FloatArray) -> ComplexArray:
        """Return the roots of `modes` (m,) at coefficients (6,), to first order."""
        roots, slopes = self._tangent
        return np.asarray(roots + slopes @ self.steps(coefficients[:, None])[:, 0])

    @cached_property
    def _tangent(self) -> tuple[ComplexArray, ComplexArray]:
        return self.roots[self.modes], self.slopes[self.modes]

    def steps(self, coefficients: FloatArray) -> FloatArray:
        """Return z (v, P) of coefficients (6, P), the same for all nodes."""
        return (coefficients[self.rows] - self.centre[:, None]) / self.scales[:, None]


def inside(roots: ComplexArray, band: tuple[float, float] | None) -> FloatArray:
    """
    Return growth rates that turn negative where a mode leaves the band, continuously.

    That a mode grows and is in the band is that the least of its growth rate and its distances
    from the band's ends is above zero.
    """
    if band is None:
        return roots.real
    return np.minimum(roots.real, np.minimum(roots.imag - band[0], band[1] - roots.imag))
