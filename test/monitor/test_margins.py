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

"""Margins by full solutions: closed forms, the offline search, brakes together."""

from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper
from squeal_core.brake.friction import FrictionLaw
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.monitor.margin_evaluator import MarginEvaluator
from squeal_core.monitor.margins import Margin, OtherMargin, OTHERS
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import Tolerances
from support.margin_searches import (
    DAMPING,
    evaluator,
    flutter,
    friction_margins,
    FullSolutions,
    HERE,
    W1,
    W2,
)


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
