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

"""Tables of loggers of many locales give the same samples; what is missing in one is said."""

from contextlib import suppress
import math
from pathlib import Path
import random
import time
from typing import Any

import pytest
from squeal_core.common.errors import SquealError
from squeal_core.monitor.vehicle_monitor import MissingValue
from squeal_ros.recordings.recording_files import open_recording
from squeal_ros.recordings.signals.table_spec import TableSpec
from squeal_ros.recordings.tables.csv_layout import read_layout
from support.tables import default_settings, document, DYNO, opened, stop, stop_text, values

SI = {'rotor_speed': lambda row: row[1] * 0.10471975511965977,
      'pressure': lambda row: 1e5 * row[2], 'friction': lambda row: row[3],
      'temperature': lambda row: row[4] + 273.15}


def write(tmp_path: Path, text: str | bytes, encoding: str = 'utf-8') -> Path:
    path = tmp_path / 'stop.csv'
    path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
    return path


def check(found: dict[str, list[tuple[float, float]]], shift: float = 0.0) -> None:
    for signal, value in SI.items():
        expected = [(max(row[0] + shift, 1e-9), pytest.approx(value(row), abs=11.0))
                    for row in stop()]
        assert [(pytest.approx(stamp, abs=2e-6), number) for stamp, number in expected] == (
            found[signal])


@pytest.mark.parametrize('encoding', ['latin-1', 'utf-8', 'utf-8-sig', 'utf-16', 'utf-16-le',
                                      'utf-16-be', 'cp1252'])
def test_a_dynamometer_of_any_encoding(encoding: str, tmp_path: Path) -> None:
    recording = opened(write(tmp_path, stop_text(), encoding))
    check(values(recording))
    assert (recording.notes, recording.findings) == ([], [])
    assert recording.messages == pytest.approx(101, abs=15)


SPELLINGS: dict[str, tuple[str, dict[str, Any]]] = {
    'english': (stop_text().replace(',', '.').replace(';', ','), {}),
    'tabs': (stop_text().replace(';', '\t'), {}),
    'quoted': ('"' + stop_text().strip().replace(';', '";"').replace('\n', '"\r\n"') + '"', {}),
    'bars': (stop_text().replace(';', ' | ').replace(',', '.'), {}),
    'unit row': (stop_text().replace(';'.join(DYNO), 'Prüfstand 3;26.11.2026\n\nZeit;n;p;mu;T\n'
                                     's;1/min;bar;-;°C'), {
        'columns': {'rotor_speed': ('n', 'rpm'), 'pressure': ('p', 'bar'),
                    'friction': ('mu', '-'), 'temperature': ('T', '°C')},
        'clock': {'column': 'Zeit'}}),
    'headings of two lines': ('"' + stop_text().partition('\n')[0].replace(' [', '\n[').replace(
        ';', '";"') + '"\n' + stop_text().partition('\n')[2], {}),
    'no header': (stop_text().partition('\n')[2], {
        'columns': {'rotor_speed': ('2', 'U/min'), 'pressure': ('3', 'bar'),
                    'friction': ('4', '-'), 'temperature': ('5', 'degC')},
        'clock': {'column': 1, 'unit': 's'}}),
    'blanks': (stop_text().replace(',', '.').replace(';', '  ').replace(' [', '['), {
        'columns': {'rotor_speed': ('Drehzahl[1/min]', 'rpm'), 'pressure': ('Druck[bar]', 'bar'),
                    'friction': ('Reibwert[-]', '-'),
                    'temperature': ('Scheibentemp.[°C]', 'degC')},
        'clock': {'column': 'Zeit[s]', 'unit': 's'}}),
    'blanks and commas': (stop_text().replace(';', '  ').replace(' [', '['), {
        'columns': {'rotor_speed': ('2', 'rpm'), 'pressure': ('3', 'bar'),
                    'friction': ('4', '-'), 'temperature': ('5', 'degC')},
        'clock': {'column': 1, 'unit': 's'}}),
    'stated': (stop_text().replace(';', '!').replace('\n', '\n99!1!1!1!1\n', 1), {
        'table': {'delimiter': '!', 'decimal': ',', 'first_row': 3, 'header_row': 1}})}


