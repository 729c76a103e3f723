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

"""Risk of holding conditions for a while: from the noise floor, at the growth that they have."""

import numpy as np
from numpy.typing import ArrayLike
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.build_up import grown
from squeal_core.risk.scatter import at_nodes
from squeal_core.risk.squeal_risk import LEAST_KNOWN, SquealRisk

_NOMINAL = (0.0, 0.0, 1.0)  # ln contact stiffness and ln damping over the model's, slope scale


def holding_exceedances(risk: SquealRisk, model: BrakeModel, duration: float,
                        pressure: FloatArray, rotor_speed: ArrayLike,
                        friction: ArrayLike) -> FloatArray:
    """
    Return the probability, in each member, of squeal within a time at constant conditions.

    Parameters
    ----------
    risk : SquealRisk
        Ensemble and emulator.
    model : BrakeModel
        With a caliper.
    duration : float
        For which the conditions are held [s].
    pressure, rotor_speed, friction : (T,) array_like
        Brake pressure [Pa], Omega [rad/s], mu [-].

    Returns
    -------
    (T, M) array
        NaN where the emulator does not know the member.

    """
    load = model.contact_pressure(1.0) * pressure
    stiffness = [model.contact_stiffness_at(one) for one in load.tolist()]
    growth = risk.growth(np.abs(rotor_speed), load, friction, stiffness)
    result = np.full(growth.cap.shape, np.nan)
    for place in range(len(result)):
        at = growth.at(place)
        energy = grown(np.ones(()), at_nodes(at.rate, at.scatter), duration, risk.decay, at.cap)
        known = ~np.isnan(at.rate).any(axis=0)
        result[place, known] = risk.exceedances(energy)[known]
    return result


def nominal_least_stable(risk: SquealRisk, model: BrakeModel, at: SlidingConditions,
                         pressures: FloatArray) -> ComplexArray:
    """Return the least stable mode [1/s] of the nominal brake at pressures (n,) [Pa]; or NaN."""
    inputs = np.column_stack(np.broadcast_arrays(
        np.log(abs(at.rotor_speed)), np.log(model.contact_pressure(1.0) * pressures), at.friction,
        *_NOMINAL))
    result = risk.emulator.evaluate(inputs)
    rates, hertz = result.growth_rate[:, risk.families], result.frequency_hz[:, risk.families]
    rates = np.where(np.isnan(rates).any(axis=1, keepdims=True), np.nan, rates)
    best = rates.argmax(axis=1)[:, None]
    return np.asarray(np.take_along_axis(rates + 2j * np.pi * hertz, best, axis=1)[:, 0])


def over_members(risk: SquealRisk, values: FloatArray) -> FloatArray:
    """Return the means (...) over the ensemble of values (..., M); NaN where few are known."""
    weights = np.where(np.isnan(values), 0.0, risk.ensemble.weights)
    total = weights.sum(axis=-1)
    with np.errstate(invalid='ignore'):
        means = (weights * np.nan_to_num(values)).sum(axis=-1) / total
    return np.where(total < LEAST_KNOWN, np.nan, means)
