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
Probability of growth under uncertain inputs, from growth rates on a grid.

Along friction and ln k_c a Gaussian is written as a sum of narrow ones at the grid points,

    N(0, 1) = sum_i m_i N(x_i, s^2),    s = step / 2,    m_i ~ exp(-x_i^2 / (2 (1 - s^2))),

which holds to a few parts in 10,000. Growth is linear over each of them, and over the standard
deviations of rotor speed and pressure, so the probability at a grid point is Phi(growth / width)
with width^2 the sum of the squared changes of growth over the four deviations.
"""

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr, ndtri
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.growth_grid import GrowthGrid
from squeal_core.risk.uncertainty import InputUncertainty

_NARROW = 0.5  # standard deviation of the narrow Gaussians over the step between them
_SHARP = 1e-6  # 1/s, width of growth that nothing changes
SURE = 4.0  # standard deviations; 3e-5 are left beyond
_LEAST = 1e-300
_REACH = 3.0 + 1e-6  # standard deviations that are summed


def gaussian_masses(points: FloatArray, deviation: float) -> tuple[FloatArray, float]:
    """
    Return the masses of narrow Gaussians that make up a Gaussian, and their standard deviation.

    Parameters
    ----------
    points : (n,) array
        Centres of the narrow Gaussians relative to the mean, evenly spaced.
    deviation : float
        Standard deviation of the Gaussian.

    """
    step = float(points[1] - points[0]) if points.size > 1 else 0.0
    narrow = min(_NARROW * step, deviation) if step else deviation
    rest = deviation**2 - narrow**2
    nearest = np.abs(points) <= np.abs(points).min() + 1e-12
    with np.errstate(divide='ignore', over='ignore', invalid='ignore'):
        masses = np.where(nearest, 1.0, 0.0) if rest <= 0.0 else np.exp(-0.5 * points**2 / rest)
    masses[np.abs(points) > max(_REACH * deviation, 0.5 * step)] = 0.0
    return np.asarray(masses / masses.sum()), narrow


def probability_scores(grid: GrowthGrid, excess: FloatArray, nominal: slice,
                       uncertainty: InputUncertainty) -> FloatArray:
    """
    Return the standard normal quantile of the probability of growth.

    It is the mean of the growth rate over its standard deviation where growth is linear in the
    inputs, and hence nearly linear itself between grid points, where the probability is not.

    Parameters
    ----------
    grid : GrowthGrid
        Operating points.
    excess : (speeds, pressures, frictions, stiffnesses) array
        Growth rate above the threshold at them [1/s].
    nominal : slice
        Frictions of the grid for which probabilities are wanted.
    uncertainty : InputUncertainty
        Standard deviations of the inputs.

    Returns
    -------
    (speeds, pressures, nominal frictions) array
        Beyond `SURE`, where the sum over three standard deviations says little, by the tangent.

    """
    excess = np.asarray(excess, float)
    stiffness, narrow = gaussian_masses(
        np.log(grid.stiffness_factor), uncertainty.contact_stiffness)
    middle = grid.stiffness_factor.size // 2
    found = np.empty((*excess.shape[:2], grid.friction[nominal].size))
    for column, place in enumerate(range(grid.friction.size)[nominal]):
        deviation = min(uncertainty.friction, 0.5 * float(grid.friction[place]))
        masses, friction_narrow = gaussian_masses(
            grid.friction - grid.friction[place], deviation)
        used = slice(int(masses.nonzero()[0][0]), int(masses.nonzero()[0][-1]) + 1)
        edge = (uncertainty.rotor_speed, uncertainty.pressure)
        over = excess[:, :, used] / _widths(grid, excess, used, (*edge, friction_narrow, narrow))
        low, high = ((ndtr(sign * over) @ stiffness) @ masses[used] for sign in (1.0, -1.0))
        here = slice(place, place + 1)
        tangent = excess[:, :, here] / _widths(
            grid, excess, here, (*edge, deviation, uncertainty.contact_stiffness))
        found[:, :, column] = _score(low, high, tangent[:, :, 0, middle])
    return found


def _score(low: FloatArray, high: FloatArray, tangent: FloatArray) -> FloatArray:
    """Return the quantile of probabilities, and of their complements, or the tangent's."""
    score = np.where(low < high, ndtri(np.maximum(low, _LEAST)), -ndtri(np.maximum(high, _LEAST)))
    far = np.minimum(np.abs(score), np.maximum(np.abs(tangent), SURE))
    return np.asarray(np.where(np.abs(score) < SURE, score, np.sign(score) * far))


def _widths(grid: GrowthGrid, excess: FloatArray, frictions: slice,
            deviations: Sequence[float]) -> FloatArray:
    """Return the standard deviation of growth by deviations along the four axes of the grid."""
    return np.asarray(np.sqrt(_SHARP**2 + _squares(
        excess, frictions, np.array(deviations) / grid.steps)))


def _squares(excess: FloatArray, frictions: slice, widths: FloatArray) -> FloatArray:
    """Return the sum of the squared changes of growth towards zero over a width of each axis."""
    low, high = max(frictions.start - 1, 0), frictions.stop + 1
    part = excess[:, :, low:high]
    inner = slice(frictions.start - low, frictions.stop - low)
    found = np.zeros(part[:, :, inner].shape)
    for axis, width in enumerate(widths.tolist()):
        if width and part.shape[axis] > 1:
            found += (width * _change_towards_zero(part, axis)[:, :, inner]) ** 2
    return found


def _change_towards_zero(growth: FloatArray, axis: int) -> FloatArray:
    """
    Return how much nearer to zero growth is at the neighbour along an axis, of the two the nearer.

    The largest growth rate of several modes has kinks: the slope on the side where another mode
    rises says nothing about the other side. Beyond an end growth continues linearly.
    """
    along = np.moveaxis(growth, axis, 0)
    step = np.diff(along, axis=0)
    both = np.stack([-np.concatenate([step[:1], step]), np.concatenate([step, step[-1:]])])
    return np.moveaxis(np.maximum((-np.sign(along) * both).max(axis=0), 0.0), 0, axis)
