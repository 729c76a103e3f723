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

"""The operating points of a drive at which a brake is least stable, one for each mode."""

from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np
from squeal_core.brake.operating_point import MINIMUM_ROTOR_SPEED, RELEASE_PRESSURE
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND
from squeal_core.stability.mode_tracking import identify

_WIDTHS = (0.25, 0.25, 0.02)  # of cells in ln speed, ln pressure and friction
_MOST_CELLS = 400  # those with most time; each is solved
_MOST_TRACKED = 12  # points whose modes are numbered


class WorstPoint(NamedTuple):
    """Point of a mode's largest growth rate, and the fraction of the braking that is near it."""

    numbers: tuple[int, ...]
    rotor_speed: float
    pressure: float
    friction: float
    growth_rate: float
    share: float


def worst_points(model: BrakeModel, rotor_speed: FloatArray, pressure: FloatArray,
                 friction: FloatArray, count: int, *,
                 band_hz: tuple[float, float] = SQUEAL_BAND,
                 progress: Callable[[int, int], None] = lambda *_: None) -> list[WorstPoint]:
    """
    Return the points of the `count` least stable modes of a drive, worst first.

    Parameters
    ----------
    model : BrakeModel
        With a caliper.
    rotor_speed, pressure, friction : (P,) arrays
        Of any brakes at any times, evenly spaced [rad/s], [Pa], [-].
    count : int
        Number of modes.
    band_hz : (2,) floats
        Squeal band.
    progress : callable
        Told how many points are solved, and of how many.

    Raises
    ------
    SquealError
        Where the brake never slides under load.

    Notes
    -----
    Points are gathered in cells some 25 % wide in speed and pressure and 0.02 in friction; the
    mean of each is solved in full.

    """
    cells = _cells(rotor_speed, pressure, friction)
    if not cells:
        raise SquealError('the drive: no brake slides under load with a known friction; give '
                          'another drive, or an operating point')
    solved = []
    for place, (speed, load, mu, share) in enumerate(cells):
        point = model.operating_point(rotor_speed=speed, pressure=load, friction=mu)
        mode = complex_modes(model, point).worst_in(*band_hz)
        if mode is not None:
            solved.append((mode, point, WorstPoint((), speed, load, mu, mode.growth_rate, share)))
        progress(place + 1, len(cells))
    solved.sort(key=lambda row: -row[0].growth_rate)
    result: list[WorstPoint] = []
    seen: list[float] = []
    for mode, point, worst in solved:
        if len(result) == count or len(seen) == _MOST_TRACKED:
            break
        if any(math.isclose(mode.frequency_hz, other, rel_tol=2e-3) for other in seen):
            continue  # most likely the same mode, at a point next to its worst
        seen.append(mode.frequency_hz)
        numbers = identify(model, point).identity(mode).numbers
        if not any(set(numbers) & set(other.numbers) for other in result):
            result.append(worst._replace(numbers=numbers))
    return result


def _cells(rotor_speed: FloatArray, pressure: FloatArray,
           friction: FloatArray) -> list[tuple[float, float, float, float]]:
    """Return the mean speed, pressure and friction of cells and their share of the braking."""
    rows = np.column_stack([rotor_speed, pressure, friction])
    sliding = ((np.abs(rotor_speed) >= MINIMUM_ROTOR_SPEED) & (pressure > RELEASE_PRESSURE)
               & (friction > 0.0) & np.isfinite(rows).all(axis=1))
    rows = rows[sliding]
    if not len(rows):
        return []
    places = np.column_stack([
        np.sign(rows[:, 0]), np.floor(np.log(np.abs(rows[:, 0])) / _WIDTHS[0]),
        np.floor(np.log(rows[:, 1]) / _WIDTHS[1]), np.floor(rows[:, 2] / _WIDTHS[2])])
    _, cell, counts = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    means = np.stack([np.bincount(cell.ravel(), column) / counts for column in rows.T], axis=1)
    most = np.argsort(-counts, kind='stable')[:_MOST_CELLS]
    return [(*means[place].tolist(), float(counts[place] / len(rows)))
            for place in most.tolist()]
