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

"""The search for a stability boundary, on growth rates that are known in closed form."""

from collections.abc import Callable
import math

import numpy as np
import pytest
from squeal_core.common.arrays import ComplexArray, FloatArray, IndexArray
from squeal_core.stability.boundaries import Crossing
from squeal_core.stability.boundary_search import BoundarySearch, linear_walk

Growth = Callable[[FloatArray], FloatArray]
OMEGA = 2.0 * math.pi * 3210.0  # rad/s
CURVES: dict[str, tuple[Growth, float]] = {  # growth rate [1/s] over friction; where it is zero
    'straight': (lambda mu: 300.0 * (mu - 0.2731), 0.2731),
    'nearly flat': (lambda mu: 0.4 * (mu - 0.2731), 0.2731),
    'steep': (lambda mu: np.expm1(40.0 * (mu - 0.2731)), 0.2731),
    'cubic': (lambda mu: 1e6 * (mu - 0.2731)**3, 0.2731),
    'merging': (lambda mu: 400.0 * np.sqrt(np.maximum(mu - 0.25, 0.0)) - 2.0, 0.25 + 2.5e-5),
    'plateau': (lambda mu: np.maximum(0.01 * (mu - 0.9), 1e4 * (mu - 0.2731)), 0.2731),
    'kink': (lambda mu: np.maximum(3.0 * mu - 2.0, 900.0 * (mu - 0.2731)), 0.2731)}


class Evaluator:
    """Eigenvalues by growth rates, in calls that are counted; NaN outside the known range."""

    def __init__(self, *growth: Growth, known: tuple[float, float] = (-1.0, 2.0)) -> None:
        self.growth, self.known, self.calls = growth, known, 0

    def __call__(self, rows: IndexArray, values: FloatArray) -> ComplexArray:
        self.calls += 1
        return np.array([np.where((row >= self.known[0]) & (row <= self.known[1]),
                                  self.growth[i](row) + 1j * OMEGA, np.nan)
                         for i, row in zip(rows, values, strict=True)])

    def at(self, value: float) -> ComplexArray:
        return self(np.arange(len(self.growth)), np.full((len(self.growth), 1), value))[:, 0]


def found(evaluator: Evaluator, start: float = 0.0, end: float = 1.0, *, batch: int = 1,
          width: float = 1e-6, level: float = 0.0, first: FloatArray | None = None) -> Crossing:
    search = BoundarySearch(parameter='friction', level=level, width=width, trials=batch)
    walk = linear_walk(start if first is None else float(first[-1]), end, 0.02)
    values = [walk[:, i:i + batch] for i in range(0, walk.shape[1], batch)]
    here = evaluator.at(start)
    evaluator.calls = 0
    return search(np.array([start]), here, values if first is None else [first[None], *values],
                  evaluator).crossings()[0]


@pytest.mark.parametrize('start', [0.0, 0.42])
@pytest.mark.parametrize('batch', [1, 2, 4, 8])
@pytest.mark.parametrize('name', CURVES)
def test_growth_rates_in_closed_form(name: str, batch: int, start: float) -> None:
    growth, zero = CURVES[name]
    evaluator = Evaluator(growth)
    crossing = found(evaluator, start, 1.0 - start, batch=batch) if start == 0.0 else found(
        evaluator, start, 0.0, batch=batch)
    assert crossing.converged
    assert crossing.value == pytest.approx(zero, abs=1e-6)
    low, high = sorted(crossing.bracket)
    assert low <= zero <= high
    assert high - low <= 1e-6
    np.testing.assert_array_equal(crossing.growth_rates, growth(np.array(crossing.bracket)))
    assert crossing.frequency_hz == pytest.approx(3210.0)
    assert crossing.reason == f'stability boundary mu = {zero:.4g} (3210 Hz), stable below'
    walked = math.ceil(abs(zero - start) / 0.02 / batch)
    bisections = math.ceil(math.log(0.02 / 1e-6, batch + 1))
    # every other one is bisection's where a chord says little
    assert evaluator.calls - walked <= (
        2 * bisections if name in ('cubic', 'merging', 'plateau') else bisections)


def test_a_straight_line_takes_few_solves() -> None:
    evaluator = Evaluator(CURVES['straight'][0])
    assert found(evaluator, 0.26).solves <= 7  # 15 by bisection
    assert found(evaluator, 0.26, batch=4, width=1e-3).value == pytest.approx(0.2731, abs=1e-9)


