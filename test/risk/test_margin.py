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

"""Margins: closed forms, the offline search, one solve a call, what each is kept apart from."""

from collections import Counter
from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.dimensions import Caliper
from squeal_core.risk.margin import Margin, Margins, MarginSettings, SlidingConditions
from squeal_core.risk.margin_search import MarginSearch
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, ComplexModes, Source, Tolerances
from squeal_core.surrogate.steps import in_a_step
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver

BAND = (1250.0, 16000.0)
SECOND = 1_000_000_000
HERE = SlidingConditions(rotor_speed=10.0, pressure=1e6, friction=0.3)
W1, W2, DAMPING = 1e4, 1.02e4, 40.0
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])


class Solver:
    """Full solves, counted; they say that they are from wherever they are told to say."""

    def __init__(self, model: BrakeModel, source: Source = 'full') -> None:
        self.model, self.source, self.points = model, source, Counter[OperatingPoint]()

    def __call__(self, point: OperatingPoint) -> ComplexModes:
        self.points[point] += 1
        return replace(complex_modes(self.model, point), source=self.source)


def searched(model: BrakeModel, inputs: SlidingConditions = HERE, *,
             band: tuple[float, float] = BAND, settings: MarginSettings | None = None,
             solve: Any = None) -> Margins:
    """One round over all parameters."""
    search = MarginSearch(model, in_a_step(solve or Solver(model)), band, settings=settings)
    for call in range(1000):
        if search.advance(inputs, call).pressure is not None:
            return search.margins
    raise AssertionError('no end')


def flutter(couple: float, **changes: Any) -> BrakeModel:
    """
    Two modes of equal damping: growth where mu k_c couple exceeds half the split of K, damped.

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
    found = searched(flutter(couple), replace(HERE, friction=friction)).friction
    assert found is not None
    expected = critical_friction(couple)
    assert (found.grows, found.converged) == (friction > expected, True)
    # the bracket is 1e-4 wide; growth counts from a little further on
    assert found.critical == pytest.approx(expected, abs=2e-4)
    assert found.value == pytest.approx(expected - friction, abs=2e-4)
    assert found.frequency_hz == pytest.approx(math.sqrt(0.5 * (W1**2 + W2**2)) / 2 / math.pi,
                                               rel=1e-3)
    assert found.index in (1, 2)
    assert abs(found.bracket[1] - found.bracket[0]) <= 1e-4
    low, high = sorted(found.growth_rates)
    assert low <= Tolerances.of(flutter(couple)).growth < high


def falling(**changes: Any) -> BrakeModel:
    """One mode with a damping that a falling friction takes away: growth = (s p0 - d) / 2."""
    from squeal_core.brake.friction import FrictionLaw
    return BrakeModel(**{
        'angular_frequencies': np.array([W1]), 'damping_ratios': 0.5 * DAMPING / W1,
        'negative_slope': np.array([[1e-3]]), 'caliper': Caliper(2.5e-3),
        'friction_law': FrictionLaw(decay=1.0), **changes})


def slope_limit(model: BrakeModel, friction: float) -> float:
    """Pressure times mu_v at which growth begins, per mu_v at HERE's speed."""
    law = model.friction_law
    assert law is not None
    slope = law.slope_at(10.0 * model.contact_radius, friction)
    return (DAMPING + 0.02) / (1e-3 * -slope) * model.contact_area / 2.5e-3


@pytest.mark.parametrize('times', [0.5, 3.0])
def test_critical_pressure_and_speed(times: float) -> None:
    model = falling()
    limit = slope_limit(model, 0.3)
    found = searched(model, replace(HERE, pressure=times * limit))
    pressure, speed = found.pressure, found.rotor_speed
    assert pressure is not None
    assert speed is not None
    assert pressure.grows == speed.grows == (times > 1.0)
    assert pressure.critical == pytest.approx(limit, rel=1e-3)
    law, radius = model.friction_law, model.contact_radius
    assert law is not None

    def slope(at: float) -> float:
        return law.slope_at(at * radius, 0.3) / law.slope_at(10.0 * radius, 0.3)

    assert speed.converged
    assert times * slope(speed.critical) == pytest.approx(1.0, rel=2e-3)
    assert (speed.value > 0.0) == (times > 1.0)  # the faster, the flatter


def test_no_margin_within_the_bounds() -> None:
    found = searched(flutter(1e-5))
    for name in ('friction', 'rotor_speed', 'pressure', 'groan', 'divergence'):
        margin = getattr(found, name)
        assert math.isnan(margin.critical)
        assert math.isnan(margin.value)
        assert not margin.converged
        assert 'does not begin' in margin.reason
    assert found.friction is not None
    assert found.friction.bracket == (0.3, 0.9)


