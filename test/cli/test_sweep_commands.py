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

"""`squeal map` and `squeal locus`: friction at each point, what is counted, what is kept."""

import csv
from dataclasses import replace
import math
from pathlib import Path

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.dimensions import StiffnessTable
from squeal_core.common.errors import SquealError
from squeal_core.studies.point_options import point_with
from squeal_core.studies.sweep_file import load_sweep
from squeal_ros.cli.arguments import point_options
from squeal_ros.cli.main import main, parser
from squeal_ros.cli.swept_axes import settle_point, StudySource
from support.commands import answer, FEW, squeal
from support.sweeps import PAIR

AXES = {'contact.stiffness_n_m3': '2e10:4e10:2', 'contact_stiffness': '2e10:4e10:2',
        'caliper.piston_diameter_mm': '50:60:2', 'caliper.efficiency': '0.8:0.9:2',
        'preload': '1000:2000:2', 'pressure': '4e5:8e5:2', 'contact_pressure': '4e5:8e5:2',
        'friction.static': '0.4:0.6:2', 'friction.decay_s_m': '0.5:1:2', 'friction': '0.3:0.5:2',
        'friction_slope': '-0.02:-0.01:2', 'rotor_speed': '2:10:2'}
RADIUS = 2.0 / 3.0 * (0.142**3 - 0.1**3) / (0.142**2 - 0.1**2)  # m, of K09's patch
LAW = [(0.32 + fall, -fall) for fall in (0.18 * math.exp(-RADIUS * speed)
                                         for speed in (2.0, 10.0))]


@pytest.mark.parametrize(('arguments', 'expected'), [
    ([], LAW), (['--friction-law'], LAW), (['--friction', '0.5'], [(0.5, 0.0)] * 2),
    (['--friction', '0.5', '--friction-slope', '-0.1'], [(0.5, -0.1)] * 2),
    # the law's slope, scaled to --friction, at each speed
    (['--friction', '0.5', '--friction-law'], [(0.5, 0.5 * s / f) for f, s in LAW])])
