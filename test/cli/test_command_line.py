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

"""The command line as users meet it: versions, words that are nearly right, what is printed."""

import dataclasses
import json
from pathlib import Path
import re
from typing import Any
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
import squeal_core
from squeal_core import BrakeModel, OperatingPoint
from squeal_core.stability.eigensolution import complex_modes
from squeal_core.studies.sweep import sweep
from squeal_core.studies.sweep_file import load_sweep, save_sweep
from squeal_core.vehicle.drive_cycle import read_drive_cycle
from support.brake_monitors import small_model
from support.commands import squeal
from support.rows import each
import yaml

ROOT = Path(__file__).parents[2]
POINT = OperatingPoint(rotor_speed=5.0, friction=0.4, contact_pressure=3.6e5,
                       contact_stiffness=0.35e11)


@pytest.fixture
def small(tmp_path: Path) -> str:
    """Return a model file of four modes."""
    small_model().save(tmp_path / 'small.npz')
    return str(tmp_path / 'small.npz')


def test_one_version_everywhere() -> None:
    package = ElementTree.parse(ROOT / 'package.xml').getroot().findtext('version')
    assert squeal_core.__version__ == package
    messages = ElementTree.parse(ROOT / 'squeal_msgs' / 'package.xml').getroot()
    assert messages.findtext('version') == package
    cited = yaml.safe_load((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))
    released = re.search(r'^(\d+\.\d+\.\d+) \((\d{4}-\d\d-\d\d)\)\n-+$',
                         (ROOT / 'CHANGELOG.rst').read_text(encoding='utf-8'), re.MULTILINE)
    assert released
    assert (cited['version'], str(cited['date-released'])) == released.groups()
    assert released[1] == package
    for name in ('setup.py', 'pyproject.toml'):  # neither states a number of its own
        assert not re.search(r'^\s*version\s*=\s*[\'"]\d',
                             (ROOT / name).read_text(encoding='utf-8'), re.MULTILINE)


def test_records_of_arrays_are_shown_in_a_line(kang: BrakeModel) -> None:
    records = [kang, kang.surface, complex_modes(kang, POINT),
               sweep(kang, POINT, {'friction': [0.1, 0.2]}),
               read_drive_cycle(ROOT / 'config' / 'drive_cycles' / 'us06.csv')]
    for record in records:
        text = repr(record)
        assert len(text) < 500
        assert '\n' not in text
        assert 'array' not in text or '5 arrays' in text
    assert repr(kang).startswith("BrakeModel('kang2009': 92 modes, 0 to 32283 Hz")
    assert 'eigenvalues=<2x92 complex128>' in repr(records[3])
    assert len(repr(dataclasses.replace(kang, provenance={'brake': 'b' * 10**5}))) < 300


@pytest.mark.parametrize(('arguments', 'near'), [
    (['modes', 'kang200', '--rotor-speed', '5'], 'kang2009'),
    (['build', 'kang09', '-o', 'x.npz'], 'kang2009'),
    (['tabulate', 'kang2009', '--drive', 'uso6', '-o', 'x.npz'], 'us06'),
    (['tabulate', 'kang2009', '--drive', 'us06', '--vehicle', 'midsise', '-o', 'x.npz'],
     'midsize')])
