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

"""Speed and brake pressure of a recorded drive over time: for a sound's clock, and for whine."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from squeal_core.common.arrays import FloatArray, repr_with_shapes
from squeal_core.monitor.results.history import AssessmentRecord
from squeal_core.monitor.results.result_files import ReplayResult
from squeal_core.sound.sound_errors import SoundError
from squeal_core.vehicle.drive_cycle import read_drive_cycle

_LONGEST_GAP = 1.0  # s, over which values are interpolated
_APPLIED = 3e4  # Pa, mean of the brakes; pads may trail at less
_AROUND = 0.5  # s before and after braking in which a brake may be sliding yet


@dataclass(frozen=True, eq=False)
class RecordedDrive:
    """
    Speed and brake pressure of a vehicle during a recording.

    Parameters
    ----------
    name : str
        Of the recording.
    time : (T,) array
        Rising, on the recording's clock [s].
    speed : (T,) array
        Mean of the wheels, without sign, in any unit; NaN: not known.
    pressure : (T,) array
        Mean of the brakes [Pa]; NaN: not known.

    """

    name: str
    time: FloatArray
    speed: FloatArray
    pressure: FloatArray

    __repr__ = repr_with_shapes

    def speed_at(self, time: FloatArray) -> FloatArray:
        """Return the speed at times; NaN where it is not known."""
        return self._at(time, self.speed)

    def pressure_at(self, time: FloatArray) -> FloatArray:
        """Return the pressure at times; NaN where it is not known."""
        return self._at(time, self.pressure)

    def braking_at(self, time: FloatArray, uncertainty: float = 0.0) -> FloatArray:
        """
        Return 1 where brakes slide under pressure, from 0.5 s before to after, else 0.

        NaN where it is not known; `uncertainty` is the standard deviation of the times [s].
        """
        around = _AROUND + 2.0 * uncertainty
        first, last = (np.searchsorted(self.time, time + side) for side in (-around, around))
        slides, known = (np.concatenate([[0], np.cumsum(rows)]) for rows in (
            (self.pressure >= _APPLIED) & (self.speed > 0.0),
            np.isfinite(self.pressure + self.speed)))
        return np.where(known[last] > known[first], slides[last] > slides[first], np.nan)

    def _at(self, time: FloatArray, values: FloatArray) -> FloatArray:
        known = np.isfinite(values)
        if known.sum() < 2:
            return np.full(np.shape(time), np.nan)
        places, values = self.time[known], values[known]
        after = np.clip(np.searchsorted(places, time), 1, places.size - 1)
        near = places[after] - places[after - 1] <= _LONGEST_GAP
        inside = (time >= places[0]) & (time <= places[-1])
        return np.where(near & inside, np.interp(time, places, values), np.nan)


def read_drive(path: str | Path) -> RecordedDrive:
    """
    Read a drive from a result of `squeal replay`, or its speed from time_s,speed_m_s.

    Raises
    ------
    SquealError
        For files that are neither.

    """
    path = Path(path)
    if path.suffix == '.csv':
        cycle = read_drive_cycle(path)
        return RecordedDrive(path.stem, cycle.time, cycle.speed,
                             np.full(cycle.time.size, np.nan))
    result = ReplayResult.load(path)
    return drive_of_rows(result.name, result.rows())


def drive_of_rows(name: str, rows: Iterable[AssessmentRecord]) -> RecordedDrive:
    """Return the drive in the rows of a table, those of one tick behind each other."""
    ticks = []
    for time, brakes in groupby(rows, key=lambda row: row.time_s):
        result = np.array([(abs(row.rotor_speed_rad_s), row.pressure_pa) for row in brakes])
        known = np.isfinite(result)
        sums = np.where(known, result, 0.0).sum(axis=0)
        ticks.append((time, *np.where(known.any(axis=0), sums, np.nan)
                      / np.maximum(known.sum(axis=0), 1)))
    if len(ticks) < 2:
        raise SoundError(name, f'has {len(ticks)} ticks', 'give the result of a longer recording')
    time, speed, pressure = np.array(ticks, dtype=float).T
    return RecordedDrive(name, time, speed, pressure)
