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

"""Files of signals: units into SI, changed inputs of the settings, errors with line and key."""

from pathlib import Path
from typing import Any

import pytest
from squeal_core.common.errors import SquealError
from squeal_core.common.measured_units import find_unit
from squeal_core.monitor.settings import MonitorSettings, read_settings
from squeal_ros.recordings.signals.signal_settings import settings_with_signals
from squeal_ros.recordings.signals.signals_file import read_signals
from support.tables import document, opened, signals_file, stop_text, values


def settings_of(path: Path, content: dict[str, Any], **parameters: Any) -> MonitorSettings:
    return settings_with_signals(read_settings(parameters),
                                 read_signals(signals_file(path / 's.yaml', content)))


@pytest.mark.parametrize(('signal', 'unit', 'number', 'si'), [
    ('pressure', 'bar', 10.0, 1e6), ('pressure', 'kPa', 10.0, 1e4), ('pressure', 'hPa', 10.0, 1e3),
    ('pressure', 'MPa', 1.0, 1e6), ('pressure', 'psi', 100.0, 689475.7293),
    ('pressure', 'Pa', 5.0, 5.0), ('pressure', 'N/mm²', 1.0, 1e6),
    ('rotor_speed', '1/min', 60.0, 6.283185307), ('rotor_speed', 'U/min', 60.0, 6.283185307),
    ('rotor_speed', 'rev/s', 1.0, 6.283185307), ('rotor_speed', 'rad/s', 5.0, 5.0),
    ('rotor_speed', 'deg/s', 180.0, 3.141592654), ('rotor_speed', 'km/h', 36.0, 31.25),
    ('rotor_speed', 'm/s', 10.0, 31.25), ('rotor_speed', 'mph', 10.0, 13.97),
    ('temperature', 'degC', 20.0, 293.15), ('temperature', '°C', 20.0, 293.15),
    ('temperature', 'degF', 212.0, 373.15), ('temperature', 'K', 300.0, 300.0),
    ('friction', '-', 0.4, 0.4), ('friction', '%', 40.0, 0.4)])
def test_units(signal: str, unit: str, number: float, si: float, tmp_path: Path) -> None:
    content = document({'rotor_speed': ('n', 'rpm'), 'pressure': ('p', 'bar'),
                        'friction': ('mu', '-'), 'temperature': ('T', 'degC'),
                        signal: ('x', unit)}, wheel_radius_m=0.32)
    (brake,) = settings_of(tmp_path, content).brakes
    source = brake.inputs[signal]  # type: ignore[index]
    assert source.scale * number + source.offset == pytest.approx(si)


@pytest.mark.parametrize('text', ['1/s', 'mPa s', 'foo', '', '[]'])
def test_what_is_no_unit_or_may_be_two(text: str) -> None:
    assert find_unit(text) is None


def test_topics_change_inputs_and_the_rest_is_as_in_the_settings(tmp_path: Path) -> None:
    topic = {'topic': '/wheels', 'type': 'a/msg/B', 'unit': 'rad/s', 'field': 'speed'}
    content = {'clock': {'stamp': 'receipt'}, 'brakes': {
        'fl': {'rotor_speed': topic, 'pressure': {**topic, 'unit': 'bara', 'max_age': 2},
               'friction': {**topic, 'unit': '-', 'stamp': 'header', 'scale': 2, 'offset': 0.1}}}}
    chosen = settings_of(tmp_path, content, brakes=['fl', 'fr'], rate=20.0, **{
        'fl.rotor_speed.max_age': 0.7, 'fl.temperature.topic': 'gone'})
    (brake,) = chosen.brakes
    assert (chosen.rate, brake.name, set(brake.inputs)) == (
        20.0, 'fl', {'rotor_speed', 'pressure', 'friction'})
    speed, pressure, friction = brake.inputs.values()
    assert (speed.topic, speed.field, speed.type, speed.stamp, speed.max_age) == (
        '/wheels', 'speed', 'a/msg/B', 'receipt', 0.7)
    assert (pressure.scale, pressure.reference, pressure.max_age) == (1e5, 'absolute', 2.0)
    assert (friction.stamp, friction.scale, friction.offset) == ('header', 2.0, 0.1)


COLUMN = {'column': 'x', 'unit': 'bar'}


@pytest.mark.parametrize('key', ['column', 'topic'])
def test_a_constant_friction(key: str, tmp_path: Path) -> None:
    inputs = {'rotor_speed': {key: 'n', 'unit': 'rpm'}, 'pressure': {key: 'p', 'unit': 'bar'},
              'friction': {'constant': 0.41}}
    (brake,) = settings_of(tmp_path, {'brakes': {'fl': inputs}}).brakes
    assert (set(brake.inputs), brake.constant_friction) == ({'rotor_speed', 'pressure'}, 0.41)


def wrong(**changes: Any) -> dict[str, Any]:
    """Return a file with other entries of the brake's inputs, None for one left out."""
    content = document()
    inputs = {**content['brakes']['fl'], **changes}
    content['brakes']['fl'] = {key: value for key, value in inputs.items() if value is not None}
    return content