def test_friction_over_speed(arguments: list[str], expected: list[tuple[float, float]],
                             tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.csv'
    assert main(['map', 'kang2009', '--over', 'rotor_speed=2:10:2', '-o', str(path),
                 *arguments]) == 0
    with path.open(newline='') as file:
        rows = [row for row in csv.DictReader(list(file)[1:]) if row['index'] == '1']
    assert [float(row['rotor_speed']) for row in rows] == [2.0, 10.0]
    for row, (friction, slope) in zip(rows, expected, strict=True):
        assert float(row['friction']) == pytest.approx(friction, rel=1e-12)
        assert float(row['friction_slope']) == pytest.approx(slope, rel=1e-12)


def test_swept_friction_is_constant_over_speed(tmp_path: Path,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'map.npz'
    assert main(['map', 'kang2009', *FEW, '-o', str(path)]) == 0
    assert load_sweep(path).column('friction_slope').tolist() == [0.0] * 3
    assert main(['map', 'kang2009', '--over', 'friction=0.3:0.6:2', '--over',
                 'rotor_speed=2:10:2', '--friction-law', '-o', str(path), '--force']) == 0
    record = load_sweep(path)
    assert record.column('friction').tolist() == [0.3, 0.3, 0.6, 0.6]
    assert record.column('friction_slope') == pytest.approx(
        [mu * s / f for mu in (0.3, 0.6) for f, s in LAW], rel=1e-12)
    assert record.about['friction_law'] == 'slope'


def test_flutter_and_divergence_are_counted_apart(tmp_path: Path,
                                                  capsys: pytest.CaptureFixture[str]) -> None:
    """One mode that slides freely and one that vibrates, each with a slope of its own."""
    for diagonal, expected in (([1e-3, 0.0], (0, 2)), ([0.0, 1e-2], (2, 0))):
        BrakeModel(angular_frequencies=[0.0, 1e4], negative_slope=np.diag(diagonal)).save(
            tmp_path / 'two.npz')
        found = answer(capsys, 'map', str(tmp_path / 'two.npz'), '--over',
                       'friction_slope=-0.1:0:3', '--friction', '0.3')
        assert (found['points_with_flutter'], found['points_with_divergence']) == expected
        assert found['points_with_squeal'] == expected[0]  # at 1.6 kHz
    # a study of two parameters says it in the same words
    study = ('--over', 'damping_scale=1:2:1', '--exact')
    for over, done in ((), '3 of 3 points; '), (study, ' s; '):
        out = squeal(capsys, 'map', str(tmp_path / 'two.npz'), '--friction', '0.3', '--plot',
                     str(tmp_path / 'a.svg'), '--force', '--over', 'friction_slope=-0.1:0:3',
                     *over)[1]
        assert f'{done}squeal at 2, flutter at 2, divergence at 0; ' in out


def test_a_locus_with_and_without_rotation(tmp_path: Path,
                                           capsys: pytest.CaptureFixture[str]) -> None:
    files = [tmp_path / name for name in ('a.json', 'a_without_rotation.json', 'a.svg')]
    assert main(['locus', 'kang2009', '--over', 'friction=0.3:0.5:5', '--modes', '13,14',
                 '--without-rotation', '-o', str(files[0]), '--plot', str(files[2])]) == 0
    one, other = map(load_sweep, files[:2])
    assert (one.about['rotation'], other.about['rotation']) == (True, False)
    assert not one.merged(13).any()
    # it merges at 0.348, wherever the path begins
    assert other.merged(14).tolist() == [False, True, True, True, True]
    assert other.names(13).tolist()[::4] == ['13', '13/14']


@pytest.mark.parametrize(('arguments', 'words'), [
    (['map', '--over', 'friction=0.6:0.2:3'], 'runs down; give the lower end first'),
    (['map', '--over', 'friction=0.2:0.2:3'], 'has no width'),
    (['map', '--over', 'friction=0.1:0.6:100000', '--over', 'rotor_speed=1:2:100000', '-o',
      'a.csv'], '1e+10 points are too many; give 1e+08 at most'),
    (['map', '--over', 'disc.rotor_thicknes_mm=14:18:3'], 'did you mean disc.rotor_thickness_mm'),
    (['map', '--over', 'disc.rotor_thickness_mm=0.014:0.018:3'], '0.014 m would be 14 mm'),
    (['map', '--over', 'preload=1000:2000:3', '--over', 'pressure=1e5:2e5:3'], 'one load'),
    (['locus', '--over', 'disc.hat_height_mm=25:30:3'], '--modes: give the modes'),
    (['critical', '--parameter', 'disc.hat_height_mm'], '--bounds: give the lowest'),
    (['critical', '--parameter', 'disc.rotor_thickness_mm', '--bounds', '0.014', '0.018'],
     'on either side of 16 mm (0.014 m would be 14 mm)'),
    (['critical', '--parameter', 'disc.rotor_thickness_mm', '--bounds', '15', '17', '--modes',
      '13,14'], 'leave it out, narrow --band, or search along rotor_speed'),
    (['critical', '--over', 'friction=0.1:0.2:2'], 'is what is searched along'),
    (['critical', '-o', 'a.csv'], 'sweep with --over')])
def test_what_is_no_study(arguments: list[str], words: str, tmp_path: Path,
                          monkeypatch: pytest.MonkeyPatch,
                          capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    command, *rest = arguments
    code, out, err = squeal(capsys, command, 'kang2009', *rest)
    assert (code, out) == (2, '')
    assert len(err.splitlines()) == 1
    assert words in err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(('axes', 'options', 'why'), [
    ('contact.stiffness_n_m3', '--contact-stiffness 3e10', 'as --contact-stiffness sets'),
    ('contact.stiffness_n_m3 contact_stiffness', '', 'as --over contact_stiffness sets'),
    ('caliper.piston_diameter_mm', '', 'give --pressure PA'),
    ('caliper.efficiency preload', '--friction 0.4', 'give --over pressure in its place'),
    ('friction.static', '--friction 0.4', 'or add --friction-law'),
    ('friction.decay_s_m friction', '', 'as --over friction takes the place'),
    ('friction.static friction_slope', '--friction 0.4 --friction-law', '--friction-law: has no'),
    ('preload', '--pressure 8e5', '--pressure: has no effect beside --over preload'),
    ('contact_pressure', '--preload 2000', '--preload: has no effect'),
    *((axes, f'{options} --without-rotation', 'as --without-rotation leaves out')
      for axes, options in (
          ('friction_slope', '--friction 0.4'), ('preload', ''),
          ('friction preload', ''), ('caliper.efficiency', '--pressure 8e5'),
          ('rotor_speed', '--friction 0.4'), ('rotor_speed', '--friction 0.4 --friction-law'),
          ('friction.static', '--friction 0.4 --friction-law'),
          ('friction friction.static', '--friction-law'))),
])
def test_what_no_point_depends_on(axes: str, options: str, why: str,
                                  capsys: pytest.CaptureFixture[str]) -> None:
    over = [word for name in axes.split() for word in ('--over', f'{name}={AXES[name]}')]
    for command in (['map'], ['locus', '--modes', '13']):
        code, out, err = squeal(capsys, *command, 'kang2009', *over, *options.split())
        assert (code, out) == (2, '')
        assert len(err.splitlines()) == 1
        assert 'has no effect' in err
        assert why in err


@pytest.mark.parametrize(('parameter', 'options'), [
    ('friction_slope', []), ('contact_pressure', []), ('rotor_speed', ['--friction', '0.4']),
    ('friction_slope', ['--over', 'friction=0.2:0.4:2'])])
def test_what_no_critical_value_depends_on(parameter: str, options: list[str],
                                           capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = squeal(capsys, 'critical', 'kang2009', '--parameter', parameter,
                          '--without-rotation', *options)
    assert (code, len(err.splitlines())) == (2, 1)
    assert f'--parameter {parameter}: has no effect, as --without-rotation' in err


def test_what_points_without_rotation_depend_on() -> None:
    """The law's friction over speed; of a follower force or a stiffness table the load, too."""
    chosen = parser().parse_args(['map', 'kang2009', '--without-rotation'])
    source = StudySource('kang2009')
    assert settle_point(chosen, {'rotor_speed': np.array([1.0, 2.0])}, source) is True
    for more in ({'follower': np.eye(source.model.size)},
                 {'stiffness_table': StiffnessTable((1e5, 1e6), (1e10, 2e10))}):
        counts = StudySource('kang2009')
        counts.__dict__['model'] = replace(source.model, **more)
        settle_point(chosen, {'preload': np.array([1e3, 2e3])}, counts)
    with pytest.raises(SquealError, match='--over preload: has no effect'):
        settle_point(chosen, {'preload': np.array([1e3, 2e3])}, source)


@pytest.mark.parametrize(('axes', 'options'), [
    ('contact.stiffness_n_m3', []), ('caliper.efficiency', ['--pressure', '8e5']),
    ('caliper.efficiency pressure', []), ('friction.static', []),
    ('friction.static', ['--friction', '0.4', '--friction-law']),
    ('friction.static friction_slope', []), ('preload', ['--preload', '2000'])])
def test_what_points_depend_on(axes: str, options: list[str]) -> None:
    """Points, or stiffness, differ along each axis; nothing is refused."""
    chosen = parser().parse_args(['map', 'kang2009', *options])
    source = StudySource('kang2009')
    ends = {name: [float(end) for end in AXES[name].split(':')[:2]] for name in axes.split()}
    law = settle_point(chosen, {name: np.array(ends[name]) for name in ends}, source)
    brake = source.require_design('').brake
    for name in ends:
        points = []
        for end in ends[name]:
            values = {**{other: ends[other][0] for other in ends}, name: end}
            read = brake({path: values[path] for path in values if '.' in path})
            model = replace(source.model, caliper=read.caliper, friction_law=read.friction_law,
                            nominal_contact_stiffness=read.contact.stiffness)
            points.append(point_with(model, point_options(chosen).at(model), {
                path: values[path] for path in values if '.' not in path}, law))
        assert points[0] != points[1]


def test_studies_print_draw_and_write(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Impossible points are told while the others are computed; pictures of one to three axes."""
    PAIR.save(tmp_path / 'pair.npz')
    model = str(tmp_path / 'pair.npz')
    over = ['--over', 'friction=0.1:0.6:3', '--over', 'rotor_speed=-2:2:3', '--over',
            'damping_scale=0.5:2:3']
    found = answer(capsys, 'map', model, *over)
    assert (found['points'], found['impossible_points']) == (27, 9)
    assert found['impossible'][0]['reason'].startswith('rotor_speed is 0 rad/s')
    assert [row['source'] for row in found['results'][:9]] == ['full'] * 3 + [
        'impossible'] * 3 + ['full'] * 3
    bounds = ['--rotor-speed', '5', '--friction', '0.1']
    for i, arguments in enumerate([
            ['map', model, *over], ['map', model, '--over', 'damping_scale=1:2:3', *bounds],
            ['map', model, *over[2:], '--friction', '0.5'],
            ['locus', model, *over[:2], *over[4:], '--modes', '1,2'],
            ['critical', model, *over[4:], *bounds],
            ['critical', model, '--over', 'contact_stiffness=1e10:2e10:3', *over[4:], *bounds]]):
        picture, file = tmp_path / f'{i}.png', tmp_path / f'{i}.csv'
        assert main([*arguments, '--plot', str(picture), '-o', str(file)]) == 0
        assert picture.read_bytes().startswith(b'\x89PNG')
        assert file.read_text().startswith('# {"format": "squeal_ros study"')
