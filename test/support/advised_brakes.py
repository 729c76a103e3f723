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

"""Brakes whose quiet pressures and growth are known in closed form, and their emulator."""

import math
from typing import Any

import numpy as np
from scipy.optimize import brentq
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.emulator_records import EmulatedGrowth, EmulatorError
from squeal_core.risk.ensemble import Ensemble
from squeal_core.risk.mode_families import ModeFamily
from squeal_core.risk.squeal_risk import SquealRisk
from support.margin_searches import DAMPING, SKEW, W1, W2

PRESSURES = (1e5, 8e6)
_COUPLE, _STIFFENING = 1e-3, 2e-3
_STIFFNESS = (1e8, 4e9)  # N/m^3, from no load to that of the last pressure


def ridge() -> BrakeModel:
    """Two modes that meet as the lining stiffens under load: unstable between two pressures."""
    last = Caliper(2.5e-3).preload(PRESSURES[1]) / BrakeModel(
        angular_frequencies=[1.0]).contact_area
    return BrakeModel(
        angular_frequencies=np.array([W1, W2]), friction_couple=_COUPLE * SKEW,
        contact_stiffness=np.diag([_STIFFENING, 0.0]), caliper=Caliper(2.5e-3),
        damping_ratios=0.5 * DAMPING / np.array([W1, W2]), friction_law=FrictionLaw(),
        stiffness_table=StiffnessTable(pressure=(0.0, last), stiffness=_STIFFNESS))


def ridge_pressures(friction: float) -> tuple[float, float]:
    """Return the pressures between which `ridge` is unstable [Pa]."""
    def excess(pressure: float) -> float:
        low, high = _STIFFNESS
        stiffness = low + (high - low) * pressure / PRESSURES[1]
        gap = 0.5 * (W2**2 - W1**2 - _STIFFENING * stiffness)
        mean = 0.5 * (W1**2 + W2**2 + _STIFFENING * stiffness)
        return (friction * _COUPLE * stiffness)**2 - gap**2 - DAMPING**2 * mean

    peak = (0.5 * (W2**2 - W1**2) / (0.5 * _STIFFENING) - _STIFFNESS[0]) / (
        _STIFFNESS[1] - _STIFFNESS[0]) * PRESSURES[1]
    return (brentq(excess, PRESSURES[0], peak), brentq(excess, peak, PRESSURES[1]))


def falling() -> BrakeModel:
    """One mode that a falling friction drives: growth = (s p0 |slope| - d) / 2."""
    return BrakeModel(
        angular_frequencies=np.array([W1]), damping_ratios=0.5 * DAMPING / W1,
        negative_slope=np.array([[3e-4]]), caliper=Caliper(2.5e-3),
        friction_law=FrictionLaw(decay=1.0))


def falling_growth(model: BrakeModel, rotor_speed: Any, pressure: Any, friction: Any,
                   ln_damping: Any = 0.0, slope_scale: Any = 1.0) -> Any:
    """Return the growth rate of `falling` [1/s]; all broadcast, the pressure is p0 [Pa]."""
    assert model.friction_law is not None
    slope = friction * -model.friction_law.relative_slope(model.contact_radius * rotor_speed)
    return 0.5 * (3e-4 * pressure * slope * slope_scale - DAMPING * np.exp(ln_damping))


class FallingEmulator:
    """The growth of `falling` in closed form, up to some friction."""

    families = (ModeFamily(numbers=(1,), frequency_hz=W1 / math.tau,
                           decay_rate=0.5 * DAMPING),)
    error = EmulatorError(rms=0.0, largest=0.0)

    def __init__(self, model: BrakeModel, most_friction: float = 1.0) -> None:
        self._model, self._most = model, most_friction

    def evaluate(self, inputs: FloatArray) -> EmulatedGrowth:
        ln_speed, ln_pressure, friction, _, ln_damping, scale = np.moveaxis(inputs, -1, 0)
        rate = falling_growth(self._model, np.exp(ln_speed), np.exp(ln_pressure), friction,
                              ln_damping, scale)
        rate = np.where(friction <= self._most, rate, np.nan)
        by_damping = -0.5 * DAMPING * np.exp(ln_damping)
        return EmulatedGrowth(*(values[..., None] for values in (
            rate, np.full(rate.shape, W1 / math.tau), (rate - by_damping) / friction,
            by_damping)))


def falling_risk(model: BrakeModel, *, most_friction: float = 1.0,
                 scatter: float = 0.02) -> SquealRisk:
    """Return the risk of an ensemble of 32 such brakes."""
    random = np.random.default_rng(7)
    size = 32
    ensemble = Ensemble(
        ln_damping=0.1 * random.standard_normal(size), ln_contact_stiffness=np.zeros(size),
        friction_bias=0.01 * random.standard_normal(size), slope_scale=np.ones(size),
        audible_build_up=5.5 + random.standard_normal(size),
        weights=np.full(size, 1.0 / size), friction_scatter=scatter, damping_scatter=scatter)
    emulator: Any = FallingEmulator(model, most_friction)
    return SquealRisk(emulator, ensemble)
