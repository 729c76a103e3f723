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

"""The alarm over the risk: hysteresis, hold, and unknown risks."""

from collections.abc import Sequence
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st
from squeal_core.monitor.alarm import Alarm
from support.brake_monitors import NAN, SECOND, TICK


def raised(risks: Sequence[float], *, rate: float = 10.0, hold: float = 0.5) -> list[bool]:
    alarm = Alarm(0.5, 0.1, hold)
    return [alarm.update(TICK + round(i / rate * SECOND), risk) for i, risk in enumerate(risks)]


def test_an_alarm_ends_below_the_hysteresis_and_after_the_hold() -> None:
    assert raised([0.49, 0.5, 0.45, 0.41, 0.4] + [0.45] * 20) == [False] + [True] * 24
    assert raised([0.9] + [0.39] * 8) == [True] * 5 + [False] * 4
    assert raised([0.9, 0.3, 0.3, 0.3, 0.42] + [0.39] * 5) == [True] * 9 + [False]
    assert raised([0.9, 0.3, 0.3], hold=0.0) == [True, False, False]
    assert raised([0.9] + [0.0] * 5 + [0.45, 0.49, 0.5]) == [True] * 5 + [False] * 3 + [True]


def test_an_unknown_risk_neither_raises_nor_keeps_an_alarm() -> None:
    assert raised([NAN] * 3) == [False] * 3
    assert raised([0.9] + [NAN] * 6) == [True] * 5 + [False] * 2


def test_an_alarm_and_a_clock_set_back() -> None:
    alarm = Alarm(0.5, 0.1, 3600.0)
    assert alarm.update(TICK, 0.9)
    assert not alarm.update(TICK - 1, 0.1)
    assert alarm.update(TICK - 1, 0.6)


def test_an_alarm_can_always_end() -> None:
    alarm = Alarm(0.3, 0.9, 0.0)
    assert [alarm.update(i, risk) for i, risk in enumerate((0.3, 0.01, 0.0))] == [
        True, True, False]
    alarm.update_settings(0.0, 0.0, 0.0)
    assert alarm.update(9, 0.0)


@given(st.lists(st.floats(0.0, 1.0) | st.just(NAN), max_size=60))
def test_an_alarm_does_not_chatter(risks: list[float]) -> None:
    """Up for the hold at least; up and down only where the risk crossed its levels."""
    said = raised(risks)
    assert said == raised(risks)
    ends = [i for i, (a, b) in enumerate(pairwise(said), start=1) if a and not b]
    for end in ends:
        assert all(not risk >= 0.4 for risk in risks[end - 4:end + 1])
    for i, (risk, up) in enumerate(zip(risks, said, strict=True)):
        assert up or not risk >= 0.5
        assert not up or i == 0 or said[i - 1] or risk >= 0.5