def test_a_shipped_name_that_is_nearly_right(arguments: list[str], near: str,
                                             capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = squeal(capsys, *arguments)
    assert (code, out, len(err.splitlines())) == (2, '', 1)
    assert f'did you mean {near}?' in err


def test_squeal_is_listed_before_divergence(capsys: pytest.CaptureFixture[str]) -> None:
    """Under the friction law K09's brake has both; a divergence grows fastest."""
    _, out, _ = squeal(capsys, 'modes', 'kang2009', '--rotor-speed', '5')
    assert '5 of 92 modes are unstable: 3 squeal' in out
    rows = [line.split() for line in out.splitlines()[3:]]
    kinds, growth = [row[2] for row in rows], [float(row[4]) for row in rows]
    assert kinds == ['flutter'] * 3 + ['divergence'] * 2
    assert growth[:3] == sorted(growth[:3], reverse=True)
    assert growth[3] > growth[0]


@pytest.mark.parametrize('command', ['map', 'locus'])
def test_sweeps_without_a_file_print_their_result(command: str, small: str,
                                                  capsys: pytest.CaptureFixture[str]) -> None:
    model = BrakeModel.load(small)
    arguments = (command, small, '--over', 'friction=0.3:0.6:2')
    _, out, _ = squeal(capsys, *arguments)
    lines = out.splitlines()
    assert len(lines) == 4  # headings, a line a point, the summary
    point = dataclasses.replace(POINT, friction=0.6, contact_pressure=2000.0 / model.contact_area,
                                contact_stiffness=model.nominal_contact_stiffness)
    unstable = complex_modes(model, point).unstable
    assert lines[2].split()[:2] == ['0.6', str(len(unstable))]
    assert f'{unstable[0].frequency_hz:.1f} ({unstable[0].growth_rate:+.3f})' in lines[2]
    _, out, _ = squeal(capsys, *arguments, '--json')
    (_, last) = json.loads(out)['results']
    assert last['friction'] == 0.6
    assert [m['frequency_hz'] for m in last['unstable']] == pytest.approx(
        [m.frequency_hz for m in unstable], rel=1e-9)


def test_a_locus_prints_the_modes_that_it_follows(capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = squeal(capsys, 'locus', 'kang2009', '--modes', '13,14', '--without-rotation',
                       '--over', 'friction=0:0.5:2')
    lines = out.splitlines()
    assert lines.index('without rotation') == 3
    assert '13: 1657.4 (-17.593), 14: ' in lines[1]


@pytest.mark.parametrize('suffix', ['.csv', '.json', '.npz'])
def test_records_have_frequencies_in_hz(suffix: str, tmp_path: Path, kang: BrakeModel) -> None:
    record = sweep(kang, POINT, {'friction': [0.1, 0.2]})
    path = tmp_path / f'r{suffix}'
    save_sweep(record, path)
    assert load_sweep(path).frequencies_hz == pytest.approx(record.frequencies_hz)
    written: Any
    if suffix == '.csv':
        header, *rows = path.read_text().splitlines()[1:]
        written = [float(row.split(',')[header.split(',').index('frequency_hz')]) for row in rows]
        older = [line.rpartition(',')[0] for line in (header, *rows)]  # of an earlier version
        path.write_text('\n'.join([path.read_text().splitlines()[0], *older]))
        assert load_sweep(path).frequencies_hz == pytest.approx(record.frequencies_hz)
    elif suffix == '.json':
        written = json.loads(path.read_text())['frequencies_hz']
    else:
        written = np.load(path)['frequencies_hz']
    assert np.ravel(written) == pytest.approx(record.frequencies_hz.ravel())


def test_remedies_name_no_package_that_a_stranger_could_publish() -> None:
    """This project is on no package index: it is installed from the checkout."""
    texts = [path.read_text(encoding='utf-8') for folder in ('squeal_core', 'squeal_ros', 'docs')
             for path in (ROOT / folder).rglob('*') if path.suffix in ('.py', '.md')]
    texts.append((ROOT / 'README.md').read_text(encoding='utf-8'))
    commands = [found for text in texts for found in re.findall(r'pip install ([^`\n]+)', text)]
    assert len(commands) > 10
    assert [c for c in commands if not re.match(r"-e '\.\[[\w,]+\]'|\./squeal_msgs$", c)] == []


@pytest.mark.parametrize(('arguments', 'words'), [
    (['moddes', 'kang2009'], 'did you mean modes?'), (['--verson'], 'did you mean --version?'),
    (['tabulate', 'kang2009', '--drive', 'us06', '--duration', '-3', '-o', 'x.npz'],
     '--duration: is -3'),
    (['modes', 'kang2009', '--rotor-speed', '5', '--frction', '3'], 'did you mean --friction?'),
    (['modes', 'kang2009', '--rotor-speed', '5x'], "invalid float value: '5x'"),
    (['modes', 'kang2009'], 'required: --rotor-speed'),
    (['modes', 'kang2009', '--rotor-sped', '5'], 'required: --rotor-speed (did you mean --rotor-'),
    (['modes', 'kang2009', '--friction', '0.4', '--pres', '1e6'], 'required: --rotor-speed;'),
    ([], 'required: COMMAND')])
def test_wrong_words_of_a_command_line(arguments: list[str], words: str,
                                       capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = squeal(capsys, *arguments)
    assert (code, out, len(err.splitlines())) == (2, '', 1)
    assert words in err


def test_a_negative_number_with_an_exponent_is_no_option(
        small: str, capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = squeal(capsys, 'modes', small, '--rotor-speed', '5', '--friction', '0.4',
                       '--friction-slope', '-1e-1')
    assert 'slope -0.1 s/m' in out


@each(('option', 'value', 'words'), [
    ('--friction', '42', '42 % would be 0.42'), ('--friction', '-0.4', 'that of the speed'),
    ('--pressure', '-8e5', 'is -800000 Pa; give 0 to'),
    ('--friction-slope', '500', 'is 500 s/m; give 0 to 100 s/m'),
    ('--preload', '1e9', 'is 1e+09 N; give 0 to')])
def test_options_that_nothing_can_follow(option: str, value: str, words: str,
                                         capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = squeal(capsys, 'modes', 'kang2009', '--rotor-speed', '5', option, value)
    assert (code, out, len(err.splitlines())) == (2, '', 1)
    assert err.startswith(f'squeal: {option}: is ')
    assert words in err


@each(('option', 'value', 'words'), [
    ('--pressure', '8', '8 bar would be 800000 Pa'), ('--preload', '2', '2 kN would be 2000 N'),
    ('--friction', '0.02', 'models were validated at 0.05 to 0.9'),
    ('--contact-stiffness', '35', '35 N/mm^3 would be 3.5e+10 N/m^3'),
    ('--rotor-speed', '900', '900 rpm would be 94.2478 rad/s')])
def test_options_that_are_doubted(option: str, value: str, words: str, small: str,
                                  capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = squeal(capsys, 'modes', small, '--rotor-speed', '5', option, value,
                            '--json')
    assert code == 0
    assert json.loads(out)['modes']
    assert len(err.splitlines()) == 1
    assert err.startswith(f'squeal: warning: {option}: is {value}')
    assert words in err


@each(('arguments', 'words'), [
    (('map', '--over', 'contact_pressure=1:2:1'), '--over contact_pressure: is 1 Pa'),
    (('critical', '--rotor-speed', '5', '--friction', '0.4', '--band', '1.25', '16'),
     '1.25 to 16 kHz would be 1250 16000')])
def test_axes_and_bands_are_doubted(arguments: tuple[str, ...], words: str, small: str,
                                    capsys: pytest.CaptureFixture[str]) -> None:
    command, *options = arguments
    code, _, err = squeal(capsys, command, small, *options)
    assert code == 0
    assert words in err


def test_ordinary_points_are_not_doubted(small: str, capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (('--preload', '2000'), ('--pressure', '8e5', '--friction', '0'),
                      ('--friction-law', '--contact-stiffness', '7e10')):
        code, _, err = squeal(capsys, 'modes', small, '--rotor-speed', '5', *arguments)
        assert (code, err) == (0, '')


def test_build_says_what_it_doubts_and_refuses_before_any_work(
        tmp_path: Path, capsys: pytest.CaptureFixture[str],
        monkeypatch: pytest.MonkeyPatch) -> None:
    shipped = (ROOT / 'config' / 'brakes' / 'kang2009.yaml').read_text(encoding='utf-8')
    monkeypatch.setattr('squeal_core.assembly.build.build_model',
                        lambda *_, **__: pytest.fail('worked'))
    path = tmp_path / 'mine.yaml'
    path.write_text(shipped.replace('{value: 16.0', '{value: 0.014').replace(
        'damping_ratio: {value: 0.002', 'damping_ratio: {value: 0.2'))
    code, out, err = squeal(capsys, 'build', str(path), '-o', str(tmp_path / 'm.npz'))
    assert (code, out) == (2, '')
    assert err == ('squeal: mine.yaml.disc.rotor_thickness_mm: is 0.014 mm; give 0.5 to 300 mm '
                   '(0.014 m would be 14 mm)\n')
