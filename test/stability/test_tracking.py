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

"""Identities of modes against closed forms, plain continuation, and K09's numbering."""

from dataclasses import replace

import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.common.errors import ModelError, OperatingPointError
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.mode_tracking import identify, identities, Identity, track
from squeal_core.stability.parameter_paths import moved

POINT = OperatingPoint(rotor_speed=5.0, friction=0.5, contact_pressure=1e5, contact_stiffness=1e10)
SKEW = np.array([[0.0, 1e-3], [-1e-3, 0.0]])
# friction at which K = diag(w^2) + mu k_c SKEW has a double root: |w1^2 - w2^2| / (2 k_c 1e-3)
MERGING = (1.02e4**2 - 1e4**2) / (2.0 * 1e10 * 1e-3)


def pair(ratios: float | list[float] = 0.0, couple: FloatArray = SKEW) -> BrakeModel:
    """Two modes that friction couples; equal damping 2 xi w where ratios go as 1 / w."""
    return BrakeModel(angular_frequencies=[1e4, 1.02e4], damping_ratios=ratios,
                      friction_couple=couple)


def at(model: BrakeModel, speed: float, friction: float = 0.42) -> OperatingPoint:
    return OperatingPoint(rotor_speed=speed, friction=friction, contact_stiffness=0.35e11,
                          contact_pressure=2000.0 / model.contact_area)


def names(model: BrakeModel, point: OperatingPoint, resolution: float = 1e-2) -> list[str]:
    return list(map(str, identities(model, point, resolution=resolution)))


def rotation_free(model: BrakeModel) -> BrakeModel:
    return replace(model, gyroscopic=None, radial_dissipation=None, negative_slope=None)


def continued(model: BrakeModel, point: OperatingPoint, steps: int) -> ComplexArray:
    """Roots at the point, each where the one of its number comes to by nearness alone."""
    def roots(part: float) -> ComplexArray:
        here = replace(point, friction=part * point.friction)
        return np.array([m.eigenvalue for m in complex_modes(model, here).modes])

    before, now = roots(0.0), roots(1.0 / steps)
    for i in range(2, steps + 1):
        expected, new = 2.0 * now - before, roots(i / steps)
        before, now = now, new[np.abs(expected[:, None] - new).argmin(axis=1)]
    return now


# ---------------------------------------------------------------- merging

@pytest.mark.parametrize(('friction', 'expected'), [
    (0.5, ['1', '2']), (0.97, ['1', '2']), (1.03, ['1/2', '1/2']), (3.0, ['1/2', '1/2'])])
def test_merging_in_closed_form(friction: float, expected: list[str]) -> None:
    """Of equal damping: two frequencies up to the double root, one from there on."""
    model = pair([0.001, 0.001 / 1.02])
    there = replace(POINT, friction=friction * MERGING)
    assert names(model, there) == expected
    roots = [m.eigenvalue for m in complex_modes(model, there).modes]
    assert (abs(roots[0].imag - roots[1].imag) < 1e-3) == (friction > 1.0)


def test_merged_modes_stay_merged() -> None:
    """Beyond the double root and back: which of the two is which is not known any more."""
    points = [replace(POINT, friction=part * MERGING) for part in (0.0, 0.8, 1.5, 0.8, 0.0)]
    found = [[str(i) for i in here.identities] for here in track(pair(), points)]
    assert found == [['1', '2']] * 2 + [['1/2'] * 2] * 3


@pytest.mark.parametrize(('ratios', 'growing'), [([0.001, 0.00103], '1'), ([0.00103, 0.001], '2')])
def test_a_near_merging_is_no_guess(ratios: list[float], growing: str) -> None:
    """Unlike damping keeps roots apart: fine steps find which grows, coarse ones say merged."""
    model, there = pair(ratios), replace(POINT, friction=1.2 * MERGING)
    assert names(model, there) == ['1/2', '1/2']
    fine = names(model, there, 1e-5)
    assert sorted(fine) == ['1', '2']
    worst = complex_modes(model, there).unstable[0]
    assert fine[worst.index - 1] == growing
    plain = continued(model, there, 4000)
    assert plain[int(growing) - 1] == pytest.approx(worst.eigenvalue, rel=1e-9)


def test_only_those_that_merge_are_merged() -> None:
    """A pair that merges, between two modes that do not take part."""
    couple = np.zeros((4, 4))
    couple[1:3, 1:3] = SKEW
    model = BrakeModel(angular_frequencies=[0.98e4, 1e4, 1.02e4, 1.021e4], damping_ratios=0.0,
                       friction_couple=couple)
    assert names(model, replace(POINT, friction=1.2 * MERGING)) == ['1', '2/3', '2/3', '4']


