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

"""What each term adds to a growth rate, against closed forms and differences; labels; trust."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.model.brake_model import OPERATORS, SUPPORTS
from squeal_core.stability.eigensolution import complex_modes, Mode
from squeal_core.stability.eigenvectors import eigenvalue_conditions, mode_vectors
from squeal_core.stability.mechanism import (
    contributions,
    Label,
    Mechanism,
    mechanisms,
    participation,
    powers,
    ROTATION,
    TERMS,
    without_rotation,
)

POINT = OperatingPoint(rotor_speed=7.0, friction=0.5, friction_slope=-0.1, contact_pressure=5e5,
                       contact_stiffness=1e9)
SKEW = np.array([[0.0, 1.0], [-1.0, 0.0]])
W1, W2 = 1e4, 1.02e4
MERGING = (W2**2 - W1**2) / 2.0  # of mu k_c b, for K = diag(w^2) + mu k_c b SKEW
LOAD = 0.5 * 1e9  # mu k_c at POINT


def random_model(seed: int, size: int = 4) -> BrakeModel:
    """All six arrays, none of them small, at POINT."""
    rng = np.random.default_rng(seed)
    skew, *square = rng.standard_normal((6, size, size))
    a, r, s = (x @ x.T for x in square[:3])
    k, d = (x @ x.T for x in rng.standard_normal((2, size, size)))
    return BrakeModel(
        angular_frequencies=np.sort(rng.uniform(1e3, 1e4, size)), damping_ratios=0.01,
        gyroscopic=skew - skew.T, contact_stiffness=1e-3 * a, friction_couple=1e-3 * square[3],
        radial_dissipation=1e-4 * r, negative_slope=1e-4 * s, follower=square[4],
        support_stiffness=1e6 * k, support_damping=10.0 * d, contact_retardation_time=2e-5)


def at(model: BrakeModel, speed: float) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=0.42, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


def by_law(model: BrakeModel, speed: float) -> OperatingPoint:
    assert model.caliper is not None
    return model.operating_point(rotor_speed=speed, pressure=2000.0 / model.caliper.piston_area)


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
    n = model.size
    return np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-k, -d]]))


@pytest.fixture(scope='module')
def of_k09(kang: BrakeModel) -> Callable[[float, bool], tuple[Mechanism, ...]]:
    """Return what gives the mechanisms at a speed, at constant friction or by the law, once."""
    @cache
    def found(speed: float, law: bool) -> tuple[Mechanism, ...]:
        return mechanisms(kang, by_law(kang, speed) if law else at(kang, speed))

    return found


# ---------------------------------------------------------------- contributions and powers

@pytest.mark.parametrize('scale', [1.0, 0.3])
@pytest.mark.parametrize('seed', range(4))
def test_sums_of_random_models(seed: int, scale: float) -> None:
    model, point = random_model(seed), replace(POINT, damping_scale=scale)
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
    point = by_law(kang, speed)
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
    model, step = random_model(seed), 1e-4
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
    point = replace(at(kang, 0.1), friction=0.0)
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
    mode = complex_modes(kang, at(kang, 5.0)).modes[0]
    (found,) = mechanisms(kang, at(kang, 5.0), [mode])
    assert set(found.contributions.values()) == {0.0}
    assert found.label == 'stable'
    assert found.participation[0].name.startswith('pad')


# ---------------------------------------------------------------- labels

TERM_OF: dict[Label, str] = {
    'mode coupling': 'friction_couple', 'negative slope': 'negative_slope',
    'gyroscopic': 'gyroscopic', 'radial-dissipation induced': 'radial_dissipation',
    'follower force': 'follower', 'contact damping': 'contact_damping',
    'divergence': 'negative_slope'}


def nearest(model: BrakeModel, point: OperatingPoint, mode: Mode) -> Mode:
    return min(complex_modes(model, point).modes,
               key=lambda m: abs(m.frequency_hz - mode.frequency_hz))


CASES: list[tuple[float, bool, dict[int, Label]]] = [
    (5.0, False, {13: 'mode coupling', 26: 'radial-dissipation induced'}),
    (20.0, False, {10: 'gyroscopic', 13: 'mode coupling', 18: 'mode coupling',
                   26: 'radial-dissipation induced', 40: 'gyroscopic', 46: 'gyroscopic'}),
    (5.0, True, {1: 'divergence', 2: 'divergence', 12: 'negative slope', 13: 'mode coupling',
                 26: 'radial-dissipation induced'})]


@pytest.mark.parametrize(('speed', 'law', 'expected'), CASES)
def test_labels_of_k09(speed: float, law: bool, expected: dict[int, Label], kang: BrakeModel,
                       of_k09: Callable[[float, bool], tuple[Mechanism, ...]]) -> None:
    """And full solves with the label's term out, in which the mode of that frequency is stable."""
    point = by_law(kang, speed) if law else at(kang, speed)
    found = of_k09(speed, law)
    assert {m.mode.index: m.label for m in found} == expected
    for m in found:
        term = TERM_OF[m.label]
        cured = nearest(replace(kang, **{term: None}), point, m.mode)
        assert not cured.unstable
        assert m.without[term] <= 1e-2
        around = [other.growth_rate for other in complex_modes(
            replace(kang, **{term: None}), point).modes
            if other.frequency_hz == pytest.approx(m.mode.frequency_hz, rel=0.01)]
        assert min(abs(growth - m.without[term]) for growth in around) < 1e-6
    free = without_rotation(kang)
    for m in found:
        if m.label == 'mode coupling':
            assert nearest(free, point, m.mode).frequency_hz == pytest.approx(
                m.mode.frequency_hz, rel=0.01)
            assert complex_modes(free, point).flutter_in(
                0.99 * m.mode.frequency_hz, 1.01 * m.mode.frequency_hz)


