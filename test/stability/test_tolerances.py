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

"""Verdicts do not depend on the unit of time: tolerances are relative to the spectrum."""

from dataclasses import replace
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.brake.operating_point import SlidingConditions
from squeal_core.monitor.brake_stability import BrakeStability
from squeal_core.monitor.settings import read_settings
from squeal_core.monitor.vehicle_stability import VehicleStability
from squeal_core.stability.critical_parameter import critical_value
from squeal_core.stability.eigensolution import complex_modes, Tolerances
from squeal_core.stability.exceptional_point import nearest_exceptional_point
from squeal_core.stability.mechanism import mechanisms
from squeal_core.stability.mode_tracking import identities
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_cell import TableTolerances
from squeal_core.surrogate.table_domain import TableDomain
from support.engine_models import point, random_model

_OF_TIME = {  # powers of the unit of frequency, with contact pressure and stiffness kept
    'angular_frequencies': 1, 'contact_stiffness': 2, 'friction_couple': 2, 'follower': 2,
    'radial_dissipation': 2, 'negative_slope': 2, 'support_stiffness': 2, 'support_damping': 1}
SCALE = st.floats(-4.0, 4.0).map(lambda power: 10.0**power)


def faster(model: BrakeModel, scale: float) -> BrakeModel:
    """Return the brake in another unit of time: all eigenvalues are `scale` times as large."""
    return replace(model, provenance={}, **{
        name: scale**power * getattr(model, name) for name, power in _OF_TIME.items()
        if getattr(model, name) is not None})


def faster_point(at: OperatingPoint, scale: float) -> OperatingPoint:
    return replace(at, rotor_speed=scale * at.rotor_speed,
                   friction_slope=at.friction_slope / scale)


def kinds(model: BrakeModel, at: OperatingPoint) -> list[str]:
    return [mode.kind for mode in complex_modes(model, at).modes]


def resting(size: int, seed: int) -> BrakeModel:
    """Return a model with two modes of no frequency, of which one has no stiffness at all."""
    model = random_model(size, seed)
    free = np.ones(size)
    free[0] = 0.0
    return replace(model, angular_frequencies=np.concatenate(
        [[0.0, 0.0], model.angular_frequencies[2:]]), **{
            name: free[:, None] * getattr(model, name) * free
            for name in ('contact_stiffness', 'friction_couple')})


# ---------------------------------------------------------------- the unit of time

@settings(deadline=None, max_examples=40)
@given(size=st.integers(2, 8), seed=st.integers(0, 1000), scale=SCALE,
       slope=st.sampled_from([-0.02, -0.3, 0.0]), rests=st.booleans())
def test_kinds_and_identities_in_any_unit_of_time(size: int, seed: int, scale: float,
                                                  slope: float, rests: bool) -> None:
    model = (resting if rests else random_model)(size, seed)
    at = point(friction_slope=slope)
    other, there = faster(model, scale), faster_point(at, scale)
    assert kinds(other, there) == kinds(model, at)
    here, scaled = complex_modes(model, at), complex_modes(other, there)
    np.testing.assert_allclose(scaled.mode_eigenvalues / scale, here.mode_eigenvalues, atol=1e-3,
                               rtol=0.0)
    assert identities(other, there) == identities(model, at)


@settings(deadline=None, max_examples=15)
@given(size=st.integers(2, 8), seed=st.integers(0, 1000), scale=SCALE)
def test_analysis_in_any_unit_of_time(size: int, seed: int, scale: float) -> None:
    """Critical friction, mechanisms and the merging of two modes."""
    model, at = random_model(size, seed), point()
    found = []
    for times in (1.0, scale):
        brake, where = faster(model, times), faster_point(at, times)
        band = (0.0, times * 1e5)
        critical = critical_value(brake, where, 'friction', (0.0, 1.0), band_hz=band)
        merged = nearest_exceptional_point(brake, where, band_hz=band)
        found.append((
            [critical.below.value, critical.above.value, merged.distance],
            [critical.below.converged, critical.above.converged, merged.converged],
            [(one.mode.index, one.label) for one in mechanisms(brake, where)]))
    np.testing.assert_allclose(found[1][0], found[0][0], rtol=1e-5)
    assert found[1][1:] == found[0][1:]