def test_groan_is_no_squeal() -> None:
    couple = 5e-4
    low = searched(flutter(couple), band=(2000.0, 16000.0))
    assert low.friction is not None
    assert low.groan is not None
    assert math.isnan(low.friction.critical)
    assert low.groan.critical == pytest.approx(critical_friction(couple), abs=2e-4)
    assert low.groan.converged
    high = searched(flutter(couple))
    assert high.groan is not None
    assert math.isnan(high.groan.critical)


def test_divergence_is_no_squeal() -> None:
    """A coordinate without stiffness grows by any negative slope, and does not oscillate."""
    model = falling(angular_frequencies=np.array([0.0, W1]), damping_ratios=0.01,
                    negative_slope=np.diag([1e-3, 0.0]))
    found = searched(model)
    assert found.divergence is not None
    assert found.friction is not None
    assert found.divergence.grows
    assert found.divergence.frequency_hz != found.divergence.frequency_hz  # no crossing: NaN
    assert not found.friction.grows


def test_a_mode_that_leaves_the_band_is_a_jump() -> None:
    """Frequency falls with friction by an uneven couple; the band ends amid growth."""
    model = falling(friction_couple=np.array([[-3e-3]]))
    limit = slope_limit(model, 0.3)
    inputs = replace(HERE, pressure=5.0 * limit)
    edge = math.sqrt(W1**2 - 3e-3 * 1e10 * 0.25) / 2.0 / math.pi  # where friction is 0.25
    settings = MarginSettings(friction=(0.2, 0.3))
    model = replace(model, nominal_contact_stiffness=1e10)
    found = searched(model, inputs, band=(1250.0, edge), settings=settings).friction
    assert found is not None
    assert found.grows
    assert found.critical == pytest.approx(0.25, abs=2e-4)
    assert not found.converged
    assert 'jump' in found.reason


@pytest.mark.parametrize(('speed', 'pressure', 'friction'), [
    (8.165, 4.403e5, 0.425), (3.94, 3.65e5, 0.4176)])
def test_as_the_offline_search_of_the_shipped_model(kang: BrakeModel, speed: float,
                                                    pressure: float, friction: float) -> None:
    band = (6500.0, 8000.0)
    inputs = SlidingConditions(rotor_speed=speed, pressure=pressure, friction=friction)
    found = searched(kang, inputs, band=band, solve=TabulatedSolver(kang).complex_modes).friction
    assert found is not None
    assert found.converged
    point = kang.operating_point(rotor_speed=speed, pressure=pressure, friction=friction)
    reference = critical_value(kang, point, 'friction', (friction - 0.06, friction + 0.06),
                               samples=6, tolerance=1e-3, band_hz=band)
    expected = reference.below if found.grows else reference.above
    assert found.critical == pytest.approx(expected.value, abs=2e-4)  # brackets of 1e-4
    assert found.frequency_hz == pytest.approx(expected.frequency_hz, abs=1.0)


@pytest.mark.parametrize(('source', 'confirming'), [('full', 0), ('table', 2)])
def test_one_solve_a_call(source: Source, confirming: int) -> None:
    """What was solved in full needs no other solve to confirm it."""
    model = flutter(5e-4)
    solver = Solver(model, source)
    search = MarginSearch(model, in_a_step(solver), BAND)
    solved, found = 0, None
    for call in range(1, 200):
        margins = search.advance(HERE, call)
        assert solver.points.total() - solved <= 1
        solved = solver.points.total()
        if found is None and margins.friction is not None:
            found = margins.friction
            # one call solves what the next one uses
            assert found.solves == call - 1 == solved - 1 + confirming
    assert found is not None


@pytest.mark.parametrize('couple', [3.2e-4, 5e-4, 7e-4, 9e-4])
def test_few_solves_narrow_a_bracket(couple: float) -> None:
    """From a step of 0.02 to 1e-4 of friction: 8 by halves. Growth sets in like a square root."""
    solver = Solver(flutter(couple))
    found = searched(solver.model, solve=solver).friction
    assert found is not None
    assert found.converged
    assert found.critical == pytest.approx(critical_friction(couple), abs=1e-4)
    walked = math.ceil(abs(found.critical - HERE.friction) / 0.02) + 1
    assert found.solves - walked <= 6
    assert abs(found.bracket[1] - found.bracket[0]) <= 1e-4


