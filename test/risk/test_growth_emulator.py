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

"""Growth emulator: against full solutions, its slopes, its domain, families that it finds."""

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import ModelError
from squeal_core.common.resources import config_folder
from squeal_core.risk.emulator_audit import audit
from squeal_core.risk.emulator_builder import build_growth_emulator, scattered_inputs
from squeal_core.risk.emulator_file import read_emulator
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.growth_emulator import affine_coefficients, GrowthEmulator, points_at
from squeal_core.risk.mode_families import clusters, coupled, mixing, ReferenceModes
from squeal_core.risk.training_solutions import part_of, solve_points
from support.engine_models import crossing_model, random_model


@pytest.fixture(scope='module')
def model() -> BrakeModel:
    return random_model(5, 3, friction_law=FrictionLaw(), contact_retardation_time=3e-6,
                        damping_ratios=0.004)


@pytest.fixture(scope='module')
def emulator(model: BrakeModel) -> GrowthEmulator:
    return build_growth_emulator(model, solutions=200, hold_out=60)


@pytest.fixture(scope='module')
def inputs(model: BrakeModel) -> FloatArray:
    """Return rows of inputs well inside the domain, for each member of an ensemble."""
    speed = np.exp(np.random.default_rng(3).uniform(np.log(2.0), np.log(100.0), 30))
    return prior_ensemble(EnsemblePrior(count=16)).inputs(
        speed, 3000.0 / model.contact_area, np.linspace(0.2, 0.6, 30))


@pytest.mark.parametrize('name', ['kang2009', 'kang2009_damped'])
def test_shipped_emulators_agree_with_independent_solutions(name: str) -> None:
    model = BrakeModel.load(name)
    emulator = read_emulator(config_folder() / 'tables' / f'{name}.growth.npz', model)
    assert emulator.error.rms < 0.45  # most of it is of one mode that decays at nearly 30 1/s
    assert emulator.error.points >= 500
    assert 0 < len(emulator.families) < len(emulator.every)  # some never grow
    law, rng, off = model.friction_law, np.random.default_rng(5), []
    assert law is not None
    for _ in range(40):
        speed, load = np.exp(rng.uniform(np.log([2.0, 300.0]), np.log([110.0, 8000.0])))
        friction, stiffness, scale, steep = rng.uniform(
            [0.2, 0.8, 0.6, 0.3], [0.6, 1.25, 1.6, 1.7])
        modes = complex_modes(model, OperatingPoint(
            rotor_speed=speed, friction=friction, contact_pressure=load / model.contact_area,
            friction_slope=steep * law.slope_at(model.contact_radius * speed, friction),
            contact_stiffness=stiffness * model.nominal_contact_stiffness, damping_scale=scale))
        worst = modes.least_stable(1250.0, 16000.0)[0]
        if -30.0 < worst.growth_rate < 100.0:
            row = [np.log(speed), np.log(load / model.contact_area), friction, np.log(stiffness),
                   np.log(scale), steep]
            off.append(emulator.evaluate(np.array(row)).growth_rate.max() - worst.growth_rate)
    assert len(off) > 10
    assert np.sqrt(np.mean(np.square(off))) < 2.0 * emulator.error.rms
    assert np.abs(off).max() <= emulator.error.largest


def test_growth_rates_and_frequencies_are_those_of_full_solutions(
        model: BrakeModel, emulator: GrowthEmulator, inputs: FloatArray) -> None:
    rows = inputs[:, 0]
    found = emulator.evaluate(rows)
    assert emulator.error.points == 60
    for row, point, growth, frequency in zip(rows, points_at(model, rows), found.growth_rate,
                                             found.frequency_hz, strict=True):
        worst = complex_modes(model, point).least_stable(1250.0, 16000.0)[0]
        if worst.growth_rate > -30.0:
            assert growth.max() == pytest.approx(worst.growth_rate, abs=emulator.error.largest)
            assert frequency[growth.argmax()] == pytest.approx(worst.frequency_hz, rel=1e-3)
            assert audit(emulator, row) <= emulator.error.largest