@pytest.mark.parametrize('scale', [1e-4, 3e-3, 0.07, 20.0, 1e4])
@pytest.mark.parametrize('speed', [1.0, 20.0])
def test_the_shipped_brake_in_any_unit_of_time(kang: BrakeModel, scale: float,
                                               speed: float) -> None:
    at = OperatingPoint(rotor_speed=speed, friction=0.42, friction_slope=-0.05,
                        contact_pressure=2000.0 / kang.contact_area, contact_stiffness=0.35e11)
    expected = kinds(kang, at)
    assert {'rigid', 'flutter', 'divergence', 'stable'} == set(expected)
    assert kinds(faster(kang, scale), faster_point(at, scale)) == expected


def around(scale: float) -> TableDomain:
    return TableDomain(rotor_speed=(19.0 * scale, 21.0 * scale), contact_pressure=(6e5, 8e5),
                       friction=(0.4, 0.44))


def test_blocks_beyond_single_precision_are_gaps_of_a_table() -> None:
    """All twelve eigenvalues are one block: products of twelve differences of 1e6 1/s."""
    assert build_table(faster(random_model(6), 1e3), around(1e3)).cells == ()


@pytest.mark.parametrize('scale', [1e-3, 1.0])
def test_a_table_in_any_unit_of_time(scale: float) -> None:
    """It answers as often and as closely, relative to the spectrum."""
    model = faster(random_model(6), scale)
    domain = around(scale)
    table, limits = build_table(model, domain), Tolerances.of(model)
    x = domain.low + domain.width * np.random.default_rng(0).random((40, 3))
    points, found = domain.points(model, x), table.evaluate(x, limits)
    assert found.answered.sum() > 30
    listed = found.listed()
    for place in np.flatnonzero(found.answered).tolist():
        ours, truth = listed[place], complex_modes(model, points[place])
        own = truth.mode_eigenvalues[ours.numbers - 1]
        assert np.abs(ours.mode_eigenvalues - own).max() < 0.01 * scale
        assert [mode.kind for mode in ours.unstable] == [mode.kind for mode in truth.unstable]


def test_tolerances_of_the_shipped_brake(kang: BrakeModel) -> None:
    """1 rad/s and 0.01 1/s, as in K09's unit."""
    found = Tolerances.of(kang)
    assert found.oscillation == pytest.approx(1.0, rel=0.01)
    assert found.growth == pytest.approx(0.01, rel=0.01)
    assert TableTolerances.of(kang).growth == pytest.approx(0.1, rel=0.01)


# ---------------------------------------------------------------- models of order one

def minimal(**changes: Any) -> BrakeModel:
    return BrakeModel(**{'angular_frequencies': [1.0, 1.02], 'damping_ratios': 0.0,
                         'friction_couple': [[0.0, 1.0], [-1.0, 0.0]], **changes})


def slow(friction: float, **changes: float) -> OperatingPoint:
    return OperatingPoint(**{'rotor_speed': 1.0, 'friction': friction, 'contact_pressure': 0.0,
                             'contact_stiffness': 1.0, **changes})


@pytest.mark.parametrize('damping', [0.0, 0.001])
def test_flutter_of_frequencies_of_order_one(damping: float) -> None:
    """
    Two modes and a couple mu: they merge at mu = (w2^2 - w1^2) / 2, and grow beyond.

    lambda^2 + d lambda + mean +- sqrt(half^2 - mu^2) = 0 with equal damping d of both.
    """
    model = minimal(damping_ratios=0.5 * damping / np.array([1.0, 1.02]))
    mean, half = 0.5 * (1.0 + 1.02**2), 0.5 * (1.02**2 - 1.0)
    for friction in (0.01, 0.02, 0.0203, 0.03):
        split = np.emath.sqrt(half**2 - friction**2)
        exact = -0.5 * damping + np.emath.sqrt(
            0.25 * damping**2 - mean - np.array([split, -split]))
        found = complex_modes(model, slow(friction))
        assert max(mode.growth_rate for mode in found.modes) == pytest.approx(
            max(exact.real.max(), -damping - exact.real.min()), abs=1e-12)
        grows = friction > 0.02025  # 0.0202 and 0.02023 are critical
        assert [mode.kind for mode in found.unstable] == ['flutter'] * grows
    critical = critical_value(model, slow(0.0), 'friction', (0.0, 0.1), band_hz=(0.0, 10.0))
    # Re = -d/2 + |Im split| / (2 w): zero where mu^2 = half^2 + d^2 (mean - ...), to first order
    assert critical.above.value == pytest.approx(np.hypot(half, damping * np.sqrt(mean)), rel=1e-5)


