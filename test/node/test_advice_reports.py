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

"""Advice of a car tick after tick: when it is published, and when it is not known."""

from collections import Counter
import math
from typing import Any, TypeAlias

import numpy as np
import pytest
from squeal_core.monitor.advice import PressureAdvice
from squeal_core.monitor.force_split import SplitAdvice, SplitSteps
from squeal_core.monitor.settings import read_settings
from squeal_ros.node.advice_reports import AdviceReports

PAUSE = 3.0  # s
Told: TypeAlias = list[tuple[int, str, str, float]]
CAR = ('front_left', 'front_right', 'rear_left', 'rear_right')


class Tick:
    """An assessment as far as this goes: its brake and its time."""

    def __init__(self, brake: str, time: int) -> None:
        self.brake, self.time, self.state = brake, time, 'steady'


class Advice:
    """Advice that is the time it was asked for, the split after 52 steps."""

    def pressures(self, found: Tick) -> PressureAdvice:
        return PressureAdvice(present=0.0, below=float(found.time), above=math.nan, reason='r')

    def split(self, found: list[Tick]) -> SplitSteps:
        for _ in range(52):
            yield
        return SplitAdvice(front_share=float(found[0].time), reason='s')


def published(rate: float, seconds: int, pause: float = PAUSE) -> tuple[AdviceReports, Told]:
    """Return what is published over some seconds: tick [ns], brake, topic, value."""
    told: Told = []
    now = 0
    advice: Any = Advice()
    settings = read_settings({'rate': rate, 'margin_confirm_interval': pause})
    reports = AdviceReports(settings, advice, lambda *what: told.append((now, *what)))
    for now in range(0, seconds * 10**9, round(1e9 / rate)):
        car: Any = [Tick(name, now) for name in CAR]
        reports.take(car)
    return reports, told


def test_each_brake_once_a_second_and_one_at_a_tick() -> None:
    reports, told = published(20.0, 4)
    below = [one for one in told if one[2] == 'quiet_pressure_below']
    assert Counter(one[1] for one in below) == dict.fromkeys(CAR, 4)
    assert all(value == now for now, _, _, value in below)
    assert max(Counter(one[0] for one in below).values()) == 1
    assert all(math.isnan(value) for _, _, topic, value in told if topic == 'quiet_pressure_above')
    figures = reports.of_brake('rear_left')
    assert figures['quiet_pressure_below_bar'] == 1e-5 * [
        value for _, brake, _, value in below if brake == 'rear_left'][-1]
    assert figures['quiet_pressure_reason'] == 'r'


@pytest.mark.parametrize('rate', [1.0, 10.0, 100.0])
def test_split_is_of_the_tick_it_began_at_and_takes_some_seconds(rate: float) -> None:
    reports, told = published(rate, 9)
    shares = [(now, value) for now, _, topic, value in told if topic == 'least_risk_front_share']
    assert len(shares) in (2, 3)
    assert all(0 <= now - value <= 2e9 for now, value in shares)
    began = np.array([value for _, value in shares])
    assert (np.diff(began) >= 1e9 * PAUSE).all()
    assert reports.of_vehicle()['split_front_share'] == shares[-1][1]


@pytest.mark.parametrize('rate', [100.0, 40.0, 20.0, 10.0])
def test_the_search_pauses_where_risks_are_evaluated(rate: float) -> None:
    """20 times a second; where they are at each tick, it does not."""
    stepped = []

    class Searching(Advice):

        def split(self, found: list[Tick]) -> SplitSteps:
            for _ in range(52):
                stepped.append(now)
                yield
            return SplitAdvice(reason='s')

    advice: Any = Searching()
    reports = AdviceReports(read_settings({'rate': rate}), advice, lambda *_: None)
    for now in range(0, 4 * 10**9, round(1e9 / rate)):
        car: Any = [Tick(name, now) for name in CAR]
        reports.take(car)
    risks = {now for now in stepped if now % (10**9 // 20) == 0}
    assert len(stepped) == 52
    assert risks == (set() if rate > 20.0 else {*stepped})


def test_nothing_is_searched_for_where_margins_are_not_confirmed() -> None:
    _, told = published(20.0, 3, pause=0.0)
    assert all(topic != 'least_risk_front_share' for _, _, topic, _ in told)


def test_what_is_forgotten_is_not_known() -> None:
    reports, told = published(20.0, 2)
    told.clear()
    reports.forget(CAR)
    assert len(told) == 2 * len(CAR) + 1
    assert all(math.isnan(value) for _, _, _, value in told)
    assert (reports.of_brake('rear_left'), reports.of_vehicle()) == ({}, {})