@pytest.mark.parametrize(('content', 'error'), [
    (wrong(pressure={'column': 'p', 'unit': 'baar'}),
     r"line \d+, brakes.fl.pressure.unit: is 'baar', which is no known unit; .*mean bar\?"),
    (wrong(pressure={'column': 'p', 'unit': 'rpm'}), "is 'rpm', a unit of angular speed; write"),
    (wrong(pressure={'column': 'p'}), r'brakes.fl.pressure.unit: is missing'),
    (wrong(rotor_speed={'column': 'v', 'unit': 'km/h'}), 'give wheel_radius_m'),
    (wrong(rotor_speed={'column': 'v', 'unit': '1/s'}), 'write rev/s or rad/s'),
    (wrong(pressure={'column': 'p', 'topic': '/p', 'unit': 'bar'}), 'has column and topic'),
    (wrong(pressure={'unit': 'bar'}), 'has no column or topic'),
    (wrong(pressure={**COLUMN, 'max_agee': 1}), r'max_agee: unknown key .*did you mean max_age'),
    (wrong(pressure={**COLUMN, 'max_age': -1}), r'pressure: max_age is -1 .*0.001 to 3600'),
    (wrong(pressure={**COLUMN, 'minimum': 5.0, 'maximum': 4.0}), 'maximum is 4 and minimum 5'),
    (wrong(pressure={**COLUMN, 'scale': 0}), 'scale: is 0'),
    (wrong(pressure={'column': 'p', 'unit': 'barg', 'reference': 'absolute'}), 'is gauge'),
    (wrong(pressure={'topic': '/p', 'unit': 'bar'}), 'pressure: is missing as column'),
    (wrong(pressure=[COLUMN, {'topic': '/p', 'unit': 'bar'}]), 'rotor_speed: is missing as topic'),
    (wrong(pressure=[COLUMN, dict(COLUMN)]), r'line \d+, brakes.fl.pressure: is named 2 times'),
    (wrong(pressure=[]), r'brakes.fl.pressure: is missing'),
    (wrong(pressure=None), r'line \d+, brakes.fl.pressure: is missing'),
    (wrong(friction=None, temperature=None), 'friction: is missing, and so is temperature'),
    (wrong(friction={'constant': 0.4, 'column': 'mu'}), 'column: unknown key'),
    (wrong(friction={'constant': 2.0}), 'constant: is 2.0; write a number from 0 to 1.5'),
    (wrong(friction={'constant': 0.95}, temperature=None), 'is 0.95; give 0.05 to 0.9'),
    (wrong(friction={'constant': 0.4}, temperature=COLUMN | {'unit': 'K'}),
     'friction.constant is 0.4, and temperature has a topic'),
    (wrong(presure=COLUMN), r'presure: unknown key .*did you mean pressure'),
    (wrong(pressure=3), 'brakes.fl.pressure: is 3; write keys and values'),
    ({'brakes': {}}, 'names no brake'), ({'brakes': {'f l': {}}}, "has 'f l'; use letters"),
    (document(table={'decimal': ';'}), "table.decimal: is ';'; write one of ., ,"),
    (document(table={'delimiter': 'xx'}), 'one character, tab or space'),
    (document(table={'encoding': 'latin-99'}), 'write utf-8'),
    (document(table={'header_row': 1.5}), 'whole number'),
    (document(clock={'column': 't', 'unit': 'sec.'}), 'clock.unit'),
    (document(clock={'column': 't', 'start': 'noon'}), 'line 1[0-9]*, clock.start|clock.start'),
    (document(clok={}), r'clok: unknown key .*did you mean clock')])
def test_errors_name_line_and_key(content: dict[str, Any], error: str, tmp_path: Path) -> None:
    with pytest.raises(SquealError, match=error) as raised:
        settings_of(tmp_path, content)
    assert str(raised.value).startswith(str(tmp_path / 's.yaml'))
    assert '\n' not in str(raised.value)


def test_axles_of_other_brakes_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(SquealError, match='names the brakes fl, and the settings other axles'):
        settings_of(tmp_path, document(), brakes=['a', 'b'], axles=['a+b'])


def test_another_unit_than_the_column_states_is_said(tmp_path: Path) -> None:
    path = tmp_path / 'stop.csv'
    path.write_text(stop_text(), encoding='latin-1')
    content = wrong(pressure={'column': 'Druck [bar]', 'unit': 'kPa'},
                    friction={'column': 'Scheibentemp. [°C]', 'unit': '%'})
    recording = opened(path, {**content, 'clock': {'column': 'Zeit [s]', 'unit': 'ms'}})
    said = ' '.join(recording.notes)
    assert "brakes.fl.pressure: column 'Druck [bar]' states bar, and the file kPa" in said
    assert 'states degC, a unit of temperature, and the file %, which is taken' in said
    assert "clock: the column 'Zeit [s]' states s, and" in said
    assert values(recording)['pressure'][5][1] == pytest.approx(841, abs=60.0)
