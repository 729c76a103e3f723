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

"""Eigenvalues of small matrices in closed form, against LAPACK and known ones."""

import numpy as np
import pytest
from squeal_core.common.arrays import ComplexArray
from squeal_core.risk.small_matrices import FourModes, in_four, least_stable


def _random(size: int, count: int = 300) -> ComplexArray:
    """Return matrices and slopes (3, count, size, size) like those of modes that cross."""
    rng = np.random.default_rng(size)
    parts = rng.normal(size=(2, 3, count, size, size)) * 30.0
    found = parts[0] + 1j * parts[1]
    found[0] += np.eye(size) * (2e4j + 500j * rng.normal(size=(count, size, 1)))
    return found


@pytest.mark.parametrize('size', [4, 7])
def test_growth_and_slopes_are_those_of_eigenvectors(size: int) -> None:
    matrices = _random(size)
    values, right = np.linalg.eig(matrices[0])
    rows, place = np.arange(len(values)), values.real.argmax(axis=1)
    left = np.linalg.inv(right)[rows, place]
    slopes = np.einsum('pi,kpij,pj->kp', left, matrices[1:], right[rows, :, place])
    found = least_stable(matrices)
    np.testing.assert_allclose(found[0], values[rows, place].real, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(found[1], values[rows, place].imag, rtol=0.0, atol=1e-8)
    # the resolvent 1e-3 1/s beside an eigenvalue has that over the distance to others of them
    np.testing.assert_allclose(found[2:], slopes.real, rtol=0.0, atol=0.02)


def test_eigenvalues_of_several_times_are_found() -> None:
    known = np.array([[0, 0, 0, 0], [1, 1, 1, 1], [1, 1, -1, -1], [1j, -1j, 0, 2], [3, 3, 3, 1j]])
    shear = np.eye(4) + np.eye(4, k=1)
    matrices = shear @ (known[:, None] * np.eye(4)) @ np.linalg.inv(shear)
    found = FourModes.of(matrices).eigenvalues()
    for values, wanted in zip(found, known, strict=True):
        # one of three times is known to the third root of rounding
        np.testing.assert_allclose(np.sort_complex(values.round(4)), np.sort_complex(wanted),
                                   atol=1e-3)


def test_three_modes_have_the_same_growth_as_four() -> None:
    matrices = _random(3, 1)[:, 0]
    weights = np.stack([matrices.real, matrices.imag], axis=-1).reshape(3, 18)
    padded = in_four(weights).reshape(3, 4, 4, 2).copy().view(complex)[:, None, ..., 0]
    found, wanted = least_stable(padded), least_stable(matrices[:, None])
    # 1e-3 1/s over the distance of the fourth, times slopes
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-4)
