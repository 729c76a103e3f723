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

"""The map of the risk over pressure, speed and friction, precomputed for a control unit."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
import math
from typing import TypeAlias

import numpy as np
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray, repr_with_shapes
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.holding import holding_exceedances, over_members
from squeal_core.risk.squeal_risk import SquealRisk
from squeal_core.stability.eigensolution import SQUEAL_BAND, Tolerances
from squeal_core.stability.quiet_intervals import full_solutions

NOTICE = 'Advice, never a command: computed, not measured; no safety function may rest on it.'
Progress: TypeAlias = Callable[[int, int], None]
_TOGETHER = 16  # conditions whose members are evaluated at once


@dataclass(frozen=True, eq=False, kw_only=True)
class AdviceMap:
    """
    Risk and growth rate over pressure, speed and friction.

    Parameters
    ----------
    pressure, rotor_speed, friction : (P,), (S,), (F,) arrays
        Axes [Pa], [rad/s], [-], rising.
    risk : (P, S, F) array
        Probability of squeal where the conditions are held [-]; NaN: not known.
    growth_rate : (P, S, F) array
        Of the least stable mode of the nominal brake in the squeal band [1/s].
    about : mapping
        What it is of, in words.

    """

    pressure: FloatArray
    rotor_speed: FloatArray
    friction: FloatArray
    risk: FloatArray
    growth_rate: FloatArray
    about: Mapping[str, str] = field(default_factory=dict)

    __repr__ = repr_with_shapes

    @property
    def axes(self) -> dict[str, FloatArray]:
        """Axes by name with unit, in the order of the arrays' indices."""
        return {'pressure_pa': self.pressure, 'rotor_speed_rad_s': self.rotor_speed,
                'friction': self.friction}


def advice_map(model: BrakeModel, pressure: FloatArray, rotor_speed: FloatArray,
               friction: FloatArray, *, risk: SquealRisk | None, hold: float,
               about: Mapping[str, str] | None = None,
               band_hz: tuple[float, float] = SQUEAL_BAND, tolerances: Tolerances | None = None,
               workers: int = 0, progress: Progress | None = None) -> AdviceMap:
    """
    Return the map: risks by the ensemble, growth rates by full solutions.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    pressure, rotor_speed, friction : arrays
        Axes [Pa], [rad/s], [-].
    risk : SquealRisk, optional
        Without one no risk is known.
    hold : float
        For which conditions are held, from the noise floor [s].
    about : mapping, optional
        What the map is of, in words.
    band_hz : (2,) floats
        The squeal band.
    tolerances : Tolerances, optional
        Of the classification of eigenvalues.
    workers : int
        Processes; 0: this one.
    progress : callable, optional
        Told how many columns of pressures are done, and of how many.

    """
    limits = tolerances or Tolerances.of(model)
    jobs = {place: (model, SlidingConditions(rotor_speed=speed, pressure=math.nan, friction=mu),
                    pressure, band_hz, limits) for place, (speed, mu) in enumerate(product(
                        rotor_speed.tolist(), friction.tolist()))}
    columns: dict[int, ComplexArray] = {}
    for place, column in run_jobs(full_solutions, jobs, workers):
        columns[place] = column
        if progress:
            progress(len(columns), len(jobs))
    growth = np.real([columns[place] for place in jobs]).reshape(
        rotor_speed.size, friction.size, pressure.size)
    return AdviceMap(
        pressure=pressure, rotor_speed=rotor_speed, friction=friction,
        risk=_risks(model, risk, hold, pressure, rotor_speed, friction),
        growth_rate=np.moveaxis(growth, -1, 0), about=dict(about or {}))


def _risks(model: BrakeModel, risk: SquealRisk | None, hold: float,
           *axes: FloatArray) -> FloatArray:
    shape = tuple(axis.size for axis in axes)
    if risk is None:
        return np.full(shape, np.nan)
    places = np.stack(np.meshgrid(*axes, indexing='ij'), axis=-1).reshape(-1, len(axes))
    return np.concatenate([
        over_members(risk, holding_exceedances(risk, model, hold, *some.T))
        for some in np.array_split(places, -(-len(places) // _TOGETHER))]).reshape(shape)
