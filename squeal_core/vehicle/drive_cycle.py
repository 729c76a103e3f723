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

"""Drive cycles: a vehicle's speed over time, read from a table and resampled smoothly."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from squeal_core.common.arrays import FloatArray, readonly, repr_with_shapes
from squeal_core.common.bounded_reader import bounded_lines, open_bounded
from squeal_core.common.errors import SquealError
from squeal_core.common.ranges import Warn, warn_implausible
from squeal_core.common.resources import names
from squeal_core.vehicle.cycle_table import Column, CycleTable, SPEED, TIME

MAX_BYTES = 20_000_000
MAX_ROWS = 500_000
MAX_LINE = 10_000  # characters
MAX_SPEED, MAX_DURATION = 340.0, 1e6  # m/s, s
_USUAL_SPEED, _USUAL_CHANGE = 100.0, 12.0  # m/s, m/s^2
_COLUMNS = Column(0, TIME, 1.0), Column(1, SPEED, 1.0)


class DriveCycleError(SquealError):
    """A drive cycle that cannot be used; the message has place, value and remedy."""


@dataclass(frozen=True, eq=False)
class DriveCycle:
    """
    A vehicle's speed over time.

    Parameters
    ----------
    name : str
        Short name, for reports.
    time : array (n,)
        Increasing times [s], n >= 2; the steps need not be equal.
    speed : array (n,)
        Vehicle speed at these times [m/s], never negative.
    source : str
        Where the trace comes from.

    Raises
    ------
    DriveCycleError
        If the arrays differ in length, are too short, or hold a value that cannot be.

    """

    name: str
    time: FloatArray
    speed: FloatArray
    source: str = ''

    __repr__ = repr_with_shapes

    def __post_init__(self) -> None:
        object.__setattr__(self, 'time', readonly(self.time))
        object.__setattr__(self, 'speed', readonly(self.speed))
        if self.time.ndim != 1 or self.time.shape != self.speed.shape:
            raise DriveCycleError(
                f'drive cycle {self.name!r}: time has shape {self.time.shape} and speed '
                f'{self.speed.shape}; give two one-dimensional arrays of the same length')
        fault = _first_fault(self.time, self.speed)
        if fault is not None:
            raise DriveCycleError(f'drive cycle {self.name!r}, sample {fault[0]}: {fault[1]}')

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

    def sample(self, rate: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """
        Interpolate the trace at a constant rate.

        The interpolation is the monotone cubic of Fritsch and Carlson (PCHIP): it overshoots no
        sample, so speed stays non-negative, and its slope, the acceleration, is continuous.

        Parameters
        ----------
        rate : float
            Samples a second [1/s], more than zero.

        Returns
        -------
        time, speed, acceleration : arrays (m,)
            [s], [m/s] and [m/s^2]; the first sample is the trace's own, the last lies within
            one step of its end.

        Raises
        ------
        DriveCycleError
            If `rate` is not a positive number.

        """
        from scipy.interpolate import PchipInterpolator
        if not (np.isfinite(rate) and rate > 0.0):
            raise DriveCycleError(f'drive cycle {self.name!r}: cannot sample at rate = {rate} '
                                  'per second; give a positive number, such as 100.0')
        steps = np.arange(int(self.duration * rate + 1e-9) + 1)  # 1e-9: keep an exact last step
        time = np.minimum(self.time[0] + steps / rate, self.time[-1])
        curve = PchipInterpolator(self.time, self.speed)
        return time, np.maximum(curve(time), 0.0), curve(time, 1)  # max: rounding below zero


def read_drive_cycle(path: str | Path, *, warn: Warn = warn_implausible) -> DriveCycle:
    """
    Read a drive cycle from a table with the columns `time_s` and `speed_m_s` or `speed_km_h`.

    Other columns, comments (#) and empty lines are passed over; see `CycleTable` for what tables
    may look like. The file's stem becomes the name.

    Parameters
    ----------
    path : str or Path
        The table.
    warn : callable
        Given a text where the trace can be used but is unusual for a road vehicle.

    Returns
    -------
    DriveCycle

    Raises
    ------
    DriveCycleError
        With file, line, value and remedy: a column is missing, a value is no number, not finite
        or negative, time does not increase, there are fewer than two rows, or no such file.

    """
    path = Path(path)
    try:
        with open_bounded(path, MAX_BYTES, _file_error) as file:
            # a byte that is no UTF-8 becomes a value that is no number, reported with its line
            blocks = iter(lambda: file.read(1 << 20), b'')
            if sum(block.count(b'\n') for block in blocks) > MAX_ROWS:
                raise DriveCycleError(f'{path}: has more than {MAX_ROWS} lines; sample it more '
                                      'coarsely, or give a part of it')
            file.seek(0)
            text = bounded_lines(file, MAX_LINE, lambda line: DriveCycleError(
                f'{path}, line {line}: has more than {MAX_LINE} characters; give a table of '
                'lines'), errors='replace')
            table = CycleTable(text, lambda line, what, remedy: DriveCycleError(
                f'{path}, line {line}: {what}; {remedy}'))
            rows = list(table.rows())
    except DriveCycleError:
        raise
    except (OSError, ValueError, csv.Error) as error:
        raise _file_error(path, f'cannot be read ({error})', '') from None
    time, speed = np.array([row[1:] for row in rows], dtype=np.float64).reshape(-1, 2).T
    fault = _first_fault(time, speed, (table.time, table.speed))
    if fault is not None:
        line = f', line {rows[fault[0]][0]}' if fault[0] < len(rows) else ''
        raise DriveCycleError(f'{path}{line}: {fault[1]}')
    _check_road_vehicle(path, time, speed, warn)
    return DriveCycle(name=path.stem, time=time, speed=speed, source=path.name)


def _check_road_vehicle(path: Path, time: FloatArray, speed: FloatArray, warn: Warn) -> None:
    """Refuse or doubt a trace that looks like one in km/h or in ms."""
    fastest, duration = float(speed.max()), float(time[-1] - time[0])
    change = float(np.max(np.abs(np.diff(speed) / np.diff(time))))
    if fastest > MAX_SPEED or duration > MAX_DURATION:
        raise DriveCycleError(
            f'{path}: reaches {fastest:g} m/s and lasts {duration:g} s; give speed_m_s in m/s up '
            f'to {MAX_SPEED:g} and time_s in s up to {MAX_DURATION:g} (km/h, or ms?)')
    if fastest > _USUAL_SPEED:
        warn(f'{path}: speed_m_s reaches {fastest:g} m/s; usual is up to {_USUAL_SPEED:g} m/s: '
             f'check it ({fastest:g} km/h would be {fastest / 3.6:.4g} m/s)')
    if change > _USUAL_CHANGE:
        warn(f'{path}: speed_m_s changes by {change:.4g} m/s^2; usual is up to '
             f'{_USUAL_CHANGE:g} m/s^2: check the units of both columns')


def _file_error(path: object, what: str, _: str) -> DriveCycleError:
    return DriveCycleError(f'{path}: {what}; give a table of {TIME},{SPEED}, or a shipped '
                           f'cycle: {", ".join(names("drive_cycles", ".csv"))}')


def _first_fault(time: FloatArray, speed: FloatArray, columns: tuple[Column, Column] = _COLUMNS
                 ) -> tuple[int, str] | None:
    """Return index and description of the first impossible sample, or None."""
    if len(time) < 2:
        return len(time), f'{len(time)} rows of data; give at least two'
    finite = np.isfinite(time) & np.isfinite(speed)
    later = np.append(True, time[1:] > time[:-1])
    wrong = np.flatnonzero(~(finite & (speed >= 0.0) & later))
    if wrong.size == 0:
        return None
    i = int(wrong[0])
    for column, value in zip(columns, (time[i], speed[i]), strict=True):
        if not np.isfinite(value):
            return i, f'{column.said(value)} is not finite; remove the line, gaps are interpolated'
    if speed[i] < 0.0:
        return i, f'{columns[1].said(speed[i])} is negative; give the magnitude of the speed'
    return i, (f'{columns[0].said(time[i])} does not come after {columns[0].own(time[i - 1])}; '
               'sort the lines by time and remove repeated ones')
