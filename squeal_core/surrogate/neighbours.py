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

"""Operating points near each other: where to make the next anchor, so that it serves longest."""

from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
import math

from squeal_core.brake.operating_point import OperatingPoint

_MAGNITUDES = ('rotor_speed', 'contact_pressure', 'contact_stiffness', 'friction')
_AHEAD = 0.6  # of the way from the last anchor: how far beyond a point the next one is made
_DRIFT = 2.0  # ratio of a parameter over that way from which on it is a jump
_ALIKE = 0.1  # relative difference of parameters up to which one anchor is enough for the time
# logarithms of ratios up to which one anchor between two points serves both
_SHARED = {'rotor_speed': 0.3, 'contact_pressure': 0.4, 'contact_stiffness': 0.05,
           'friction': 0.15}


def ahead(point: OperatingPoint, behind: OperatingPoint, part: float = _AHEAD) -> OperatingPoint:
    """
    Return a point further on the way from one behind: an anchor serves on both sides of it.

    A long way, or one through a change of sign, is no drift; the point itself then.
    """
    there = {}
    for name in _MAGNITUDES:
        here, before = getattr(point, name), getattr(behind, name)
        if here == before:
            continue
        ratio = here / before if before else 0.0
        if not 1.0 / _DRIFT < ratio < _DRIFT:
            return point
        # as speed falls where a vehicle slows down, and pressure rises and falls
        there[name] = here * min(max(1.0 + part * (1.0 - 1.0 / ratio), 1.0 / _DRIFT), _DRIFT)
    slope = point.friction_slope
    return replace(point, **there, friction_slope=slope + part * (slope - behind.friction_slope))


class Trail:
    """Where some points were, which tells where they will be."""

    def __init__(self) -> None:
        self._marks: deque[tuple[int, tuple[OperatingPoint, ...]]] = deque()

    def foreseen(self, points: Sequence[OperatingPoint], now: int,
                 horizons: Sequence[int]) -> list[list[OperatingPoint]]:
        """
        Return where points are going to be; they themselves, where nothing is known of before.

        Parameters
        ----------
        points : sequence of OperatingPoint
            As many each time, or all begins anew.
        now : int
            The present, in whatever it is counted.
        horizons : sequence of int
            How far ahead; from a quarter of the farthest as far back it is told.

        """
        marks = self._marks
        if marks and len(marks[0][1]) != len(points):
            marks.clear()
        marks.append((now, tuple(points)))
        while len(marks) > 2 and 4 * (now - marks[1][0]) >= max(horizons):
            marks.popleft()
        then, before = marks[0]
        if then == now:
            return [list(points)] * len(horizons)
        return [[ahead(point, behind, horizon / (now - then))
                 for point, behind in zip(points, before, strict=True)] for horizon in horizons]


def alike(one: OperatingPoint, other: OperatingPoint) -> bool:
    """Whether two points are as near each other as those of both brakes of an axle."""
    return all(abs(getattr(one, name) - there) <= _ALIKE * abs(there)
               for name, there in other.__dict__.items() if name != 'friction_slope')


def amid(point: OperatingPoint, company: Iterable[OperatingPoint]) -> OperatingPoint:
    """Return the point amid those that could share an anchor with one of them."""
    near = [other for other in company if _share(point, other)]
    if all(other == point for other in near):
        return point
    means = {name: getattr(point, name) * math.exp(
        sum(_logarithm(one, point, name) for one in near) / len(near)) for name in _MAGNITUDES}
    return replace(point, **means, friction_slope=(
        sum(one.friction_slope for one in near) / len(near)))


def _share(one: OperatingPoint, other: OperatingPoint) -> bool:
    return all(abs(_logarithm(one, other, name)) <= most for name, most in _SHARED.items())


def _logarithm(one: OperatingPoint, other: OperatingPoint, name: str) -> float:
    """Return the logarithm of the ratio of a parameter; infinite over zero or a change of sign."""
    here, there = getattr(one, name), getattr(other, name)
    if here == there:
        return 0.0
    return math.log(here / there) if here * there > 0.0 else math.inf
