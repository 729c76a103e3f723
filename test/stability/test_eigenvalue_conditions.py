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

"""How far an eigenvalue can be trusted: its condition and its backward error."""

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.common.arrays import ComplexArray
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.stability.eigenvectors import eigenvalue_conditions, mode_vectors
from support.stability_models import (
    kang_point,
    LOAD,
    MERGING,
    POINT,
    SKEW,
    supported_model,
    W1,
    W2,
)


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
    model, part = supported_model(seed), 1e-9
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
    point = kang_point(kang, 5.0)
    modes = complex_modes(kang, point).modes
    found = eigenvalue_conditions(kang, point, modes)
    assert len(found) == 92
    assert [t.condition for t in found[:6]] == [np.inf] * 6
    assert all(t.error < 1e-3 for t in found[6:])  # growth rates are of 1 to 100 1/s
    assert max(t.condition for t in found[6:]) > 1e2
