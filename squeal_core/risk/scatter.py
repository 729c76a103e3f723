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
Scatter of friction and damping from one brake application to the next, inside each brake.

Both are Gaussian, and a growth rate is linear in them as far as they scatter. So all that a growth
rate has of them is one Gaussian, in which more friction and less damping go together; how much of
either differs little between the modes of a brake, so that one is enough for all of them. Growth
rates, and build-ups by them, are computed at nodes of it. A build-up rises from the noise floor to
saturation within less than a standard deviation: nodes are dense where that is probable.
"""

import numpy as np
from scipy.special import ndtr, ndtri
from squeal_core.common.arrays import FloatArray, RealArray

_COUNT = 7
NODES = 1.2 * ndtri((np.arange(_COUNT) + 0.5) / _COUNT)  # standard deviations
MIDDLE = _COUNT // 2  # the node without scatter
_FARTHEST = 9.0  # standard deviations, beyond which are 1e-19
_POINTS = np.array([-_FARTHEST, *NODES, _FARTHEST])
_BELOW = ndtr(_POINTS)
_BETWEEN = np.diff(_BELOW)
WEIGHTS = np.diff(ndtr([-np.inf, *0.5 * (NODES[1:] + NODES[:-1]), np.inf]))  # nearest to a node


def along_scatter(by_friction: RealArray, by_damping: RealArray) -> RealArray:
    """
    Return the change of growth rates over one standard deviation of their scatter.

    Parameters
    ----------
    by_friction, by_damping : arrays
        Their changes over one standard deviation of friction and of ln damping.

    """
    size = np.sqrt(by_friction**2 + by_damping**2)
    return np.asarray(np.copysign(size, by_friction - by_damping))


def at_nodes(rate: RealArray, scatter: RealArray) -> RealArray:
    """Return growth rates at the nodes of the scatter, (7, ...), by their change over it."""
    nodes = NODES.astype(rate.dtype).reshape(-1, *np.ones(rate.ndim, int))
    return np.asarray(rate + nodes * scatter)


def exceedance(margin: FloatArray) -> FloatArray:
    """
    Return the probability that functions of the scatter are positive.

    They are linear between nodes and go on as straight lines beyond the outer ones.

    Parameters
    ----------
    margin : (7, ...) array
        The functions at the nodes.

    Returns
    -------
    (...) array

    """
    values = np.empty((_COUNT + 2, margin[0].size))
    values[1:-1] = margin.reshape(_COUNT, -1)
    reach = (_FARTHEST - NODES[-1]) / (NODES[-1] - NODES[-2])
    values[0] = values[1] + reach * (values[1] - values[2])
    values[-1] = values[-2] + reach * (values[-2] - values[-3])
    above = values > 0.0
    result = (_BETWEEN[:, None] * (above[1:] & above[:-1])).sum(axis=0)
    segment, place = np.nonzero(above[1:] != above[:-1])
    low, high = values[segment, place], values[segment + 1, place]
    left, right = _POINTS[segment], _POINTS[segment + 1]
    below = ndtr(left + (right - left) * low / (low - high))
    inside = np.where(high > low, _BELOW[segment + 1] - below, below - _BELOW[segment])
    result += np.bincount(place, inside, minlength=result.size)
    return np.asarray(result.reshape(margin.shape[1:]))
