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

"""Events of measured squeal, and the applications that they are matched with."""

from collections.abc import Sequence
import math
from pathlib import Path

import numpy as np
import pytest
from squeal_core.calibration.applications import (
    BrakeApplication,
    match_events,
    MatchedEvents,
    Observation,
)
from squeal_core.calibration.events import EventFileError, MeasuredEvent, read_events
from squeal_core.common.errors import SquealError
from support.rows import each

PLACES = {'fl': ('fl',), 'fr': ('fr',), 'front': ('fl', 'fr')}


def read(folder: Path, text: str) -> list[MeasuredEvent]:
    path = folder / 'events.csv'
    path.write_text(text, encoding='utf-8')
    return read_events(path, PLACES)


def test_a_table_of_events(tmp_path: Path) -> None:
    first, second = read(tmp_path, 'time_s,brake,frequency_hz,level_db,end_s,mode\n'
                         '1.5,fl,1655.2,84,2.0,13\n\n7, unknown,,,,\n')
    assert first == MeasuredEvent(1.5, 'fl', 1655.2, 84.0, '', 2, 2.0)
    assert (second.time, second.place, second.line) == (7.0, '', 4)
    assert math.isnan(second.end)
    assert math.isnan(second.frequency_hz)
    assert read(tmp_path, 'frequency_hz,time_s\n3000,2\n')[0].place == ''


@each(('encoding', 'text'), [
    ('utf-8-sig', 'time_s;frequency_hz;brake;comment\n1,5;1.660,2;fl;schön, laut\n7,25;;;\n'),
    ('cp1252', 'time_s;frequency_hz;brake;comment\n1,5;1660,2;fl;schön, laut\n7,25;;;\n'),
    ('utf-16', 'time_s\tfrequency_hz\tbrake\n1,5\t1660,2\tfl\n7,25\t\t\n'),
    ('utf-8', '"time_s";"frequency_hz";"brake"\n"1.5";"1660.2";"fl"\n7.25;;\n'),
    ('utf-8', 'time_s,frequency_hz,brake\n"1,5","1660,2",fl\n"7,25",,\n')])
def test_a_table_as_any_spreadsheet_writes_it(tmp_path: Path, encoding: str, text: str) -> None:
    path = tmp_path / 'events.csv'
    path.write_text(text.replace('\n', '\r\n'), encoding=encoding, newline='')
    first, second = read_events(path, PLACES)
    assert (first.time, first.frequency_hz, first.place) == (1.5, 1660.2, 'fl')
    assert (second.time, second.line) == (7.25, 3)
    assert math.isnan(second.frequency_hz)


def test_what_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / 'events.csv'
    path.write_bytes(b'\x00\x01\x02\xff' * 100)
    with pytest.raises(EventFileError, match='is no text; save it as CSV'):
        read_events(path, PLACES)


@each(('text', 'words'), [
    ('', r'line 1: has no column time_s in \[.*\]; name the columns'),
    ('time_s,brake\n', 'line 1: has no column frequency_hz'),
    ('time_s,frequency_hz,brakes\n', "unknown column 'brakes'.*did you mean brake"),
    ('time_s,frequency_hz,time_s\n', "twice the column 'time_s'"),
    ('time_s,frequency_hz\n1\n', 'line 2: has 1 cells for 2 columns'),
    ('time_s,frequency_hz\nx,1000\n', "line 2: time_s is 'x'; write a number of seconds"),
    ('time_s,frequency_hz\n,1000\n', "line 2: time_s is ''"),
    ('time_s,frequency_hz\n1,nan\n', "line 2: frequency_hz is 'nan'; write a number, or nothing"),
    ('time_s,frequency_hz\n1,3.2\n', r'is 3.2; give 20 to 20000 \(3.2 kHz would be 3200\)'),
    ('time_s,frequency_hz,level_db\n1,2e3,900\n', 'level_db is 900; give -20 to 200'),
    ('time_s,frequency_hz,brake\n1,2e3,frontt\n', "brake is 'frontt'; give one of fl, fr, front"),
    ('time_s,frequency_hz\n1,"2e3\n', 'cannot be read as CSV'),
    (f'time_s,frequency_hz\n{"1" * 20_000},2\n', 'more than 10000 characters')])
