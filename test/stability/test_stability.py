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

"""Roots, their order and kinds, and vectors, against plain eigensolutions."""

from hypothesis import given, settings
from hypothesis import strategies as st
import numpy as np
import pytest
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import (
    classify,
    complex_modes,
    ComplexModes,
    eigenvalues,
    Tolerances,
)
from squeal_core.stability.eigenvectors import mode_vectors
from support.eigenvalues import companion_at, companion_roots, distance
from support.engine_models import dense_model

TOLERANCES = Tolerances(oscillation=1.0, growth=1e-2)
POINT = OperatingPoint(rotor_speed=7.0, friction=0.5, friction_slope=-0.1, contact_pressure=5e5,
                       contact_stiffness=1e9)
RATE = st.floats(-1e4, 1e4)


def at(model: BrakeModel, speed: float = 5.0, **changes: float) -> OperatingPoint:
    """K09's point, or changes of it."""
    values = {'friction': 0.42, 'contact_pressure': 2000.0 / model.contact_area,
              'contact_stiffness': 0.35e11}
    return OperatingPoint(rotor_speed=speed, **(values | changes))


# ---------------------------------------------------------------- roots

@pytest.mark.parametrize('seed', range(5))
def test_all_roots_of_random_models(seed: int) -> None:
    model = dense_model(seed, 5)
    found = complex_modes(model, POINT).eigenvalues
    # roots up to 1e4 with conditions up to 1e2: eps * 1e6
    assert distance(found, companion_roots(model, POINT)) < 1e-8


@pytest.mark.parametrize('slope', [0.0, -0.1])
def test_all_roots_of_the_shipped_model(slope: float, kang: BrakeModel) -> None:
    point = at(kang, friction_slope=slope)
    found = complex_modes(kang, point).eigenvalues
    whole = companion_roots(kang, point)
    assert found.size == 184
    assert np.count_nonzero(found == 0.0) >= 6  # a zero for each free coordinate, to the last bit
    # the whole matrix' zeros are defective: sqrt(eps) of what couples them; others eps * 2e5 * 1e3
    small, blurred = np.abs(found) < 1.0, np.abs(whole) < 1.0
    assert np.count_nonzero(small) == np.count_nonzero(blurred)
    assert np.abs(found[small]).max() < 1e-9
    assert distance(found[~small], whole[~blurred]) < 1e-6


def test_every_root_solves_the_quadratic(kang: BrakeModel) -> None:
    """Least singular value of lambda^2 + lambda D + K, as a relative change of the matrices."""
    point = at(kang, 20.0)
    d, k = kang.damping(point), kang.stiffness(point)
    for root in eigenvalues(kang, point)[::9]:
        least = np.linalg.svd(root**2 * np.eye(92) + root * d + k, compute_uv=False)[-1]
        size = abs(root)**2 + abs(root) * np.linalg.norm(d, 2) + np.linalg.norm(k, 2)
        assert least < 1e-14 * size  # 184 rows of backward stable QR


def test_no_coordinate_moves() -> None:
    """Only free coordinates: their roots are zero and -D."""
    model = BrakeModel(angular_frequencies=[0.0, 0.0], negative_slope=np.diag([1e-3, 2e-3]))
    found = np.sort(eigenvalues(model, POINT).real)
    assert found == pytest.approx([0.0, 0.0, 50.0, 100.0], rel=1e-14)


def test_a_weakly_held_coordinate_is_not_free() -> None:
    """A millionth of the others' stiffness is a frequency still; only rounding is none."""
    model = BrakeModel(angular_frequencies=np.zeros(3), damping_ratios=0.0,
                       contact_stiffness=np.diag([1.0, 1e-6, 1e-17]))
    assert model.free_coordinates.tolist() == [False, False, True]
    found = complex_modes(model, POINT).modes
    assert [m.kind for m in found] == ['rigid', 'stable', 'stable']
    # sqrt(k_c A0): undamped, so exact to rounding
    assert [m.eigenvalue.imag for m in found[1:]] == pytest.approx(
        [np.sqrt(1e3), np.sqrt(1e9)], rel=1e-12)


