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

"""Series of the spectrum against full eigensolutions, closed forms and their own convergence."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray, FloatArray
from squeal_core.stability.eigensolution import eigenvalues
from squeal_core.surrogate.expansion_builder import expand_spectrum
from squeal_core.surrogate.spectral_expansion import SpectralExpansion
from support.engine_models import between, companion_roots, near, point, random_model, random_point

# terms from the second degree on are of single precision, and so large at most
SINGLE = 1e-4
OPERATORS = ('gyroscopic', 'contact_stiffness', 'friction_couple', 'radial_dissipation',
             'negative_slope')


def series_at(anchor: SpectralExpansion, at: OperatingPoint) -> tuple[ComplexArray, FloatArray]:
    roots, errors = anchor.eigenvalues(np.array(at.coefficients())[:, None])
    return roots[:, 0], errors[:, 0]


def whole(anchor: SpectralExpansion, values: Any) -> Any:
    """Values of the anchor's roots, then of their mirror images (conjugates)."""
    return np.concatenate([values, np.conj(values[anchor.mirrored])])


def off(anchor: SpectralExpansion, roots: ComplexArray,
        truth: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Distance of each root from its own of the truth, one to one; and the truth in that order."""
    every = whole(anchor, roots)
    zeros = np.zeros(truth.size - every.size)  # of coordinates that nothing holds
    ours, theirs = linear_sum_assignment(np.abs(np.append(every, zeros)[:, None] - truth))
    assert np.array_equal(ours, np.arange(truth.size))
    away = np.abs(np.append(every, zeros) - truth[theirs])
    assert away[every.size:].max(initial=0.0) < 1e-6
    return away[:roots.size], truth[theirs][:roots.size]


def blocks_of(anchor: SpectralExpansion) -> Any:
    """Size of the block of each root."""
    return np.repeat(anchor.sizes, anchor.sizes)


# ---------------------------------------------------------------- convergence

@pytest.mark.parametrize('degree', [3, 4, 5])
@pytest.mark.parametrize('which', ['kang', 'blocks'])
def test_errors_fall_with_the_step(kang: BrakeModel, degree: int, which: str) -> None:
    """
    Error ~ step^(degree + 1): single modes, pairs and larger blocks.

    Of a block the mean of its roots is what a power series holds; the roots themselves may merge.
    """
    model, start, floor = {
        'kang': (kang, kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42),
                 10.0 * SINGLE),
        'blocks': (random_model(14, seed=1), point(), 0.1 * SINGLE)}[which]
    anchor = expand_spectrum(model, start, degree=degree)
    end = replace(start, rotor_speed=22.0, friction=0.40, contact_stiffness=0.357e11,
                  contact_pressure=1.08 * start.contact_pressure)
    steps = 1.25 ** np.arange(8, -8, -1)
    away = np.transpose([off_means(anchor, model, between(start, end, step)) for step in steps])
    rates: dict[int, list[float]] = {1: [], 2: [], 3: []}
    for size, line in zip(anchor.sizes, away, strict=True):
        # where the series converges, and its error is more than single precision
        used = np.flatnonzero((line > floor) & (line < 0.1))[-5:]
        if used.size >= 4:
            rates[min(size, 3)].append(np.polyfit(np.log(steps[used]), np.log(line[used]), 1)[0])
    for size in (1,) if which == 'kang' else (1, 2, 3):
        of_size = rates[size]
        # where the first term that is left out happens to be small the line bends
        assert sum(rate < degree + 0.4 for rate in of_size) <= 0.05 * len(of_size)
        assert degree + 0.6 < np.median(of_size) < degree + 2.0


def off_means(anchor: SpectralExpansion, model: BrakeModel, at: OperatingPoint) -> FloatArray:
    """Return how far the mean of each block's roots is from that of the truth."""
    roots, _ = series_at(anchor, at)
    truth = eigenvalues(model, at)
    every = whole(anchor, roots)
    _, theirs = linear_sum_assignment(np.abs(every[:, None] - truth))
    ends = np.cumsum(anchor.sizes) - anchor.sizes
    return np.abs(np.add.reduceat(roots - truth[theirs[:roots.size]], ends)) / anchor.sizes


@pytest.mark.parametrize('degree', [3, 4, 6])
def test_rate_of_a_single_mode_in_closed_form(degree: int) -> None:
    """Expand w -> sqrt(w^2 + k a - (d/2)^2): its series in k is known, and the error's rate."""
    model = BrakeModel(angular_frequencies=[1e3], contact_stiffness=[[1.0]])
    anchor = expand_spectrum(model, point(contact_stiffness=2e6), degree=degree)

    def error(step: float) -> float:
        k = 2e6 + step * 2e6
        exact = -2.0 + 1j * np.sqrt(1e6 + k - 4.0)
        (root,), _ = series_at(anchor, point(contact_stiffness=k))
        return float(abs(root - exact))

    large, small = error(0.4), error(0.2)
    assert small > 1e-6  # no rounding
    # the ratio of successive errors is 2^(degree + 1), less a part in the step
    assert np.log2(large / small) == pytest.approx(degree + 1.0, abs=0.35)


# ---------------------------------------------------------------- closed forms

def flutter_pair(couple: float = 1e-3) -> BrakeModel:
    """Two undamped modes, w^2 = 1e8 and 1.1e8, coupled as friction does."""
    return BrakeModel(angular_frequencies=np.sqrt([1e8, 1.1e8]), damping_ratios=0.0,
                      friction_couple=[[0.0, couple], [-couple, 0.0]])


@pytest.mark.parametrize('friction', [0.2, 0.49, 0.4999, 0.5001, 0.52, 0.7])
def test_flutter_of_two_modes(friction: float) -> None:
    """lambda^2 = -(mean +- sqrt(half^2 - (mu k b)^2)); they merge at mu k b = half = 5e6."""
    def at(mu: float) -> OperatingPoint:
        return point(friction=mu, contact_stiffness=1e10)

    anchor = expand_spectrum(flutter_pair(), at(0.48))
    assert anchor.sizes.tolist() == [2]
    roots, errors = series_at(anchor, at(friction))
    split = np.emath.sqrt(5e6**2 - (friction * 1e7) ** 2)
    truth = np.emath.sqrt(-(1.05e8 + np.array([split, -split])))
    away, _ = off(anchor, roots, np.concatenate([truth, -truth]))
    # of a root that is a square root of the distance to the merging, rounding is one too
    assert np.all(away <= errors + 1e-6)
    # the two are 490 rad/s apart at most: the other half of the spectrum, 20,000 away, is all
    # that the series has to follow
    assert away.max() < 0.01
    assert (roots.real.max() > 1.0) == (friction > 0.5)


EXCEPTIONAL = BrakeModel(  # D = r diag(1, -1) + g [[0, 1], [-1, 0]], K = 0
    angular_frequencies=[0.0, 0.0], damping_ratios=0.0, gyroscopic=[[0.0, 1.0], [-1.0, 0.0]],
    radial_dissipation=np.diag([1.0, -1.0]))


def damped(turning: float, dissipation: float) -> OperatingPoint:
    return point(rotor_speed=turning, friction=0.5, friction_slope=0.0,
                 contact_pressure=2.0 * dissipation * turning)


@pytest.mark.parametrize('dissipation', [0.0, 8.0, 9.999, 9.999999, 10.001, 12.0, 500.0])
def test_an_exceptional_point_inside_a_block_is_exact(dissipation: float) -> None:
    """+-sqrt(r^2 - g^2): all modes are in the block, so there is nothing that it leaves out."""
    anchor = expand_spectrum(EXCEPTIONAL, damped(10.0, 8.0))
    assert anchor.sizes.tolist() == [2]
    roots, errors = series_at(anchor, damped(10.0, dissipation))
    exact = np.emath.sqrt(dissipation**2 - 100.0) * np.array([1.0, -1.0])
    ours, theirs = linear_sum_assignment(np.abs(roots[:, None] - exact))
    away = np.abs(roots[ours] - exact[theirs])
    # the estimate leaves out the rounding of the last few additions
    assert np.all(away <= errors[ours] + 1e-15 * dissipation)
    # a root of r^2 - g^2: rounding of it, 1e-15 of both squares, over the distance of the roots
    assert away.max() <= 1e-14 * (dissipation**2 + 100.0) / max(abs(exact[0]), 1e-6)


def test_an_anchor_on_an_exceptional_point_does_not_pretend() -> None:
    """Its vectors do not span the space: whatever its series says is worth nothing nearby."""
    try:
        anchor = expand_spectrum(EXCEPTIONAL, damped(10.0, 10.0))
    except np.linalg.LinAlgError:
        return
    for dissipation in (8.0, 9.9, 10.1, 12.0):
        roots, errors = series_at(anchor, damped(10.0, dissipation))
        exact = np.emath.sqrt(dissipation**2 - 100.0)
        assert np.abs(roots - exact).min() <= errors.max()


@pytest.mark.parametrize('stiffness', [1.6e10, 1.88e10, 1.95e10, 2e10, 2.05e10, 2.4e10])
@pytest.mark.parametrize(('couple', 'sizes'), [(2e-5, [2]), (2e-6, [1, 1])])
def test_veering(stiffness: float, couple: float, sizes: list[int]) -> None:
    """
    Two modes of which one stiffens: they veer at k = 2e10, and change places beyond.

    In one block they are followed through it; of two blocks each says that it is lost.
    """
    model = BrakeModel(angular_frequencies=np.sqrt([0.9e8, 1.1e8]), damping_ratios=0.0,
                       contact_stiffness=[[1e-3, couple], [couple, 0.0]])
    anchor = expand_spectrum(model, point(contact_stiffness=1.9e10))
    assert anchor.sizes.tolist() == sizes
    roots, errors = series_at(anchor, point(contact_stiffness=stiffness))
    k = np.array([[0.9e8 + 1e-3 * stiffness, couple * stiffness], [couple * stiffness, 1.1e8]])
    exact = 1j * np.sqrt(np.linalg.eigvalsh(k))
    away, _ = off(anchor, roots, np.concatenate([exact, exact.conj()]))
    assert np.all(away <= errors + 1e-7)
    if sizes == [2]:
        assert away.max() < 0.05
        assert np.abs(roots.real).max() < 0.05
    else:
        assert (errors.max() < 1.0) == (stiffness in (1.88e10, 1.95e10))


def test_two_equal_modes_that_have_nothing_to_do_with_each_other() -> None:
    model = BrakeModel(angular_frequencies=[1e4, 1e4, 3e4],
                       contact_stiffness=np.diag([0.0, 0.0, 1e-3]))
    anchor = expand_spectrum(model, point(contact_stiffness=1e10))
    at = point(contact_stiffness=1.2e10)
    roots, errors = series_at(anchor, at)
    away, _ = off(anchor, roots, companion_roots(model, at))
    assert np.all(np.isfinite(errors))
    assert np.all(away <= errors + 1e-6)


# ---------------------------------------------------------------- error estimates

@pytest.mark.parametrize('seed', [1, 2])
def test_errors_are_honest(kang: BrakeModel, seed: int) -> None:
    """
    Over the whole range, anchors up to 30 % away in every parameter.

    The estimate is none of all that could be: of roots that oscillate one in 200 is off by more,
    all but a few of them where no answer would come of it. Where one would, the estimate of no
    root is beaten by half. Closely spaced roots that decay at 2e4 1/s without oscillating are the
    known exception: their error estimate counts for nothing, and nothing hangs on them.
    """
    generator = np.random.default_rng(seed)
    larger = beaten = answered = 0
    for _ in range(12):
        start = random_point(generator, kang.contact_area)
        anchor = expand_spectrum(kang, start)
        for step in 10.0 ** generator.uniform(-2.5, -0.5, 6):
            at = near(start, float(step), generator)
            roots, errors = series_at(anchor, at)
            away, truth = off(anchor, roots, eigenvalues(kang, at))
            counted = (truth.imag > 1.0) & (away > SINGLE)
            larger += int(counted.sum())
            beaten += int(np.count_nonzero(away[counted] > errors[counted]))
            if np.all(errors <= np.maximum(0.1, -0.02 * roots.real)):
                answered += 1
                assert np.all(away[counted] <= 1.5 * errors[counted])
                # what a tolerance of 0.1 1/s is for
                growing = truth.real > -5.0
                assert away[growing & (truth.imag > 1.0)].max(initial=0.0) < 0.1
    assert answered > 24
    assert larger > 500
    assert beaten <= 0.005 * larger + 1


def test_far_away_the_error_is_not_finite(kang: BrakeModel) -> None:
    anchor = expand_spectrum(kang, point())
    for far in (point(rotor_speed=200.0), point(contact_stiffness=0.1e11), point(friction=0.9),
                point(rotor_speed=1e6, contact_pressure=1e9)):
        assert series_at(anchor, far)[1].max() == np.inf


def test_at_the_anchor_it_is_the_full_solution(kang: BrakeModel) -> None:
    anchor = expand_spectrum(kang, point())
    roots, errors = series_at(anchor, point())
    away, _ = off(anchor, roots, eigenvalues(kang, point()))
    assert away.max() < 1e-4  # rounding of both, of matrices with entries of 1e10
    assert errors.max() < 1e-3


def test_reach_is_where_errors_are_a_tenth(kang: BrakeModel) -> None:
    """A step of the reach in a single coefficient costs about 0.1 1/s, within its order."""
    anchor = expand_spectrum(kang, point())
    for row, reach in zip(anchor.rows, anchor.trust_radius, strict=True):
        if anchor.centre[anchor.rows.tolist().index(row)] == 0.0 or reach > 1e10:
            continue
        moved = np.array(point().coefficients())[:, None]
        moved[row] += 0.3 * reach
        assert 0.0 < anchor.eigenvalues(moved)[1].min() < 0.1


# ---------------------------------------------------------------- any model

@pytest.mark.parametrize('size', [1, 2, 3, 60, 150])
def test_models_of_any_size(size: int) -> None:
    model, generator = random_model(size, seed=size), np.random.default_rng(size)
    anchor = expand_spectrum(model, point())
    assert anchor.sizes.sum() + anchor.mirrored.sum() == 2 * size
    for step in (0.001, 0.01, 0.03):
        at = near(point(), step, generator)
        roots, errors = series_at(anchor, at)
        away, truth = off(anchor, roots, companion_roots(model, at))
        counted = (truth.imag > 1.0) & np.isfinite(errors)
        assert counted.any()
        assert np.all(away[counted] <= np.maximum(1.5 * errors[counted], SINGLE))


@pytest.mark.parametrize('changes', [
    *(pytest.param({name: None}, id=f'no {name}') for name in OPERATORS),
    pytest.param(dict.fromkeys(OPERATORS[:4]), id='slope alone'),
    pytest.param(dict.fromkeys(OPERATORS), id='nothing'),
    pytest.param({'follower': 1e-6}, id='follower'),
    pytest.param({'support_stiffness': 1e6, 'support_damping': 3.0}, id='supports'),
    pytest.param({'contact_retardation_time': 8e-6}, id='contact damping'),
    pytest.param({'gyroscopic': 0.0}, id='zeros')])
def test_models_without_or_with(changes: dict[str, Any]) -> None:
    size, generator = 12, np.random.default_rng(3)
    shapes = generator.normal(size=(size, size))
    symmetric = shapes @ shapes.T / size
    arrays = {name: scale if scale is None or name.endswith('time') else scale * (
        shapes if name == 'follower' else symmetric) for name, scale in changes.items()}
    model = random_model(size, seed=4, **arrays)
    anchor = expand_spectrum(model, point())
    for step in (0.003, 0.02):
        at = near(point(), step, generator)
        roots, errors = series_at(anchor, at)
        away, truth = off(anchor, roots, companion_roots(model, at))
        counted = (truth.imag > 1.0) & np.isfinite(errors)
        assert counted.sum() >= size - 2
        assert np.all(away[counted] <= np.maximum(1.5 * errors[counted], SINGLE))
    assert anchor.rows.size == (0 if changes.keys() >= set(OPERATORS) else anchor.centre.size)
    assert anchor.rows.max(initial=0) < 6  # contact damping adds no variable to the series


@pytest.mark.parametrize('changes', [
    {'friction': 0.0}, {'friction_slope': 0.0}, {'contact_pressure': 0.0},
    {'contact_stiffness': 0.0}, {'rotor_speed': -20.0, 'friction': -0.42}])
def test_points_where_a_coefficient_vanishes_or_is_negative(changes: dict[str, float]) -> None:
    model, start = random_model(12, seed=5), point(**changes)
    anchor = expand_spectrum(model, start)
    at = replace(start, rotor_speed=1.002 * start.rotor_speed,
                 friction_slope=start.friction_slope + 1e-4)
    roots, errors = series_at(anchor, at)
    away, _ = off(anchor, roots, companion_roots(model, at))
    assert errors.max() < 1.0
    assert np.all(away <= np.maximum(1.5 * errors, SINGLE))


def turned(model: BrakeModel, angle: float) -> BrakeModel:
    """Return the brake with the cos and sin shapes of every doublet turned into each other."""
    w, turn, i = model.angular_frequencies, np.eye(model.size), 0
    while i + 1 < model.size:
        if w[i] > 0.0 and abs(w[i + 1] - w[i]) < 1e-9 * w[i]:
            c, s = np.cos(angle * (i + 1)), np.sin(angle * (i + 1))
            turn[i:i + 2, i:i + 2] = [[c, -s], [s, c]]
            i += 1
        i += 1
    assert not np.array_equal(turn, np.eye(model.size))
    return replace(model, provenance={}, **{
        name: turn.T @ getattr(model, name) @ turn for name in OPERATORS})


def test_the_orientation_of_doublets_does_not_matter(kang: BrakeModel) -> None:
    start = kang.operating_point(rotor_speed=20.0, pressure=7.84e5, friction=0.42)
    first, second = expand_spectrum(kang, start), expand_spectrum(turned(kang, 0.7), start)
    assert first.sizes.tolist() == second.sizes.tolist()
    at = replace(start, rotor_speed=21.0, friction=0.41)
    (roots, errors), (others, other_errors) = (series_at(a, at) for a in (first, second))
    ours, theirs = linear_sum_assignment(np.abs(roots[:, None] - others))
    assert np.abs(roots[ours] - others[theirs]).max() < SINGLE
    assert other_errors[theirs] == pytest.approx(errors[ours], rel=0.1, abs=SINGLE)


def test_many_points_at_once_are_each_of_them(kang: BrakeModel) -> None:
    anchor, generator = expand_spectrum(kang, point()), np.random.default_rng(1)
    points = [near(point(), step, generator) for step in (0.0, 0.01, 0.03, 0.1, 0.3)]
    roots, errors = anchor.eigenvalues(np.transpose([p.coefficients() for p in points]))
    for i, at in enumerate(points):
        alone = series_at(anchor, at)
        assert roots[:, i] == pytest.approx(alone[0], rel=1e-12, abs=1e-6)
        assert errors[:, i] == pytest.approx(alone[1], rel=1e-6)


def test_an_anchor_cannot_be_changed(kang: BrakeModel) -> None:
    anchor = expand_spectrum(kang, point())
    for array in (anchor.series, anchor.coupling_ratio, anchor.scales, anchor.rounding,
                  anchor.pair_remainder.rates, *anchor.term_norms):
        assert not array.flags.writeable
    assert 10_000 < anchor.nbytes < 1_000_000


# ---------------------------------------------------------------- roots alone

@pytest.mark.parametrize(('speed', 'friction', 'sizes'), [
    (2.0, 0.2, {1, 2, 3}), (5.0, 0.42, {1, 2, 4}), (20.0, 0.42, {1, 5})])
def test_roots_alone_are_those_with_errors(kang: BrakeModel, speed: float, friction: float,
                                           sizes: set[int]) -> None:
    """At many points at once, block by block: of larger blocks in whatever order."""
    start = kang.operating_point(rotor_speed=speed, pressure=7.84e5, friction=friction)
    anchor, generator = expand_spectrum(kang, start), np.random.default_rng(2)
    assert set(anchor.sizes.tolist()) == sizes
    points = np.array([near(start, 0.05, generator).coefficients() for _ in range(6)])
    alone, (roots, _) = anchor.eigenvalues_alone(points), anchor.eigenvalues_at(points)
    place = 0
    for size in anchor.sizes.tolist():
        ours, theirs = (np.sort_complex(found[:, place:place + size]) for found in (alone, roots))
        # of matrices of 1e5 1/s, and next to an exceptional point the root of that rounding
        np.testing.assert_allclose(ours, theirs, atol=1e-9 if size < 3 else 1e-5, rtol=0.0)
        place += size
    assert place == roots.shape[1]