@pytest.mark.parametrize(('place', 'name'), [(2, 'by_friction'), (4, 'by_damping')])
def test_slopes_are_those_of_differences(emulator: GrowthEmulator, inputs: FloatArray,
                                         place: int, name: str) -> None:
    step = np.zeros(6)
    step[place] = 1e-5
    up, down = (emulator.eigenvalues((inputs + sign * step).reshape(-1, 6)).real
                for sign in (1.0, -1.0))
    slope = getattr(emulator.evaluate(inputs), name)
    assert slope.shape == (30, 16, len(emulator.families))
    wanted = ((up - down) / 2e-5)[:, :slope.shape[2]].reshape(slope.shape)
    np.testing.assert_allclose(slope, wanted, rtol=1e-3, atol=2e-2)


def test_many_rows_give_the_numbers_of_each(emulator: GrowthEmulator, inputs: FloatArray) -> None:
    """To the bit those of the rows that are evaluated together, whatever else there is."""
    found = emulator.evaluate(inputs)
    for i in (0, 3, 29):
        for many, one in zip(found, emulator.evaluate(inputs[i]), strict=True):
            assert np.array_equal(many[i], one)
    for i in (0, 17):
        for many, one in zip(found, emulator.evaluate(inputs[i, 3]), strict=True):
            np.testing.assert_allclose(many[i, 3], one, rtol=1e-6, atol=2e-3)


@pytest.mark.parametrize('name', ['kang2009', 'kang2009_damped'])
def test_brakes_have_the_numbers_of_each_alone(name: str) -> None:
    """With families that cross, in matrices of four modes and of more."""
    model = BrakeModel.load(name)
    emulator = read_emulator(config_folder() / 'tables' / f'{name}.growth.npz', model)
    brakes = prior_ensemble(EnsemblePrior()).inputs(
        [1.0, 20.0, 20.1, 60.0, 100.0], np.array([600.0, 1500.0, 3000.0, 900.0, 6000.0])
        / model.contact_area, [0.3, 0.42, 0.42, 0.5, 0.36])
    every = emulator.evaluate(brakes)
    for count in (1, 2, 3, 4):
        for i in range(0, 5, count):
            for many, few in zip(every, emulator.evaluate(brakes[i:i + count]), strict=True):
                assert np.array_equal(many[i:i + count], few)


def test_no_rows_have_no_numbers(emulator: GrowthEmulator, inputs: FloatArray) -> None:
    """As a search for quiet pressures asks for where nothing is left to look at."""
    found = emulator.evaluate(inputs[0, :0])
    assert found.growth_rate.shape == (0, len(emulator.families))


def test_families_that_cross_have_a_common_matrix() -> None:
    model = crossing_model()
    emulator = build_growth_emulator(model, solutions=400, hold_out=100)
    assert [common.families.tolist() for common in emulator.common] == [[1, 2]]
    assert emulator.error.rms < 1.5  # 9 with matrices of their own
    rows = scattered_inputs(emulator.domain, 60, 5)
    found = emulator.evaluate(rows)
    np.testing.assert_allclose(found.growth_rate.max(axis=1),
                               emulator.eigenvalues(rows).real.max(axis=1), atol=0.02)
    for place, name in ((2, 'by_friction'), (4, 'by_damping')):
        step = np.zeros(6)
        step[place] = 1e-4
        up, down = (emulator.eigenvalues(rows + sign * step).real.max(axis=1)
                    for sign in (1.0, -1.0))
        slope = getattr(found, name)[np.arange(60), found.growth_rate.argmax(axis=1)]
        np.testing.assert_allclose(slope, (up - down) / 2e-4, rtol=1e-3, atol=0.02)


def test_rows_outside_the_domain_are_not_known(emulator: GrowthEmulator,
                                               inputs: FloatArray) -> None:
    rows = np.repeat(inputs[:1, 0], 8, axis=0)
    rows[1, 0], rows[2, 1], rows[3, 2], rows[4, 3], rows[5, 4] = 9.0, -np.inf, 0.8, 0.4, -1.0
    rows[6, 5] = np.nan
    rows[7, :3] = np.log(0.6), emulator.domain.high[1] - 0.1, 0.7  # creeping under full load
    for array in emulator.evaluate(rows):
        assert np.isfinite(array[0]).all()
        assert np.isnan(array[1:]).all()
    assert np.isnan(audit(emulator, rows[1]))


