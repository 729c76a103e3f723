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

"""`squeal signals`: what is inside, and a proposed file that can be used as it is."""

import json
from pathlib import Path

import pytest

pytest.importorskip('rosbags', reason='needs rosbags')
import numpy as np  # noqa: E402, I100
from squeal_core.common.errors import SquealError  # noqa: E402
from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.recordings.recording_files import open_recording  # noqa: E402
from squeal_ros.recordings.signals.contents import Entry  # noqa: E402
from squeal_ros.recordings.signals.signal_guesses import propose  # noqa: E402
from squeal_ros.recordings.signals.signal_settings import settings_with_signals  # noqa: E402
from squeal_ros.recordings.signals.signals_file import read_signals  # noqa: E402
from support.bags import braking, JOINTS, make, reports, write_bag  # noqa: E402, I100
from support.bags import Entry as Message  # noqa: E402
from support.tables import default_settings, stop_text  # noqa: E402


def entry(name: str, unit: str = '', low: float = 0.0, high: float = 100.0) -> Entry:
    return Entry(name=name, unit=unit, count=100, rate_hz=100.0, minimum=low, maximum=high)


CARS = {  # names as loggers of several countries have them; brakes, and units with (why)
    'german': ([entry('nRad_VL', '1/min'), entry('nRad_VR', '1/min'), entry('pBrems_VL', 'bar'),
                entry('Bremsdruck VR', 'bar'), entry('Reibwert_VL'), entry('Reibwert_VR'),
                entry('Motordrehzahl', '1/min'), entry('Reifendruck VL', 'bar'),
                entry('Umgebungsdruck', 'hPa')],
               {'front_left': ['nRad_VL', 'pBrems_VL', 'Reibwert_VL'],
                'front_right': ['nRad_VR', 'Bremsdruck VR', 'Reibwert_VR']}),
    'french': ([entry('Vitesse roue avant gauche', 'tr/min'),
                entry('Pression avant gauche', 'bar'),
                entry('Frottement avant gauche', '', 0.2, 0.5), entry('Température disque AVG'),
                entry('Température air', '°C')],
               {'front_left': ['Vitesse roue avant gauche', 'Pression avant gauche',
                               'Frottement avant gauche', 'Température disque AVG']}),
    'italian': ([entry('velocità ruota posteriore sinistra', 'giri/min'),
                 entry('pressione freno post. sx', 'MPa'), entry('attrito posteriore sinistro')],
                {'rear_left': ['velocità ruota posteriore sinistra', 'pressione freno post. sx',
                               'attrito posteriore sinistro']}),
    'english': ([entry('wss_speed_fl_rad_s', 'rad/s'), entry('cba_actual_pressure_fl_pa', 'Pa'),
                 entry('brake_disk_temp_fl'), entry('brake_pad_temp_fl'), entry('tire_temp_fl'),
                 entry('brake_pressure_cmd_fl', 'Pa'), entry('yaw rate', 'deg/s')],
                {'front_left': ['wss_speed_fl_rad_s', 'cba_actual_pressure_fl_pa',
                                'brake_disk_temp_fl']}),
    'one brake': ([entry('Disc Temp'), entry('Rotor speed'), entry('Brake Pressure'),
                   entry('COF')],
                  {'brake': ['Rotor speed', 'Brake Pressure', 'COF', 'Disc Temp']}),
    'vehicle speed': ([entry('Vehicle Speed', 'km/h'), entry('PressFL', 'bar'), entry('µ_FL')],
                      {'front_left': ['Vehicle Speed', 'PressFL', 'µ_FL']}),
    'short': ([entry('n', 'rpm'), entry('p', 'bar'), entry('mu'), entry('T', '°C')],
              {'brake': ['n', 'p', 'mu', 'T']})}


@pytest.mark.parametrize('name', CARS)
def test_names_of_several_languages(name: str) -> None:
    entries, expected = CARS[name]
    found = propose(entries).brakes
    assert {brake: [guess.entry.name for guess in one] for brake, one in found.items()} == expected


