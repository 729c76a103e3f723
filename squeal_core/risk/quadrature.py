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
The rule by which the probability of growth is summed over uncertain inputs.

Contact stiffness (by its logarithm) and friction are laid out on a fixed grid, as growth rates may
rise and fall along them; pressure and rotor speed, along which they are nearly linear, widen the
edge between decay and growth.

Along the grid a Gaussian is written as a sum of narrow ones at its points,

    N(0, 1) = sum_i m_i N(x_i, s^2),   s = step / 2,   m_i ~ exp(-x_i^2 / (2 (1 - s^2))),

to a few parts in 10,000, and growth is linear over each of them: the estimate is smooth and no
count of points.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import block_diag
from scipy.special import ndtr
from squeal_core.common.arrays import FloatArray, readonly

_FRICTION_END = 3.0  # standard deviations up to which friction is laid out
_NARROW = 0.5  # standard deviation of the narrow Gaussians over the step between them
_SHARP = 1e-12  # square of an edge that is none [1/s^2]
_SURE = 5.0  # standard deviations beyond which 3e-7 are left


@dataclass(frozen=True)
class TensorQuadrature:
    """
    Points along friction and along contact stiffness, and the probability of each.

    Parameters
    ----------
    nodes : int
        Contact stiffnesses a series is made for, odd.
    spacing : float
        Of their logarithms.
    parts : int
        Contact stiffnesses evaluated for each of them, odd.
    stiffness_deviation : float
        Standard deviation of ln k_c.
    friction_nodes : int
        Friction coefficients evaluated: one more than the degree of the series, which are
        polynomials of friction.
    friction_points : int
        Friction coefficients the polynomials are continued to: 1 + 4 n.

    """

    nodes: int
    spacing: float
    parts: int
    stiffness_deviation: float
    friction_nodes: int
    friction_points: int

    @cached_property
    def factors(self) -> FloatArray:
        """Contact stiffnesses (nodes,) of the series over the nominal one."""
        return readonly(np.exp(self.spacing * _centred(self.nodes)))

    @cached_property
    def offsets(self) -> FloatArray:
        """Logarithms (parts,) of the contact stiffnesses evaluated over their node's."""
        return readonly(self.spacing / self.parts * _centred(self.parts))

    @cached_property
    def stiffness_masses(self) -> FloatArray:
        """Probability of each contact stiffness (nodes, parts)."""
        every = self.spacing / self.parts * _centred(self.nodes * self.parts)
        masses = _masses(every / (self.stiffness_deviation or 1.0))
        return readonly(masses.reshape(self.nodes, self.parts))

    @cached_property
    def friction_steps(self) -> FloatArray:
        """Where friction is evaluated (friction_nodes,), in standard deviations: Chebyshev's."""
        turn = np.pi * (np.arange(self.friction_nodes) + 0.5) / self.friction_nodes
        return readonly(-_FRICTION_END * np.cos(turn))

    @cached_property
    def _points(self) -> FloatArray:
        return 2.0 * _FRICTION_END / (self.friction_points - 1) * _centred(self.friction_points)

    @cached_property
    def friction_masses(self) -> FloatArray:
        """Probability of each friction coefficient (friction_points,)."""
        return readonly(_masses(self._points))

    @cached_property
    def coarse_masses(self) -> FloatArray:
        """Return the same for every second one of them."""
        return readonly(_masses(self._points[::2]))

    @cached_property
    def continuation(self) -> FloatArray:
        """Matrix (friction_nodes, friction_points): a polynomial at the nodes -> at the points."""
        nodes, points = self.friction_steps, self._points
        columns = []
        for i, node in enumerate(nodes):
            others = np.delete(nodes, i)
            columns.append(np.prod((points[:, None] - others) / (node - others), axis=1))
        return readonly(np.stack(columns))

    @cached_property
    def friction_moves(self) -> FloatArray:
        """Return steps of friction (friction_nodes * parts,) where series are evaluated."""
        return readonly(np.repeat(self.friction_steps, self.parts))

    @cached_property
    def stiffness_moves(self) -> FloatArray:
        """Contact stiffness there over that of the node."""
        return readonly(np.tile(np.exp(self.offsets), self.friction_nodes))

    @cached_property
    def continued(self) -> FloatArray:
        """Matrix from these places, and four beside them, to points * parts and the same four."""
        return readonly(block_diag(np.kron(self.continuation, np.eye(self.parts)), np.eye(4)))

    def widths(self, growth: FloatArray, edge: FloatArray) -> FloatArray:
        """
        Return the standard deviation of growth rates around each point of the grid.

        Parameters
        ----------
        growth : (..., points, nodes * parts) array
            [1/s]. Fewer points than `friction_points`, every second one, will do for a mode.
        edge : array that fits
            Standard deviation of it by inputs that are not laid out [1/s].

        """
        square = _steps(growth, -2)
        square += _steps(growth, -1)
        square *= (0.5 * _NARROW) ** 2
        square += edge**2 + _SHARP
        return np.asarray(np.sqrt(square, out=square))

    def probability(self, growth: FloatArray, widths: FloatArray) -> FloatArray:
        """Return the fraction, of shape (...), in which growth rates are above zero."""
        masses = self.friction_masses if growth.shape[-2] == self.friction_points else (
            self.coarse_masses)
        return np.asarray(_normal(growth / widths) @ self.stiffness_masses.ravel() @ masses)


def rule_for(stiffness_deviation: float, degree: int) -> TensorQuadrature:
    """
    Return the rule for a standard deviation of ln k_c and a degree of the series.

    Nodes lie 0.04 apart, by which modes do not come near enough to each other to need large
    blocks, and reach to 2.7 standard deviations, beyond which 0.7 % are left. Friction is laid
    out more finely where nothing is along the contact stiffness: a merging, where growth sets in
    like a square root, then always lies at the same place between two points.
    """
    spacing = min(0.04, max(0.4 * stiffness_deviation, 0.004))
    known = stiffness_deviation == 0.0
    half = 0 if known else int(np.ceil(2.7 * stiffness_deviation / spacing - 0.5))
    return TensorQuadrature(nodes=2 * half + 1, spacing=spacing, parts=1 if known else 3,
                            stiffness_deviation=stiffness_deviation, friction_nodes=degree + 1,
                            friction_points=65 if known else 17)


def _centred(count: int) -> FloatArray:
    return np.asarray(np.arange(count) - (count - 1) / 2.0)


def _masses(points: FloatArray) -> FloatArray:
    """Return the parts m_i of a Gaussian; points, in standard deviations, are evenly spaced."""
    step = points[1] - points[0] if points.size > 1 else 0.0
    parts = np.exp(-0.5 * points**2 / (1.0 - (_NARROW * step) ** 2))
    return np.asarray(parts / parts.sum())


def _normal(values: FloatArray) -> FloatArray:
    """Return Phi of each value; 0 or 1 beyond `_SURE`, where most growth rates are."""
    found = (values > 0.0).astype(float)
    open_ = np.abs(values) < _SURE
    found[open_] = ndtr(values[open_])
    return found


def _steps(growth: FloatArray, axis: int) -> FloatArray:
    """
    Return the square of the steps to the points on both sides of each, taken together.

    Beyond an end there is no step. The slope at a point is that of half of it.
    """
    found = np.zeros(growth.shape)
    both, along = found.swapaxes(0, axis), growth.swapaxes(0, axis)
    if len(along) > 1:
        np.subtract(along[2:], along[:-2], out=both[1:-1])
        np.subtract(along[1], along[0], out=both[0])
        np.subtract(along[-1], along[-2], out=both[-1])
    found *= found
    return found
