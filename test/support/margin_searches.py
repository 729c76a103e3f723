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

"""Brakes of one or two modes, and evaluators of their margins by full solutions."""

from collections.abc import Sequence
from dataclasses import replace
import math
from typing import Any

import numpy as np
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.monitor.margin_evaluator import MarginEvaluator
from squeal_core.monitor.margins import Kind, least_stable, Margin, MarginSettings
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances

HERE = SlidingConditions(rotor_speed=10.0, pressure=1e6, friction=0.3)
W1, W2, DAMPING = 1e4, 1.02e4, 40.0
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])
SETTINGS = MarginSettings(band_hz=SQUEAL_BAND, friction=(0.0, 0.9), rotor_speed=(0.5, 200.0),
                          pressure=(2e4, 1.6e7), error=0.1)


class FullSolutions:
    """Look-up by full solutions, counted; as a table off by some growth rate or of some range."""

    def __init__(self, model: BrakeModel, band_hz: tuple[float, float] = SQUEAL_BAND, *,
                 off: float = 0.0, friction: tuple[float, float] = (-1.0, 2.0)) -> None:
        self.model, self.band_hz, self.off, self.friction = model, band_hz, off, friction
        self.calls, self.points = 0, 0

    def __call__(self, rows: FloatArray, kind: Kind) -> ComplexArray:
        self.calls += 1
        self.points += len(rows)
        return np.array([self._at(kind, *row) for row in rows.tolist()])

    def _at(self, kind: Kind, speed: float, pressure: float, friction: float) -> complex:
        if not self.friction[0] <= friction <= self.friction[1]:
            return complex(math.nan, math.nan)
        point = self.model.operating_point(rotor_speed=speed, pressure=pressure,
                                           friction=friction)
        modes = complex_modes(self.model, point)
        return complex(least_stable(modes.mode_eigenvalues[None], kind, self.band_hz,
                                    modes.tolerances)[0]) + self.off


def evaluator(growth: FullSolutions, settings: MarginSettings = SETTINGS,
              scan: Any = None) -> MarginEvaluator:
    settings = replace(settings, band_hz=growth.band_hz)
    return MarginEvaluator(growth.model, settings, Tolerances.of(growth.model), growth=growth,
                           scan=scan)


def friction_margins(margins: MarginEvaluator, conditions: Sequence[SlidingConditions]
                     ) -> list[Margin]:
    return margins.friction_margins(conditions, [
        complex_modes(margins.model, margins.model.operating_point(**vars(at))).worst_in(
            *margins.settings.band_hz) for at in conditions])


def flutter(couple: float, **changes: Any) -> BrakeModel:
    """
    Two modes of equal damping: unstable where mu k_c couple exceeds half the split of K, damped.

    (half the split)^2 + d^2 mean = (mu k_c couple)^2, mean that of the squares of frequency.
    """
    return BrakeModel(**{
        'angular_frequencies': np.array([W1, W2]), 'friction_couple': couple * SKEW,
        'damping_ratios': 0.5 * DAMPING / np.array([W1, W2]), 'caliper': Caliper(2.5e-3),
        'nominal_contact_stiffness': 1e10, **changes})
