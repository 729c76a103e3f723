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

"""Builds an operating map: growth rates on a grid, the risk from them, and its error."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
from scipy.special import ndtr
from squeal_core.common.worker_processes import run_jobs
from squeal_core.model.brake_model import BrakeModel
from squeal_core.risk.expansion_check import BandGrowth
from squeal_core.risk.growth_boxes import box_growth, first_boxes
from squeal_core.risk.growth_grid import grid_around, grid_over, GrowthGrid
from squeal_core.risk.operating_map import MapError, OperatingMap
from squeal_core.risk.smoothing import probability_scores
from squeal_core.risk.uncertainty import RiskParameters
from squeal_core.stability.eigensolution import Tolerances
from squeal_core.surrogate.table_domain import FRICTION, PRELOAD, Range, ROTOR_SPEED

Progress: TypeAlias = Callable[[int, int], None]

_CHECKS = 16  # points at which the map is compared with a direct integration
_CANDIDATES = 400
_OPEN = (0.02, 0.98)  # risks between which half of these points are chosen


def build_operating_map(model: BrakeModel, parameters: RiskParameters, *,
                        rotor_speed: Range = ROTOR_SPEED, preload: Range = PRELOAD,
                        friction: Range = FRICTION, workers: int = 0,
                        checks: int = _CHECKS,
                        progress: Progress = lambda *_: None) -> OperatingMap:
    """
    Return the map of risk and growth rate over an envelope.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    parameters : RiskParameters
        What the risk is the probability of.
    rotor_speed, preload, friction : (2,) floats
        Envelope of nominal conditions [rad/s], [N], [-].
    workers : int
        Processes; 0: this one.
    checks : int
        Number of points at which the map's error is measured.
    progress : callable
        Called with the number of boxes that are done and of all boxes.

    """
    grid, nominal = grid_over(
        model, parameters.uncertainty, rotor_speed=rotor_speed, friction=friction,
        contact_pressure=(preload[0] / model.contact_area, preload[1] / model.contact_area))
    excess = _excess(grid, criterion_of(model, parameters), workers, progress)
    score = probability_scores(grid, excess, nominal, parameters.uncertainty)
    growth = excess[:, :, nominal, grid.stiffness_factor.size // 2] + parameters.growth_threshold
    found = OperatingMap(
        parameters, grid.rotor_speed, grid.contact_pressure, grid.friction[nominal],
        score.astype(np.float32), growth.astype(np.float32), MapError(0, np.nan, np.nan))
    return _with_error(model, found, workers, checks)


def criterion_of(model: BrakeModel, parameters: RiskParameters) -> BandGrowth:
    """Return which growth counts: oscillating, in the band and above the threshold."""
    low, high = (2.0 * np.pi * end for end in parameters.band_hz)
    return BandGrowth((max(low, Tolerances.of(model).oscillation), high),
                      parameters.growth_threshold)


def integrated_risk(model: BrakeModel, parameters: RiskParameters, rotor_speed: float,
                    contact_pressure: float, friction: float) -> float:
    """Return the risk at one operating point from expansions around it, without a map."""
    grid, place = grid_around(model, parameters.uncertainty, rotor_speed, contact_pressure,
                              friction)
    excess = _excess(grid, criterion_of(model, parameters), 0, lambda *_: None)
    found = probability_scores(grid, excess, slice(place, place + 1), parameters.uncertainty)
    return float(ndtr(found[1, 1, 0]))


def _excess(grid: GrowthGrid, criterion: BandGrowth, workers: int, progress: Progress) -> Any:
    """Return the excess growth at all points of a grid."""
    jobs = {i: (grid, criterion, box) for i, box in enumerate(first_boxes(grid))}
    found: Any = np.empty(grid.shape, np.float32)
    for done, (_, part) in enumerate(run_jobs(box_growth, jobs, workers), start=1):
        found[part.box.slices] = part.excess
        progress(done, len(jobs))
    return found


def _with_error(model: BrakeModel, found: OperatingMap, workers: int, checks: int) -> OperatingMap:
    """Return a map with its error; half of the check points have an open risk, if there are."""
    rng = np.random.default_rng(0)
    low, high = np.array([(axis[0], axis[-1]) for axis in (
        np.log(found.rotor_speed), np.log(found.contact_pressure), found.friction)]).T
    places = low + (high - low) * rng.random((_CANDIDATES, 3))
    places[:, :2] = np.exp(places[:, :2])
    risk = found.risk_at(*places.T)
    open_ = np.flatnonzero((risk > _OPEN[0]) & (risk < _OPEN[1]))[:checks // 2]
    other = np.setdiff1d(np.arange(_CANDIDATES), open_)[:checks - open_.size]
    chosen = places[np.concatenate([open_, other])]
    jobs = {i: (model, found.parameters, *place) for i, place in enumerate(chosen.tolist())}
    off = np.array([risk - float(found.risk_at(*chosen[i]))
                    for i, risk in run_jobs(integrated_risk, jobs, workers)])
    if not off.size:
        return found
    return replace(found, error=MapError(off.size, float(np.abs(off).max()),
                                         float(np.sqrt(np.mean(off**2)))))
