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

"""Build-up: the equation of energy, and what becomes of it over brake applications."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from squeal_core.common.arrays import FloatArray
from squeal_core.risk.application_risk import ApplicationRisk
from squeal_core.risk.build_up import grown, halves, nepers, saturation_energy
from squeal_core.risk.scatter import MIDDLE
from squeal_core.risk.squeal_risk import MemberGrowth, RiskSettings, SquealRisk
from support.linear_growth import LinearGrowth, one_brake
from support.whole_applications import over_application

DECAY, GAIN = 100.0, 1000.0  # 1/s; friction 0.4 holds the amplitude, 0.42 grows at 20 1/s
STIFFNESS, PRESSURE = 0.35e11, 3.5e5  # p0 / k_c = 10 um
MS = 1_000_000  # ns


@pytest.fixture
def risk() -> SquealRisk:
    return SquealRisk(LinearGrowth([3000.0], [DECAY], [GAIN]), one_brake())


def growing(risk: SquealRisk, rate: float) -> MemberGrowth:
    """Return the growth of a tick, at a growth rate."""
    return risk.growth(20.0, PRESSURE, 0.3 + (rate + DECAY) / GAIN, STIFFNESS)


def build_up(application: ApplicationRisk) -> float:
    return float(nepers(application.energy[MIDDLE, 0, 0]))


@pytest.mark.parametrize('rate', [-300.0, -100.0, -1.0, 0.0, 1e-4, 20.0, 80.0])
def test_energy_obeys_its_equation(rate: float) -> None:
    """By an integrator of ordinary differential equations, from three energies."""
    start = np.array([1.0, 0.3, 50.0])
    found = grown(start, np.array(rate), 0.1, np.array(DECAY), np.array(np.inf))
    wanted = solve_ivp(lambda _, e: 2.0 * rate * e + 2.0 * DECAY, (0.0, 0.1), start,
                       rtol=1e-9, atol=1e-9).y[:, -1]
    assert found == pytest.approx(wanted, rel=1e-6)


def test_noise_holds_the_floor_and_contact_loss_ends_growth() -> None:
    at_rest = grown(np.array(1.0), np.array(-DECAY), 3.0, np.array(DECAY), np.array(np.inf))
    assert at_rest == pytest.approx(1.0, abs=1e-12)
    cap = saturation_energy(PRESSURE, STIFFNESS)
    assert float(nepers(cap)) == pytest.approx(np.log(2e4), abs=1e-12)  # 20 um over 1 nm
    assert grown(np.array(1.0), np.array(1e3), 1.0, np.array(DECAY), cap) == cap
    # of a pressure that falls, the tone falls with it
    assert grown(cap, np.array(20.0), 0.1, np.array(DECAY), 0.25 * cap) == 0.25 * cap


def test_the_rule_in_time_is_trapezoidal() -> None:
    """Along a ramp of 200 1/s^2 the logarithmic gain is the integral of the growth rate."""
    energy = np.array(1e4)
    for tick in range(5):
        rates = halves(np.array(10.0 * tick), np.array(10.0 * tick + 10.0), edge=False)
        for rate in rates:
            energy = grown(energy, rate, 0.025, np.array(0.0), np.array(np.inf))
    assert nepers(energy / 1e4) == pytest.approx(0.25 * 25.0, abs=1e-12)


def highest(risk: SquealRisk, hz: float, phase: float, duration: float,
            profile: Callable[[FloatArray], FloatArray]) -> float:
    """Return the largest build-up over a touch that begins at 1 s and a phase."""
    ticks = np.arange(int(2.0 * hz)) / hz - 1.0 - phase
    ticks = ticks[(ticks > -1e-9) & (ticks < duration - 1e-9)]
    application = over_application(
        risk, np.round(1e9 * (2.0 + ticks)).astype(int).tolist(), risk.growth(
            20.0, PRESSURE, 0.3 + (profile(ticks) + DECAY) / GAIN, STIFFNESS))
    return float(nepers(application.peak.max()))


@pytest.mark.parametrize('rate', [10.0, 25.0, 40.0])
def test_rates_of_ticks_agree_on_touches_of_a_fifth_of_a_second(
        risk: SquealRisk, rate: float) -> None:
    """Wherever the ticks fall in the touch, at its ends too: 10, 20 and 100 Hz."""
    found = [[highest(risk, hz, phase, 0.2, lambda time: np.full_like(time, rate))
              for phase in (0.0, 0.013, 0.05, 0.0731, 0.099)] for hz in (10, 20, 100)]
    cap = saturation_energy(PRESSURE, STIFFNESS)
    wanted = nepers(np.minimum(cap, (1.0 + DECAY / rate) * np.exp(0.4 * rate) - DECAY / rate))
    assert np.array(found) == pytest.approx(float(wanted), abs=1e-5)


def test_rates_of_ticks_agree_on_growth_that_comes_and_goes(risk: SquealRisk) -> None:
    """A touch of a second whose growth rate swings from -40 to 20 1/s and back."""
    def swing(time: FloatArray) -> FloatArray:
        return -10.0 - 30.0 * np.cos(2.0 * np.pi * time)

    wanted = highest(risk, 400.0, 0.0, 1.0, swing)
    assert 3.0 < wanted < 7.0
    for hz, error in ((10, 0.4), (20, 0.1), (100, 0.01)):
        found = [highest(risk, hz, phase, 1.0, swing) for phase in (0.0, 0.025, 0.0731)]
        assert found == pytest.approx([wanted] * 3, abs=error), hz


def test_an_unknown_tick_adds_nothing_and_is_marked(risk: SquealRisk) -> None:
    application = ApplicationRisk(risk)
    application.release(0)
    for tick in range(1, 4):
        result = application.update(tick * 50 * MS, growing(risk, 20.0))
    assert result is not None
    assert not result.incomplete
    before = build_up(application)
    application.skip(200 * MS)
    result = application.update(250 * MS, growing(risk, 20.0))
    assert result is not None
    assert result.incomplete
    assert build_up(application) == before
    application.update(300 * MS, growing(risk, 20.0))
    assert build_up(application) > before + 0.9
    application.release(350 * MS)
    result = application.update(400 * MS, growing(risk, 20.0))
    assert result is not None
    assert not result.incomplete


@pytest.mark.parametrize('time', [900 * MS, 50 * MS], ids=['gap', 'clock set back'])
def test_time_that_is_not_known_counts_as_an_unknown_tick(risk: SquealRisk, time: int) -> None:
    application = ApplicationRisk(risk)
    application.release(0)
    for tick in (100, 150):
        application.update(tick * MS, growing(risk, 20.0))
    before = build_up(application)
    result = application.update(time, growing(risk, 20.0))
    assert result is not None
    assert result.incomplete
    assert build_up(application) == before
    application.update(time + 50 * MS, growing(risk, 20.0))
    assert build_up(application) > before + 0.9


def test_a_monitor_started_while_braking_says_that_it_missed_something(risk: SquealRisk) -> None:
    result = ApplicationRisk(risk).update(10**18, growing(risk, 20.0))
    assert result is not None
    assert result.incomplete


def test_a_standstill_ends_the_tone_but_not_the_application(risk: SquealRisk) -> None:
    """Modes decay to their floor by their own damping; what was before is not forgotten."""
    application = ApplicationRisk(risk)
    application.release(0)
    for tick in range(1, 9):
        application.update(tick * 50 * MS, growing(risk, 20.0))
    tone, peak = build_up(application), application.peak.copy()
    application.rest(450 * MS)
    assert build_up(application) == pytest.approx(tone + 20.0 * 0.025 - DECAY * 0.025, abs=0.1)
    for tick in range(10, 14):
        application.rest(tick * 50 * MS)
    assert build_up(application) == pytest.approx(0.0, abs=1e-3)
    result = application.update(700 * MS, growing(risk, 20.0))
    assert result is not None
    assert not result.incomplete
    assert (application.peak >= peak).all()
    assert 0.5 < build_up(application) < 1.5  # half an interval out of the floor


def test_a_release_ends_the_application(risk: SquealRisk) -> None:
    """Its last result has the half interval before; then all is at the floor."""
    application = ApplicationRisk(risk)
    application.release(0)
    for tick in range(1, 5):
        before = application.update(tick * 100 * MS, growing(risk, 10.0))
    last = application.release(500 * MS)
    assert before is not None
    assert last is not None
    assert last.build_up == pytest.approx(before.build_up + 0.05 * 10.0, abs=0.05)
    assert application.energy == pytest.approx(1.0)
    assert application.release(600 * MS) is None


def test_sliding_between_two_evaluations_is_seen(risk: SquealRisk) -> None:
    """Ticks at 100 Hz, every fifth evaluated: 0.23 s are 0.23 s, before a release or a rest."""
    for end in (ApplicationRisk.finish, ApplicationRisk.rest):
        application = ApplicationRisk(risk)
        application.release(0)
        for tick in range(1, 24):
            if tick % 5 == 1:
                application.update(tick * 10 * MS, growing(risk, 20.0))
            else:
                application.hold(tick * 10 * MS)
        end(application, 240 * MS)
        wanted = (1.0 + DECAY / 20.0) * np.exp(40.0 * 0.23) - DECAY / 20.0
        assert application.peak[MIDDLE, 0, 0] == pytest.approx(wanted)


def test_a_band_without_families_has_no_risk() -> None:
    risk = SquealRisk(LinearGrowth([3000.0], [DECAY], [GAIN]), one_brake(),
                      RiskSettings(band_hz=(5000.0, 6000.0)))
    application = ApplicationRisk(risk)
    application.release(0)
    for tick in range(1, 9):
        result = application.update(tick * 50 * MS, growing(risk, 50.0))
    assert result is not None
    assert (result.squeal_risk, result.instability_probability, result.family) == (0.0, 0.0, -1)
    assert np.isnan(result.frequency_hz)
