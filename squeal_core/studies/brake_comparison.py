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

"""Brakes side by side: their modes matched, growth, critical friction; models and tables."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
import math
from typing import NamedTuple, TypeAlias

import numpy as np
from squeal_core.brake.operating_point import OperatingPoint
from squeal_core.common.errors import SquealError
from squeal_core.model.brake_model import BrakeModel
from squeal_core.stability.boundaries import NO_MODE
from squeal_core.stability.boundary_search import BoundarySearch, one_by_one
from squeal_core.stability.eigensolution import Mode, Tolerances
from squeal_core.stability.mode_matching import (
    frictionless_modes,
    match_modes,
    ModeMatch,
    ModeShapes,
)
from squeal_core.stability.mode_name import short_name
from squeal_core.stability.mode_tracking import follow, identify, track, Tracked
from squeal_core.stability.parameter_paths import between, moved
from squeal_core.surrogate.expansion_table import ExpansionTable

_SAMPLES = 41  # of friction, between which a boundary is looked for
_WIDTH = 1e-4  # of the bracket of a critical friction

Progress: TypeAlias = Callable[[str], None]


class ComparedMode(NamedTuple):
    """
    A mode of one brake.

    Attributes
    ----------
    identity : str
        Its number; of modes that merged those of all, as '13/14'. Of a table its place in order
        of frequency.
    frictionless_hz : float
        Frequency without friction; NaN from a table.
    frequency_hz, growth_rate, damping_ratio : float
        At the point; NaN where it does not oscillate any more.
    unstable : bool
    critical_friction : float
        From which on it is unstable; NaN where it is stable up to the bound, or not known.
    component : str
        Its short name at the point.

    """

    identity: str
    frictionless_hz: float
    frequency_hz: float
    growth_rate: float
    damping_ratio: float
    unstable: bool
    critical_friction: float
    component: str = ''


@dataclass(frozen=True, eq=False)
class ComparedBrake:
    """
    One brake of a comparison.

    Parameters
    ----------
    name : str
    modes : tuple of ComparedMode
        Those that oscillate, by frequency without friction.
    shapes : ModeShapes
        Of these modes.
    boundaries_known : bool
        Whether critical frictions are; a table does not follow modes.

    """

    name: str
    modes: tuple[ComparedMode, ...]
    shapes: ModeShapes
    boundaries_known: bool = True


@dataclass(frozen=True, eq=False)
class BrakeComparison:
    """
    Brakes side by side; the others are matched with the first one.

    Parameters
    ----------
    brakes : sequence of ComparedBrake
    matches : sequence of ModeMatch
        Of the modes of the first among those of each other.

    """

    brakes: Sequence[ComparedBrake]
    matches: Sequence[ModeMatch]

    def rows(self) -> list[list[ComparedMode | None]]:
        """Return the modes of each brake that are one, and then those that only others have."""
        first, *others = self.brakes
        rows = [[mode, *(None if match.places[i] < 0 else other.modes[match.places[i]]
                         for other, match in zip(others, self.matches, strict=True))]
                for i, mode in enumerate(first.modes)]
        for place, (other, match) in enumerate(zip(others, self.matches, strict=True), 1):
            known = set(match.places.tolist())
            rows += [[mode if i == place else None for i in range(len(self.brakes))]
                     for own, mode in enumerate(other.modes) if own not in known]
        return rows


def compare_brakes(brakes: Sequence[ComparedBrake]) -> BrakeComparison:
    """Match the modes of brakes with those of the first."""
    first, *others = brakes
    return BrakeComparison(brakes, [match_modes(*_alike(first, other)) for other in others])


def mac_of(result: BrakeComparison, row: Sequence[ComparedMode | None], place: int) -> float:
    """Return the MAC of the mode of a brake with that of the first; NaN: there is none."""
    if place == 0 or row[0] is None or row[place] is None:
        return math.nan
    return float(result.matches[place - 1].mac[result.brakes[0].modes.index(row[0])])


def _alike(first: ComparedBrake, other: ComparedBrake) -> tuple[ModeShapes, ModeShapes]:
    """Return the shapes of two brakes; beside a table frequencies at the point."""
    if first.boundaries_known and other.boundaries_known:
        return first.shapes, other.shapes
    result = [ModeShapes(np.array([mode.frequency_hz for mode in one.modes]))
              for one in (first, other)]
    return result[0], result[1]


def compared_model(name: str, model: BrakeModel, point: OperatingPoint, *,
                   bounds: tuple[float, float] = (0.0, 1.0),
                   progress: Progress = lambda _: None) -> ComparedBrake:
    """
    Return the modes and shapes of a model for a comparison.

    Parameters
    ----------
    name : str
        Of the brake.
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Where growth is compared.
    bounds : (2,) floats
        Of the friction in which stability boundaries are looked for.
    progress : callable
        Told in a few words what is being done.

    """
    progress(f'{name}: modes and critical friction')
    start, shapes = frictionless_modes(model, point)
    here = identify(model, point)
    names, critical = _short_names(model, here), critical_frictions(model, point, bounds)
    still = start.modes[model.size - shapes.frequencies_hz.size:]  # those that oscillate
    modes = [_at_point(here, mode.index, mode.frequency_hz, critical, names) for mode in still]
    return ComparedBrake(name, tuple(modes), shapes)


def _short_names(model: BrakeModel, here: Tracked) -> dict[Mode, str]:
    vectors = here.spectrum.right[-model.size:].T  # of the last modes
    return {mode: short_name(model, vector) for mode, vector in zip(
        here.modes[-len(vectors):], vectors, strict=True)}


def _at_point(here: Tracked, number: int, hertz: float, critical: dict[int, float],
              names: dict[Mode, str]) -> ComparedMode:
    """Return the mode of a number."""
    mode, limit = here.mode(number), critical.get(number, math.nan)
    if mode is None:
        return ComparedMode(str(number), hertz, math.nan, math.nan, math.nan, False, limit)
    return ComparedMode(str(here.identity(mode)), hertz, mode.frequency_hz, mode.growth_rate,
                        mode.damping_ratio, mode.unstable, limit, names[mode])


def critical_frictions(model: BrakeModel, point: OperatingPoint,
                       bounds: tuple[float, float]) -> dict[int, float]:
    """
    Return the friction from which each mode is unstable, by its number.

    Parameters
    ----------
    model : BrakeModel
        Modal brake model.
    point : OperatingPoint
        Its friction changes, and the slope in proportion.
    bounds : (2,) floats
        Of the search; a mode that is stable all over has no entry.

    Notes
    -----
    All modes are followed together over 41 values, and each boundary is narrowed between two of
    them; two within one step pass unseen.

    """
    limits = Tolerances.of(model, point)
    sign = math.copysign(1.0, point.rotor_speed)
    values = [sign * value for value in np.linspace(*bounds, _SAMPLES).tolist()]
    points = [moved(model, point, 'friction', value) for value in values]
    result: dict[int, float] = {}
    before: Tracked | None = None
    for place, here in enumerate(track(model, points, tolerances=limits)):
        for number in _fluttering(here) - result.keys():
            result[number] = abs(values[place]) if before is None else abs(_boundary(
                model, point, number, (values[place - 1], values[place]), before, limits))
        before = here
    return result


def _fluttering(here: Tracked) -> set[int]:
    """Return the numbers of unstable modes; of those that merged the lowest come first."""
    counts = Counter(identity.numbers for mode, identity in zip(
        here.modes, here.identities, strict=True) if mode.kind == 'flutter')
    return {number for numbers, count in counts.items() for number in numbers[:count]}


def _boundary(model: BrakeModel, point: OperatingPoint, number: int,
              ends: tuple[float, float], start: Tracked, limits: Tolerances) -> float:
    """Return the friction between two at which a mode becomes unstable."""
    def eigenvalue(value: float) -> complex:
        here = start if value == ends[0] else follow(
            model, between(model, moved(model, point, 'friction', ends[0]),
                           moved(model, point, 'friction', value)), start, tolerances=limits)
        return _worst(here.of((number,)))

    search = BoundarySearch(parameter='friction', level=limits.growth, width=_WIDTH)
    crossing = search(np.array([ends[0]]), np.array([eigenvalue(ends[0])]),
                      [np.array([[ends[1]]])], one_by_one(eigenvalue))
    value = float(crossing.values[0])
    return ends[1] if math.isnan(value) else value


def _worst(modes: Sequence[Mode]) -> complex:
    oscillating = [mode.eigenvalue for mode in modes if mode.kind in ('flutter', 'stable')]
    return max(oscillating, key=lambda eigenvalue: eigenvalue.real, default=NO_MODE)


def compared_table(name: str, table: ExpansionTable, model: BrakeModel,
                   point: OperatingPoint) -> ComparedBrake:
    """
    Return the modes of a table at a point; it has neither shapes nor identities.

    Parameters
    ----------
    name : str
        Of the table.
    table : ExpansionTable
        Of the model.
    model : BrakeModel
        Whose table it is.
    point : OperatingPoint
        Where growth is compared.

    Raises
    ------
    SquealError
        Where the table does not answer.

    """
    limits = Tolerances.of(model)
    result = table.evaluate(table.domain.places(model, [point]), limits)
    if not result.answered[0]:
        raise SquealError(
            f'{name}: does not answer at the point: outside the range that `squeal info` shows, '
            'too near to a boundary, or not on the friction law; give --friction-law or another '
            'point')
    modes = [ComparedMode(str(mode.index), math.nan, mode.frequency_hz, mode.growth_rate,
                          mode.damping_ratio, mode.unstable, math.nan)
             for mode in result.listed()[0].modes if mode.kind in ('flutter', 'stable')]
    return ComparedBrake(name, tuple(modes), ModeShapes(np.array(
        [mode.frequency_hz for mode in modes])), boundaries_known=False)
