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

"""Eigenvalues by LAPACK: numpy's, but other threads go on meanwhile."""

from collections.abc import Callable, Iterator
import sys
import threading
import time

import numpy as np
import pytest
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.lapack import eigvals


@pytest.mark.parametrize('size', [0, 1, 2, 5, 60, 184, 300])
def test_numpy_finds_the_same(size: int) -> None:
    matrix = np.random.default_rng(size).standard_normal((size, size))
    for given in (matrix, matrix.T, np.asfortranarray(matrix), 1e10 * matrix):
        before = given.copy()
        found, expected = np.sort(eigvals(given)), np.sort(np.linalg.eigvals(given))
        # backward stable, by a factor of some hundreds for the worst of their conditions
        assert np.abs(found - expected).max(initial=0.0) <= 1e3 * 2.3e-16 * np.abs(given).sum()
        assert (given == before).all()


def test_closed_forms() -> None:
    assert sorted(eigvals(np.diag([3.0, -1.0, 2.0])).real) == [-1.0, 2.0, 3.0]
    rotation = np.array([[0.0, 7.0], [-7.0, 0.0]])
    assert sorted(eigvals(rotation).imag) == pytest.approx([-7.0, 7.0], rel=1e-15)


@pytest.mark.parametrize('entry', [np.nan, np.inf, -np.inf])
def test_no_eigenvalues_of_what_is_no_number(entry: float) -> None:
    with pytest.raises(np.linalg.LinAlgError, match='not finite'):
        eigvals(np.array([[1.0, entry], [0.0, 1.0]]))


@pytest.mark.parametrize('shape', [(3,), (2, 3), (3, 2), (0, 2), (2, 3, 3)])
def test_no_eigenvalues_of_what_is_not_square(shape: tuple[int, ...]) -> None:
    with pytest.raises(np.linalg.LinAlgError, match='shape'):
        eigvals(np.ones(shape))


@pytest.fixture
def turns() -> Iterator[list[int]]:
    """How often another thread had its turn, where it gets one only if it is let."""
    count, over, before = [0], threading.Event(), sys.getswitchinterval()

    def run() -> None:
        while not over.is_set():
            count[0] += 1
            time.sleep(1e-4)

    other = threading.Thread(target=run)
    sys.setswitchinterval(1000.0)
    other.start()
    yield count
    sys.setswitchinterval(before)
    over.set()
    other.join()


def _keeps_others_waiting(matrix: FloatArray) -> float:
    return sum(matrix.ravel().tolist())


@pytest.mark.parametrize(('solve', 'lets_go_on'), [
    (eigvals, True), (_keeps_others_waiting, False)])
def test_other_threads_go_on(solve: Callable[[FloatArray], object], lets_go_on: bool,
                             turns: list[int]) -> None:
    matrix = np.random.default_rng(1).standard_normal((400, 400))
    before = turns[0]
    solve(matrix)
    after = turns[0]
    assert (after > before) is lets_go_on
