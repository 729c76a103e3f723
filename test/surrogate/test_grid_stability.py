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

"""Stability at many points by expansions of groups of them, against full solutions."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.eigensolution import SQUEAL_BAND, Tolerances
from squeal_core.studies.point_options import grid_points, PointOptions
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.grid_columns import EXPANSION, FULL, IMPOSSIBLE
from squeal_core.surrogate.grid_stability import GridStability
from squeal_core.surrogate.group_expansion import LastTerms
from squeal_core.surrogate.spectral_deviation import Accuracy
from squeal_core.surrogate.table_cell import TableTolerances
from support.engine_models import point
from support.expansions import series_at

EXACT_COLUMNS = ('mode', 'squeal_modes', 'flutter_modes', 'divergent_modes')


def coefficients(points: Sequence[OperatingPoint]) -> FloatArray:
    return np.array([at.coefficients() for at in points])


def test_random_points_of_a_wide_grid(kang: BrakeModel) -> None:
    """Low speeds and high loads, too: few full solutions, and no point that differs from one."""
    axes = {'friction': np.linspace(0.2, 0.3, 8), 'rotor_speed': np.linspace(2.0, 10.0, 6),
            'preload': np.linspace(500.0, 6000.0, 10),
            'contact_stiffness': np.linspace(2e10, 2.7e10, 8)}
    points, _ = grid_points(kang, PointOptions(rotor_speed=5.0, friction=0.4).at(kang), {
        name: values.tolist() for name, values in axes.items()}, False)
    tolerances = TableTolerances.of(kang)
    solver = GridStability(kang, SQUEAL_BAND, tolerances)
    found = solver.solve(points)
    assert solver.counts.full < 0.05 * len(points)
    assert (found['source'] == EXPANSION).mean() > 0.97
    assert solver.counts.checks > 0
    assert solver.counts.largest_error <= tolerances.growth
    some = np.random.default_rng(3).choice(len(points), 150, replace=False)
    truth = GridStability(kang, SQUEAL_BAND).solve([points[i] for i in some])
    growth = truth['growth_rate']
    assert (np.abs(found['growth_rate'][some] - growth) <= tolerances.allowed(growth)).all()
    for name in EXACT_COLUMNS:
        assert np.array_equal(found[name][some], truth[name])
    assert found['frequency_hz'][some] == pytest.approx(truth['frequency_hz'], rel=2e-5)


def test_what_cannot_be_expanded_together(kang: BrakeModel) -> None:
    """Damping scales apart; impossible points; one point many times over."""
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    near = [replace(start, friction=friction) for friction in np.linspace(0.40, 0.44, 20)]
    points = [*near, None, *(replace(at, damping_scale=2.0) for at in near), *20 * [start]]
    found = GridStability(kang, SQUEAL_BAND, TableTolerances.of(kang)).solve(points)
    assert np.flatnonzero(found['source'] == IMPOSSIBLE).tolist() == [20]
    assert np.isnan(found['growth_rate'][20])
    truth = GridStability(kang, SQUEAL_BAND).solve(points)
    assert set(truth['source']) == {FULL, IMPOSSIBLE}
    assert found['growth_rate'] == pytest.approx(truth['growth_rate'], abs=0.1, nan_ok=True)
    assert (np.delete(found['source'], 20) == EXPANSION).mean() > 0.8


def test_a_model_that_nothing_acts_on() -> None:
    """No coefficient is a variable; all points have the eigenvalues of the middle."""
    model = BrakeModel(angular_frequencies=[1e4, 2e4], damping_ratios=0.002)
    points = [point(rotor_speed=speed) for speed in np.linspace(1.0, 9.0, 30)]
    found = GridStability(model, SQUEAL_BAND, TableTolerances.of(model)).solve(points)
    assert (found['source'] == EXPANSION).all()
    assert found['growth_rate'] == pytest.approx(-20.0, rel=1e-9)
    assert set(found['mode']) == {1.0}


def test_a_series_has_the_coefficients_that_vary_as_variables(kang: BrakeModel) -> None:
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    group = [replace(start, contact_pressure=pressure * start.contact_pressure)
             for pressure in np.linspace(0.5, 1.5, 5)]
    expansion = expand_spectrum(kang, start, degree=4, around=coefficients(group))
    assert expansion.rows.tolist() == [1, 2]  # of radial dissipation and negative slope
    for at in group:
        roots = series_at(expansion, at)
        [truth] = [series_at(expand_spectrum(kang, at), at)]
        unstable = truth[truth.real > -5.0]
        assert np.abs(unstable[:, None] - roots).min(axis=1).max() < 0.01


def test_modes_that_meet_within_a_group_share_a_block() -> None:
    """Veering with a weak coupling, at k = 2e10, too weak to be seen from the centre."""
    couple, group = 2e-6, [point(contact_stiffness=k) for k in np.linspace(1.6e10, 2.4e10, 9)]
    model = BrakeModel(angular_frequencies=np.sqrt([0.9e8, 1.1e8]), damping_ratios=0.0,
                       contact_stiffness=[[1e-3, couple], [couple, 0.0]])
    centre = point(contact_stiffness=1.9e10)
    assert expand_spectrum(model, centre).sizes.tolist() == [1, 1]
    expansion = expand_spectrum(model, centre, degree=4, around=coefficients(group))
    assert expansion.sizes.tolist() == [2]
    for at in group:
        k = at.contact_stiffness
        exact = np.sqrt(np.linalg.eigvalsh([[0.9e8 + 1e-3 * k, couple * k], [couple * k, 1.1e8]]))
        assert np.sort(series_at(expansion, at).imag)[-2:] == pytest.approx(exact, rel=2e-5)


def test_a_group_is_halved_along_the_coefficient_that_matters(kang: BrakeModel) -> None:
    """Terms of degree 4 of half of a group are a 16th; a coefficient of no effect is left."""
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    group = [replace(start, rotor_speed=speed, contact_stiffness=stiffness)
             for speed in (19.99, 20.0, 20.01)
             for stiffness in start.contact_stiffness * np.linspace(0.96, 1.04, 9)]
    here = coefficients(group)
    expansion = expand_spectrum(kang, start, degree=4, around=here)
    last = LastTerms.of(expansion, np.ones(expansion.sizes.sum(), bool)).worth(here, 8.0)
    assert last.predicted(here).max() == pytest.approx(8.0)
    far = last.far_half(here)
    assert np.array_equal(far, here[:, 3] > start.contact_stiffness * 1.0001)
    inner = [i for i, at in enumerate(group)
             if abs(at.contact_stiffness / start.contact_stiffness - 1.0) < 0.021]
    assert last.predicted(here[inner]).max() == pytest.approx(0.5, rel=0.2)


LIMITS = Tolerances(oscillation=1.0, growth=0.01)
ACCURACY = Accuracy(TableTolerances(), LIMITS, (1000.0, 4000.0))


def spectrum(*pairs: tuple[float, float]) -> ComplexArray:
    """Return eigenvalues by growth [1/s] and frequency [Hz]."""
    return np.array([complex(growth, 2.0 * np.pi * hertz) for growth, hertz in pairs])


@pytest.mark.parametrize(('truth', 'off'), [
    (((2.0, 2000.0), (-30.0, 500.0)), 0.0),
    (((2.05, 2000.0), (-30.0, 500.0)), 0.5),  # of 0.1 1/s
    (((2.0, 2000.08), (-30.0, 500.0)), 2.0),  # 2e-5 of the frequency is 0.04 Hz
    (((2.0, 2000.0), (-40.0, 500.0)), 0.0),  # out of the band and far from growing
    (((2.0, 2000.0), (3.0, 6000.0)), np.inf)])  # one that the expansion has missed
def test_deviations_of_spectra(truth: tuple[tuple[float, float], ...], off: float) -> None:
    found = spectrum((2.0, 2000.0), (-30.0, 500.0))
    deviation = ACCURACY.deviation(found, spectrum(*truth))
    if np.isinf(off):
        assert deviation.off > 1e4  # as far as the nearest one is
    else:
        assert deviation.off == pytest.approx(off, abs=1e-9)
        assert deviation.growth == pytest.approx(truth[0][0] - 2.0)


def test_the_least_stable_mode_matters_however_much_it_decays() -> None:
    roots = spectrum((-50.0, 2000.0), (-50.05, 3000.0), (-51.0, 3500.0), (-6.0, 500.0))
    assert ACCURACY.matters(roots[None]).tolist() == [[True, True, False, False]]
