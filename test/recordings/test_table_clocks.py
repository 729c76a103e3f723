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

"""Clocks of tables: units, dates of several locales, zones, starts; late and repeated times."""

from datetime import datetime
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

import pytest
from squeal_core.common.errors import SquealError
from support.tables import document, opened, values

BERLIN = ZoneInfo('Europe/Berlin')
TEN = datetime(2026, 11, 26, 10, 0, 0, tzinfo=BERLIN).timestamp()
COLUMNS = {'rotor_speed': ('n', 'rpm'), 'pressure': ('p', 'bar'), 'friction': ('mu', '-')}


def times(tmp_path: Path, cells: list[str], clock: dict[str, Any], **top: Any
          ) -> tuple[list[float], str]:
    """Return the times of the samples of a table, and what is said of them."""
    path = tmp_path / 'a.csv'
    path.write_text('t;n;p;mu\n' + ''.join(f'{cell};1,5;2,5;0,4\n' for cell in cells))
    recording = opened(path, document(COLUMNS, clock={'column': 't', **clock}, **top))
    found = [time for time, _ in values(recording)['friction']]
    return found, ' '.join(recording.notes)


@pytest.mark.parametrize(('cell', 'clock', 'time'), [
    ('12,5', {'unit': 's'}, 12.5), ('12500', {'unit': 'ms'}, 12.5), ('12500', {}, None),
    ('0,5', {'unit': 'min'}, 30.0), ('1795683600,25', {'unit': 's'}, TEN + 0.25),
    ('1795683600250', {'unit': 'ms'}, TEN + 0.25),
    ('12,5', {'unit': 's', 'start': '2026-11-26T10:00:00+01:00'}, TEN + 12.5),
    ('12,5', {'unit': 's', 'start': datetime(2026, 11, 26, 10), 'timezone': 'Europe/Berlin',
              'offset': -2.0}, TEN + 10.5),
    ('2026-11-26T10:00:00.25+01:00', {'unit': 'iso'}, TEN + 0.25),
    ('2026-11-26 09:00:00,25Z', {'unit': 'iso'}, TEN + 0.25),
    ('2026/11/26 10:00:00.25', {'unit': 'ymd', 'timezone': '+01:00'}, TEN + 0.25),
    ('26.11.2026 10:00:00,250', {'unit': 'dmy', 'timezone': 'Europe/Berlin'}, TEN + 0.25),
    ('26.11.26 10:00', {'unit': 'dmy', 'timezone': 'Europe/Berlin'}, TEN),
    ('11/26/2026 10:00:00 AM', {'unit': 'mdy', 'timezone': 'Europe/Berlin'}, TEN),
    ('11/26/2026 12:30 am', {'unit': 'mdy', 'timezone': 'Europe/Berlin'}, TEN - 34200.0),
    ('46352,4166666667', {'unit': 'excel', 'timezone': 'Europe/Berlin'}, TEN),
    ('10:00:00,25', {'unit': 'clock'}, 36000.25),
    ('10:00:00.25', {'unit': 'clock', 'start': '2026-11-26', 'timezone': 'Europe/Berlin'},
     TEN + 0.25), ('26.13.2026 10:00', {'unit': 'dmy'}, None), ('soon', {'unit': 's'}, None)])
def test_units_and_formats(cell: str, clock: dict[str, Any], time: float | None,
                           tmp_path: Path) -> None:
    if time is None:
        with pytest.raises(SquealError, match='has no unit|without a time that can be read'):
            times(tmp_path, [cell], clock)
        return
    found, notes = times(tmp_path, [cell], clock)
    assert found == [pytest.approx(time, abs=2e-5 if clock['unit'] == 'excel' else 3e-7)]
    local = clock['unit'] in ('iso', 'dmy', 'mdy') and not ('timezone' in clock or '+' in cell
                                                            or 'Z' in cell)
    assert ('taken as UTC' in notes) == (
        local or clock['unit'] == 'excel' and 'timezone' not in clock)


def test_date_and_time_in_columns_of_their_own(tmp_path: Path) -> None:
    path = tmp_path / 'a.csv'
    path.write_text('d;t;n;p;mu\n26.11.2026;10:00:00,5;1;2;0,4\n')
    recording = opened(path, document(COLUMNS, clock={
        'column': ['d', 't'], 'unit': 'dmy', 'timezone': 'Europe/Berlin'}))
    assert values(recording)['friction'] == [(TEN + 0.5, 0.4)]


@pytest.mark.parametrize(('cells', 'expected', 'said'), [
    ('1 2 2 3', [1, 2, 2, 3], '1 row with the time of the row before, the first in line 4'),
    ('1 2 x  3', [1, 2, 3], '2 rows without a time that can be read, the first in line 4'),
    ('1 2 1,5 3', [1, 2, 1.5, 3], '1 row with a time before that of the row before, by up to 0.5'),
    ('9 10 1 2', [9, 10, 1, 2], 'the time goes back once, by up to 9 s, first in line 4'),
    ('-1,5 0 1', [0.5, 2, 3], '2 s are added to all of them'),
    ('0 1 1e99', [1e-9, 1], '1 row without a time that can be read, the first in line 4')])
def test_times_out_of_order_are_taken_and_said(cells: str, expected: list[float], said: str,
                                               tmp_path: Path) -> None:
    found, notes = times(tmp_path, cells.split(' '), {'unit': 's'})
    assert found == pytest.approx(expected)
    assert said in notes


def test_midnight(tmp_path: Path) -> None:
    found, notes = times(tmp_path, ['23:59:59', '00:00:01', '00:00:02'], {'unit': 'clock'})
    assert found == [86399.0, 86401.0, 86402.0]
    assert 'begins anew once, first in line 3: taken as the next day' in notes


def test_recorded_times_rise_but_where_the_clock_is_set_back(tmp_path: Path) -> None:
    path = tmp_path / 'a.csv'
    path.write_text('t;n;p;mu\n' + ''.join(f'{t};1;2;0,4\n' for t in (1, 2, '1,5', 3, '0,5')))
    recording = opened(path, document(COLUMNS, clock={'column': 't', 'unit': 's'}))
    assert [time / 1e9 for time, _ in recording.samples()] == [1, 2, 2, 3, 0.5]