def test_what_is_refused_of_a_table(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(EventFileError, match=words):
        read(tmp_path, text)


def application(brake: str, start: float, duration: float = 2.0, *, recording: str = 'a',
                unknown: Sequence[int] = ()) -> BrakeApplication:
    time = start + np.arange(0.0, duration + 0.05, 0.1)
    friction = np.full(time.size, 0.4)
    friction[list(unknown)] = math.nan
    return BrakeApplication(brake, recording, time, np.full(time.size, 20.0),
                            np.full(time.size, 1e6), friction)


def match(applications: list[BrakeApplication], *events: MeasuredEvent) -> MatchedEvents:
    return match_events(applications, events, PLACES)


TWO = [application('fl', 0.0), application('fr', 0.0), application('fl', 5.0)]


def test_an_application_without_event_was_silent() -> None:
    found = match(TWO, MeasuredEvent(1.0, 'fl', 1600.0), MeasuredEvent(1.2, 'fl', 1700.0))
    assert found.observations == (Observation((0,), True, 1600.0), Observation((1,), False),
                                  Observation((2,), False))
    assert (found.heard, found.unmatched, found.incomplete) == (1, (), 0)


def test_an_event_of_an_axle_is_of_one_of_its_brakes() -> None:
    found = match(TWO, MeasuredEvent(1.0, 'front', 1600.0))
    assert [one.applications for one in found.observations] == [(0, 1), (2,)]
    assert found == match(TWO, MeasuredEvent(1.0, '', 1600.0))
    known = match(TWO, MeasuredEvent(1.0, 'fr', 1600.0), MeasuredEvent(1.0, '', 1610.0))
    assert [one.heard for one in known.observations] == [False, True, False]
    others = match(TWO, MeasuredEvent(1.0, 'fr', 1600.0), MeasuredEvent(1.0, '', 3200.0))
    assert [one.heard for one in others.observations] == [True, True, False]
    assert match(TWO, MeasuredEvent(6.0, '', 900.0)).observations[2].heard


def test_events_outside_of_applications_are_counted() -> None:
    late, soon = MeasuredEvent(4.0, 'fl'), MeasuredEvent(2.3, 'fl')
    found = match(TWO, late, soon)
    assert found.unmatched == (late,)
    assert found.observations[0].heard


def test_what_is_hardly_known_is_no_observation() -> None:
    found = match([application('fl', 0.0, unknown=range(5)), TWO[2]], MeasuredEvent(1.0, 'fl'))
    assert found.observations == (Observation((1,), False),)
    assert found.incomplete == 1


def test_recordings_of_one_time_want_a_name() -> None:
    both = [TWO[0], application('fl', 0.5, recording='b')]
    with pytest.raises(EventFileError, match='time_s 1 is of a and b; name the recording'):
        match(both, MeasuredEvent(1.0, 'fl', line=3))
    found = match(both, MeasuredEvent(1.0, 'fl', recording='b'))
    assert [one.heard for one in found.observations] == [False, True]
    with pytest.raises(EventFileError, match="recording is 'c'; give one of a, b"):
        match(both, MeasuredEvent(1.0, 'fl', recording='c'))
    shifted = match_events(both, [MeasuredEvent(4.0, 'fl', recording='b')], PLACES,
                           zero={'b': -3.0})
    assert shifted.observations[1].heard


def test_knots_leave_gaps_out() -> None:
    ticks, duration = application('fl', 0.0, unknown=(10,)).knots(0.5)
    assert 10 not in ticks
    assert duration.sum() == pytest.approx(2.0 - 0.2 + 0.1)  # the gap, half a tick at both ends
    ticks, duration = application('fl', 0.0).knots(0.5)
    assert (ticks.size, duration.sum()) == (6, pytest.approx(2.1))


def test_an_application_needs_rising_times() -> None:
    with pytest.raises(SquealError, match='rising'):
        BrakeApplication('fl', 'a', np.zeros(2), np.ones(2), np.ones(2), np.ones(2))
    with pytest.raises(SquealError, match='friction: shape'):
        BrakeApplication('fl', 'a', np.arange(2.0), np.ones(2), np.ones(2), np.ones(3))