def test_the_level_counts_as_stable() -> None:
    """A growth rate that grazes the level is stable; one that exceeds it is not."""
    def hump(mu: FloatArray) -> FloatArray:
        return 0.01 - (mu - 0.5)**2

    level = float(hump(np.array([0.5]))[0])
    grazing = found(Evaluator(hump), level=level)
    assert math.isnan(grazing.value)
    assert not grazing.converged
    assert grazing.reason == (
        'no stability boundary from mu = 0 to 1, stable')
    over = found(Evaluator(hump), level=0.0)
    assert over.value == pytest.approx(0.4, abs=1e-6)  # the nearer one of two
    assert found(Evaluator(hump), 0.5, 1.0).value == pytest.approx(0.6, abs=1e-6)
    assert found(Evaluator(hump), 0.5, 1.0).reason.endswith('stable above')


@pytest.mark.parametrize('batch', [1, 4])
def test_the_nearest_of_several_boundaries(batch: int) -> None:
    crossing = found(Evaluator(lambda mu: np.sin(20.0 * mu) - 0.5), batch=batch)
    assert crossing.value == pytest.approx(math.asin(0.5) / 20.0, abs=1e-6)


@pytest.mark.parametrize('batch', [1, 4])
@pytest.mark.parametrize('outside', [-math.inf, -3.0])
def test_a_mode_that_enters_the_band_is_a_jump(outside: float, batch: int) -> None:
    crossing = found(Evaluator(lambda mu: np.where(mu < 0.2731, outside, 5.0 + 10.0 * mu)),
                     batch=batch)
    assert crossing.value == pytest.approx(0.2731, abs=1e-6)
    assert not crossing.converged
    assert crossing.reason == ('stability boundary mu = 0.2731 (3210 Hz), stable below, by a '
                               'jump: a mode leaves or enters the band or the group')


@pytest.mark.parametrize('estimate', [0.2731, 0.27, 0.25, 0.3, 0.35])
def test_an_estimate_saves_the_walk_and_cannot_mislead(estimate: float) -> None:
    """Right, or wrong by up to four of the walk's steps."""
    evaluator = Evaluator(CURVES['steep'][0])
    first = estimate + np.array([-0.02, -0.004, -0.001, 0.001, 0.004, 0.02])
    crossing = found(evaluator, first=first, batch=4, width=1e-3)
    assert crossing.value == pytest.approx(0.2731, abs=1e-5)
    assert evaluator.calls <= (3 if abs(estimate - 0.2731) < 0.02 else 7)
    assert found(Evaluator(lambda mu: mu - 2.0), first=first).bracket == (0.0, 1.0)


def test_where_the_table_does_not_answer() -> None:
    growth = CURVES['straight'][0]
    beyond = found(Evaluator(growth, known=(0.1, 0.5)), 0.42, 0.0, batch=4)
    assert beyond.value == pytest.approx(0.2731, abs=1e-6)
    short = found(Evaluator(growth, known=(0.3, 0.5)), 0.42, 0.0, batch=4)
    assert math.isnan(short.value)
    assert short.bracket[1] >= 0.3
    assert short.reason == ('no stability boundary from mu = 0.42 to 0.3, unstable; outside the '
                            'table beyond it')


def test_a_gap_of_the_table_in_the_bracket() -> None:
    def evaluate(_: IndexArray, values: FloatArray) -> ComplexArray:
        return np.where((values > 0.262) & (values < 0.278), np.nan,
                        values - 0.2731 + 1j * OMEGA)

    search = BoundarySearch(parameter='friction', level=0.0, width=1e-4)
    crossing = search(np.array([0.26]), np.array([-0.0131 + 1j * OMEGA]),
                      [linear_walk(0.26, 1.0, 0.02)], evaluate).crossings()[0]
    assert math.isnan(crossing.value)
    assert 'outside the table' in crossing.reason


def test_no_way_to_go() -> None:
    crossing = found(Evaluator(CURVES['straight'][0]), 0.4, 0.4)
    assert crossing.bracket == (0.4, 0.4)
    assert math.isnan(crossing.value)
    assert crossing.solves == 0


def test_searches_side_by_side_are_those_alone() -> None:
    """One evaluation for all that are not over; the results are those one by one, bit for bit."""
    curves = [growth for growth, _ in CURVES.values()]
    search = BoundarySearch(parameter='friction', level=0.01, width=1e-5, trials=4)
    walk = linear_walk(0.42, 0.0, 0.02)
    start, alone = np.array([0.42]), [Evaluator(curve) for curve in curves]
    expected = [search(start, one.at(0.42), [walk], one).crossings()[0] for one in alone]
    together, count = Evaluator(*curves), len(curves)
    results = search(np.repeat(start, count), together.at(0.42), [np.repeat(walk, count, axis=0)],
                     together)
    assert results.crossings() == expected
    assert together.calls < sum(one.calls for one in alone) / 3
