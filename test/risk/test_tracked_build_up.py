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

"""Build-up of modes that are followed by frequency."""

import numpy as np
import pytest
from squeal_core.common.arrays import ComplexArray
from squeal_core.risk.tracked_build_up import TrackedBuildUp

MS = 1_000_000  # ns
CAP = 4e8


def roots(*modes: tuple[float, float]) -> ComplexArray:
    """Return eigenvalues of modes of growth rates [1/s] and frequencies [Hz]."""
    return np.array([complex(rate, 2.0 * np.pi * frequency) for rate, frequency in modes])


@pytest.fixture
def tracked() -> TrackedBuildUp:
    return TrackedBuildUp(np.array([2000.0, 2100.0]), np.array([60.0, 60.0]))


def test_modes_whose_frequencies_cross_keep_their_build_up(tracked: TrackedBuildUp) -> None:
    """One grows at 10 1/s from 2000 Hz upwards, the other decays from 2065 Hz downwards."""
    for tick in range(1, 16):
        rising, falling = (10.0, 2000.0 + 4.0 * tick), (-50.0, 2065.0 - 4.0 * tick)
        found = tracked.update(tick * 50 * MS, roots(rising, falling), CAP)
        if tick == 6:
            before = found
    assert found[0] == pytest.approx(before[0] + 9 * 0.05 * 10.0, abs=0.1)
    assert found[1] < 0.2


def test_merged_modes_share_their_energy(tracked: TrackedBuildUp) -> None:
    """Of a pair the one that grows is now the upper, now the lower one."""
    for tick in range(1, 11):
        pair = ((20.0, 2000.0), (-90.0, 2000.5)) if tick % 4 < 2 else (
            (-90.0, 2000.0), (20.0, 2000.5))
        found = tracked.update(tick * 50 * MS, roots(*pair), CAP)
    assert found[0] == found[1]
    assert found[0] > 3.0


def test_modes_that_a_table_omits_begin_at_their_floors(tracked: TrackedBuildUp) -> None:
    for tick in range(1, 6):
        found = tracked.update(tick * 50 * MS, roots((20.0, 2000.0)), CAP)
    assert found[0] > 3.0
    assert tracked.update(300 * MS, roots(), CAP).size == 0
    assert tracked.update(350 * MS, roots((20.0, 2000.0)), CAP)[0] < 1.5


def test_a_gap_adds_nothing_and_a_release_ends_all(tracked: TrackedBuildUp) -> None:
    for tick in range(1, 6):
        found = tracked.update(tick * 50 * MS, roots((20.0, 2000.0)), CAP)
    assert tracked.update(1000 * MS, roots((20.0, 2000.0)), CAP) == found
    tracked.release(1050 * MS)
    assert tracked.update(1100 * MS, roots((20.0, 2000.0)), CAP)[0] < 1.5
