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

"""Margins: closed forms, full solutions, estimates by a map, confirmation, brakes together."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
import math
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.monitor.margin_evaluator import MarginEvaluator, NO_TABLE, table_growth
from squeal_core.monitor.margins import (
    confirmation_due,
    Kind,
    least_stable,
    Margin,
    Margins,
    MarginSettings,
    OtherMargin,
    OTHERS,
)
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, SQUEAL_BAND, Tolerances
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain

HERE = SlidingConditions(rotor_speed=10.0, pressure=1e6, friction=0.3)
W1, W2, DAMPING = 1e4, 1.02e4, 40.0
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])
SETTINGS = MarginSettings(band_hz=SQUEAL_BAND, friction=(0.0, 0.9), rotor_speed=(0.5, 200.0),
                          pressure=(2e4, 1.6e7), error=0.1)
SECOND = 1_000_000_000


class FullSolutions:
    """Look-up by full solutions, counted; as a table off by some growth rate or of some range."""

    def __init__(self, model: BrakeModel, band_hz: tuple[float, float] = SQUEAL_BAND, *,
                 off: float = 0.0, friction: tuple[float, float] = (-1.0, 2.0)) -> None:
        self.model, self.band_hz, self.off, self.friction = model, band_hz, off, friction
        self.calls, self.points = 0, 0

    def __call__(self, rows: FloatArray, kind: Kind) -> ComplexArray:
        self.calls += 1
        self.points += len(rows)
        return np.array([self._at(kind, *row) for row in rows.tolist()])

    def _at(self, kind: Kind, speed: float, pressure: float, friction: float) -> complex:
        if not self.friction[0] <= friction <= self.friction[1]:
            return complex(math.nan, math.nan)
        point = self.model.operating_point(rotor_speed=speed, pressure=pressure,
                                           friction=friction)
        modes = complex_modes(self.model, point)
        return complex(least_stable(modes.mode_eigenvalues[None], kind, self.band_hz,
                                    modes.tolerances)[0]) + self.off


def evaluator(growth: FullSolutions, settings: MarginSettings = SETTINGS,
              growth_map: Any = None) -> MarginEvaluator:
    settings = replace(settings, band_hz=growth.band_hz)
    return MarginEvaluator(growth.model, settings, Tolerances.of(growth.model), growth=growth,
                           growth_map=growth_map)


def friction_margins(margins: MarginEvaluator, conditions: Sequence[SlidingConditions]
                     ) -> list[Margin]:
    return margins.friction_margins(conditions, [
        complex_modes(margins.model, margins.model.operating_point(**vars(at))).worst_in(
            *margins.settings.band_hz) for at in conditions])


def flutter(couple: float, **changes: Any) -> BrakeModel:
    """
    Two modes of equal damping: unstable where mu k_c couple exceeds half the split of K, damped.

    (half the split)^2 + d^2 mean = (mu k_c couple)^2, mean that of the squares of frequency.
    """
    return BrakeModel(**{
        'angular_frequencies': np.array([W1, W2]), 'friction_couple': couple * SKEW,
        'damping_ratios': 0.5 * DAMPING / np.array([W1, W2]), 'caliper': Caliper(2.5e-3),
        'nominal_contact_stiffness': 1e10, **changes})


def critical_friction(couple: float) -> float:
    half, mean = 0.5 * (W2**2 - W1**2), 0.5 * (W1**2 + W2**2)
    return math.sqrt(half**2 + DAMPING**2 * mean) / (1e10 * couple)


@pytest.mark.parametrize('friction', [0.1, 0.4, 0.55, 0.8])
@pytest.mark.parametrize('couple', [4e-4, 7e-4])
def test_critical_friction(couple: float, friction: float) -> None:
    """The margin is negative where the brake is unstable, towards more friction where not."""
    growth = FullSolutions(flutter(couple))
    found, = friction_margins(evaluator(growth), [replace(HERE, friction=friction)])
    expected = critical_friction(couple)
    # unstable from a growth rate of 5e-4 1/s on
    assert found.critical == pytest.approx(expected, abs=2e-5)
    assert found.value == pytest.approx(expected - friction, abs=2e-5)
    assert found.frequency_hz == pytest.approx(math.sqrt(0.5 * (W1**2 + W2**2)) / 2 / math.pi,
                                               rel=1e-3)
    assert found.reason == (f'stability boundary mu = {found.critical:.4g} '
                            f'({found.frequency_hz:.0f} Hz), stable below')
    assert growth.calls <= 7


def test_brakes_together_have_the_margins_of_each_alone() -> None:
    growth = FullSolutions(flutter(5e-4))
    conditions = [replace(HERE, friction=0.05 + 0.1 * i, pressure=1e5 * (i + 1))
                  for i in range(8)]
    together = friction_margins(evaluator(growth), conditions)
    calls, growth.calls = growth.calls, 0
    alone = [friction_margins(evaluator(growth), [at])[0] for at in conditions]
    assert [(m.critical, m.value, m.reason) for m in together] == [
        (m.critical, m.value, m.reason) for m in alone]
    assert calls < growth.calls / 4


def falling(**changes: Any) -> BrakeModel:
    """One mode with a damping that a falling friction takes away: growth = (s p0 - d) / 2."""
    return BrakeModel(**{
        'angular_frequencies': np.array([W1]), 'damping_ratios': 0.5 * DAMPING / W1,
        'negative_slope': np.array([[1e-3]]), 'caliper': Caliper(2.5e-3),
        'friction_law': FrictionLaw(decay=1.0), **changes})


def slope_limit(model: BrakeModel, friction: float) -> float:
    """Return the pressure at which the mode is unstable at HERE's speed."""
    law = model.friction_law
    assert law is not None
    slope = law.slope_at(10.0 * model.contact_radius, friction)
    return (DAMPING + 2.0 * Tolerances.of(model).growth) / (1e-3 * -slope) * (
        model.contact_area / 2.5e-3)


