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

"""Brakes assessed together: what each of them gets by itself, and no more calls than needed."""

from collections.abc import Callable, Sequence
from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.dimensions import StiffnessTable
from squeal_core.brake.friction import FrictionLaw
from squeal_core.monitor.brake_stability import BrakeEvaluator, evaluate_brakes
from squeal_core.monitor.settings import MonitorSettings, read_settings, Signal
from squeal_core.monitor.vehicle_monitor import Sample, VehicleMonitor
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.risk.margin import SlidingConditions
from squeal_core.risk.probability import Inputs, InputUncertainty
from squeal_core.risk.risk_cell import Family
from squeal_core.risk.risk_table import RiskSettings, RiskTable
from squeal_core.stability.eigensolution import classify, classify_rows, complex_modes, Tolerances
from squeal_core.surrogate import workers
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.steps import Call
from squeal_core.surrogate.tabulated_solver import SolverSettings, TabulatedSolver
from squeal_core.surrogate.workers import Worker
from support.engine_models import point, random_model

TICK = 1_000_000_000
DEVIATIONS = InputUncertainty(friction=0.02, pressure=0.03, rotor_speed=0.01,
                              contact_stiffness=0.1)
# of sums in another order: of roots up to 1e5 1/s, and of probabilities
ROUNDING, OF_RISK = 1e-7, 1e-9


def axles(model: BrakeModel, speed: float, pressure: float, friction: float) -> list[Inputs]:
    """Four brakes as on a car: nearly alike on an axle, less pressure behind."""
    return [Inputs(rotor_speed=speed * (1.0 + 0.002 * i), friction=friction + 0.003 * i,
                   pressure=pressure * (1.0 if i < 2 else 0.43),
                   contact_stiffness=model.nominal_contact_stiffness) for i in range(4)]


def points(model: BrakeModel, brakes: Sequence[Inputs]) -> list[OperatingPoint]:
    return [model.operating_point(rotor_speed=at.rotor_speed, pressure=at.pressure,
                                  friction=at.friction) for at in brakes]


def way(model: BrakeModel, ticks: int) -> list[list[OperatingPoint]]:
    return [points(model, axles(model, 40.0 * 0.985**i, 1.2e6 * 1.01**i, 0.4))
            for i in range(ticks)]


def settings(**changes: object) -> MonitorSettings:
    return read_settings({'rate': 50.0, **changes})


# ---------------------------------------------------------------- modes

@pytest.mark.parametrize(('delay', 'ticks'), [(0, 12), (30, 40)])
def test_modes_together_are_those_of_the_full_solver(kang: BrakeModel, delay: int,
                                                     ticks: int) -> None:
    """Within the tolerance, wherever they come from, with anchors made meanwhile."""
    table = TabulatedSolver(kang, SolverSettings(delay=delay, audit_every=7))
    for brakes in way(kang, ticks):
        for found, at in zip(table.complex_modes_of(brakes), brakes, strict=True):
            truth = complex_modes(kang, at)
            assert found.mode_eigenvalues.size == truth.mode_eigenvalues.size
            away = np.abs(found.mode_eigenvalues[:, None] - truth.mode_eigenvalues).min(axis=1)
            assert np.all(away <= np.maximum(0.1, -0.02 * found.mode_eigenvalues.real))
            assert [m.index for m in found.unstable] == [m.index for m in truth.unstable]
    table.close()
    figures = table.statistics
    assert figures.tabulated + figures.full == 4 * ticks
    assert figures.tabulated > ticks
    assert figures.audits == figures.tabulated // 7
    assert figures.mismatches == 0


def test_together_or_one_by_one(kang: BrakeModel) -> None:
    """From the same table: the same numbers but for rounding, the same counts and entries."""
    one, other = (TabulatedSolver(kang, SolverSettings(audit_every=0)) for _ in range(2))
    for brakes in way(kang, 15):
        apart = [one.complex_modes(at) for at in brakes]
        for anchor in one.anchors[len(other.anchors):]:
            other.add(anchor)
        for found, alone in zip(other.complex_modes_of(brakes), apart, strict=True):
            assert found.source == alone.source
            if found.series is alone.series:
                np.testing.assert_allclose(found.mode_eigenvalues, alone.mode_eigenvalues,
                                           atol=ROUNDING, rtol=0.0)
                np.testing.assert_allclose(found.errors, alone.errors, rtol=1e-3, atol=ROUNDING)
                np.testing.assert_allclose(found.eigenvalues, alone.eigenvalues, atol=ROUNDING)
    assert one.statistics.tabulated == other.statistics.tabulated
    assert other.statistics.made == 0