def labels(**arrays: FloatArray | list[float] | float) -> dict[Label, str]:
    model = BrakeModel(**{'angular_frequencies': [W1, W2], 'damping_ratios': 1e-5,  # type: ignore[arg-type]  # noqa: E501
                          **arrays})
    return {m.label: m.reason for m in mechanisms(model, POINT)}


BELOW, ABOVE = (part * MERGING / LOAD * SKEW for part in (0.8, 1.2))
SPIN = 20.0 / 7.0 * SKEW  # G0: 20 1/s at POINT's speed
ONE_SIDED = np.diag([20.0, 0.0]) / (5e5 * 0.5 / 7.0)  # R0: 20 1/s of mode 1
SLIDING = np.diag([1e-3, 1e-3])  # S0: -50 1/s of both


@pytest.mark.parametrize(('arrays', 'label'), [
    ({'friction_couple': ABOVE}, 'mode coupling'),
    ({'friction_couple': BELOW, 'gyroscopic': SPIN}, 'gyroscopic'),
    ({'friction_couple': BELOW, 'radial_dissipation': ONE_SIDED}, 'radial-dissipation induced'),
    ({'friction_couple': BELOW, 'negative_slope': SLIDING}, 'negative slope'),
    ({'negative_slope': SLIDING}, 'negative slope'),
    ({'follower': 1.2 * MERGING / (5e5 * 0.5) * SKEW}, 'follower force'),
    # friction of the dashpot's force along the motion: -25 1/s; that of the spring's only softens
    ({'friction_couple': -1e-3 * np.eye(2), 'contact_retardation_time': 5e-5},
     'contact damping'),
    # either of two is enough: taking one out cures nothing
    ({'friction_couple': ABOVE, 'negative_slope': SLIDING}, 'combined'),
    ({'friction_couple': BELOW, 'gyroscopic': SPIN, 'radial_dissipation': ONE_SIDED},
     'mode coupling'),
], ids=lambda value: value if isinstance(value, str) else '+'.join(value))
def test_labels_by_construction(arrays: dict[str, FloatArray], label: Label) -> None:
    assert label in labels(**arrays)


def test_none_of_the_parts_alone_makes_those_flutter() -> None:
    """The couple below merging, rotation and one-sided damping are all stable on their own."""
    for arrays in ({'friction_couple': BELOW}, {'gyroscopic': SPIN},
                   {'radial_dissipation': ONE_SIDED}):
        assert labels(**arrays) == {}


def test_a_stable_mode() -> None:
    model = BrakeModel(angular_frequencies=[W1, W2], damping_ratios=1e-3)
    found = mechanisms(model, POINT, complex_modes(model, POINT).modes)
    assert [m.label for m in found] == ['stable', 'stable']
    assert found[0].reason == 'growth rate -10.00 1/s'
    assert found[0].without == {}


def test_reason_says_what_was_taken_out(
        of_k09: Callable[[float, bool], tuple[Mechanism, ...]]) -> None:
    found = [mechanism for mechanism in of_k09(5.0, True) if mechanism.mode.index == 12]
    assert found[0].reason.startswith('negative slope needed: growth rate +17.')
    assert '-17.1' in found[0].reason
    assert list(found[0].without) == ['gyroscopic', 'friction_couple', 'radial_dissipation',
                                      'negative_slope', 'rotation']


# ---------------------------------------------------------------- participation

