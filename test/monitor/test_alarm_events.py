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

"""Starts and ends of alarms: one each, with what raised them and what ended them."""

from dataclasses import replace
import math
from typing import Any

import numpy as np
import pytest
from squeal_core.monitor.alarm_events import AlarmEvents
from squeal_core.monitor.assessment import Assessment
from squeal_core.monitor.brake_risk import BrakeRisk
from squeal_core.monitor.inputs.reading import Reading
from squeal_core.monitor.settings import read_settings
from squeal_core.risk.risk_records import RiskResult

TENTH = 100_000_000  # ns
SETTINGS = read_settings({'brakes': ['fl', 'fr'], 'risk_hold': 0.2})


def result(**changes: Any) -> RiskResult:
    return RiskResult(**{
        'squeal_risk': 0.9, 'error': 0.02, 'peak_risk': 0.9, 'instability_probability': 1.0,
        'build_up': 6.0, 'family_build_up': np.array([6.0]), 'time_to_squeal': 0.0, 'family': 3,
        'frequency_hz': 3211.0, 'calibrated': False, 'incomplete': False, 'basis': 'prior',
        **changes})


def assessed(tick: int, risk: float, brake: str = 'fl', **changes: Any) -> Assessment:
    steady = {'state': 'steady', 'reason': '', 'risk_result': BrakeRisk(
        result=result(squeal_risk=risk, frequency_hz=3000.0 + 100.0 * risk), modes=(25, 26))}
    return Assessment(**{
        'brake': brake, 'time': tick * TENTH, 'risk': risk, 'build_up': 6.0, 'growth_rate': 21.5,
        'friction': 0.45, 'inputs': {'rotor_speed': Reading('good', 20.0),
                                     'pressure': Reading('good', 1.23e6)}, **steady, **changes})


@pytest.fixture
def alarms() -> AlarmEvents:
    return AlarmEvents(SETTINGS)


def test_an_alarm_begins_once_and_ends_once(alarms: AlarmEvents) -> None:
    """Its modes and frequency are in the end those of the largest risk."""
    risks = (0.1, 0.6, 0.9, 0.45, 0.3, 0.2, 0.1, 0.1)
    said = [(tick, event) for tick, risk in enumerate(risks)
            for event in alarms.update([assessed(tick, risk), assessed(tick, 0.1, 'fr')])]
    (began, start), (ended, end) = said
    assert (began, start.kind, start.brake, start.time) == (1, 'start', 'fl', TENTH)
    assert (start.risk, start.modes, start.frequency_hz) == (0.6, (25, 26), 3060.0)
    assert start.cause == ('build-up 6.0 nepers, growth +21.5 1/s at 20.0 rad/s, 12.3 bar, '
                           'friction 0.450')
    assert (ended, end.kind, end.since, end.duration) == (5, 'end', TENTH, 0.4)
    assert (end.risk, end.peak_risk, end.frequency_hz) == (0.2, 0.9, 3090.0)
    assert end.cause == 'the risk fell'
    assert start.in_words.startswith('squeal probable, risk 0.60: mode 25/26 at 3060 Hz; build-')
    assert end.in_words == ('squeal alarm over after 0.4 s, risk up to 0.90: mode 25/26 at 3090 '
                            'Hz; the risk fell')


def test_a_mode_that_has_grown_and_decays_now_is_told_apart(alarms: AlarmEvents) -> None:
    ((_, event),) = [(tick, event) for tick, growth in enumerate((21.5, -0.3))
                     for event in alarms.update([assessed(tick, 0.4 + 0.2 * tick,
                                                          growth_rate=growth)])]
    assert event.cause.startswith('build-up 6.0 nepers, growth -0.3 1/s now, after growing, at ')


@pytest.mark.parametrize(('state', 'risk', 'cause'), [
    ('released', 0.0, 'brake released'), ('not sliding', math.nan, 'why'),
    ('stale', math.nan, 'whether it squeals is no longer known: why')])
def test_an_alarm_ends_with_the_reason_of_the_state(alarms: AlarmEvents, state: str, risk: float,
                                                    cause: str) -> None:
    alarms.update([assessed(0, 0.9)])
    assert alarms.is_up('fl')
    after = [alarms.update([assessed(tick, risk, state=state, reason='why', risk_result=None)])
             for tick in (1, 2, 3)]
    assert [len(events) for events in after] == [0, 1, 0]
    assert (after[1][0].cause, after[1][0].peak_risk) == (cause, 0.9)
    assert not alarms.is_up('fl')


@pytest.mark.parametrize(('changes', 'cause'), [
    ({'squeal_band_low_hz': 2000.0}, 'the settings changed (squeal_band_low_hz)'),
    ({'rate': 20.0}, 'the risk fell')])
def test_an_alarm_that_settings_end_says_so(alarms: AlarmEvents, changes: dict[str, float],
                                            cause: str) -> None:
    """A risk that falls later, after it kept the alarm up by the new settings, fell by itself."""
    alarms.update([assessed(0, 0.9), assessed(0, 0.9, 'fr')])
    alarms.update_settings(replace(SETTINGS, **changes))
    alarms.update([assessed(1, 0.1), assessed(1, 0.9, 'fr')])
    ended = [event for tick in (2, 3, 4, 5)
             for event in alarms.update([assessed(tick, 0.1), assessed(tick, 0.1, 'fr')])]
    assert [(event.brake, event.cause) for event in ended] == [
        ('fl', cause), ('fr', 'the risk fell')]


def test_all_alarms_end_when_nothing_is_known_any_more(alarms: AlarmEvents) -> None:
    alarms.update([assessed(0, 0.9), assessed(0, 0.9, 'fr')])
    unknown = [assessed(1, math.nan, brake, state='stale', reason='not active', risk_result=None)
               for brake in ('fl', 'fr')]
    assert [(event.brake, event.kind, event.cause) for event in alarms.end(unknown)] == [
        (brake, 'end', 'whether it squeals is no longer known: not active')
        for brake in ('fl', 'fr')]
    assert alarms.end(unknown) == []
    assert alarms.update([assessed(2, 0.45), assessed(2, 0.45, 'fr')]) == []  # below its level