# ---------------------------------------------------------------- order and kinds

def make_roots(real: list[float], pairs: list[complex], seed: int) -> ComplexArray:
    roots = np.concatenate([np.array(real, complex), pairs, np.conj(pairs)])
    return np.random.default_rng(seed).permutation(roots)


@settings(deadline=None)
@given(real=st.lists(RATE, max_size=4).filter(lambda x: len(x) % 2 == 0),
       pairs=st.lists(st.builds(complex, RATE, st.floats(1.5, 1e5)), min_size=1, max_size=6),
       seed=st.integers(0, 2**32 - 1))
def test_numbering(real: list[float], pairs: list[complex], seed: int) -> None:
    found = classify(make_roots(real, pairs, seed), TOLERANCES)
    modes, still = found.modes, len(real) // 2
    assert [m.index for m in modes] == list(range(1, still + len(pairs) + 1))
    # modes that do not oscillate come first, each the less stable of two; then by frequency
    assert [m.eigenvalue for m in modes[:still]] == sorted(real, reverse=True)[:still]
    assert [m.frequency_hz for m in modes[still:]] == sorted(z.imag / 2 / np.pi for z in pairs)
    assert all(m.eigenvalue.imag >= 0.0 for m in modes)
    assert sorted(map(str, found.eigenvalues)) == sorted(
        map(str, make_roots(real, pairs, seed)))
    together = found.eigenvalues[len(real):].reshape(-1, 2)
    assert np.array_equal(together[:, 0], together[:, 1].conj())
    growth = [m.growth_rate for m in found.unstable]
    assert growth == sorted(growth, reverse=True)  # worst first
    assert sum(m.growth_rate > TOLERANCES.growth for m in modes) == len(growth)


@pytest.mark.parametrize(('root', 'kind'), [
    (0.011 + 2j, 'flutter'), (0.009 + 2j, 'stable'), (-5 + 2j, 'stable'), (50 + 1.1j, 'flutter'),
    (50 + 0.9j, 'divergence'), (0.011 + 0.9j, 'divergence'), (0.009 + 0.9j, 'rigid'),
    (-0.009 + 0.5j, 'rigid'), (-0.011 + 0.5j, 'stable')])
def test_kinds_at_their_bounds(root: complex, kind: str) -> None:
    """|Im| > 1 rad/s oscillates, Re > 1e-2 1/s grows."""
    modes = classify(np.array([root, np.conj(root)]), TOLERANCES).modes
    assert [m.kind for m in modes] == [kind]
    assert modes[0].unstable == (kind in ('flutter', 'divergence'))


def test_tolerances_are_the_callers(kang: BrakeModel) -> None:
    point = at(kang)
    strict = complex_modes(kang, point, tolerances=Tolerances.of(kang, growth=8.0))
    assert [m.index for m in strict.unstable] == [26]
    assert [m.index for m in complex_modes(kang, point).unstable] == [26, 13]


def test_flutter_in_a_band(kang: BrakeModel) -> None:
    found = complex_modes(kang, at(kang, 20.0, friction_slope=-0.01))
    assert 'divergence' in {m.kind for m in found.unstable}
    band = found.flutter_in(1250.0, 3000.0)
    assert [round(m.frequency_hz, -2) for m in band] == [2500.0, 1700.0]
    edge = band[0].frequency_hz
    assert found.flutter_in(edge, edge) == band[:1]  # both ends belong to it


@pytest.mark.parametrize(('root', 'expected'), [
    (-3 + 4j, 0.6), (3 + 4j, -0.6), (-2 + 0j, 1.0), (2 + 0j, -1.0), (5j, 0.0), (0j, 0.0)])