def others(margins: MarginEvaluator, at: SlidingConditions) -> dict[OtherMargin, Margin]:
    """Return the margins besides that of friction."""
    return {name: margins.other_margin(at, name) for name in OTHERS}


@pytest.mark.parametrize('times', [0.5, 3.0])
def test_critical_pressure_and_speed(times: float) -> None:
    model = falling()
    limit = slope_limit(model, 0.3)
    found = others(evaluator(FullSolutions(model)), replace(HERE, pressure=times * limit))
    assert found['pressure'].critical == pytest.approx(limit, rel=1e-4)
    assert found['pressure'].reason.startswith('stability boundary pressure = ')
    law, radius, speed = model.friction_law, model.contact_radius, found['rotor_speed']
    assert law is not None
    fall = law.slope_at(speed.critical * radius, 0.3) / law.slope_at(10.0 * radius, 0.3)
    assert times * fall == pytest.approx(1.0, rel=1e-3)
    assert (speed.value > 0.0) == (times > 1.0)  # the faster, the flatter


def test_no_boundary_within_the_bounds() -> None:
    margins = evaluator(FullSolutions(flutter(1e-5)))
    found, = friction_margins(margins, [HERE])
    assert math.isnan(found.value)
    assert found.reason == ('no stability boundary from mu = 0.3 to 0.9, stable')
    rest = others(margins, HERE)
    assert set(rest) == {'rotor_speed', 'pressure', 'groan', 'divergence'}
    assert all(math.isnan(margin.critical) for margin in rest.values())
    assert 'to 0.5, stable' in rest['rotor_speed'].reason
    assert 'to 200, stable' in rest['rotor_speed'].reason


def test_groan_is_no_squeal() -> None:
    margins = evaluator(FullSolutions(flutter(5e-4), (2000.0, 16000.0)))
    found, = friction_margins(margins, [HERE])
    assert math.isnan(found.critical)
    groan = margins.other_margin(HERE, 'groan')
    assert groan.critical == pytest.approx(critical_friction(5e-4), abs=2e-5)
    assert groan.frequency_hz < 2000.0


def test_divergence_is_no_squeal() -> None:
    """A coordinate without stiffness is unstable by any negative slope, and does not oscillate."""
    model = falling(angular_frequencies=np.array([0.0, W1]), damping_ratios=0.01,
                    negative_slope=np.diag([1e-3, 0.0]))
    margins = evaluator(FullSolutions(model))
    divergence = margins.other_margin(HERE, 'divergence')
    assert divergence.critical == pytest.approx(0.0, abs=1e-3)
    assert divergence.reason.endswith('stable below')
    found, = friction_margins(margins, [HERE])
    assert math.isnan(found.critical)


