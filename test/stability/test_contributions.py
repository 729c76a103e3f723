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

"""What each term adds to a growth rate and its power, against closed forms and differences."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray
from squeal_core.model.matrix_names import OPERATORS, SUPPORTS
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.eigenvectors import mode_vectors
from squeal_core.stability.mechanism import (
    contributions,
    Mechanism,
    mechanisms,
    powers,
    ROTATION,
    TERMS,
)
from support.eigenvalues import companion
from support.stability_models import (
    kang_point,
    kang_point_by_law,
    LOAD,
    MERGING,
    POINT,
    SKEW,
    supported_model,
    W1,
    W2,
)


def scaled(model: BrakeModel, point: OperatingPoint, term: str, factor: float) -> ComplexArray:
    """Roots with one term scaled, by a plain eigensolution."""
    d, k = np.diag(model.structural_damping), np.diag(model.angular_frequencies**2)
    d = d * (factor if term == 'structural_damping' else 1.0)
    k = k * (factor if term == 'structural_stiffness' else 1.0)
    for name in SUPPORTS:
        held = getattr(model, name) * (factor if name == term else 1.0)
        d, k = (d + held, k) if name.endswith('damping') else (d, k + held)
    for name in OPERATORS:
        array = getattr(model, name)
        if array is None:
            continue
        value = getattr(point.coefficients(), name) * (factor if name == term else 1.0)
        d, k = (d + value * array, k) if name in ROTATION else (d, k + value * array)
    spring = point.contact_stiffness * (model.contact_stiffness
                                        + point.friction * model.friction_couple)
    d = d + model.contact_retardation_time * spring * (
        factor if term == 'contact_damping' else 1.0)
    return np.linalg.eigvals(companion(k, d))


@pytest.mark.parametrize('scale', [1.0, 0.3])
@pytest.mark.parametrize('seed', range(4))
def test_sums_of_random_models(seed: int, scale: float) -> None:
    model, point = supported_model(seed), replace(POINT, damping_scale=scale)
    for mode in complex_modes(model, point).modes:
        vectors = mode_vectors(model, point, mode.eigenvalue)
        found, work = (f(model, point, vectors) for f in (contributions, powers))
        assert tuple(found) == tuple(work) == TERMS
        for terms in (found, work):
            assert sum(terms.values()) == pytest.approx(
                mode.growth_rate, abs=1e-9 * abs(mode.eigenvalue))
            assert max(map(abs, terms.values())) > 1.0


@pytest.mark.parametrize('speed', [0.5, 5.0, 20.0])
def test_sums_of_the_shipped_model(speed: float, kang: BrakeModel) -> None:
    point = kang_point_by_law(kang, speed)
    for mode in complex_modes(kang, point).modes:
        if mode.kind == 'rigid':
            continue
        vectors = mode_vectors(kang, point, mode.eigenvalue)
        limit = 1e-9 * abs(mode.eigenvalue)
        assert sum(contributions(kang, point, vectors).values()) == pytest.approx(
            mode.growth_rate, abs=limit)
        work = powers(kang, point, vectors)
        assert (work == {}) == (mode.kind == 'divergence')
        assert sum(work.values()) == pytest.approx(
            mode.growth_rate if work else 0.0, abs=limit)


@pytest.mark.parametrize('term', TERMS)
@pytest.mark.parametrize('seed', [0, 1])
def test_contributions_are_changes_by_scaling_a_term(seed: int, term: str) -> None:
    """Of damping terms once, of stiffness terms twice the change per relative change."""
    model, step = supported_model(seed), 1e-4
    weight = 1.0 if term in (*ROTATION, 'structural_damping', 'support_damping',
                             'contact_damping') else 2.0
    for mode in complex_modes(model, POINT).modes:
        root = mode.eigenvalue
        found = contributions(model, POINT, mode_vectors(model, POINT, root))[term]
        high, low = (r[np.abs(r - root).argmin()].real
                     for r in (scaled(model, POINT, term, 1.0 + s) for s in (step, -step)))
        # (1e-4)^2 of third derivatives cut off; rounding of 1e4 eps 1e2 over the step
        assert found == pytest.approx(weight * (high - low) / (2.0 * step), rel=1e-4, abs=1e-4)


def test_one_mode_in_closed_form() -> None:
    """-D_j / 2 of each damping term, nothing of a stiffness."""
    model = BrakeModel(angular_frequencies=[1e3], damping_ratios=0.01,
                       contact_stiffness=[[2e-4]], negative_slope=[[3e-4]],
                       radial_dissipation=[[4e-4]])
    mode = complex_modes(model, POINT).modes[0]
    vectors = mode_vectors(model, POINT, mode.eigenvalue)
    expected = {'structural_damping': -10.0, 'structural_stiffness': 0.0,
                'contact_stiffness': 0.0, 'radial_dissipation': -0.5 * 5e5 * 0.5 / 7.0 * 4e-4,
                'negative_slope': 0.5 * 5e5 * 0.1 * 3e-4}
    assert contributions(model, POINT, vectors) == pytest.approx(expected, abs=1e-9)
    assert powers(model, POINT, vectors) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize('beyond', [1.01, 1.3, 3.0])
def test_flutter_of_two_modes_in_closed_form(beyond: float) -> None:
    """
    Of K = diag(w^2) + b SKEW: growing root l^2 = -(mean +- i sqrt(b^2 - gap^2)).

    The couple adds Re(i b^2 / (s l)), the separation takes Re(i gap^2 / (s l)), s the root.
    """
    model = BrakeModel(angular_frequencies=[W1, W2], damping_ratios=0.0,
                       friction_couple=beyond * MERGING / LOAD * SKEW)
    mode = complex_modes(model, POINT).unstable[0]
    root, split = mode.eigenvalue, MERGING * np.sqrt(beyond**2 - 1.0)
    assert root**2 == pytest.approx(-0.5 * (W1**2 + W2**2) + 1j * split, rel=1e-9)
    found = contributions(model, POINT, mode_vectors(model, POINT, root))
    couple = ((1j / split / root) * (beyond * MERGING)**2).real
    mean = (-0.5 * (W1**2 + W2**2) / root).real
    assert found['friction_couple'] == pytest.approx(couple, rel=1e-6)
    assert found['structural_stiffness'] == pytest.approx(
        mean - ((1j / split / root) * MERGING**2).real, rel=1e-6)
    assert found['friction_couple'] > mode.growth_rate > 0.0
    work = powers(model, POINT, mode_vectors(model, POINT, root))
    assert work == pytest.approx({'structural_damping': 0.0, 'structural_stiffness': 0.0,
                                  'friction_couple': mode.growth_rate}, abs=1e-6)


def test_conservative_terms_add_nothing_to_weakly_damped_modes(kang: BrakeModel) -> None:
    """Without friction, all but the modes that G couples most."""
    point = replace(kang_point(kang, 0.1), friction=0.0)
    for mode in complex_modes(kang, point).modes[6:60]:
        found = contributions(kang, point, mode_vectors(kang, point, mode.eigenvalue))
        assert found['structural_damping'] == pytest.approx(mode.growth_rate, abs=0.1)
        rest = found['structural_stiffness'] + found['contact_stiffness'] + found['gyroscopic']
        assert abs(rest) < 1e-5 * abs(mode.eigenvalue)


def test_signs_in_k09(of_k09: Callable[[float, bool], tuple[Mechanism, ...]]) -> None:
    """What makes a mode grow counts as positive: the couple, G at speed, R in the pad pair."""
    slow, fast = ({round(m.mode.frequency_hz, -1): m for m in of_k09(speed, False)}
                  for speed in (5.0, 20.0))
    assert all(m.contributions['friction_couple'] > 0.0 for m in slow.values())
    assert slow[3210.0].contributions['radial_dissipation'] > 0.5
    assert slow[1660.0].contributions['radial_dissipation'] < -10.0
    assert fast[5690.0].contributions['gyroscopic'] > 25.0
    # what radial dissipation does directly is take power
    assert all(m.powers['radial_dissipation'] < -1.0 for m in fast.values())
    assert all(m.powers['gyroscopic'] == 0.0 for m in fast.values())


def test_zeros_for_a_root_at_zero(kang: BrakeModel) -> None:
    mode = complex_modes(kang, kang_point(kang, 5.0)).modes[0]
    (found,) = mechanisms(kang, kang_point(kang, 5.0), [mode])
    assert set(found.contributions.values()) == {0.0}
    assert found.label == 'stable'
    assert found.participation[0].name.startswith('pad')