# ---------------------------------------------------------------- crossing and veering

def rising(coupling: float) -> BrakeModel:
    """Friction lifts mode 1 past mode 2, to whom it is coupled symmetrically."""
    return pair(0.001, np.array([[2e-3, coupling], [coupling, 0.0]]))


def test_modes_that_cross_change_places() -> None:
    assert names(rising(0.0), POINT) == ['2', '1']
    assert names(rising(0.0), replace(POINT, friction=0.1)) == ['1', '2']


def test_modes_that_veer_do_not() -> None:
    """The branches stay apart; the shapes change places."""
    assert names(rising(2e-4), POINT) == ['1', '2']
    assert names(rising(-2e-4), POINT) == ['1', '2']


def test_between_crossing_and_veering_nothing_is_guessed() -> None:
    """From no coupling to much: crossed, then perhaps not to be told, then veered."""
    found = [names(rising(c), POINT) for c in np.geomspace(1e-9, 1e-3, 40)]
    crossed, merged, veered = ['2', '1'], ['1/2', '1/2'], ['1', '2']
    order = [crossed, merged, veered]
    assert found[0] == crossed
    assert found[-1] == veered
    assert [order.index(f) for f in found] == sorted(order.index(f) for f in found)


def test_a_doublet_turned_is_the_same_doublet(kang: BrakeModel) -> None:
    """Turning cos and sin of every disc doublet, and signs of vectors, changes no identity."""
    rng = np.random.default_rng(3)
    turn = np.diag(rng.choice([-1.0, 1.0], kang.size))
    for i, name in enumerate(kang.names):
        if name.endswith('c') and f'{name[:-1]}s' == kang.names[min(i + 1, kang.size - 1)]:
            if kang.angular_frequencies[i] != kang.angular_frequencies[i + 1]:
                continue
            c, s = np.cos(a := rng.uniform(0, 6)), np.sin(a)
            turn[i:i + 2, i:i + 2] = [[c, s], [-s, c]]
    assert np.count_nonzero(turn) > kang.size + 40
    turned = replace(kang, **{name: turn @ getattr(kang, name) @ turn.T for name in (
        'gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
        'negative_slope')})
    assert identities(turned, at(kang, 5.0)) == identities(kang, at(kang, 5.0))


# ---------------------------------------------------------------- modes that stop or start

def test_an_overdamped_mode_keeps_its_number() -> None:
    """A friction that rises with speed damps mode 2 until it oscillates no more."""
    model = BrakeModel(angular_frequencies=[1e3, 2e3], damping_ratios=0.01,
                       negative_slope=np.diag([0.0, 0.1]))
    there = replace(POINT, friction_slope=1.0)
    found = identify(model, there)
    assert [m.kind for m in found.modes] == ['stable', 'stable']
    assert [m.frequency_hz > 0.0 for m in found.modes] == [False, True]
    assert list(map(str, found.identities)) == ['2', '1']


def test_a_mode_that_starts_to_oscillate_carries_the_others_numbers() -> None:
    """Two rigid motions of which contact stiffness holds one: it may be either."""
    model = BrakeModel(angular_frequencies=[0.0, 0.0, 1e3], damping_ratios=0.01,
                       contact_stiffness=np.diag([1e-3, 1e-9, 0.0]))
    points = [replace(POINT, contact_stiffness=k) for k in (0.0, 1e6)]
    first, second = track(model, points)
    assert list(map(str, first.identities)) == ['1', '2', '3']
    assert list(map(str, second.identities)) == ['1/2', '1/2', '3']
    assert second.modes[1].frequency_hz == pytest.approx(np.sqrt(1e3) / 2.0 / np.pi, rel=1e-9)


# ---------------------------------------------------------------- the shipped model

@pytest.mark.parametrize(('speed', 'unstable'), [
    (5.0, {'13': 1661.0, '26': 3211.0}),
    (20.0, {'10': 858.0, '13': 1659.0, '18': 2521.0, '26': 3209.0, '40': 5686.0, '46': 7156.0})])
def test_numbers_of_k09(speed: float, unstable: dict[str, float], kang: BrakeModel) -> None:
    """Pairs 13/14 and 25/26 at 5 rad/s (figs 11, 12), 39/40 at 20 rad/s (fig. 14)."""
    found = identify(kang, at(kang, speed))
    grown = {str(i): m.frequency_hz for m, i in zip(found.modes, found.identities, strict=True)
             if m.unstable}
    assert grown == pytest.approx(unstable, rel=2e-3)