@pytest.mark.parametrize('contact', [False, True])
def test_two_degrees_of_freedom_on_a_belt(contact: bool) -> None:
    """
    Hoffmann et al. 2002: M = I, K = [[k11, k12 - mu k3], [k12, k22]], merging in closed form.

    With all of the stiffness in the contact the model has no frequency of its own.
    """
    k11, k22, k12, k3 = 11.0 / 6.0, 7.0 / 6.0, -np.sqrt(3.0) / 6.0, 4.0 / 3.0
    stiffness = np.array([[k11, k12], [k12, k22]])
    square, shapes = np.linalg.eigh(stiffness)
    couple = np.array([[0.0, -k3], [0.0, 0.0]])
    model = (BrakeModel(angular_frequencies=[0.0, 0.0], damping_ratios=0.0,
                        contact_stiffness=stiffness, friction_couple=couple) if contact else
             BrakeModel(angular_frequencies=np.sqrt(square), damping_ratios=0.0,
                        friction_couple=shapes.T @ couple @ shapes))
    # the roots merge where (k11 - k22)^2 / 4 + k12 (k12 - mu k3) = 0
    merges = (k12 + (k11 - k22) ** 2 / (4.0 * k12)) / k3
    assert merges < 0.0  # friction the other way round
    for friction, grows in ((1.01 * merges, True), (0.99 * merges, False)):
        found = complex_modes(model, slow(friction, rotor_speed=-1.0))
        assert [mode.kind for mode in found.unstable] == ['flutter'] * grows
        split = np.emath.sqrt((k11 - k22) ** 2 / 4.0 + k12 * (k12 - friction * k3))
        exact = np.emath.sqrt(-(k11 + k22) / 2.0 + np.array([split, -split]))
        assert max(mode.growth_rate for mode in found.modes) == pytest.approx(
            np.abs(exact.real).max(), abs=1e-7)


def test_a_disc_of_order_one_that_a_negative_slope_drives() -> None:
    """A doublet that turns: growth -d/2 + p0 |mu_v| S / 2 of both."""
    model = BrakeModel(angular_frequencies=[1.0, 1.0], damping_ratios=5e-4,
                       gyroscopic=[[0.0, 0.3], [-0.3, 0.0]], negative_slope=np.eye(2))
    for slope, kind in ((-0.0009, 'stable'), (-0.0011, 'flutter')):
        found = complex_modes(model, slow(0.4, friction_slope=slope, contact_pressure=1.0))
        assert [mode.kind for mode in found.modes] == [kind] * 2
        assert sum(mode.growth_rate for mode in found.modes) == pytest.approx(-slope - 1e-3)


def test_divergence_and_rest_of_order_one() -> None:
    """A free coordinate rests; one that a negative slope drives diverges."""
    model = BrakeModel(angular_frequencies=[0.0, 0.0, 1.0],
                       negative_slope=np.diag([0.0, 1.0, 0.0]))
    at = slow(0.4, friction_slope=-1e-3, contact_pressure=1.0)
    assert kinds(model, at) == ['divergence', 'rigid', 'stable']


# ---------------------------------------------------------------- the monitor's setting

def test_the_threshold_of_growth_is_a_setting(kang: BrakeModel) -> None:
    """From which growth rate on a mode is unstable in verdicts."""
    counts = []
    for threshold in (0.01, 20.0, 1000.0):
        settings_ = read_settings({
            'brakes': ['front'], 'table': 'none', 'growth_threshold': threshold})
        found, = VehicleStability(kang, settings_).evaluate([
            SlidingConditions(rotor_speed=20.0, pressure=7.84e5, friction=0.42)], [False])
        assert isinstance(found, BrakeStability)
        rates = [mode.growth_rate for mode in found.modes.unstable]
        assert all(rate > threshold for rate in rates)
        counts.append(len(rates))
    assert counts[0] > counts[1] > counts[2] == 0
