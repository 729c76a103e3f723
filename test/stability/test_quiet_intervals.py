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

"""Quiet intervals: against closed forms and scans, with pockets between values of the scan."""

import math

import numpy as np
import pytest
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.boundaries import NO_MODE
from squeal_core.stability.quiet_intervals import nearest_quiet, quiet_intervals, QuietInterval

BOUNDS = (1e5, 1e7)


class Valley:
    """Growth = slope |ln(p / centre)| - depth: quiet between centre exp(-+ depth / slope)."""

    def __init__(self, centre: float, slope: float, depth: float, sign: float = 1.0) -> None:
        self.centre, self.slope, self.depth, self.sign = centre, slope, depth, sign
        self.values = 0

    def __call__(self, values: FloatArray) -> ComplexArray:
        self.values += values.size
        growth = self.slope * np.abs(np.log(values / self.centre)) - self.depth
        return np.asarray(self.sign * growth + 1j * (1e4 + np.log(values)))

    @property
    def ends(self) -> tuple[float, float]:
        half = math.exp(self.depth / self.slope)
        return self.centre / half, self.centre * half


def found_by(growth: Valley, level: float = 0.0) -> tuple[QuietInterval, ...]:
    return quiet_intervals('pressure', BOUNDS, growth, level=level, together=True)


def ends(found: tuple[QuietInterval, ...]) -> list[float]:
    return [end.value for one in found for end in one]


@pytest.mark.parametrize('depth', [30.0, 1.0, 0.1])
def test_a_quiet_valley_narrower_than_the_steps_of_the_scan(depth: float) -> None:
    growth = Valley(7.3e5, 10.0, depth)  # from e^6 wide down to 2 % where steps are 20 %
    found = found_by(growth)
    low, high = (min(max(end, BOUNDS[0]), BOUNDS[1]) for end in growth.ends)
    assert ends(found) == pytest.approx([low, high], rel=1e-3)
    assert all(end.growth_rate <= 0.0 for one in found for end in one)
    assert growth.values < 120


@pytest.mark.parametrize('depth', [3.0, 0.1])
def test_an_unstable_ridge_divides_what_is_quiet(depth: float) -> None:
    growth = Valley(2.1e6, 10.0, depth, sign=-1.0)
    first, second = found_by(growth)
    assert (first.low.value, first.low.kind) == (BOUNDS[0], 'limit')
    assert (second.high.value, second.high.kind) == (BOUNDS[1], 'limit')
    assert (first.high.kind, second.low.kind) == ('boundary', 'boundary')
    assert (first.high.value, second.low.value) == pytest.approx(growth.ends, rel=1e-3)
    assert first.high.frequency_hz == pytest.approx(1e4 / math.tau, rel=0.01)


def test_ends_are_quiet_by_what_was_evaluated() -> None:
    growth = Valley(7.3e5, 10.0, 5.0)
    found = found_by(growth, level=-0.1)
    assert growth(np.array(ends(found))).real.max() <= -0.1
    assert growth(np.array(ends(found)) * [0.998, 1.002]).real.min() > -0.1


def test_all_or_nothing_is_quiet() -> None:
    always = quiet_intervals('pressure', BOUNDS, lambda p: np.full(p.size, NO_MODE), level=0.0,
                             together=True)
    assert ends(always) == [*BOUNDS]
    assert [end.kind for end in always[0]] == ['limit', 'limit']
    assert found_by(Valley(7.3e5, 10.0, -1.0)) == ()


def test_what_is_not_known_is_not_quiet_and_ends_an_interval() -> None:
    def growth(values: FloatArray) -> ComplexArray:
        return np.where(values > 2e6, complex(math.nan, math.nan), -1.0 + 1e4j)

    only, = quiet_intervals('pressure', BOUNDS, growth, level=0.0, together=True)
    assert (only.low.value, only.low.kind, only.high.kind) == (BOUNDS[0], 'limit', 'unknown')
    assert 1.6e6 < only.high.value <= 2e6


def test_nearest_quiet_values() -> None:
    found = found_by(Valley(2.1e6, 10.0, 3.0, sign=-1.0))
    (_, below), (above, _) = ((one.low.value, one.high.value) for one in found)
    assert nearest_quiet(found, 2e6) == (below, above)
    assert nearest_quiet(found, 2e5) == (2e5, 2e5)  # quiet already
    only = found_by(Valley(7.3e5, 10.0, 5.0))
    assert nearest_quiet(only, 9e6) == pytest.approx((only[0].high.value, math.nan), nan_ok=True)
    assert nearest_quiet(only, 2e5) == pytest.approx((math.nan, only[0].low.value), nan_ok=True)