@pytest.mark.parametrize('number', [10, 13, 14, 18, 19, 25, 26, 40, 46])
def test_against_plain_continuation(number: int, kang: BrakeModel,
                                    plain: ComplexArray) -> None:
    found = identify(kang, at(kang, 5.0)).of((number,))
    assert [m.eigenvalue for m in found] == [pytest.approx(plain[number - 1], rel=1e-9)]


@pytest.fixture(scope='module')
def plain(kang: BrakeModel) -> ComplexArray:
    return continued(kang, at(kang, 5.0), 150)


def test_all_numbers_are_given_once(kang: BrakeModel) -> None:
    found = identities(kang, at(kang, 5.0))
    assert sorted(n for i in found for n in i.numbers) == list(range(1, 93))
    assert found != identities(kang, at(kang, 5.0, 0.0))  # some change places on the way
    assert [i.numbers for i in identities(kang, at(kang, 5.0, 0.0))] == [
        (n,) for n in range(1, 93)]


def test_resolution_decides_only_what_is_merged(kang: BrakeModel) -> None:
    coarse, fine = (identities(kang, at(kang, 1.0), resolution=r) for r in (1e-2, 1e-4))
    differ = [(a, b) for a, b in zip(coarse, fine, strict=True) if a != b]
    assert all(a.merged and set(b.numbers) < set(a.numbers) for a, b in differ)


def test_the_third_doublet_merges_without_rotation(kang: BrakeModel) -> None:
    """K09 fig. 12, broken lines: one frequency from a friction of some 0.35 on."""
    model = rotation_free(kang)
    points = [at(kang, 5.0, mu) for mu in (0.0, 0.25, 0.5)]
    found = list(track(model, points))
    assert [str(here.identities[12]) for here in found] == ['13', '13', '13/14']
    one, other = found[2].of((13,))
    assert one.frequency_hz == pytest.approx(other.frequency_hz, rel=1e-4)
    assert one.growth_rate - other.growth_rate > 100.0
    assert found[2].of((14,)) == (one, other)


def test_modes_are_those_of_a_solve(kang: BrakeModel) -> None:
    here, there = identify(kang, at(kang, 20.0)).modes, complex_modes(kang, at(kang, 20.0)).modes
    assert [m.kind for m in here] == [m.kind for m in there]
    assert [m.eigenvalue for m in here[6:]] == [
        pytest.approx(m.eigenvalue, rel=1e-9) for m in there[6:]]


def test_a_path_ends_where_its_end_is_identified(kang: BrakeModel) -> None:
    points = [at(kang, 20.0, mu) for mu in np.linspace(0.0, 0.42, 6)]
    *_, last = track(kang, points)
    assert last.identities == identities(kang, points[-1])


# ---------------------------------------------------------------- points

def test_friction_takes_its_slope_along() -> None:
    point = replace(POINT, friction_slope=-0.1)
    assert moved(pair(), point, 'friction', 0.25) == replace(
        point, friction=0.25, friction_slope=-0.05)
    assert moved(pair(), point, 'rotor_speed', 9.0) == replace(point, rotor_speed=9.0)


@pytest.mark.parametrize('speed', [3.0, -3.0])
def test_friction_by_the_law(speed: float, kang: BrakeModel) -> None:
    """The same point as a vehicle's signals give."""
    assert kang.caliper is not None
    expected = kang.operating_point(rotor_speed=speed, pressure=8e5)
    start = replace(expected, rotor_speed=5.0, friction=0.1, friction_slope=0.0)
    found = moved(kang, start, 'rotor_speed', speed, friction_law=True)
    assert found.__dict__ == pytest.approx(expected.__dict__, rel=1e-14)


def test_what_cannot_be_meant() -> None:
    with pytest.raises(ModelError, match='friction_law'):
        moved(pair(), POINT, 'rotor_speed', 1.0, friction_law=True)
    with pytest.raises(OperatingPointError, match='parameter is speed'):
        moved(pair(), POINT, 'speed', 1.0)
    with pytest.raises(OperatingPointError, match='both signs'):
        list(track(pair(), [POINT, replace(POINT, rotor_speed=-5.0)]))


def test_text_of_an_identity() -> None:
    assert str(Identity((25,)).joined(Identity((26, 25)))) == '25/26'
    assert [Identity((3,)).merged, Identity((3, 4)).merged] == [False, True]
