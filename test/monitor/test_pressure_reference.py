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

"""The reference of a pressure: absolute given as gauge, and gauge given as absolute."""

from collections.abc import Sequence

import numpy as np
import pytest
from squeal_core.monitor.inputs.plausibility import AbsoluteGuard, GaugeGuard
from support.brake_monitors import feed, GOOD, monitor, SECOND, TICK
from support.guards import judged

ABSOLUTE, GAUGE = 'looks like an absolute pressure', 'looks like a gauge pressure'


def braked(*, rest: float = 0.0, noise: float = 0.0, rate: float = 50.0,
           brakings: int = 4) -> Sequence[float]:
    """Rests of 6 s and brakings of 2 s to 20 bar."""
    one = np.concatenate([np.zeros(round(6 * rate)),
                          20e5 * np.sin(np.linspace(0.0, np.pi, round(2 * rate)))])
    values = rest + np.tile(one, brakings)
    values += noise * np.random.default_rng(0).standard_normal(values.size)
    return list(values)


@pytest.mark.parametrize('air', [6.6e4, 9e4, 101325.0, 1.06e5])
@pytest.mark.parametrize('noise', [0.0, 5e3])
def test_an_absolute_pressure_given_as_gauge_is_told_in_five_seconds(air: float,
                                                                     noise: float) -> None:
    said = judged(GaugeGuard(), [*braked(rest=air, noise=noise, brakings=1)] * 2, rate=50.0)
    assert said[249] == ''
    assert all(text.startswith(ABSOLUTE) for text in said[600:])
    assert 'until it falls below 40000 Pa' in said[-1]


def test_an_absolute_pressure_after_a_gauge_is_told_with_its_third_return() -> None:
    guard = GaugeGuard()
    assert set(judged(guard, braked())) == {''}
    said = judged(guard, braked(rest=1e5), rate=50.0, start=100.0)
    assert said.index(next(filter(None, said))) == pytest.approx((8 * 3 + 5) * 50, abs=15)
    assert judged(guard, [0.0, 1e5], start=200.0) == ['', '']


@pytest.mark.parametrize('values', [
    braked(), braked(noise=2e4), [0.0, *[1e5] * 3000], [*[2e5] * 300, *[0.0] * 10, *[1e5] * 900],
    list(np.tile([1e5, 2.5e5, 0.9e5], 2000)), list(1e5 + 6e4 * np.sin(np.arange(3000)))],
    ids=['brakings', 'noise', 'held at 1 bar', 'held later', 'pulses', 'waves'])
def test_what_is_no_absolute_pressure(values: Sequence[float]) -> None:
    assert set(judged(GaugeGuard(), values, rate=50.0)) == {''}


def test_a_gauge_pressure_given_as_absolute() -> None:
    guard = AbsoluteGuard()
    said = judged(guard, braked(rest=-101325.0), rate=50.0)
    assert said[149] == ''
    assert all(text.startswith(GAUGE) for text in said[155:])
    assert set(judged(guard, [0.0] * 3100, rate=50.0, start=100.0)[3001:]) == {''}
    undershoot = [*braked(brakings=1), *[-9e4] * 100]
    assert set(judged(AbsoluteGuard(), undershoot, rate=50.0)) == {''}


def test_the_reference_is_looked_for_in_the_monitor() -> None:
    for parameters, rest, words in (({}, 101325.0, ABSOLUTE), (
            {'a.pressure.reference': 'absolute'}, -101325.0, GAUGE)):
        for check in (True, False):
            watch = monitor(reference_check=check, **parameters)
            for tenths in range(60):
                feed(watch, TICK + tenths * SECOND // 10, **{**GOOD, 'pressure': rest})
            found = watch.assess(TICK + 6 * SECOND)
            assert (words in found.reason) is check
            assert (found.state == 'invalid') is check