def test_damping_ratio(root: complex, expected: float) -> None:
    """-Re / |lambda|: negative grows; not industry's -2 Re / |Im|."""
    mode = classify(np.array([root, np.conj(root)]), TOLERANCES).modes[0]
    assert mode.damping_ratio == pytest.approx(expected, abs=1e-15)
    assert mode.growth_rate == root.real


def test_records_are_frozen(kang: BrakeModel) -> None:
    found: ComplexModes = complex_modes(kang, at(kang))
    with pytest.raises(ValueError, match='read-only'):
        found.eigenvalues[0] = 1.0


# ---------------------------------------------------------------- vectors

def residuals(model: BrakeModel, point: OperatingPoint, root: complex) -> tuple[float, float]:
    """Of the right and of the left vector, relative to the matrices."""
    d, k = model.damping(point), model.stiffness(point)
    pencil = root**2 * np.eye(model.size) + root * d + k
    size = abs(root)**2 + abs(root) * np.linalg.norm(d) + np.linalg.norm(k)
    v = mode_vectors(model, point, root)
    assert np.linalg.norm(v.right) == pytest.approx(1.0, abs=1e-14)
    assert np.linalg.norm(v.left) == pytest.approx(1.0, abs=1e-14)
    right, left = (float(np.linalg.norm(x)) / size
                   for x in (pencil @ v.right, v.left.conj() @ pencil))
    assert v.backward_error == pytest.approx(right, rel=1e-3, abs=1e-20)
    return right, left


@pytest.mark.parametrize(('speed', 'slope'), [(5.0, 0.0), (20.0, 0.0), (1.0, -0.1)])
def test_vectors_of_the_shipped_model(speed: float, slope: float, kang: BrakeModel) -> None:
    point = at(kang, speed, friction_slope=slope)
    for mode in complex_modes(kang, point).modes[6::5]:
        # ten times eps; 1.6e-15 is the worst seen
        assert max(residuals(kang, point, mode.eigenvalue)) < 5e-15


@pytest.mark.parametrize('seed', range(3))
def test_vectors_against_numpy(seed: int) -> None:
    """Same lines as eigenvectors of the state matrix and of its transpose, with all six arrays."""
    model = dense_model(seed, 5)
    state, n = companion_at(model, POINT), model.size
    roots, right = np.linalg.eig(state)
    for root, x in zip(roots, right[:n].T, strict=True):
        v = mode_vectors(model, POINT, complex(root))
        assert max(residuals(model, POINT, complex(root))) < 5e-15
        # vectors are conditioned by gaps of 1e-3 of the roots: eps * 1e3, with a margin
        assert abs(v.right.conj() @ x) / np.linalg.norm(x) == pytest.approx(1.0, abs=1e-11)


def test_backward_error_tells_a_wrong_root(kang: BrakeModel) -> None:
    point = at(kang)
    root = complex_modes(kang, point).unstable[0].eigenvalue
    wrong = mode_vectors(kang, point, root * (1.0 + 1e-6)).backward_error
    assert wrong > 1e3 * mode_vectors(kang, point, root).backward_error


def test_vectors_of_an_exact_root() -> None:
    """A root exact to the last bit, as of an uncoupled mode: the pencil has a zero pivot."""
    model = BrakeModel(angular_frequencies=[1000.0, 2000.0], damping_ratios=0.0)
    vectors = mode_vectors(model, POINT, 1000j)
    assert np.abs(vectors.right) == pytest.approx([1.0, 0.0], abs=1e-12)
    assert np.abs(vectors.left) == pytest.approx([1.0, 0.0], abs=1e-12)


def test_vectors_of_the_exact_root_of_a_single_mode() -> None:
    model = BrakeModel(angular_frequencies=[1000.0], damping_ratios=0.0)
    assert np.abs(mode_vectors(model, POINT, 1000j).right) == pytest.approx([1.0], abs=1e-12)