def test_one_point_far_from_all_others(kang: BrakeModel) -> None:
    """What no anchor has is solved for itself; the others stay."""
    table = TabulatedSolver(kang)
    near = points(kang, axles(kang, 40.0, 1.2e6, 0.4))
    table.complex_modes_of(near)
    table.settings = replace(table.settings, delay=10**6)
    far = points(kang, axles(kang, 3.0, 6e6, 0.7))[:1]
    found = table.complex_modes_of([near[0], *far, near[3]])
    assert [modes.source for modes in found] == ['table', 'full', 'table']
    np.testing.assert_array_equal(found[1].mode_eigenvalues,
                                  complex_modes(kang, far[0]).mode_eigenvalues)
    table.close()


def test_axles_near_each_other_share_an_anchor(kang: BrakeModel) -> None:
    """It is made amid them, and asked for all of them at once, though each had a nearer one."""
    table = TabulatedSolver(kang)
    brakes = [kang.operating_point(rotor_speed=40.0, pressure=pressure, friction=0.42)
              for pressure in (1.5e6, 1.5e6, 1.2e6, 1.2e6)]
    found = table.complex_modes_of(brakes)
    assert len(table.anchors) == 1
    middle = table.anchors[0].point.contact_pressure
    assert brakes[2].contact_pressure < middle < brakes[0].contact_pressure
    # of a quarter of the distance between the axles, to the fourth power
    assert max(modes.errors.max() for modes in found) < 0.02
    table.add(expand_spectrum(kang, brakes[2]))
    again = table.complex_modes_of(brakes)
    assert {id(modes.series) for modes in again} == {id(table.anchors[0])}
    far = kang.operating_point(rotor_speed=40.0, pressure=0.8e6, friction=0.42)
    table.add(expand_spectrum(kang, far))
    apart = table.complex_modes_of([*brakes[:2], far])
    assert [id(modes.series) for modes in apart] == [
        *[id(table.anchors[0])] * 2, id(table.anchors[2])]


def test_one_point_is_answered_as_ever(kang: BrakeModel) -> None:
    one, other = TabulatedSolver(kang), TabulatedSolver(kang)
    for brakes in way(kang, 4):
        alone, (found,) = one.complex_modes(brakes[0]), other.complex_modes_of(brakes[:1])
        np.testing.assert_array_equal(found.mode_eigenvalues, alone.mode_eigenvalues)
        np.testing.assert_array_equal(found.errors, alone.errors)


@pytest.mark.parametrize('seed', range(6))
def test_rows_sorted_as_each_by_itself(seed: int) -> None:
    """Also where some rows have other modes that do not oscillate, or equal roots."""
    generator, limits = np.random.default_rng(seed), Tolerances(oscillation=1.0, growth=1e-2)
    frequency = generator.choice([0.0, 10.0, 10.0, 25.0, 300.0], (5, 9))
    if seed % 2:
        frequency = np.repeat(frequency[:1], 5, axis=0)
    growth = generator.choice([-1.0, -1.0, 0.0, 2.0, 5.0], frequency.shape)
    roots, errors = growth + 1j * frequency, generator.random(frequency.shape)
    for row, found in enumerate(classify_rows(roots, limits, errors, 'series')):
        alone = classify(roots[row], limits, errors[row], 'series', 'table')
        for name in ('nonoscillatory', 'oscillatory', 'mode_eigenvalues', 'errors'):
            np.testing.assert_array_equal(getattr(found, name), getattr(alone, name))
            assert not getattr(found, name).flags.writeable
        assert (found.source, found.series) == ('table', 'series')


