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

"""The operating map: smoothing against closed forms, risks against full solutions, its file."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import norm, qmc
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import Caliper, StiffnessTable
from squeal_core.brake.friction import FrictionLaw
from squeal_core.common.arrays import FloatArray
from squeal_core.common.errors import TableFileError
from squeal_core.risk.growth_boxes import box_growth, first_boxes
from squeal_core.risk.growth_grid import grid_over, stiffness_factors
from squeal_core.risk.map_builder import build_operating_map, criterion_of, integrated_risk
from squeal_core.risk.map_file import map_path, read_operating_map, write_operating_map
from squeal_core.risk.operating_map import OperatingMap
from squeal_core.risk.smoothing import gaussian_masses, probability_scores
from squeal_core.risk.uncertainty import InputUncertainty, RiskParameters
from squeal_core.stability.eigensolution import eigenvalues

BAND = (1250.0, 16000.0)
USUAL = InputUncertainty(friction=0.02, pressure=0.03, rotor_speed=0.01, contact_stiffness=0.1)
PARAMETERS = RiskParameters(band_hz=BAND, growth_threshold=0.01, uncertainty=USUAL)
PLACE = (10.0, 9e5, 0.24)  # rotor speed [rad/s], contact pressure [Pa], friction
WITHIN = 0.02  # of a probability


def small_model() -> BrakeModel:
    """Four modes; those at 2000 and 2060 Hz merge at mu = 0.24, or at another stiffness."""
    couple = np.zeros((4, 4))
    couple[2, 3], couple[3, 2] = 2e-3, -2e-3
    shape = np.random.default_rng(0).standard_normal((4, 4))
    return BrakeModel(
        angular_frequencies=2 * np.pi * np.array([900.0, 1500.0, 2000.0, 2060.0]),
        contact_stiffness=1e-4 * np.diag([1.0, 0.5, 2.0, 1.0]), friction_couple=couple,
        gyroscopic=1e-3 * (shape - shape.T), radial_dissipation=1e-8 * (shape @ shape.T),
        negative_slope=1e-6 * (shape @ shape.T), nominal_contact_stiffness=1e10,
        caliper=Caliper(2.5e-3), friction_law=FrictionLaw())


SMALL = small_model()


@cache
def small_map() -> OperatingMap:
    area = SMALL.contact_area
    return build_operating_map(SMALL, PARAMETERS, rotor_speed=(8.0, 12.0), friction=(0.1, 0.4),
                               preload=(7e5 * area, 1.2e6 * area), checks=6)


def sampled(model: BrakeModel, parameters: RiskParameters, place: tuple[float, float, float],
            count: int) -> tuple[float, float]:
    """Return the fraction of samples, solved in full, in which a mode grows; two errors of it."""
    steps = norm.ppf(qmc.Sobol(4, seed=1).random(count))
    deviations = parameters.uncertainty
    criterion, grows = criterion_of(model, parameters), 0
    for speed, pressure, friction, stiffness in steps.tolist():
        grid, _ = grid_over(
            model, replace(deviations, friction=0.0, contact_stiffness=0.0),
            rotor_speed=(place[0] * (1.0 + deviations.rotor_speed * speed),) * 2,
            contact_pressure=(place[1] * (1.0 + deviations.pressure * pressure),) * 2,
            friction=(place[2] + deviations.friction * friction,) * 2)
        first = np.zeros(4, np.intp)
        point = grid.between(first, first)
        point = replace(point, contact_stiffness=point.contact_stiffness * np.exp(
            deviations.contact_stiffness * stiffness))
        grows += criterion.excess(eigenvalues(model, point)).max() > 0.0
    found = grows / count
    return found, 2.0 * np.sqrt(max(found * (1.0 - found), 1.0 / count) / count)


@pytest.mark.parametrize('deviation', [0.003, 0.01, 0.02, 0.1])
def test_narrow_gaussians_make_up_a_gaussian(deviation: float) -> None:
    points = np.asarray(0.01 * np.arange(-40, 41), float)
    masses, narrow = gaussian_masses(points, deviation)
    assert masses.sum() == pytest.approx(1.0)
    square = float(masses @ points**2) + narrow**2
    # what lies beyond three standard deviations takes a little away
    assert np.sqrt(square) == pytest.approx(deviation, rel=0.02)


@pytest.mark.parametrize('mean', [-8.0, -2.0, 0.0, 1.0, 5.0])
@pytest.mark.parametrize('changes', [
    (0.0, 0.0, 0.0, 3.0), (0.0, 0.0, 3.0, 0.0), (2.0, -1.0, 0.0, 0.0), (0.5, 1.0, -2.0, 3.0)])
def test_growth_linear_in_the_inputs(mean: float, changes: tuple[float, ...]) -> None:
    grid, nominal = grid_over(SMALL, USUAL, rotor_speed=(8.0, 12.0), contact_pressure=(5e5, 1e6),
                              friction=(0.3, 0.32))
    at = [np.log(grid.rotor_speed / grid.rotor_speed[2]) / 0.01,
          np.log(grid.contact_pressure / grid.contact_pressure[2]) / 0.03,
          (grid.friction - 0.3) / 0.02, np.log(grid.stiffness_factor) / 0.1]
    excess: FloatArray = mean + sum(change * axis for change, axis in zip(
        changes, np.meshgrid(*at, indexing='ij'), strict=True))
    found = ndtr(probability_scores(grid, excess, nominal, USUAL)[2, 2])
    expected = ndtr((mean + changes[2] * 0.5 * np.arange(3)) / np.linalg.norm(changes))
    assert found == pytest.approx(expected, abs=2e-3)  # three deviations are summed


def test_another_mode_that_rises_does_not_doubt_growth() -> None:
    grid, nominal = grid_over(SMALL, USUAL, rotor_speed=(8.0, 12.0), contact_pressure=(5e5, 1e6),
                              friction=(0.3, 0.32))
    excess = np.ones(grid.shape)
    excess[..., grid.stiffness_factor.size // 2] = 100.0
    assert probability_scores(grid, excess, nominal, USUAL).min() > 3.0
    assert probability_scores(grid, -excess, nominal, USUAL).max() < -3.0


def test_certain_stiffness_is_one_factor() -> None:
    assert stiffness_factors(0.0).tolist() == [1.0]
    assert np.log(stiffness_factors(0.1)[[0, -1]]) == pytest.approx([-0.3, 0.3], abs=0.01)


def test_boxes_cover_the_grid_and_growth_is_that_of_full_solutions() -> None:
    model = replace(SMALL, stiffness_table=StiffnessTable((0.0, 2e5, 4e6), (0.5e10, 1e10, 2e10)))
    grid, _ = grid_over(model, USUAL, rotor_speed=(2.0, 8.0), contact_pressure=(3e5, 3e6),
                        friction=(0.2, 0.3))
    covered = np.zeros(grid.shape, int)
    for box in first_boxes(grid):
        covered[box.slices] += 1
    assert (covered == 1).all()
    criterion, rng = criterion_of(model, PARAMETERS), np.random.default_rng(0)
    box = first_boxes(grid)[0]
    found = box_growth(grid, criterion, box)
    for place in rng.integers(0, box.size, (40, 4)):
        truth = criterion.excess(eigenvalues(
            model, grid.between(place + box.low, place + box.low))).max()
        assert (found.excess[tuple(place)] > 0.0) == (truth > 0.0) or abs(truth) < 1.0
        if abs(truth) < 10.0:
            assert found.excess[tuple(place)] == pytest.approx(truth, abs=1.0)


@pytest.mark.parametrize('friction', [0.15, 0.21, 0.247, 0.28])
def test_map_against_samples(friction: float) -> None:
    place = (*PLACE[:2], friction)
    expected, error = sampled(SMALL, PARAMETERS, place, 512)
    assert float(small_map().risk_at(*place)) == pytest.approx(expected, abs=WITHIN + error)


@pytest.mark.parametrize(('deviations', 'friction'), [
    (replace(USUAL, contact_stiffness=0.0), 0.24),
    (replace(USUAL, friction=0.0, contact_stiffness=0.03), 0.22)])
def test_other_uncertainties_against_samples(deviations: InputUncertainty,
                                             friction: float) -> None:
    parameters, place = replace(PARAMETERS, uncertainty=deviations), (*PLACE[:2], friction)
    expected, error = sampled(SMALL, parameters, place, 512)
    assert 0.02 < expected < 0.98
    assert integrated_risk(SMALL, parameters, *place) == pytest.approx(
        expected, abs=WITHIN + error)


def test_mode_that_enters_the_band_against_samples() -> None:
    parameters, place = replace(PARAMETERS, band_hz=(2039.5, 16000.0)), (10.0, 9e5, 0.4)
    expected, error = sampled(SMALL, parameters, place, 512)
    assert 0.1 < expected < 0.9
    assert integrated_risk(SMALL, parameters, *place) == pytest.approx(
        expected, abs=WITHIN + error)


def test_shipped_model_against_samples(kang: BrakeModel) -> None:
    parameters = replace(PARAMETERS, band_hz=(2000.0, 3000.0))
    place = (36.25, 7.6e5, 0.388)
    expected, error = sampled(kang, parameters, place, 128)
    assert integrated_risk(kang, parameters, *place) == pytest.approx(
        expected, abs=WITHIN + error)


def test_map_knows_its_error() -> None:
    error = small_map().error
    assert error.points == 6
    assert 0.0 < error.rms <= error.largest < WITHIN


def test_interpolation_is_linear_and_ends_at_the_envelope() -> None:
    found = small_map()
    speed, pressure, friction = (axis[1:3] for axis in (
        found.rotor_speed, found.contact_pressure, found.friction))
    corner = found.risk_at(speed[0], pressure[1], friction[0])
    assert float(corner) == pytest.approx(float(ndtr(found.score[1, 2, 1])))
    middle = found.risk_at(np.sqrt(speed[0] * speed[1]), np.sqrt(pressure[0] * pressure[1]),
                           friction.mean())
    assert float(middle) == pytest.approx(float(ndtr(found.score[1:3, 1:3, 1:3].mean())))
    outside = found.risk_at([7.9, 10.0, 10.0, 10.0, np.nan, 0.0],
                            [9e5, 2e6, 9e5, 9e5, 9e5, 9e5], [0.2, 0.2, 0.05, 0.5, 0.2, 0.2])
    assert np.isnan(outside).all()
    ends = found.risk_at(found.rotor_speed[[0, -1]], found.contact_pressure[[0, -1]],
                         found.friction[[0, -1]])
    assert ends == pytest.approx(ndtr([found.score[0, 0, 0], found.score[-1, -1, -1]]))


def test_growth_along_friction_is_that_of_full_solutions() -> None:
    found = small_map()
    frictions, (growth,) = found.friction, found.growth_along_friction(
        np.array(PLACE[:1]), np.array(PLACE[1:2]))
    assert np.isnan(found.growth_along_friction(np.array([1e3]), np.array(PLACE[1:2]))).all()
    assert frictions[[0, -1]] == pytest.approx([0.1, 0.4])
    for friction, rate in zip(frictions.tolist(), growth.tolist(), strict=True):
        point = grid_over(SMALL, USUAL, rotor_speed=PLACE[:1] * 2, contact_pressure=PLACE[1:2] * 2,
                          friction=(friction, friction))[0]
        middle = np.array([0, 0, np.argmin(np.abs(point.friction - friction)),
                           point.stiffness_factor.size // 2])
        truth = criterion_of(SMALL, PARAMETERS).excess(
            eigenvalues(SMALL, point.between(middle, middle))).max() + 0.01
        assert rate == pytest.approx(truth, abs=0.5, rel=0.05)


def test_file_gives_the_map_back(tmp_path: Path, kang: BrakeModel) -> None:
    found, path = small_map(), map_path(tmp_path / 'table.npz')
    assert read_operating_map(path, SMALL) is None
    write_operating_map(found, SMALL, path)
    again = read_operating_map(path, SMALL)
    assert again is not None
    assert again.parameters == found.parameters
    assert float(again.risk_at(*PLACE)) == float(found.risk_at(*PLACE))
    with pytest.raises(TableFileError, match='of another model'):
        read_operating_map(path, kang)
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(TableFileError):
        read_operating_map(path, SMALL)


def test_map_of_header_and_arrays() -> None:
    found = small_map()
    again = OperatingMap.of(found.header(), found.arrays())
    assert again.parameters == found.parameters
    assert again.error == found.error
    assert float(again.risk_at(*PLACE)) == float(found.risk_at(*PLACE))
    for header, arrays in (({}, found.arrays()), (found.header(), {}),
                           (found.header(), {**found.arrays(), 'score': np.zeros((2, 2, 2))}),
                           (found.header(), {**found.arrays(), 'friction': np.zeros(3)})):
        with pytest.raises(ValueError, match='no operating map'):
            OperatingMap.of(header, arrays)