def test_workers_give_the_same_emulator(model: BrakeModel) -> None:
    first, second = (build_growth_emulator(model, solutions=48, hold_out=4, workers=workers)
                     for workers in (0, 2))
    assert np.array_equal(first.weights, second.weights)
    np.testing.assert_equal(vars(first.error), vars(second.error))  # NaN where none matters
    assert first.families == second.families


def test_families_decay_without_friction_as_a_solution_there_does(
        model: BrakeModel, emulator: GrowthEmulator) -> None:
    modes = complex_modes(model, OperatingPoint(
        rotor_speed=1e-3, friction=0.0, contact_pressure=0.0,
        contact_stiffness=model.nominal_contact_stiffness)).modes
    for family in emulator.families:
        own = [modes[number - 1] for number in family.numbers]
        assert family.decay_rate == pytest.approx(-np.mean([m.growth_rate for m in own]))
        assert family.frequency_hz == pytest.approx(np.mean([m.frequency_hz for m in own]))


def test_models_that_never_grow_are_refused() -> None:
    model = random_model(3, 1, damping_ratios=0.5)
    with pytest.raises(ModelError, match='no mode of the squeal band comes near to growing'):
        build_growth_emulator(model, solutions=20, hold_out=0)


def test_matrices_of_modes_have_their_eigenvalues_and_slopes(model: BrakeModel) -> None:
    row = np.array([np.log(20.0), np.log(5e5), 0.4, 0.1, -0.2, 1.3])
    reference, modes = ReferenceModes(model, (0.2e11, 0.7e11)), np.array([0, 2, 3])
    steps = 1e-5 * np.concatenate([np.eye(6), -np.eye(6)])
    found = solve_points(model, reference, np.concatenate([[row], row + steps]), [modes])
    [cluster] = found.clusters
    moved = affine_coefficients(points_at(model, row + steps))
    by = (moved[:6] - moved[6:]) / 2e-5  # of coefficients (last axis) along inputs
    first = part_of(cluster, found.eigenvalues[:, modes], np.array([0, 2]))
    for matrix, own in ((cluster, modes), (first, modes[[0, 2]])):
        values = np.linalg.eigvals(matrix.values[0])
        np.testing.assert_allclose(np.sort_complex(values),
                                   np.sort_complex(found.eigenvalues[0, own]), rtol=1e-9)
        expected = (matrix.values[1:7] - matrix.values[7:]) / 2e-5
        np.testing.assert_allclose(np.tensordot(by, matrix.slopes[0], 1), expected, rtol=1e-4,
                                   atol=0.05)


def test_modes_that_cross_keep_their_numbers() -> None:
    """The first mode alone stiffens with the contact and passes the second one."""
    model = BrakeModel(angular_frequencies=np.array([1e4, 1.02e4]), nominal_contact_stiffness=1e10,
                       contact_stiffness=np.diag([2e-3, 1e-9]))
    reference = ReferenceModes(model, (0.5e10, 1.5e10))
    low, high = (np.abs(reference.at(stiffness)) for stiffness in (0.5e10, 1.5e10))
    np.testing.assert_allclose(low, high, atol=1e-6)


def test_families_are_modes_that_mix_while_they_are_near() -> None:
    values = np.tile([1000j, 1001j, 1002j, 2000j, 2001j, 3000j], (2, 1))
    projections = np.tile(0.8 * np.eye(6), (2, 1, 1))
    projections[:, 0, 1], projections[:, 1, 2] = 0.1, 0.2
    projections[:, 3, 4], projections[:, 4, 5] = 0.05, 0.3
    mixed = mixing(values, projections)
    families = coupled(mixed)
    assert [places.tolist() for places in families] == [[0], [1, 2], [3, 4], [5]]
    assert [places.tolist() for places in clusters(mixed, families)] == [[0, 1, 2], [3, 4], [5]]
