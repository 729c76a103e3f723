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

"""Predicted against measured squeal: outcomes, pitches and lead times of known cases, scores."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
import json
import math
from pathlib import Path
from typing import Any

import pytest
from squeal_core.monitor.results.drive_applications import ApplicationRecord
from squeal_core.monitor.results.history import AssessmentRecord, CsvWriter
from squeal_core.monitor.results.history_columns import HistoryBlock, read_blocks
from squeal_core.monitor.results.squeal_events import SquealEvent
from squeal_core.sound.brakings import groups_of
from squeal_core.sound.comparison import compare, Comparison
from squeal_core.sound.listening import MeasuredSquealError
from squeal_core.view.report.measured import measured_section

BRAKES = ('front_left', 'front_right')
NAN = math.nan
BEGIN = 1_700_000_000.0


@dataclass
class Replayed:
    """What a replay said of a recording."""

    applications: Sequence[ApplicationRecord]
    name: str = 'monday'
    events: Sequence[SquealEvent] = ()
    ticks: Sequence[AssessmentRecord] = ()
    end: float = 1000.0
    folder: Path = Path()
    summary: dict[str, Any] = field(init=False)

    def __post_init__(self) -> None:
        self.summary = {'recording': {'start_s': BEGIN, 'end_s': BEGIN + self.end},
                        'inputs': [{'brake': brake} for brake in BRAKES]}

    def blocks(self, columns: Sequence[str]) -> Iterator[HistoryBlock]:
        return read_blocks(self.folder / 'table.csv', columns)

    def written(self, folder: Path) -> 'Replayed':
        """Write the table of ticks."""
        self.folder = folder
        with (folder / 'table.csv').open('w', encoding='utf-8') as file:
            table = CsvWriter(file)
            for one in self.ticks:
                table.write(one)
        return self


def application(brake: str, start: float, alarm: bool | None, risk: float = NAN,
                length: float = 3.0) -> ApplicationRecord:
    if math.isnan(risk) and alarm is not None:
        risk = 0.8 if alarm else 0.1
    return ApplicationRecord(brake, BEGIN + start, BEGIN + start + length, 1.0, risk, risk, 6.0,
                             10.0, -1e-3, 2000.0, 13, alarm, 10.0 + start / 100.0, 5.0, 1e6, 2e6,
                             0.4, 400.0)


def tick(brake: str, time: float, *frequencies: float) -> AssessmentRecord:
    return AssessmentRecord(BEGIN + time, brake, 'steady', 10.0, 1e6, 0.4, *[NAN] * 8,
                            frequencies, tuple(1.0 for _ in frequencies), '')


def measured(folder: Path, *rows: str, span: tuple[float, float] | None = None,
             **about: Any) -> Path:
    """Write a table, with times after BEGIN, and the JSON of a sound of a span."""
    path = folder / 'measured.csv'
    lines = [(str(BEGIN + float(time)), *rest) for time, *rest in (row.split(',') for row in rows)]
    lines = [(*cells[:3], str(BEGIN + float(cells[3])) if cells[3:] and cells[3] else '')
             for cells in lines]
    path.write_text('\n'.join(['time_s,frequency_hz,brake,end_s', *(
        ','.join(cells) for cells in lines)]) + '\n')
    if span:
        path.with_suffix('.json').write_text(json.dumps({
            'offset_s': BEGIN + span[0], 'offset_uncertainty_s': None, 'band_hz': [1250, 16000],
            'heard_share': 1.0, 'recording': '', 'sound': {'duration_s': span[1] - span[0]},
            **about}))
    return path


def compared(drive: Replayed, folder: Path, *rows: str, **sound: Any) -> Comparison:
    return compare([drive.written(folder)], measured(folder, *rows, **sound))


def outcomes(found: Comparison) -> list[tuple[str, float, str]]:
    return [('+'.join(one.braking.brakes), one.braking.start - BEGIN, one.outcome)
            for one in found.matches.applications]


def test_each_outcome_and_its_figures(tmp_path: Path) -> None:
    drive = Replayed(
        [application('front_left', 10.0, True), application('front_right', 10.0, True),
         application('front_left', 50.0, False), application('front_right', 50.0, False),
         application('front_left', 90.0, None), application('front_right', 90.0, None)],
        events=[SquealEvent('front_left', BEGIN + 11.0, BEGIN + 12.5),
                SquealEvent('front_right', BEGIN + 11.5, BEGIN + 12.5)],
        ticks=[tick('front_left', 11.9, 1500.0, 2100.0), tick('front_left', 12.2, 2060.0),
               tick('front_right', 12.2, 2000.0), tick('front_left', 14.0, 2001.0)])
    found = compared(drive, tmp_path, '12.0,2000,front_left,12.5',
                     '50.9,3000,front_right,51', '90.5,3000,front_left,', '200,3000,front_left,')
    assert outcomes(found) == [
        ('front_left', 10.0, 'hit'), ('front_right', 10.0, 'false alarm'),
        ('front_left', 50.0, 'correct silence'), ('front_right', 50.0, 'miss'),
        ('front_left', 90.0, 'not known'), ('front_right', 90.0, 'not known')]
    hit = found.matches.applications[0]
    assert hit.lead_time == pytest.approx(1.0)
    assert hit.frequency_errors == (pytest.approx(60.0),)  # of its own brake, while it squealed
    assert [one.time - BEGIN for one in found.matches.unmatched] == [200.0]
    assert found.counts == {'hit': 1, 'miss': 1, 'false alarm': 1, 'correct silence': 1,
                            'not known': 2}
    text = '\n'.join(found.lines())
    assert 'not known: 2; 2: the squeal risk is not known for enough of it' in text
    assert 'alarm: 1.00 s ahead, before the squeal in 1 of 1 hit\n' in text
    plain = json.loads(json.dumps(found.as_json()))
    assert plain['frequency']['median_relative_error'] == pytest.approx(0.03)
    assert plain['applications'][3]['measured'][0]['frequency_hz'] == 3000.0


def test_of_hits_it_is_said_whose_pitch_and_time_fit(tmp_path: Path) -> None:
    """Pitch and time fit in the first, the pitch in the second, neither in the third."""
    drive = Replayed(
        [application('front_left', start, True) for start in (10.0, 50.0, 90.0)],
        events=[SquealEvent('front_left', BEGIN + start, BEGIN + start + 1.0)
                for start in (11.0, 51.5, 92.5)],
        ticks=[tick('front_left', 11.9, 2030.0), tick('front_left', 51.2, 1990.0),
               tick('front_left', 91.0, 1360.0), tick('front_left', 92.6, 2010.0)])
    found = compared(drive, tmp_path, '11.4,2000,front_left,12', '51,2000,front_left,51.4',
                     '91,2000,front_left,91.5')
    assert found.hits == found.as_json()['hits'] == {
        'count': 3, 'pitch_within_2_percent': 2, 'alarm_first': 1, 'both': 1}
    text, page = '\n'.join(found.lines()), str(measured_section(found, ''))
    for words in ('of 3 hits, pitch within 2% in 2, alarm before the squeal in 1, both in 1',
                  '0.50 s late (median; 1.50 s late to 0.40 s ahead), before the squeal in 1 of '
                  '3 hits'):
        assert words in text
        assert words in page
    assert 'a hit alone says nothing of pitch or time' in text
    assert 'A hit alone says nothing of pitch or time' in page
    assert 'alarm 1.50 s late' in text
    assert '1.50 s late</td>' in page


def test_the_page_says_that_no_pitch_was_predicted(tmp_path: Path) -> None:
    drive = Replayed([application('front_left', 10.0, True, 0.998)])
    found = compared(drive, tmp_path, '12,2000,front_left', '12.5,2000,front_left')
    assert 'risk up to >0.99, measured' in found.lines()[-1]
    assert '>&gt;0.99</td>' in str(measured_section(found, ''))
    words = 'no unstable mode was predicted at any of 2 events'
    assert f'pitch: {words}' in found.lines()
    assert f'Pitch: {words}.' in str(measured_section(found, ''))


def test_events_of_no_brake_are_of_the_vehicle(tmp_path: Path) -> None:
    drive = Replayed(
        [application('front_left', 10.0, False), application('front_right', 11.0, True),
         application('front_left', 50.0, False), application('front_right', 50.0, None)])
    found = compared(drive, tmp_path, '12.0,2000,', '2000,3000,front_left')
    assert found.unit == 'vehicle'
    assert outcomes(found) == [('front_left+front_right', 10.0, 'hit'),
                               ('front_left+front_right', 50.0, 'not known')]
    # an event of another time does not say what events of this time tell apart
    found = compared(drive, tmp_path, '2000,2000,', '12,3000,front_left')
    assert found.unit == 'brake'


def test_groups_are_brakes_that_events_do_not_tell_apart() -> None:
    brakes, places = ('a', 'b', 'c', 'd'), {'a': ('a',), 'front': ('a', 'b'), 'right': ('b', 'd')}
    assert groups_of(brakes, places, ['a']) == (('a',), ('b',), ('c',), ('d',))
    assert groups_of(brakes, places, ['a', 'front']) == (('a', 'b'), ('c',), ('d',))
    assert groups_of(brakes, places, ['front', 'right']) == (('a', 'b', 'd'), ('c',))
    assert groups_of(brakes, places, ['']) == (brakes,)


def test_silence_is_only_where_somebody_listened(tmp_path: Path) -> None:
    drive = Replayed([application('front_left', start, alarm) for start, alarm in (
        (10.0, True), (50.0, False), (90.0, True), (130.0, False))])
    found = compared(drive, tmp_path, '11,2000,front_left', span=(0.0, 100.0))
    assert [one for *_, one in outcomes(found)] == [
        'hit', 'correct silence', 'false alarm', 'not known']
    assert found.matches.applications[-1].why == 'nobody listened to the whole of it'
    assert not found.notes
    # nor where the microphone was dead for a part of it; what was heard beside that was heard
    found = compared(drive, tmp_path, '11,2000,front_left', span=(0.0, 200.0),
                     not_heard_s=[[BEGIN + 12.0, BEGIN + 51.0], [BEGIN + 93.5, BEGIN + 129.9]])
    assert [one for *_, one in outcomes(found)] == [
        'hit', 'not known', 'false alarm', 'correct silence']
    assert '75.40 s of the sound were not heard' in found.notes[0]
    # a pitch that the sound cannot hold was not heard to be absent
    found = compared(drive, tmp_path, '11,1600,front_left', span=(0.0, 100.0),
                     band_hz=[1250, 1900])
    assert [one for *_, one in outcomes(found)] == [
        'hit', 'correct silence', 'not known', 'not known']


@pytest.mark.parametrize(('rows', 'span', 'words'), [
    (['5000,2000,'], None, 'measured.csv: its events are from 1700005000.000 s '
     '(2023-11-14T23:36:40.000+00:00) to 1700005000.000 s '
     '(2023-11-14T23:36:40.000+00:00), and the recordings are '
     'from 1700000000.000 s (2023-11-14T22:13:20.000+00:00) to 1700001000.000 s (2023-11-14T22:30'
     ':00.000+00:00); give `squeal listen` the start'),
    ([], (5000.0, 5100.0), 'it was listened from 1700005000.000 s')])
def test_another_clock_is_refused(tmp_path: Path, rows: list[str],
                                  span: tuple[float, float] | None, words: str) -> None:
    drive = Replayed([application('front_left', 10.0, True)])
    with pytest.raises(MeasuredSquealError) as caught:
        compared(drive, tmp_path, *rows, span=span)
    assert words in str(caught.value)
    assert '\n' not in str(caught.value)


def test_recordings_that_cannot_be_told_apart(tmp_path: Path) -> None:
    drives = [Replayed([application('front_left', 10.0, True)], name=name)
              for name in ('monday', 'tuesday')]
    drives = [drive.written(tmp_path) for drive in drives]
    table = measured(tmp_path, '11,2000,front_left')
    with pytest.raises(MeasuredSquealError, match='line 2: time_s .* is of monday and tuesday'):
        compare(drives, table)
    with pytest.raises(MeasuredSquealError, match='2 results are of a recording of this name'):
        compare([drives[0], drives[0]], table)
    table = measured(tmp_path, '11,2000,front_left', span=(0.0, 100.0), offset_s=None,
                     clock='sync', clock_note='two places')
    with pytest.raises(MeasuredSquealError, match=r'looked for and not found \(two places\)'):
        compare(drives[:1], table)
    table.with_suffix('.json').write_text('{"sound": 1}')
    with pytest.raises(MeasuredSquealError, match='does not say how measured.csv came to be'):
        compare(drives[:1], table)


def test_squeal_that_outlasts_its_application_a_little_is_of_it(tmp_path: Path) -> None:
    """By half a second, as clocks differ and rooms echo; the application ends at 13 s."""
    drive = Replayed([application('front_left', 10.0, True)])
    for time, outcome in (('13.4', 'hit'), ('13.6', 'false alarm')):
        found = compared(drive, tmp_path, f'{time},2000,front_left')
        assert outcomes(found) == [('front_left', 10.0, outcome)]
        assert len(found.matches.unmatched) == (outcome != 'hit')