@pytest.mark.parametrize(('name', 'low', 'high', 'unit'), [
    ('pressure', 0.0, 80.0, 'bar'), ('pressure', 0.0, 8e3, 'kPa'), ('pressure', 0.0, 8e6, 'Pa'),
    ('rotor speed', 0.0, 90.0, 'rad/s'), ('rotor speed', 0.0, 900.0, '1/min'),
    ('Drehzahl', 0.0, 90.0, '1/min'), ('Geschwindigkeit', 0.0, 90.0, 'km/h'),
    ('temp', 20.0, 400.0, 'degC'), ('temp', 290.0, 700.0, 'K'), ('mu', 0.2, 0.5, '-'),
    ('mu', 20.0, 50.0, '%')])
def test_units_by_name_and_range_are_marked(name: str, low: float, high: float, unit: str) -> None:
    other = {'pressure': entry('p', 'bar'), 'rotor_speed': entry('n', 'rpm'),
             'friction or temperature': entry('COF')}
    lacks = propose([entry(name, '', low, high)]).incomplete['brake']
    found = propose([entry(name, '', low, high), *(other[one] for one in lacks)]).brakes['brake']
    (guess,) = (guess for guess in found if guess.entry.name == name)
    assert guess.unit.name == unit
    assert unit == '-' or guess.notes[0].startswith('unit by its')


def test_what_a_brake_lacks_is_said() -> None:
    proposal = propose([entry('p_FL', 'bar'), entry('p_FR', 'bar'), entry('n_FR', 'rpm')])
    assert proposal.incomplete == {'front_left': ['rotor_speed', 'friction or temperature'],
                                   'front_right': ['friction or temperature']}


