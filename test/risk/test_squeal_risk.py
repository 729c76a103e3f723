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

"""Squeal risk and instability probability against closed forms and plain Monte Carlo."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.build_up import nepers
from squeal_core.risk.ensemble import EnsemblePrior, prior_ensemble
from squeal_core.risk.scatter import along_scatter, exceedance, NODES, WEIGHTS
from squeal_core.risk.squeal_risk import MemberGrowth, RiskResult, RiskSettings, SquealRisk
from support.linear_growth import LinearGrowth, members, one_brake
from support.whole_applications import over_application

STIFFNESS, PRESSURE = 0.35e11, 3.5e5  # p0 / k_c = 10 um
PERIOD = 50_000_000  # ns
PRIOR = EnsemblePrior()
FAMILIES = ((1700.0, 2500.0, 3200.0, 5700.0, 700.0), (50.0, 80.0, 100.0, 180.0, 20.0),
            (300.0, 650.0, 900.0, 1500.0, 9000.0))  # the last is below the band


def steady(risk: SquealRisk, friction: float, ticks: int) -> RiskResult:
    """Return the risk after some ticks at one friction, a twentieth of a second each."""
    growth = risk.growth(20.0, PRESSURE, np.full(ticks, friction), STIFFNESS)
    return results(risk, growth)[-1]


def results(risk: SquealRisk, growth: MemberGrowth) -> list[RiskResult]:
    application = ApplicationRisk(risk)
    application.release(0)
    found = [application.update((tick + 1) * PERIOD, growth.at(tick))
             for tick in range(len(growth.rate))]
    assert all(found)
    return found  # type: ignore[return-value]


def brakes(count: int, prior: EnsemblePrior, seed: int) -> FloatArray:
    """Return independent brakes, each in an application of its own: scatter is in them."""
    z = np.random.default_rng(seed).standard_normal((7, count))
    return np.array([
        prior.damping * z[0] + prior.damping_scatter * z[5], prior.contact_stiffness * z[1],
        prior.friction * z[2] + prior.friction_scatter * z[6], 1.0 + prior.slope * z[3],
        np.maximum(prior.audible_build_up + prior.audible_build_up_deviation * z[4], 1.0)])


@pytest.mark.parametrize('slopes', [(2.0, -3.0), (-1.0, 0.5), (0.0, 1.0), (0.0, 0.0)])
def test_scatter_is_integrated_exactly_where_the_build_up_is_linear(
        slopes: tuple[float, float]) -> None:
    middle = np.linspace(-3.0, 3.0, 13)
    width = np.hypot(*slopes)
    wanted = norm.cdf(middle / width) if width else (middle > 0.0).astype(float)
    assert abs(along_scatter(*np.array(slopes))) == pytest.approx(width)
    assert exceedance(along_scatter(*np.array(slopes)) * NODES[:, None] + middle
                      ) == pytest.approx(wanted, abs=1e-14)
    assert WEIGHTS.sum() == pytest.approx(1.0)


def test_scatter_is_integrated_where_the_build_up_is_no_line() -> None:
    """A line between a floor and saturation; a valley, positive on both sides."""
    z = np.linspace(-6.0, 6.0, 400_001)
    weight = norm.pdf(z) * (z[1] - z[0])
    zero, width = (one.ravel() for one in np.meshgrid(np.linspace(-1.6, 1.6, 33), [0.1, 0.6]))
    ramp = np.clip((NODES[:, None] - zero) / width, -1.0, 0.8)
    assert exceedance(ramp) == pytest.approx(norm.cdf(-zero), abs=0.07)
    valley = np.abs(NODES - 0.2) - 0.5
    assert exceedance(valley[:, None]) == pytest.approx(
        weight[np.abs(z - 0.2) > 0.5].sum(), abs=0.02)


def test_a_zero_at_a_node_or_far_away_has_its_own_probability() -> None:
    """The function is 2 z of friction plus these values: from sure to impossible."""
    middle = np.array([-60.0, -19.0, -17.0, -8.0, 0.0, 8.0, 17.0, 19.0, 60.0])
    for slope in (2.0, -2.0):
        at = slope * NODES[:, None] + middle
        assert exceedance(at) == pytest.approx(norm.cdf(middle / 2.0), abs=1e-15, rel=0.0)


def test_medians_of_equal_members_are_those_by_weight() -> None:
    """Weights that differ by a millionth of a millionth are sorted, equal ones are not."""
    ensemble = prior_ensemble(PRIOR)
    nearly = 1.0 + 1e-12 * np.cos(np.arange(ensemble.count))
    for friction in (0.36, 0.41):
        found, wanted = (steady(SquealRisk(LinearGrowth(*FAMILIES), one), friction, 6)
                         for one in (ensemble, replace(ensemble, weights=nearly)))
        assert found.build_up == wanted.build_up
        assert found.time_to_squeal == wanted.time_to_squeal
        assert np.array_equal(found.family_build_up, wanted.family_build_up)


def test_risk_of_one_brake_is_that_of_its_scatter() -> None:
    """Friction alone scatters: build-up is linear in it well above the floor."""
    ensemble = members(np.array([[0.0], [0.0], [0.0], [1.0], [5.5]]), friction_scatter=0.004)
    risk = SquealRisk(LinearGrowth([3000.0], [100.0], [1000.0]), ensemble)
    found = steady(risk, 0.415, 8)  # 15 1/s for 0.375 s, 5.6 nepers and 0.9 of noise
    nominal = SquealRisk(risk.emulator, one_brake())
    gain = [steady(nominal, 0.415 + shift, 8).build_up for shift in (-0.004, 0.0, 0.004)]
    assert found.build_up == gain[1]
    assert found.squeal_risk == pytest.approx(
        norm.cdf((gain[1] - 5.5) / (0.5 * (gain[2] - gain[0]))), abs=0.02)
    assert found.time_to_squeal == 0.0
    assert found.instability_probability == pytest.approx(norm.cdf(15.0 / 4.0), abs=0.005)


def test_time_to_squeal_and_severity() -> None:
    risk = SquealRisk(LinearGrowth([3000.0], [100.0], [1000.0]), one_brake())
    found = steady(risk, 0.42, 3)
    assert found.time_to_squeal == pytest.approx((5.5 - found.build_up) / 20.0)
    assert (found.squeal_risk, found.instability_probability) == (0.0, 1.0)
    assert found.frequency_hz == pytest.approx(3000.0)
    quiet = steady(risk, 0.39, 3)
    assert quiet.time_to_squeal == np.inf
    assert quiet.instability_probability == 0.0


def test_damping_below_zeta_star_is_instability() -> None:
    """At 3 kHz, 20 1/s are zeta = -0.106 %."""
    for ratio, wanted in ((0.0, 1.0), (0.0010, 1.0), (0.0012, 0.0)):
        risk = SquealRisk(LinearGrowth([3000.0], [100.0], [1000.0]), one_brake(),
                          RiskSettings(instability_damping_ratio=ratio))
        assert steady(risk, 0.42, 3).instability_probability == wanted


@pytest.mark.parametrize('friction', [0.36, 0.39, 0.42])
def test_risks_agree_with_monte_carlo(friction: float) -> None:
    """64 members and their scatter against 8,000 brakes in one application each."""
    emulator, ticks = LinearGrowth(*FAMILIES), 12
    plain = SquealRisk(emulator, members(brakes(8000, PRIOR, seed=5)))
    growth = plain.growth(20.0, PRESSURE, np.full(ticks, friction), STIFFNESS)
    known = ~np.isnan(growth.rate).any(axis=(0, 1))
    application = over_application(plain, [PERIOD * (i + 1) for i in range(ticks)], growth)
    wanted = plain.exceedances(application.peak)[known].mean()
    unstable = (growth.rate[-1] > 0.0).any(axis=0)[known].mean()
    found = [steady(SquealRisk(emulator, prior_ensemble(replace(PRIOR, seed=seed))), friction,
                    ticks) for seed in range(4)]
    risks = np.array([one.squeal_risk for one in found])
    assert 0.02 < wanted < 0.98
    # the half interval after the last tick and the error of 8,000 brakes are in it
    assert np.sqrt(((risks - wanted)**2).mean()) < 0.02
    assert np.array([one.instability_probability for one in found]) == pytest.approx(
        unstable, abs=0.03)


def test_the_error_covers_what_more_members_change() -> None:
    emulator, seeds, off, stated = LinearGrowth(*FAMILIES), range(6), [], []
    for friction in (0.36, 0.38, 0.40, 0.42):
        many = steady(SquealRisk(emulator, prior_ensemble(replace(PRIOR, count=1024))), friction,
                      12)
        few = [steady(SquealRisk(emulator, prior_ensemble(replace(PRIOR, seed=seed))), friction,
                      12) for seed in seeds]
        off += [one.squeal_risk - many.squeal_risk for one in few]
        stated += [one.error for one in few]
        assert many.error < 0.4 * few[0].error
    rms, error = np.sqrt(np.mean(np.square(off))), np.sqrt(np.mean(np.square(stated)))
    assert rms < 0.025
    assert 0.5 * rms < error < 4.0 * rms  # Sobol members are better than their residuals tell


def test_the_emulators_error_widens_that_of_the_risk() -> None:
    exact, wrong = (steady(SquealRisk(LinearGrowth(*FAMILIES, error=error), prior_ensemble(PRIOR)),
                           0.39, 20) for error in (0.0, 1.0))
    assert wrong.squeal_risk == exact.squeal_risk
    assert wrong.error > exact.error + 0.004


def test_families_outside_the_band_do_not_count() -> None:
    """The last family squeals from friction 0.31 on; it is at 700 Hz."""
    ensemble = prior_ensemble(PRIOR)
    assert steady(SquealRisk(LinearGrowth(*FAMILIES), ensemble), 0.32, 12).squeal_risk < 0.05
    wide = SquealRisk(LinearGrowth(*FAMILIES), ensemble, RiskSettings(band_hz=(500.0, 16000.0)))
    found = steady(wide, 0.32, 12)
    assert found.squeal_risk > 0.5
    assert found.family == 4
    assert found.frequency_hz == pytest.approx(700.0)


def test_many_ticks_at_once_have_the_bits_of_single_ones() -> None:
    risk = SquealRisk(LinearGrowth(*FAMILIES), prior_ensemble(PRIOR))
    friction, pressure = np.linspace(0.35, 0.42, 9), np.linspace(2e5, 9e5, 9)
    together = results(risk, risk.growth(20.0, pressure, friction, STIFFNESS))
    application = ApplicationRisk(risk)
    application.release(0)
    for tick, wanted in enumerate(together):
        found = application.update((tick + 1) * PERIOD, risk.growth(
            20.0, pressure[tick], friction[tick], STIFFNESS))
        assert found is not None
        assert repr(found) == repr(wanted)
        assert np.array_equal(found.family_build_up, wanted.family_build_up)
    whole = over_application(risk, [PERIOD * (i + 1) for i in range(9)],
                             risk.growth(20.0, pressure, friction, STIFFNESS))
    application.finish(10 * PERIOD)
    reached = application.peak
    last = application.release(10 * PERIOD)
    assert last is not None
    assert np.array_equal(whole.peak, reached)
    assert last.peak_risk == pytest.approx(
        risk.exceedances(reached) @ risk.ensemble.weights, rel=1e-12)


def test_members_that_the_emulator_does_not_know_are_left_out() -> None:
    """Their weight is in the error; where most are unknown there is no risk."""
    emulator = LinearGrowth(*FAMILIES)
    values = brakes(256, PRIOR, seed=1)
    known = SquealRisk(emulator, members(values[:, 64:], 0.02, 0.15))
    values[0, :64] = 3.0  # e^3 times the damping: outside
    some = SquealRisk(emulator, members(values, 0.02, 0.15))
    wanted, found = steady(known, 0.39, 12), steady(some, 0.39, 12)
    assert found.squeal_risk == pytest.approx(wanted.squeal_risk, abs=1e-12)
    assert found.instability_probability == pytest.approx(
        wanted.instability_probability, abs=1e-12)
    assert found.error > 0.25
    values[0, :140] = 3.0
    most = SquealRisk(emulator, members(values, 0.02, 0.15))
    growth = most.growth(20.0, PRESSURE, 0.39, STIFFNESS)
    application = ApplicationRisk(most)
    assert application.update(PERIOD, growth) is None


def test_a_calibration_is_said() -> None:
    emulator, ensemble = LinearGrowth(*FAMILIES), prior_ensemble(PRIOR)
    prior = steady(SquealRisk(emulator, ensemble), 0.39, 2)
    assert not prior.calibrated
    assert prior.basis == 'not calibrated: the level of the risk is mostly the prior of damping'
    measured = steady(SquealRisk(emulator, replace(ensemble, calibrated='12 events')), 0.39, 2)
    assert measured.calibrated
    assert measured.basis == '12 events'
    assert measured.squeal_risk == prior.squeal_risk
    assert str(measured) == f'{prior.squeal_risk:.2f} +- {prior.error:.2f} (12 events)'


def test_energies_can_be_compared_with_other_thresholds() -> None:
    """A calibration moves N* of members without stepping again."""
    risk = SquealRisk(LinearGrowth(*FAMILIES), prior_ensemble(PRIOR))
    application = over_application(risk, [PERIOD * (i + 1) for i in range(12)], risk.growth(
        20.0, PRESSURE, np.full(12, 0.39), STIFFNESS))
    lower = SquealRisk(risk.emulator, replace(
        risk.ensemble, audible_build_up=risk.ensemble.audible_build_up - 0.9))
    assert lower.exceedances(application.peak).sum() > risk.exceedances(application.peak).sum()
    assert nepers(application.peak).shape == (NODES.size, 1, 64)