def test_a_mode_that_leaves_the_band_is_a_jump() -> None:
    """Frequency falls with friction by an uneven couple; the band ends amid instability."""
    model = falling(friction_couple=np.array([[-3e-3]]), nominal_contact_stiffness=1e10)
    at = replace(HERE, pressure=5.0 * slope_limit(model, 0.3))
    edge = math.sqrt(W1**2 - 3e-3 * 1e10 * 0.25) / 2.0 / math.pi  # where friction is 0.25
    margins = evaluator(FullSolutions(model, (1250.0, edge)))
    found, = friction_margins(margins, [at])
    assert found.critical == pytest.approx(0.25, abs=1e-3)
    assert 'jump' in found.reason
    assert found.growth_rate > 10.0
    assert margins.confirm(found, at).confirmed


@pytest.mark.parametrize(('speed', 'pressure', 'friction'), [
    (53.5, 3.66e5, 0.414), (8.165, 4.403e5, 0.425)])
def test_as_the_offline_search_of_the_shipped_model(kang: BrakeModel, speed: float,
                                                    pressure: float, friction: float) -> None:
    at = SlidingConditions(rotor_speed=speed, pressure=pressure, friction=friction)
    margins = evaluator(FullSolutions(kang))
    found, = friction_margins(margins, [at])
    expected = critical_value(kang, kang.operating_point(**vars(at)), 'friction', (0.0, friction),
                              samples=21).below
    assert found.critical == pytest.approx(expected.value, abs=1e-4)
    assert found.frequency_hz == pytest.approx(expected.frequency_hz, abs=1.0)
    assert margins.confirm(found, at).confirmed


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
    due = {brake: [tick * period for tick in range(123_400, 126_400) if confirmation_due(
        tick * period, period, interval, brake, 4)] for brake in range(4)}
    assert [len(times) for times in due.values()] == [3, 3, 3, 3]
    assert all(np.diff(times).tolist() == [interval, interval] for times in due.values())
    assert [times[0] % interval for times in due.values()] == [  # the first tick of an interval
        0, 3 * interval // 4, interval // 2, interval // 4]
    assert not confirmation_due(20 * SECOND, period, 0, 0, 4)
    assert confirmation_due(20 * SECOND, 20 * SECOND, interval, 3, 4)  # a slower tick: each time


@dataclass
class Estimate:
    """A map of growth rates that are straight lines through some friction."""

    zero: float
    friction: FloatArray = field(default_factory=lambda: np.linspace(0.0, 0.66, 34))

    def growth_along_friction(self, rotor_speed: FloatArray,
                              contact_pressure: FloatArray) -> FloatArray:
        sliding = rotor_speed * contact_pressure > 0.0
        return np.where(sliding[:, None], self.friction - self.zero, np.nan)


@pytest.mark.parametrize('friction', [0.3, 0.55])
@pytest.mark.parametrize('zero', [0.41, 0.42, 0.35, 0.5, 0.7])
def test_a_map_saves_look_ups_and_cannot_mislead(zero: float, friction: float) -> None:
    """The boundary is at 0.42; whatever the map says, that is what comes out."""
    model, at = flutter(5e-4), replace(HERE, friction=friction)
    expected, = friction_margins(evaluator(FullSolutions(model)), [at])
    growth = FullSolutions(model)
    found, = friction_margins(evaluator(growth, growth_map=Estimate(zero)), [at])
    assert found.critical == pytest.approx(expected.critical, abs=2e-5)
    if abs(zero - 0.42) < 0.02:
        assert growth.points <= 22
        assert growth.calls <= 3


def test_other_margins_are_computed_where_somebody_asks_for_them() -> None:
    growth = FullSolutions(flutter(5e-4))
    margins = evaluator(growth)
    found, = friction_margins(margins, [HERE])
    growth.calls = 0
    both = Margins(found, partial(margins.other_margin, HERE))
    assert growth.calls == 0
    assert list(both.by_name()) == ['friction', 'rotor_speed', 'pressure', 'groan', 'divergence']
    assert growth.calls > 0
    assert Margins(found).by_name() == {'friction': found}
