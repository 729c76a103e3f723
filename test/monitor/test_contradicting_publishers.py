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

"""Publishers of one topic that contradict each other."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor.vehicle_monitor import Sample
from support.brake_monitors import feed, GOOD, monitor, NAN, SECOND, TICK


def heard(*publishers: tuple[int, float, Sequence[float]], signal: Any = 'pressure',
          rate: float = 50.0, **parameters: Any) -> list[str]:
    """Return what is said of publishers that take turns: first number, delay, values."""
    watch = monitor(**parameters)
    events = sorted((round((i / rate + delay) * SECOND) + TICK, number + i, value)
                    for number, delay, values in publishers for i, value in enumerate(values))
    said = []
    for stamp, number, value in events:
        feed(watch, stamp, **{name: GOOD[name] for name in GOOD if name != signal})
        watch.receive(signal, Sample(stamp, value, number=number))
        found = watch.assess(stamp)
        said.append(found.reason if found.inputs[signal].status == 'contradicted' else '')
    return said


@pytest.mark.parametrize(('first', 'second'), [(1, 1), (1, 500), (900, 3), (7, 8)])
@pytest.mark.parametrize(('signal', 'one', 'other', 'words'), [
    ('pressure', 15e5, 0.0, '0'), ('rotor_speed', 45.0, 0.0, '0'), ('friction', 0.4, 0.6, '0.6'),
    ('friction', 0.4, NAN, 'no number'), ('pressure', 15e5, 1500.0, '1500')])
def test_publishers_that_contradict_each_other_are_told_of_every_sample(
        signal: Any, one: float, other: float, words: str, first: int, second: int) -> None:
    """As soon as both go on for 0.8 max_age, whichever comes first, whatever their numbers."""
    said = heard((first, 0.0, [one] * 50), (second, 0.004, [other] * 50), signal=signal)
    assert not any(said[:40])
    assert all(said[44:])
    assert f'another publisher of the topic, which says {words}, until' in said[-2]


def test_publishers_that_count_alike_and_take_turns_as_they_like() -> None:
    random = np.random.default_rng(6)
    watch, said = monitor(), []
    for count in range(60):
        pair = [(15e5, 1), (0.0, 2)]
        for value, offset in (pair if random.random() < 0.5 else pair[::-1]):
            stamp = TICK + count * SECOND // 50 + offset
            watch.receive('pressure', Sample(stamp, value, number=count + 1))
            said.append(watch._inputs['pressure'].read(stamp).status)
    assert set(said[44:]) == {'contradicted'}


def test_a_contradiction_begins_and_ends_with_the_values() -> None:
    apart = [0.0] * 50 + [15e5] * 100 + [0.0] * 50
    said = heard((1, 0.0, apart), (400, 0.004, [0.0] * 200))
    told = [i / 100.0 for i, text in enumerate(said) if text]
    assert 1.4 <= told[0] <= 1.44  # 0.8 max_age after they part
    assert 2.98 <= told[-1] <= 3.02
    # one of them is silent: over within one max_age
    said = heard((1, 0.0, [15e5] * 100), (400, 0.004, [0.0] * 50))
    told = [i for i, text in enumerate(said) if text]
    assert told[-1] <= 100 + 20
    assert not any(heard((1, 0.0, apart), (400, 0.004, [0.0] * 200), publisher_tolerance=0.0))


def test_publishers_that_agree_are_no_contradiction() -> None:
    time = np.arange(0.0, 2.4, 0.02)
    random = np.random.default_rng(1)
    pulsing = 40e5 + 30e5 * np.sin(2 * np.pi * 15.0 * time)  # ABS
    for values in (pulsing, np.minimum(20e5 * time, 40e5), random.normal(1e4, 2e4, time.size)):
        noise = random.normal(0.0, 5e3, time.size)
        for delay in (0.001, 0.1, 0.3):
            assert not any(heard((1, 0.0, values), (77, delay, values + noise)))
    # one hands over to another, which begins anew
    handed = heard((800, 0.0, [15e5] * 50), (1, 1.0, [0.0] * 50))
    assert not any(handed)


def test_connections_of_a_recording_are_publishers() -> None:
    watch = monitor()
    for count in range(40):
        for connection, value in ((1, 15e5), (2, 0.0)):
            stamp = TICK + count * SECOND // 50 + connection
            watch.receive('pressure', Sample(stamp, value, connection=connection))
    assert watch._inputs['pressure'].read(stamp).status == 'contradicted'
