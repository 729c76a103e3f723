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

"""A value that no longer moves: frozen, coarse, noisy."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor.inputs.stuck_signal import SignalStep, StuckCheck
from support.brake_monitors import SECOND


def held(values: Sequence[float], others: Sequence[int], *, sliding: bool = True,
         rate: float = 10.0, **changes: Any) -> list[bool]:
    guard = StuckCheck(**{
        'after': 2.0, 'changes': 5, 'longest_gap': 0.5, 'movement': 1.0, **changes})
    return [bool(guard.check(round(i / rate * SECOND), value, sliding=sliding, others=other))
            for i, (value, other) in enumerate(zip(values, others, strict=True))]


LIVELY = [float(i) for i in range(10)]


def test_a_frozen_value_is_told_while_the_others_move() -> None:
    values = LIVELY + [9.0] * 30 + [9.1]
    said = held(values, range(41))
    assert said.index(True) == 9 + 21  # more than 2 s after it froze
    assert all(said[30:40])
    assert not said[40]


@pytest.mark.parametrize(('values', 'others', 'changes'), [
    ([9.0] * 40, range(40), {}),  # never moved: a bench
    (LIVELY + [9.0] * 30, [10] * 40, {}),  # nothing moves
    (LIVELY + [9.0] * 30, range(40), {'after': 0.0}),
    (LIVELY + [9.0] * 30, range(40), {'sliding': False}),
    (LIVELY + [9.0] * 30, range(40), {'rate': 1.0}),  # gaps longer than 0.5 s are no evidence
    (LIVELY + [9.0, 9.0 + 1e-12] * 15, range(40), {})])
def test_what_is_not_stuck(values: list[float], others: Sequence[int],
                           changes: dict[str, Any]) -> None:
    assert not any(held(values, others, **changes))


def quantised(values: Any, step: float) -> list[float]:
    return list(np.round(np.asarray(values) / step) * step)


@pytest.mark.parametrize(('step', 'level', 'movement', 'after'), [
    (1e5, 12e5, 1e3, 5.0), (1e4, 12e5, 1e3, 5.0), (0.5, 25.0, 0.004, 2.0), (0.1, 25.0, 0.004, 2.0),
    (0.05, 0.42, 1e-3, 10.0), (0.01, 0.42, 1e-3, 10.0), (1.0, 400.0, 0.05, 10.0)])
@pytest.mark.parametrize('rate', [10.0, 100.0])
@pytest.mark.parametrize('kind', [float, np.float32])
def test_a_coarse_signal_is_not_stuck_while_it_stays_within_its_step(
        step: float, level: float, movement: float, after: float, rate: float, kind: Any) -> None:
    random = np.random.default_rng(3)
    ramps = np.abs(np.sin(np.arange(0.0, 12.0, 1.0 / rate))) * 20.0 * step
    held_at = level + 0.2 * step * random.uniform(-1.0, 1.0, round(30 * rate))
    values = [float(kind(v)) for v in quantised([*ramps, *held_at], step)]
    if len(set(np.diff(values))) > 3:
        said = held(values, range(len(values)), rate=rate, movement=movement, after=after)
        assert not any(said)
    frozen = [values[-1]] * round((after * step / movement + 1.0) * rate)
    values += frozen[:round(600 * rate)]
    limit = after * step / movement
    assert any(held(values, range(len(values)), rate=rate, movement=movement, after=after)) == (
        limit < 590)


@pytest.mark.parametrize('noise', [2e3, 1e4])
def test_a_fine_and_noisy_signal_is_stuck_in_its_time(noise: float) -> None:
    """Few changes tell that it has no step; so does one that is clipped at zero."""
    random = np.random.default_rng(5)
    for low in (-1e9, 11.9e5):
        values = np.maximum(12e5 + random.normal(0.0, noise, 60), low)
        said = held([*values, *[13e5] * 80], range(140), movement=1e3, after=5.0)
        assert 60 + 50 <= said.index(True) <= 60 + 53


def test_a_step_is_learned_in_spite_of_a_dead_band() -> None:
    step = SignalStep()
    values = [0.0, 0.37, 0.47, 0.67, 0.97, 1.07, 1.37, 1.27, 0.97, 0.67, 0.47, 0.37, 0.0, 0.0] * 9
    for one, other in pairwise(values):
        if one != other:
            step.add(other - one)
    assert step.value == pytest.approx(0.1)


def test_without_changes_asked_for_a_constant_is_stuck() -> None:
    assert held([9.0] * 40, [0] * 40, changes=0).index(True) == 21