@pytest.mark.parametrize('name', SPELLINGS)
def test_spellings(name: str, tmp_path: Path) -> None:
    text, content = SPELLINGS[name]
    check(values(opened(write(tmp_path, text), document(**content))))


def numbers(text: str, tmp_path: Path, **table: str) -> tuple[list[float], str]:
    """Return the pressures [Pa] of a table of times and pressures, and what is said of it."""
    content = document({signal: ('p', unit) for signal, unit in (
        ('rotor_speed', 'rpm'), ('pressure', 'Pa'), ('friction', '-'))},
        clock={'column': 't', 'unit': 's'}, table=table)
    recording = opened(write(tmp_path, text), content)
    return [value for _, value in values(recording).get('pressure', [])], ' '.join(
        [*recording.notes, *map(str, recording.findings)])


@pytest.mark.parametrize(('cells', 'expected', 'said'), [
    ('1.234,5 2.234,5 234,5', [1234.5, 2234.5, 234.5], ''),
    ("1'234.5 2'234.5 234.5", [1234.5, 2234.5, 234.5], ''),
    ('1\u00a0234,5 2\u202f234,5 234,5', [1234.5, 2234.5, 234.5], ''),
    ('1,5 1.5 2,5', [1.5, 2.5], "fl.pressure: 1 cells of 'p' are no number, the first '1.5'"),
    ('1.5 1,5 2.5', [1.5, 2.5], "the first '1,5' in line 3"),
    ('1,5e3 -2,5E-1 +,5', [1500.0, -0.25, 0.5], ''),
    ('1,5 Err ---', [1.5], "2 cells of 'p' are no number, the first 'Err' in line 3: taken as"),
    ('1,5  NaN', [1.5], "2 of 3 cells of 'p' are empty: taken as missing"),
    ('1.5 inf 1_0', [1.5], "the first 'inf' in line 3")])
def test_numbers_as_they_are_written(cells: str, expected: list[float], said: str,
                                     tmp_path: Path) -> None:
    text = 't;p;x\n' + ''.join(f'{n};{cell};a\n' for n, cell in enumerate(cells.split(' '), 1))
    found, notes = numbers(text, tmp_path)
    assert found == pytest.approx(expected)
    assert said in notes if said else not notes


def test_a_text_is_a_missing_value_and_an_empty_cell_none(tmp_path: Path) -> None:
    text = stop_text(4).replace('0,0000;0,4000', ';0,4000', 1).replace('0,4002', 'Err')
    first, second, *_ = (samples for _, samples in opened(write(tmp_path, text)).samples())
    assert [signal for _, signal, _ in first] == ['rotor_speed', 'friction', 'temperature']
    assert [sample.reason for _, signal, sample in second
            if isinstance(sample, MissingValue)] == ["'Err' is no number"]


@pytest.mark.parametrize(('text', 'error'), [
    ('', 'is empty'),
    ('\n \n', 'is empty'),
    (';'.join(DYNO) + '\n', 'has no row to read; check clock'),
    ('just words\nof no table\nat all\n', 'is no table: it has no rows of values'),
    (b'\x7fELF\x02\x01\x01\0\0\0\0\0\0\n' + bytes(1000), 'is no text'),
    (bytes(range(256)) * 40, 'is no text'),
    ('t;p\n' + 'x' * 10_000_000 + '\n', 'line 2: has more than 1000000 characters'),
    (stop_text(9).replace('Druck [', 'Druk ['), '(did you mean Druk [bar]?)'),
    (stop_text(9).replace('\n0,', '\nx,'), '9 rows without a time that can be read')])
def test_what_is_no_table_is_one_line(text: str | bytes, error: str, tmp_path: Path) -> None:
    begun = time.process_time()
    with pytest.raises(SquealError) as raised:
        values(opened(write(tmp_path, text)))
    assert error in str(raised.value)
    assert len(str(raised.value)) < 700
    assert time.process_time() - begun < 5.0