def test_participation_is_kinetic_energy() -> None:
    model = BrakeModel(angular_frequencies=[1e3, 1e3, 2e3, 3e3],
                       names=('disc (2,0)c', 'disc (2,0)s', 'disc (0,0)c', 'disc (0,0)s'))
    right = np.array([0.6, 0.8j, 2.0, 1.0 + 1.0j])
    found = participation(model, right)
    assert [(s.name, s.fraction) for s in found] == [
        ('disc (0,0)c', pytest.approx(4.0 / 7.0)), ('disc (0,0)s', pytest.approx(2.0 / 7.0)),
        ('disc (2,0)', pytest.approx(1.0 / 7.0))]
    assert participation(model, right, top=1) == found[:1]
    bare = BrakeModel(angular_frequencies=[1e3, 2e3])
    assert participation(bare, np.array([0j, 1.0]))[0].name == 'component 2'


@pytest.mark.parametrize(('index', 'name', 'least'), [
    (13, 'disc (3,0)', 0.6), (40, 'disc (6,0)', 0.7), (46, 'disc (7,0)', 0.9),
    (26, 'pad 1 roll', 0.2)])
def test_participants_in_k09(index: int, name: str, least: float, kang: BrakeModel) -> None:
    """The third and the sixth doublet; rigid motions of the pads in pair 25/26."""
    point = at(kang, 20.0)
    mode = complex_modes(kang, point).modes[index - 1]
    (found,) = mechanisms(kang, point, [mode], top=92)
    assert found.participation[0].name == name
    assert found.participation[0].fraction > least
    assert sum(s.fraction for s in found.participation) == pytest.approx(1.0, rel=1e-12)
    if index == 26:
        assert all('pad' in s.name for s in found.participation[:4])


# ---------------------------------------------------------------- trust

def test_condition_of_one_mode() -> None:
    model = BrakeModel(angular_frequencies=[1e3], damping_ratios=0.1)
    mode = complex_modes(model, POINT).modes[0]
    (found,) = eigenvalue_conditions(model, POINT, [mode])
    root, d, k = mode.eigenvalue, 200.0, 1e6
    size = abs(root)**2 + abs(root) * d + k
    assert found.condition == pytest.approx(size / (abs(root) * abs(2.0 * root + d)), rel=1e-9)
    assert found.backward_error < 1e-15
    assert found.error == pytest.approx(found.backward_error * found.condition * 1e3, abs=1e-20)


@pytest.mark.parametrize('seed', range(3))
def test_condition_is_reached_and_not_exceeded(seed: int) -> None:
    """Changes of D and K by a relative part move a root by at most condition times that part."""
    model, part = random_model(seed), 1e-9
    d, k, n = model.damping(POINT), model.stiffness(POINT), model.size

    def moved(root: complex, delta_m: ComplexArray, delta_d: ComplexArray,
              delta_k: ComplexArray) -> float:
        mass = np.eye(n) + delta_m
        lower = np.linalg.solve(mass, np.hstack([-(k + delta_k), -(d + delta_d)]))
        state = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]).astype(complex), lower])
        return float(np.abs(np.linalg.eigvals(state) - root).min())

    rng = np.random.default_rng(seed)
    for mode in complex_modes(model, POINT).modes:
        (found,) = eigenvalue_conditions(model, POINT, [mode])
        root, bound = mode.eigenvalue, found.condition * part * abs(mode.eigenvalue)
        v = mode_vectors(model, POINT, root)
        worst = np.outer(v.left, v.right.conj())
        turn = [abs(root) ** p / root ** p for p in (2, 1, 0)]
        sizes = [1.0, np.linalg.norm(d), np.linalg.norm(k)]
        along = [part * s * t * worst for s, t in zip(sizes, turn, strict=True)]
        assert moved(root, *along) == pytest.approx(bound, rel=1e-3)
        for _ in range(5):
            other = [part * s * x / np.linalg.norm(x) for s, x in zip(
                sizes, rng.standard_normal((3, n, n)), strict=True)]
            assert moved(root, *other) < bound


def test_condition_grows_towards_a_merging() -> None:
    """As the inverse of the root of the distance."""
    def condition(part: float) -> float:
        model = BrakeModel(angular_frequencies=[W1, W2], damping_ratios=0.0,
                           friction_couple=part * MERGING / LOAD * SKEW)
        return eigenvalue_conditions(model, POINT,
                                     complex_modes(model, POINT).modes[:1])[0].condition

    far, near = condition(1.0 - 1e-4), condition(1.0 - 1e-6)
    assert near / far == pytest.approx(10.0, rel=0.01)


def test_trust_of_the_shipped_model(kang: BrakeModel) -> None:
    point = at(kang, 5.0)
    modes = complex_modes(kang, point).modes
    found = eigenvalue_conditions(kang, point, modes)
    assert len(found) == 92
    assert [t.condition for t in found[:6]] == [np.inf] * 6
    assert all(t.error < 1e-3 for t in found[6:])  # growth rates are of 1 to 100 1/s
    assert max(t.condition for t in found[6:]) > 1e2
