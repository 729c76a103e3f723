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

"""Probability that a mode is unstable, to first order in the deviations of the inputs."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
import math

import numpy as np
from squeal_core.brake.operating_point import Coefficients, SlidingConditions
from squeal_core.common.arrays import FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.uncertainty import InputUncertainty
from squeal_core.stability.eigensolution import Mode
from squeal_core.stability.sensitivity import root_sensitivity


def first_order_probabilities(model: BrakeModel, conditions: SlidingConditions,
                              modes: Sequence[Mode], uncertainty: InputUncertainty,
                              growth_threshold: float) -> Iterator[float]:
    """
    Yield the probability that each mode grows faster than a threshold.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    conditions : SlidingConditions
        Expected inputs.
    modes : sequence of Mode
        Modes of the model at these conditions.
    uncertainty : InputUncertainty
        Standard deviations of the inputs.
    growth_threshold : float
        Growth rate above which a mode is unstable [1/s].

    Notes
    -----
    The growth rate is Gaussian: its mean is the present value, its variance the sum of the squared
    changes over one standard deviation of each input, by the tangent. This is exact for growth
    rates that are linear in the inputs and poor next to an exceptional point.

    """
    point = model.operating_point(**vars(conditions))
    changes = coefficient_changes(model, conditions, uncertainty)
    for mode in modes:
        sensitivity = root_sensitivity(model, point, mode.eigenvalue)
        slope = np.array([sensitivity.get(name, 0j).real for name in Coefficients._fields])
        yield _probability(mode.growth_rate - growth_threshold,
                           math.hypot(*(changes @ slope).tolist()))


def coefficient_changes(model: BrakeModel, conditions: SlidingConditions,
                        uncertainty: InputUncertainty) -> FloatArray:
    """Return the change (4, 9) of the coefficients over one standard deviation of each input."""
    stiffness = conditions.contact_stiffness
    if stiffness is None:  # an uncertain pressure moves it along the model's table
        stiffness = model.contact_stiffness_at(model.contact_pressure(conditions.pressure))
    steps = {
        'friction': min(uncertainty.friction, 0.5 * conditions.friction),
        'pressure': uncertainty.pressure * conditions.pressure,
        'rotor_speed': uncertainty.rotor_speed * conditions.rotor_speed,
        'contact_stiffness': uncertainty.contact_stiffness * stiffness}
    nominal = {**vars(conditions)}

    def moved(name: str, step: float) -> Coefficients:
        value = stiffness if name == 'contact_stiffness' else nominal[name]
        there = replace(conditions, **{name: value + step})
        return model.operating_point(**vars(there)).coefficients()

    return np.array([np.subtract(moved(name, 0.5 * step), moved(name, -0.5 * step))
                     for name, step in steps.items()])


def _probability(mean: float, deviation: float) -> float:
    """P(X > 0) of a Gaussian; a step where the deviation is zero."""
    if deviation == 0.0:
        return float(mean > 0.0)
    return 0.5 * math.erfc(-mean / deviation / math.sqrt(2.0))
