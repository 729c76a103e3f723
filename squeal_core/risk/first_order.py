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

"""Probability that a brake is unstable, to first order in the uncertain parameters."""

from collections.abc import Sequence
from dataclasses import replace
import math

import numpy as np
from squeal_core.brake.operating_point import Coefficients, OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.ensemble import EnsemblePrior
from squeal_core.stability.eigensolution import ComplexModes, Mode
from squeal_core.stability.sensitivity import eigenvalue_sensitivity

_CANDIDATES = 3  # least stable modes; a more stable one hardly changes the maximum
_CERTAIN = 0.9999  # probability from which on no other mode is looked at


def first_order_instability(model: BrakeModel, point: OperatingPoint, modes: ComplexModes,
                            band_hz: tuple[float, float], prior: EnsemblePrior,
                            damping_ratio: float = 0.0) -> float:
    """
    Return the probability that some mode of a band is unstable; NaN: modes are not separable.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Expected inputs.
    modes : ComplexModes
        Of the model at this point.
    band_hz : (2,) floats
        Squeal band.
    prior : EnsemblePrior
        Standard deviations of what is uncertain, within and between brake applications.
    damping_ratio : float
        A mode is unstable below minus this.

    Notes
    -----
    The growth rate of a mode is Gaussian: its mean is the present value, its variance the sum of
    the squared changes over one standard deviation of each input, by the tangent. This is exact
    for growth rates that are linear in the inputs and poor next to an exceptional point. The
    largest probability of the least stable modes stands for that of all.

    """
    changes, largest = coefficient_changes(point, prior), 0.0
    for mode in modes.least_stable(*band_hz, _CANDIDATES):
        probability = _of_mode(model, point, mode, changes, damping_ratio)
        largest = probability if math.isnan(probability) else max(largest, probability)
        if not largest < _CERTAIN:
            break
    return largest


def coefficient_changes(point: OperatingPoint, prior: EnsemblePrior) -> FloatArray:
    """Return the change (4, 9) of the coefficients over one standard deviation of each input."""
    friction = min(math.hypot(prior.friction, prior.friction_scatter) / abs(point.friction), 0.5)
    damping = math.hypot(prior.damping, prior.damping_scatter)

    def moved(side: float) -> Sequence[OperatingPoint]:
        factor = 1.0 + side * friction  # the friction slope goes with friction in proportion
        return (replace(point, friction=factor * point.friction,
                        friction_slope=factor * point.friction_slope),
                replace(point, friction_slope=(1.0 + side * prior.slope) * point.friction_slope),
                replace(point, contact_stiffness=point.contact_stiffness
                        * math.exp(side * prior.contact_stiffness)),
                replace(point, damping_scale=point.damping_scale * math.exp(side * damping)))

    return np.array([np.subtract(above.coefficients(), below.coefficients())
                     for above, below in zip(moved(0.5), moved(-0.5), strict=True)])


def _of_mode(model: BrakeModel, point: OperatingPoint, mode: Mode, changes: FloatArray,
             damping_ratio: float) -> float:
    above = mode.growth_rate - damping_ratio * abs(mode.eigenvalue)
    if not changes.any():
        return float(above > 0.0)
    sensitivity = eigenvalue_sensitivity(model, point, mode.eigenvalue)
    slope = np.array([sensitivity.get(name, 0j).real for name in Coefficients._fields])
    deviation = math.hypot(*(changes @ slope).tolist())
    if deviation == 0.0:
        return float(above > 0.0)
    return 0.5 * math.erfc(-above / deviation / math.sqrt(2.0))