def test_damaged_rows_are_left_out_and_said(tmp_path: Path) -> None:
    lines = stop_text(50).splitlines()
    lines[10] = lines[10][:20]
    lines[20] += ';1;2'
    lines[30] = '\0' * 40
    lines[40] = lines[40].replace(';', '\0;', 2)
    recording = opened(write(tmp_path, '\r\n'.join(lines)))
    assert len(values(recording)['friction']) == 46
    said = ' '.join(recording.notes)
    assert '2 rows have fewer cells than the 5 columns, the first in line 11: left out' in said
    assert '1 row has more cells than the 5 columns, the first in line 21: left out' in said
    assert '1 row without a time that can be read, the first in line 41: left out' in said


@pytest.mark.parametrize(('above', 'first', 'names', 'units'), [
    ('t_s,p_bar,mu,temp_C\nErr,,#N/A,---', 2, 't_s', ''),
    ('t_s,p_bar,mu,temp_C\n0,Err,,ok', 2, 't_s', ''),
    ('t_s,p_bar,mu,temp_C\n-,-,-,-', 2, 't_s', ''),
    ('t,p,mu,T\ns,bar,n/a,°C\nErr,,,', 3, 't', 's'),
    ('t,p,mu,T\n[s],[bar],[-],[°C]', 3, 't', '[s]'),
    ('t,-,2,T', 2, 't', '')])
def test_a_row_of_missing_values_is_no_row_of_units(
        above: str, first: int, names: str, units: str, tmp_path: Path) -> None:
    rows = ''.join(f'{t},1.5,.4,20\n' for t in range(3))
    layout = read_layout(write(tmp_path, f'{above}\n{rows}'), TableSpec())
    assert (layout.first_row, layout.names[0], layout.units[0]) == (first, names, units)


def test_one_row_and_a_trailing_delimiter(tmp_path: Path) -> None:
    text = stop_text(1).replace('\n', ';\n')
    assert values(opened(write(tmp_path, text)))['friction'] == [(1e-9, 0.4)]


def test_any_damage_is_one_line_or_samples(tmp_path: Path) -> None:
    """Bytes are changed, cut out and doubled: either some row is read or one line says why not."""
    whole = stop_text(30).encode('latin-1')
    for seed in range(60):
        chance = random.Random(seed)
        data = bytearray(whole)
        for _ in range(chance.choice([1, 5, 60])):
            at = chance.randrange(len(data))
            kind = chance.randrange(4)
            if kind == 0:
                data[at] = chance.randrange(256)
            elif kind == 1:
                del data[at:at + chance.randrange(30)]
            elif kind == 2:
                data[at:at] = data[at // 2:at // 2 + chance.randrange(40)]
            else:
                data[at:at] = chance.choice([b'"', b'\n', b';', b'\0', b'\xff\xfe', b'1e999'])
        with suppress(SquealError):  # which is one line, always
            values(opened(write(tmp_path, bytes(data))))


def test_a_table_needs_signals(tmp_path: Path) -> None:
    with pytest.raises(SquealError, match='run `squeal signals .*stop.csv -o SIGNALS.yaml`'):
        open_recording(write(tmp_path, stop_text()), default_settings())


def test_positions_are_columns_of_degrees_or_minutes(tmp_path: Path) -> None:
    """Rows before the receiver has a fix, at 0, 0, and those without numbers have none."""
    lines = stop_text(4).splitlines()
    fixes = ('Breite;Long', '0;0', '2886,0;11', ';', '2892,0;11,2')
    path = tmp_path / 'stop.csv'
    path.write_text(''.join(f'{line};{fix}\n' for line, fix in zip(lines, fixes, strict=True)))
    content = document(position={'latitude': {'column': 'Breite', 'unit': 'min'},
                                 'longitude': {'column': 'Long'}})
    recording = opened(path, content)
    times = [time for time, _ in recording.samples()]
    assert [recording.positions.at(time) for time in times[1:]] == [
        pytest.approx(one) for one in ((48.1, 11.0), (48.15, 11.1), (48.2, 11.2))]
    assert all(map(math.isnan, recording.positions.at(times[0])))
    assert not recording.notes
    of_text = document(position={'latitude': {'column': 'Breite'}, 'longitude': {'column': 4}})
    path.write_text(''.join(f'{line};{fix}\n' for line, fix in zip(
        lines, ('Breite;x', *['N 48;E 11'] * 4), strict=True)))
    recording = opened(path, of_text)
    assert len(list(recording.samples())) == 4
    assert any('position:' in note for note in recording.notes)