def test_stamped_with_the_call_it_began_with() -> None:
    model = flutter(5e-4)
    search = MarginSearch(model, in_a_step(Solver(model)), BAND)
    seen: list[Margin] = []
    for call in range(300):
        inputs = replace(HERE, friction=0.3 + 1e-4 * call)
        margin = search.advance(inputs, call).friction
        if margin is not None and (not seen or margin is not seen[-1]):
            seen.append(margin)
    assert len(seen) > 2
    for margin in seen:
        assert margin.inputs == replace(HERE, friction=0.3 + 1e-4 * margin.time)
        assert margin.critical == pytest.approx(critical_friction(5e-4), abs=2e-4)
    assert [m.time for m in seen] == sorted(m.time for m in seen)
    search.reset()
    assert search.margins == Margins()


def test_same_calls_same_margins(kang: BrakeModel) -> None:
    def play() -> list[str]:
        table = TabulatedSolver(kang, SolverSettings(delay=5))
        search = MarginSearch(kang, table.solving, (6500.0, 8000.0))
        inputs = SlidingConditions(rotor_speed=8.165, pressure=4.4e5, friction=0.425)
        found = [repr(search.advance(inputs, call)) for call in range(40)]
        table.close()
        return found
    first = play()
    assert first == play()
    assert 'Margin(' in first[-1]


def test_backwards_as_forwards() -> None:
    model = flutter(5e-4)
    forwards, backwards = (searched(model, replace(HERE, rotor_speed=way * 10.0))
                           for way in (1.0, -1.0))
    assert repr(forwards) == repr(backwards)


def search_with(solver: Solver, **changes: float) -> MarginSearch:
    return MarginSearch(solver.model, in_a_step(solver), BAND, settings=MarginSettings(**changes))


def rounds(search: MarginSearch, solver: Solver, begin: float, end: float,
           inputs: SlidingConditions = HERE) -> int:
    """Call 50 times a second; how many solves that took."""
    before = solver.points.total()
    for call in range(round(50 * begin), round(50 * end)):
        search.advance(inputs, call * SECOND // 50)
    return solver.points.total() - before


def test_margins_stand_where_inputs_rest() -> None:
    """They are looked for anew as they age, and where an input is another."""
    solver = Solver(flutter(5e-4))
    search = search_with(solver, rest=20.0)
    assert rounds(search, solver, 0.0, 10.0) > 20
    known = search.margins
    noise = replace(HERE, friction=0.304, pressure=1.009e6, rotor_speed=-9.95)
    assert rounds(search, solver, 10.0, 15.0, noise) == 0
    assert search.margins is known
    assert rounds(search, solver, 15.0, 40.0) > 20
    assert search.margins.friction is not None
    assert search.margins.friction.time >= 20 * SECOND


@pytest.mark.parametrize('changed', [
    replace(HERE, friction=0.306), replace(HERE, pressure=1.02e6), replace(HERE, rotor_speed=9.8)])
def test_margins_are_looked_for_anew_at_other_inputs(changed: SlidingConditions) -> None:
    solver = Solver(flutter(5e-4))
    search = search_with(solver, rest=20.0)
    rounds(search, solver, 0.0, 10.0)
    assert rounds(search, solver, 10.0, 15.0, changed) > 20
    assert search.margins.friction is not None
    assert search.margins.friction.inputs == changed
    assert rounds(search, solver, 15.0, 20.0, changed) == 0


def test_a_bracket_that_was_not_confirmed_is_looked_for_anew() -> None:
    """Though the inputs rest: the table said what the full problem does not."""
    solver = Solver(flutter(5e-4))
    search = search_with(solver, rest=20.0)
    rounds(search, solver, 0.0, 10.0)
    found = search.margins.friction
    assert found is not None
    search.margins = replace(search.margins, friction=replace(
        found, converged=False, growth_rates=(-0.5, -0.1)))
    assert rounds(search, solver, 10.0, 11.0) > 0
    assert search.margins.friction is not None
    assert search.margins.friction.converged


@pytest.mark.parametrize('name', ['pressure', 'rotor_speed'])
def test_a_search_from_inputs_left_behind_is_given_up(name: str) -> None:
    """Its margins would hold no more; friction's comes first again."""
    solver = Solver(flutter(5e-4))
    search = search_with(solver, change=0.2)
    rounds(search, solver, 0.0, 0.5)
    assert search.margins.friction is not None
    assert search.margins.pressure is None
    slightly, far = (replace(HERE, **{name: ratio * getattr(HERE, name)}) for ratio in (1.15, 1.3))
    search.margins = Margins()
    search.advance(slightly, SECOND)
    assert search.margins == Margins()
    rounds(search, solver, 2.0, 2.5, far)
    found = search.margins.friction
    assert found is not None
    assert found.inputs == far
    assert found.converged
    assert search.margins.rotor_speed is None
    assert search.margins.pressure is None