def test_a_table_and_back(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path, signals = tmp_path / 'stop.csv', tmp_path / 's.yaml'
    path.write_text(stop_text().replace('0,4040', 'Err'), encoding='latin-1')
    assert main(['signals', str(path), '--json']) == 0
    found = json.loads(capfd.readouterr().out)
    assert (found['usable'], found['clock']) == (True, {'column': 'Zeit [s]', 'unit': 's'})
    friction = next(one for one in found['entries'] if one['name'] == 'Reibwert [-]')
    assert (friction['texts'], friction['count'], friction['rate_hz']) == (
        1, 99, pytest.approx(50.0))
    assert main(['signals', str(path)]) == 0
    signals.write_text(capfd.readouterr().out)  # what is printed is a file of signals
    assert main(['replay', str(path), '--signals', str(signals), '-o',
                 str(tmp_path / 'out.mcap')]) == 0
    said = capfd.readouterr().out
    assert 'assessed 100 % of the braking time' in said
    assert "brake.friction: 1 cells of 'Reibwert [-]' are no number" in said
    assert main(['replay', str(path), '-o', str(tmp_path / 'new.mcap')]) == 2
    assert 'run `squeal signals' in capfd.readouterr().err


def test_one_is_singular_and_units_have_one_pair_of_brackets(
        tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'stop.csv'
    path.write_text('t,n,p,mu\n[s],[rpm],[bar],[-]\n0,9,1,.4\n1,9,1,.4\n')
    assert main(['signals', str(path)]) == 0
    said = capfd.readouterr().out
    assert 't: time, [s], 2 values' in said
    assert 'proposed: 1 brake (brake)' in said


def test_arrays_of_four_are_wheels_in_the_usual_order_and_said_to_be_guessed() -> None:
    wheels = [Entry(name='/chassis', field=f'{name}[{place}]', type='a/msg/B', count=9,
                    rate_hz=50.0, minimum=0.0, maximum=60.0)
              for name in ('wheel_speed', 'brake_pressure') for place in range(4)]
    friction = Entry(name='/friction', field='data', type='std_msgs/msg/Float64', count=9,
                     rate_hz=50.0, minimum=0.4, maximum=0.4)
    found = propose([*wheels, friction]).brakes
    assert list(found) == ['front_left', 'front_right', 'rear_left', 'rear_right']
    assert [guess.entry.field for guess in found['rear_left']] == [
        'wheel_speed[2]', 'brake_pressure[2]', 'data']
    assert all('by its place among four' in ' '.join(guess.notes)
               for guess in found['rear_left'][:2])
    three = propose([*wheels[:3], *wheels[4:7], friction]).brakes
    assert [guess.notes[-1] for guess in three['brake'][:2]] == ['one of 3 elements'] * 2


@pytest.mark.parametrize(('unit', 'one_bar'), [('bar', 1.0), ('kPa', 100.0), ('Pa', 1e5)])
def test_a_pressure_that_never_falls_below_that_of_the_air_is_absolute(
        unit: str, one_bar: float) -> None:
    for low, absolute in ((1.0, True), (0.0, False), (1.5, False)):
        found = propose([entry('n_FL', '1/min'), entry('mu_FL', '', 0.3, 0.5),
                         entry('p_FL', unit, low * one_bar, 60.0 * one_bar)])
        guess = {one.signal: one for one in found.brakes['front_left']}['pressure']
        assert guess.absolute == absolute


def test_a_bag_and_back(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    joints = [Message(one.topic, one.type, one.time, make(
        JOINTS, header=one.message.header, name=['steering', 'front_left_wheel'],
        position=np.zeros(0), velocity=one.message.velocity, effort=np.zeros(0)))
        for one in braking() if one.type == JOINTS]
    bag = write_bag(tmp_path / 'bag', [*joints, *(one for one in braking() if one.type != JOINTS),
                                       *(one for one in reports() if one.topic == '/wheels')])
    signals = tmp_path / 's.yaml'
    assert main(['signals', str(bag), '-o', str(signals)]) == 0
    assert '/wheels pressures[1]' in capfd.readouterr().out
    read = read_signals(signals)
    assert [(one.name, one.field) for one in read.sources] == [
        ('/joint_states', 'velocity[name=front_left_wheel]'),
        ('/fl/brake_pressure', 'fluid_pressure'), ('/fl/friction', 'data')]
    chosen = settings_with_signals(default_settings(), read)
    recording = open_recording(bag, chosen, signals=read)
    assert sum(len(samples) for _, samples in recording.samples()) == 120
    assert recording.findings == []
    assert main(['signals', str(bag), '-o', str(signals)]) == 2
    assert '--force' in capfd.readouterr().err


@pytest.mark.parametrize(('text', 'code', 'said'), [
    ('t,x\n0,1\n1,2\n', 1, 'no brake has all inputs'), ('', 2, 'is empty'),
    (None, 2, 'holds 2 recordings, the first'),
    ('Druck [bar];Drehzahl [rpm];mu\n1;2;0,4\n', 1, 'no column looks like the clock')])
def test_exit_codes(text: str | None, code: int, said: str, tmp_path: Path,
                    capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / 'a.csv').write_text(text or '')
    (tmp_path / 'b.csv').touch()
    assert main(['signals', str(tmp_path if text is None else tmp_path / 'a.csv')]) == code
    printed = capfd.readouterr()
    assert said in printed.out + printed.err


def test_signals_of_the_other_kind_are_one_line(tmp_path: Path) -> None:
    path, bag = tmp_path / 'stop.csv', write_bag(tmp_path / 'bag', braking(0.1))
    path.write_text(stop_text(9))
    signals = tmp_path / 's.yaml'
    main(['signals', str(bag), '-o', str(signals)])
    read = read_signals(signals)
    with pytest.raises(SquealError, match='is a table of columns, and the signals name'):
        open_recording(path, settings_with_signals(default_settings(), read), signals=read)


def test_what_of_a_file_does_not_fit_a_bag_is_said(tmp_path: Path) -> None:
    bag, signals = write_bag(tmp_path / 'bag', braking(0.1)), tmp_path / 's.yaml'
    main(['signals', str(bag), '-o', str(signals)])
    text = signals.read_text().replace('fluid_pressure, unit: Pa', 'fluid_pressure, unit: bar')
    for more, error in (('', ''), ('clock: {offset: 1}\n', 'names more than a stamp')):
        signals.write_text(more + text)
        read = read_signals(signals)
        chosen = settings_with_signals(default_settings(), read)
        if error:
            with pytest.raises(SquealError, match=error):
                open_recording(bag, chosen, signals=read)
        else:
            (note,) = open_recording(bag, chosen, signals=read).notes
            assert "topic '/fl/brake_pressure fluid_pressure' states Pa, and the file bar" in note
