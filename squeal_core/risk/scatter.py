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

Both are Gaussian. Growth rates, and build-ups by them, are computed at the 3 x 3 nodes of
Gauss-Hermite quadrature. A probability is that of a piecewise linear function through the nodes,
as weights of nodes alone would make steps of a sixth.
"""

import numpy as np
from scipy.special import ndtr, ndtri
from squeal_core.common.arrays import FloatArray

NODES = np.sqrt(3.0) * np.array([-1.0, 0.0, 1.0])  # standard deviations
WEIGHTS = np.outer([1.0, 4.0, 1.0], [1.0, 4.0, 1.0]) / 36.0  # (friction, damping)
_FARTHEST = -9.0  # standard deviations, beyond which are 1e-19
_FINE = ndtri((np.arange(6) + 0.5) / 6.0)  # damping, of equal probability


def _interpolation(at: FloatArray) -> FloatArray:
    """Return the weights (points, 3) of linear interpolation through the nodes."""
    left, right = np.minimum(at, 0.0) / NODES[2], np.maximum(at, 0.0) / NODES[2]
    return np.stack([-left, 1.0 + left - right, right], axis=-1)


_THROUGH = _interpolation(_FINE)


def exceedance(margin: FloatArray) -> FloatArray:
    """
    Return the probability that functions of friction and damping are positive.

    Parameters
    ----------
    margin : (3, 3, ...) array
        The functions at the nodes of friction and damping, in this order.

    Returns
    -------
    (...) array

    """
    low, middle, high = _THROUGH @ margin.reshape(3, 3, -1)  # (points, ...) each
    steps = np.stack([low - middle, high - middle])  # outwards to the nodes
    with np.errstate(divide='ignore', invalid='ignore'):
        zero = NODES[2] * middle / steps  # less the standard deviations to it
    inside = np.empty_like(steps)
    inside[:] = 0.5 * (middle > 0.0)  # of all values on the node's side
    some = np.flatnonzero((zero <= 0.0) & (zero > _FARTHEST))
    beyond = ndtr(zero.ravel()[some])
    inside.ravel()[some] = np.where(steps.ravel()[some] < 0.0, 0.5 - beyond, beyond)
    return np.asarray(inside.sum(axis=0).mean(axis=0).reshape(margin.shape[2:]))
