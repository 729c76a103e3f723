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

"""Margins by a table: their range, confirmation, calls."""

from dataclasses import dataclass, replace
from functools import partial
import math

import numpy as np
import pytest
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import FloatArray
from squeal_core.monitor.friction_scan import FrictionScan
from squeal_core.monitor.margin_evaluator import MarginEvaluator, NO_TABLE, table_growth
from squeal_core.monitor.margins import Margin, Margins, OTHERS
from squeal_core.monitor.tick_turns import is_due
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import SQUEAL_BAND, Tolerances
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from support.brake_monitors import feed, GOOD, monitor, TICK
from support.margin_searches import (
    evaluator,
    flutter,
    friction_margins,
    FullSolutions,
    HERE,
    SETTINGS,
)

SECOND = 1_000_000_000


def test_look_up_in_a_table() -> None:
    """Random conditions; the boundary is within what the table's error makes of it."""
    model = flutter(5e-4, negative_slope=np.diag([2e-5, 1e-5]), friction_law=FrictionLaw())
    limits = Tolerances.of(model)
    table = build_table(model, TableDomain.usual(
        model, rotor_speed=(6.0, 12.0), preload=(1000.0, 2200.0), friction=(0.3, 0.5)))
    growth = partial(table_growth, table, model, limits, SQUEAL_BAND)
    margins = MarginEvaluator(model, replace(SETTINGS, friction=table.domain.friction), limits,
                              growth=growth)
    rng = np.random.default_rng(3)
    conditions = [SlidingConditions(rotor_speed=rng.uniform(6.0, 12.0), friction=friction,
                                    pressure=rng.uniform(1000.0, 2200.0) / 2.5e-3)
                  for friction in rng.uniform(0.31, 0.49, 12).tolist()]
    for at, found in zip(conditions, friction_margins(margins, conditions), strict=True):
        alone, = friction_margins(margins, [at])
        assert alone.critical == pytest.approx(found.critical, abs=1e-12)  # sums in other order
        exact = critical_value(model, model.operating_point(**vars(at)), 'friction', (0.3, 0.5),
                               samples=10).nearest
        assert exact.converged
        assert found.critical == pytest.approx(exact.value, abs=1e-4)
        assert margins.confirm(found, at).confirmed
    outside, = friction_margins(margins, [replace(HERE, rotor_speed=20.0)])
    assert outside.reason.endswith('outside the table beyond it')


def test_without_a_table() -> None:
    model = flutter(5e-4)
    margins = MarginEvaluator(model, SETTINGS, Tolerances.of(model))
    found, = friction_margins(margins, [HERE])
    assert math.isnan(found.value)
    assert found.reason == NO_TABLE
    assert 'squeal tabulate' in found.reason
    assert margins.friction_margins([], []) == []


def test_outside_the_table() -> None:
    """The boundary is at 0.42; the table ends before."""
    model = flutter(5e-4)
    found, = friction_margins(evaluator(FullSolutions(model, friction=(0.0, 0.37))), [HERE])
    assert math.isnan(found.value)
    assert found.reason == ('no stability boundary from mu = 0.3 to 0.36, stable; outside the '
                            'table beyond it')


