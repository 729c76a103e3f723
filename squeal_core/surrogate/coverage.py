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

"""Anchors laid down beforehand: over an envelope of operating points, or along given points."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from itertools import islice
import math
from typing import Any, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import OperatingPointError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from squeal_core.surrogate.tabulated_solver import TabulatedSolver

Range: TypeAlias = tuple[float, float]
_LOGARITHMIC = ('rotor_speed', 'contact_pressure', 'contact_stiffness')
_WINDOW = 1000  # points over which it is judged whether more anchors are needed


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """
    Ranges of operating points; speed, pressure and stiffness are spread by their logarithms.

    Parameters
    ----------
    rotor_speed, contact_pressure, friction : (2,) floats
        Lowest and highest, above zero: rad/s, Pa, -.
    friction_slope : (2,) floats, optional
        [s/m]; None: the model's friction law at each speed, scaled to the friction; zero without.
    contact_stiffness : (2,) floats, optional
        [N/m^3]; None: the model's at each pressure.

    Raises
    ------
    OperatingPointError
        For a range that is none.

    """

    rotor_speed: Range
    contact_pressure: Range
    friction: Range
    friction_slope: Range | None = None
    contact_stiffness: Range | None = None

    def __post_init__(self) -> None:
        for name, (low, high) in self.ranges.items():
            least = -math.inf if name == 'friction_slope' else 0.0
            if not (least < low <= high < math.inf):
                raise OperatingPointError(f'{name}: {low:g} to {high:g} is no range; give the '
                                          f'lower end first{" and both above 0" * (least == 0.0)}')

    @property
    def ranges(self) -> dict[str, Range]:
        """Return the ranges that are given, by name."""
        return {item.name: value for item in fields(self)
                if (value := getattr(self, item.name)) is not None}

    def points(self, model: BrakeModel, places: Iterable[Any]) -> Iterator[OperatingPoint]:
        """Yield the points at places (5,) of the unit cube."""
        ranges = self.ranges
        for place in places:
            values = {}
            for (name, (low, high)), share in zip(ranges.items(), place, strict=False):
                values[name] = float(low * (high / low) ** share if name in _LOGARITHMIC
                                     else low + share * (high - low))
            if self.friction_slope is None and model.friction_law is not None:
                values['friction_slope'] = model.friction_law.slope_at(
                    model.contact_radius * values['rotor_speed'], values['friction'])
            if self.contact_stiffness is None:
                values['contact_stiffness'] = model.contact_stiffness_at(
                    values['contact_pressure'])
            yield OperatingPoint(**values)


def random_places(seed: int) -> Iterator[FloatArray]:
    """
    Yield independent places (5,) of the unit cube.

    An evenly spread sequence would serve worse: its points keep away from its earlier ones by a
    few fixed steps, so the anchors among them cover each other's edges and leave gaps.
    """
    generator = np.random.default_rng(seed)
    while True:
        yield generator.random(5)


@dataclass(frozen=True)
class CoverageReport:
    """
    What became of the points that anchors were laid down for.

    Parameters
    ----------
    points : int
        Looked at.
    undecided : int
        At which even an anchor of their own leaves a verdict open: on a boundary of stability.
    complete : bool
        False: the memory or the number of anchors ended it.

    """

    points: int
    undecided: int
    complete: bool


def build_table(table: TabulatedSolver, points: Iterable[OperatingPoint], *, coverage: float = 1.0,
                most: int = 1000, memory: float = 200e6,
                progress: Callable[[int, int], None] = lambda *_: None) -> CoverageReport:
    """
    Make an anchor at each point that the table does not cover yet.

    Parameters
    ----------
    table : TabulatedSolver
        Whose anchors to add to.
    points : iterable of OperatingPoint
        May be endless when `coverage` is below 1.
    coverage : float
        Ends as soon as so many of the last 1000 points needed no new anchor.
    most : int
        Anchors.
    memory : float
        Limit of their size [bytes].
    progress : callable
        Told the anchors and the points so far.

    """
    count = undecided = 0
    new: deque[bool] = deque(maxlen=_WINDOW)
    for point in points:
        count += 1
        anchor = None if table.covers(point) else _useful(table, point)
        if anchor is not None:
            if len(table.anchors) >= most or table.nbytes + anchor.nbytes > memory:
                return CoverageReport(count, undecided, False)
            table.add(anchor)
        elif not table.covers(point):
            undecided += 1
        progress(len(table.anchors), count)
        new.append(anchor is not None)
        if coverage < 1.0 and len(new) == _WINDOW and sum(new) <= (1.0 - coverage) * _WINDOW:
            break
    return CoverageReport(count, undecided, True)


def covered(table: TabulatedSolver, points: Iterable[OperatingPoint], count: int) -> float:
    """Return the part of the next `count` points that a table answers."""
    answers = [table.covers(point) for point in islice(points, count)]
    return sum(answers) / len(answers) if answers else math.nan


def _useful(table: TabulatedSolver, point: OperatingPoint) -> SpectralExpansion | None:
    """Return an anchor at a point; None where it would not answer at its own point."""
    try:
        anchor = expand_spectrum(table.model, point, degree=table.settings.degree)
    except np.linalg.LinAlgError:
        return None
    alone = TabulatedSolver(table.model, table.settings, tolerances=table.tolerances,
                            anchors=[anchor])
    return anchor if alone.covers(point) else None


def braking_points(model: BrakeModel, speeds: Sequence[float], pressures: Sequence[float],
                   frictions: Sequence[float], *, release_pressure: float,
                   minimum_rotor_speed: float) -> list[OperatingPoint]:
    """Return the points of a drive at which a brake slides under load, sample by sample."""
    return [model.operating_point(rotor_speed=speed, pressure=pressure, friction=friction)
            for speed, pressure, friction in zip(speeds, pressures, frictions, strict=True)
            if pressure >= release_pressure and speed >= minimum_rotor_speed]
