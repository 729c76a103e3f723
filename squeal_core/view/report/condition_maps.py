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

"""Maps of a drive over pressure, speed and friction: its risk and stability boundary there."""

from dataclasses import dataclass

import numpy as np
from squeal_core.common.arrays import FloatArray, IndexArray
from squeal_core.view.report.tick_stream import Ticks

_PRESSURE_CELLS, _SPEED_CELLS = 50, 40  # of the operating map
_CONDITION_CELLS = 24  # of a friction chart
_FRICTION_STEP, _FRICTION_CELLS = 0.005, 200
LEAST_TICKS = 5  # of a cell that has a boundary


@dataclass(frozen=True)
class ConditionRanges:
    """
    Ranges that hold the conditions of brake applications.

    Parameters
    ----------
    pressure : float
        Largest one [Pa].
    rotor_speed : float
        Largest magnitude [rad/s].
    pressure_classes, speed_classes : tuple of float
        Limits between low, medium and high ones.

    """

    pressure: float
    rotor_speed: float
    pressure_classes: tuple[float, ...]
    speed_classes: tuple[float, ...]

    def cells(self, pressure: FloatArray, rotor_speed: FloatArray, *,
              counts: tuple[int, int]) -> tuple[IndexArray, IndexArray]:
        """Return the cell of each pressure and speed, in so many of either."""
        def cell(values: FloatArray, largest: float, count: int) -> IndexArray:
            return np.clip(values / largest * count, 0, count - 1).astype(int)
        return (cell(pressure, self.pressure, counts[0]),
                cell(np.abs(rotor_speed), self.rotor_speed, counts[1]))


class OperatingMap:
    """
    Largest risk of sliding ticks in cells of pressure and speed; an accumulator of ticks.

    Attributes
    ----------
    risk : array (speeds, pressures)
        NaN where none is known.
    unknown : array (speeds, pressures)
        Ticks whose risk is not known.

    """

    def __init__(self, ranges: ConditionRanges) -> None:
        self.ranges = ranges
        self.risk = np.full((_SPEED_CELLS, _PRESSURE_CELLS), np.nan)
        self.unknown = np.zeros(self.risk.shape, int)

    @property
    def centres(self) -> tuple[FloatArray, FloatArray]:
        """Centres of the cells: pressures [Pa] and speeds [rad/s]."""
        return ((np.arange(_PRESSURE_CELLS) + 0.5) / _PRESSURE_CELLS * self.ranges.pressure,
                (np.arange(_SPEED_CELLS) + 0.5) / _SPEED_CELLS * self.ranges.rotor_speed)

    def add(self, ticks: Ticks) -> None:
        """Take further ticks of a brake."""
        numbers = ticks.numbers
        pressure, speed = numbers['pressure_pa'], numbers['rotor_speed_rad_s']
        there = (ticks.sliding | ticks.unknown) & np.isfinite(pressure + speed)
        cells = self.ranges.cells(np.where(there, pressure, 0.0), np.where(there, speed, 0.0),
                                  counts=(_PRESSURE_CELLS, _SPEED_CELLS))
        known = there & ticks.sliding & ~ticks.unknown
        np.fmax.at(self.risk, (cells[1][known], cells[0][known]), numbers['squeal_risk'][known])
        np.add.at(self.unknown, tuple(one[there & ticks.unknown] for one in reversed(cells)), 1)


class FrictionBoundary:
    """
    Critical friction by pressure and by speed, in classes of the other; an accumulator of ticks.

    The critical friction is the friction plus its margin, as the monitor looked it up at each
    tick.
    """

    def __init__(self, ranges: ConditionRanges) -> None:
        self.ranges = ranges
        classes = (len(ranges.speed_classes) + 1, len(ranges.pressure_classes) + 1)
        self._counts = [np.zeros((number, _CONDITION_CELLS, _FRICTION_CELLS), np.int32)
                        for number in classes]

    def add(self, ticks: Ticks) -> None:
        """Take further ticks of a brake."""
        numbers = ticks.numbers
        critical = numbers['friction'] + numbers['friction_margin']
        at = np.flatnonzero(ticks.sliding & np.isfinite(critical))
        pressure, speed = numbers['pressure_pa'][at], np.abs(numbers['rotor_speed_rad_s'][at])
        friction = np.clip(critical[at] / _FRICTION_STEP, 0, _FRICTION_CELLS - 1).astype(int)
        cells = self.ranges.cells(pressure, speed, counts=(_CONDITION_CELLS,) * 2)
        for counts, cell, other, limits in (
                (self._counts[0], cells[0], speed, self.ranges.speed_classes),
                (self._counts[1], cells[1], pressure, self.ranges.pressure_classes)):
            np.add.at(counts, (np.digitize(other, limits), cell, friction), 1)

    @property
    def known(self) -> bool:
        """Return whether any boundary was found."""
        return bool(self._counts[0].any())

    def curve(self, over: int, place: int) -> tuple[FloatArray, FloatArray]:
        """
        Return the median critical friction of a class.

        Parameters
        ----------
        over : int
            0: over pressure, of a class of speed; 1: over speed, of a class of pressure.
        place : int
            Of the class.

        Returns
        -------
        condition, friction : arrays
            [Pa] or [rad/s]; NaN where there were too few ticks.

        """
        counts = self._counts[over][place]
        largest = self.ranges.rotor_speed if over else self.ranges.pressure
        total = counts.sum(axis=1)
        median = (counts.cumsum(axis=1) >= 0.5 * total[:, None]).argmax(axis=1)
        return ((np.arange(_CONDITION_CELLS) + 0.5) / _CONDITION_CELLS * largest,
                np.where(total >= LEAST_TICKS, (median + 0.5) * _FRICTION_STEP, np.nan))


class ApplicationPath:
    """
    Ticks of one brake application; an accumulator of ticks.

    Attributes
    ----------
    numbers : dict
        Arrays of `COLUMNS` and `time_s`.

    """

    def __init__(self, brake: str, start: float, end: float) -> None:
        self._brake, self._start, self._end = brake, start, end
        self._parts: list[dict[str, FloatArray]] = []

    def add(self, ticks: Ticks) -> None:
        """Take further ticks of a brake."""
        time = ticks.numbers['time_s']
        if ticks.brake == self._brake:
            at = np.flatnonzero((time >= self._start - 1e-6) & (time <= self._end + 1e-6))
            if at.size:
                self._parts.append({name: values[at] for name, values in ticks.numbers.items()})

    @property
    def numbers(self) -> dict[str, FloatArray]:
        """Arrays of all ticks; empty where there were none."""
        return {name: np.concatenate([part[name] for part in self._parts])
                for name in (self._parts[0] if self._parts else ())}