def test_many_models_with_coordinates_that_nothing_holds() -> None:
    """Roots at zero are in every row."""
    for seed in range(5):
        model = random_model(6, seed=seed)
        table = TabulatedSolver(model)
        brakes = [replace(point(), friction=0.3 + 0.001 * i) for i in range(4)]
        for _ in range(2):
            for found, at in zip(table.complex_modes_of(brakes), brakes, strict=True):
                truth = complex_modes(model, at)
                assert found.nonoscillatory.size == truth.nonoscillatory.size
                assert [m.kind for m in found.modes] == [m.kind for m in truth.modes]


# ---------------------------------------------------------------- risk

def test_risks_together_or_one_by_one(kang: BrakeModel) -> None:
    """Both axles in cells of their own, one brake outside of both, one before its cell is made."""
    table = RiskTable(kang, (1250.0, 16000.0), RiskSettings())
    for speed, pressure in ((40.0, 1.2e6), (8.0, 5e5)):
        brakes = axles(kang, speed, pressure, 0.36)
        modes = [complex_modes(kang, at) for at in points(kang, brakes)]
        each = list(zip(brakes, modes, strict=True))
        apart = [table.assess(at, found, DEVIATIONS) for at, found in each]
        for found, alone in zip(table.assess_together(each, DEVIATIONS), apart, strict=True):
            assert found.basis == alone.basis == 'summed'
            assert found.probability == pytest.approx(alone.probability, abs=OF_RISK)
            assert found.error == pytest.approx(alone.error, abs=OF_RISK)
            assert [m.index for m in found.modes] == [m.index for m in alone.modes]
    table.settings = RiskSettings(delay=10**6)
    new = axles(kang, 150.0, 8e6, 0.6)[:1]
    both = [*each[:1], *zip(new, [complex_modes(kang, at) for at in points(kang, new)],
                            strict=True)]
    assert [risk.basis for risk in table.assess_together(both, DEVIATIONS)] == [
        'summed', 'first order']
    table.close()


def test_axles_near_each_other_share_a_cell(kang: BrakeModel) -> None:
    brakes = [replace(at, pressure=pressure) for at, pressure in zip(
        axles(kang, 40.0, 1.0, 0.36), (1.5e6, 1.5e6, 1.2e6, 1.2e6), strict=True)]
    each = list(zip(brakes, [complex_modes(kang, at) for at in points(kang, brakes)], strict=True))
    table = RiskTable(kang, (1250.0, 16000.0))
    shared = table.assess_together(each, DEVIATIONS)
    cell, = table.cells
    assert cell.inputs[1] == pytest.approx(math.sqrt(1.5e6 * 1.2e6))
    assert cell.inputs[2] == pytest.approx(0.36 + 0.0045)
    alone = RiskTable(kang, (1250.0, 16000.0))
    own = [alone.assess(*each[0], DEVIATIONS), alone.assess(*each[3], DEVIATIONS)]
    for found, truth in zip((shared[0], shared[3]), own, strict=True):
        assert found.basis == 'summed'
        assert abs(found.probability - truth.probability) <= found.error + truth.error


def test_coefficients_of_many_points_are_those_of_each(kang: BrakeModel) -> None:
    """Each with its own speed, pressure, friction and stiffness, the latter by a table too."""
    table = StiffnessTable(pressure=(1e4, 1e6), stiffness=(2e9, 9e9))
    for model in (kang, replace(kang, stiffness_table=table)):
        family, generator = Family(model), np.random.default_rng(1)
        speed, pressure, friction, factor = (
            low * (high / low) ** generator.random(7)
            for low, high in ((1, 100), (1e5, 8e6), (0.1, 0.7), (0.5, 2.0)))
        expected = [family.point(*values).coefficients() for values in zip(
            speed.tolist(), pressure.tolist(), friction.tolist(), factor.tolist(), strict=True)]
        np.testing.assert_allclose(family.coefficients(speed, pressure, friction, factor),
                                   np.array(expected).T, rtol=1e-13)


def test_relative_slope_is_the_slope_over_the_coefficient() -> None:
    law, speeds = FrictionLaw(static=0.55, kinetic=0.3, decay=0.7), np.linspace(0.0, 20.0, 9)
    expected = [law.slope_at(speed, 0.4) / 0.4 for speed in speeds.tolist()]
    np.testing.assert_allclose(law.relative_slope(speeds), expected, rtol=1e-14)


# ---------------------------------------------------------------- brakes and the vehicle