@pytest.mark.parametrize('rate', [100.0, 40.0])
def test_margins_are_confirmed_at_ticks_that_evaluate_no_risks(rate: float) -> None:
    """Both take long; risks are evaluated 20 times a second of absolute time."""
    watch = monitor(rate=rate, margin_confirm_interval=1.0,
                    **{f'a.{signal}.max_age': 10.0 for signal in GOOD})
    feed(watch, TICK, **GOOD)
    ticks = range(TICK, TICK + 4 * SECOND, round(SECOND / rate))
    contexts = [watch.prepare(tick, watch.read(tick)) for tick in ticks]
    confirmed = [one.time for one in contexts if getattr(one, 'confirm', False)]
    assert np.diff(confirmed).tolist() == 3 * [SECOND]
    assert not any(tick % (SECOND // 20) == 0 for tick in confirmed)


def test_confirmation_by_one_full_solution() -> None:
    """A table whose growth rates are off by 0.2 1/s is found out; one by 0.05 1/s passes."""
    model = flutter(5e-4)
    for off, confirmed in ((0.05, True), (0.2, False), (-0.2, False)):
        margins = evaluator(FullSolutions(model, off=off))
        before, = friction_margins(margins, [HERE])
        assert not before.confirmed
        after = margins.confirm(before, HERE)
        assert after.confirmed == confirmed
        assert (margins.statistics.confirmed, margins.statistics.not_confirmed) == (
            confirmed, not confirmed)
        if confirmed:
            assert replace(after, confirmed=False) == before
        else:
            assert math.isnan(after.value)
            assert 'not confirmed, a full solution has a growth rate of' in after.reason


def test_confirmations_are_of_absolute_time() -> None:
    """Once an interval, one brake after the other, wherever the ticks begin."""
    period, interval = SECOND // 100, 10 * SECOND
    due = {brake: [tick * period for tick in range(123_400, 126_400) if is_due(
        tick * period, period, interval, brake, 4)] for brake in range(4)}
    assert [len(times) for times in due.values()] == [3, 3, 3, 3]
    assert all(np.diff(times).tolist() == [interval, interval] for times in due.values())
    assert [times[0] % interval for times in due.values()] == [  # the first tick of an interval
        0, 3 * interval // 4, interval // 2, interval // 4]
    assert not is_due(20 * SECOND, period, 0, 0, 4)
    assert is_due(20 * SECOND, 20 * SECOND, interval, 3, 4)  # a slower tick: each time


@dataclass
class Estimate:
    """A scan that has the same critical friction everywhere."""

    zero: float

    def nearest(self, rows: FloatArray, side: FloatArray) -> FloatArray:
        beyond = side[:, 0] * (self.zero - rows[:, 2]) > 0.0
        return np.where(beyond, self.zero, side[:, 0] * np.inf)


def test_a_scan_searches_points_once_and_interpolates() -> None:
    """Critical frictions that are linear in ln speed and ln pressure are given as they are."""
    asked: list[FloatArray] = []

    def critical(speed: FloatArray, pressure: FloatArray) -> FloatArray:
        return 0.3 + 0.02 * np.log(speed / 20.0) + 0.05 * np.log(pressure / 1e6)

    def growth(rows: FloatArray) -> FloatArray:
        asked.append(rows)
        found = np.exp(30.0 * (rows[:, 2] - critical(rows[:, 0], rows[:, 1]))) - 1.0
        return np.where(rows[:, 0] > 30.0, np.nan, found)

    scan = FrictionScan(growth, 0.0, friction=(0.0, 0.65), rotor_speed=(5.0, 50.0),
                        pressure=(1e5, 1e7))
    speeds, pressures = np.array([10.0, 20.3, 40.0]), np.array([1e6, 1.1e6, 1e6])
    for friction, side in ((0.5, -1.0), (0.1, 1.0)):
        rows = np.column_stack([speeds, pressures, np.full(3, friction)])
        for count in (2, 3):
            found = scan.nearest(rows[:count], np.full((count, 1), side))
            assert found[:2] == pytest.approx(critical(speeds, pressures)[:2], abs=2e-4)
        assert np.isinf(found[2])  # outside of what is known
        assert np.isinf(scan.nearest(rows, np.full((3, 1), -side))).all()
    points = np.unique(np.concatenate(asked)[:, :2], axis=0)
    assert len(points) == 12
    assert sum(map(len, asked)) == 12 * 34 + 8 * 17  # once, and where boundaries are


@pytest.mark.parametrize('friction', [0.3, 0.55])
@pytest.mark.parametrize('zero', [0.41, 0.412, 0.42, 0.35, 0.5, 0.7])
def test_a_scan_saves_look_ups_and_cannot_mislead(zero: float, friction: float) -> None:
    """The boundary is at 0.412; whatever the scan says, that is what comes out."""
    model, at = flutter(5e-4), replace(HERE, friction=friction)
    expected, = friction_margins(evaluator(FullSolutions(model)), [at])
    growth = FullSolutions(model)
    found, = friction_margins(evaluator(growth, scan=Estimate(zero)), [at])
    assert found.critical == pytest.approx(expected.critical, abs=2e-5)
    if abs(zero - 0.412) < 0.02:
        assert (growth.points, growth.calls) <= ((6, 1) if zero == 0.412 else (22, 3))


def test_other_margins_are_computed_where_somebody_asks_for_them() -> None:
    growth = FullSolutions(flutter(5e-4))
    margins = evaluator(growth)
    found, = friction_margins(margins, [HERE])
    growth.calls = 0
    both = Margins(found, partial(margins.other_margin, HERE))
    assert growth.calls == 0
    assert both.compute_other is not None
    assert all(isinstance(both.compute_other(name), Margin) for name in OTHERS)
    assert growth.calls > 0