def test_a_vehicle_is_its_brakes(kang: BrakeModel) -> None:
    """Modes, risk and states of four brakes, of which one is released and one does not slide."""
    watch = VehicleMonitor(settings(anchor_delay=0.0, risk_delay=0.0), kang)
    inputs = {'front_left': (40.0, 1.2e6), 'front_right': (40.1, 1.21e6),
              'rear_left': (40.0, 0.0), 'rear_right': (0.0, 5e5)}
    values: dict[Signal, float]
    for brake, (speed, pressure) in inputs.items():
        values = {'rotor_speed': speed, 'pressure': pressure, 'friction': 0.4}
        for signal, value in values.items():
            watch.receive(brake, signal, Sample(TICK, value))
    found = watch.assess(TICK)
    assert [one.brake for one in found] == list(inputs)
    assert [one.state for one in found] == ['steady', 'steady', 'released', 'not sliding']
    for one in found[:2]:
        alone = watch.brakes[one.brake].assess(TICK)
        assert alone.risk == pytest.approx(one.risk, abs=OF_RISK)
        assert alone.growth_rate == pytest.approx(one.growth_rate, abs=1e-3)


def test_no_eigensolution_of_one_brake_is_its_own(kang: BrakeModel,
                                                  monkeypatch: pytest.MonkeyPatch) -> None:
    """The others are assessed, though the brakes are judged together."""
    watch = VehicleMonitor(settings(anchor_delay=0.0, risk_delay=0.0), kang)
    solve = TabulatedSolver.complex_modes_of

    def failing(table: TabulatedSolver, of: Sequence[OperatingPoint]) -> object:
        if any(at.friction > 0.5 for at in of):
            raise np.linalg.LinAlgError('did not converge')
        return solve(table, of)

    monkeypatch.setattr(TabulatedSolver, 'complex_modes_of', failing)
    for i, brake in enumerate(watch.brakes):
        for signal, value in (('rotor_speed', 40.0), ('pressure', 1.2e6),
                              ('friction', 0.6 if i == 1 else 0.4)):
            watch.receive(brake, signal, Sample(TICK, value))  # type: ignore[arg-type]
    found = watch.assess(TICK)
    assert [one.state for one in found] == ['steady', 'invalid', 'steady', 'steady']
    assert found[1].reason == 'no eigensolution (did not converge)'
    assert all(math.isfinite(one.risk) for one in (found[0], *found[2:]))


def driven(kang: BrakeModel, begin: Callable[[], None] = lambda: None) -> str:
    """Return what is known of four brakes over some ticks, to the last bit."""
    at = settings(anchor_delay=0.1, risk_delay=0.2)
    engines, found = VehicleStability(kang, at), []
    brakes = [BrakeEvaluator(engines, at, brake.name) for brake in at.brakes]
    for i in range(100):
        begin()
        found.append([
            (known.modes.mode_eigenvalues.tobytes(), known.risk.probability, known.friction_margin)
            for known in evaluate_brakes(list(zip(brakes, (
                SlidingConditions(rotor_speed=one.rotor_speed, pressure=one.pressure,
                                  friction=one.friction)
                for one in axles(kang, 30.0 * 0.996**i, 8e5, 0.4)), strict=True)),
                i * at.period)])
    assert engines.modes.statistics.made > 1
    assert engines.risks.statistics.made > 0
    assert engines.margins.statistics.made > 0
    engines.close()
    return repr(found)


def test_the_same_ticks_give_the_same_bits(kang: BrakeModel,
                                           monkeypatch: pytest.MonkeyPatch) -> None:
    """
    Anchors, cells and margins are made by workers, however slow these are.

    Where they never get to run, ticks make the steps: at most one for each brake.
    """
    expected = driven(kang)
    assert driven(kang) == expected
    steps, make = [0], workers._made

    def counted(call: Call) -> tuple[Any, Exception | None]:
        steps[-1] += call is not workers._nothing
        return make(call)

    monkeypatch.setattr(workers, '_made', counted)
    monkeypatch.setattr(workers, '_PATIENCE', 0.0)
    monkeypatch.setattr(Worker, '_do', lambda worker, work: None)
    assert driven(kang, lambda: steps.append(0)) == expected
    assert max(steps) == 4
    assert sum(steps) > 100  # a cell alone has as many
