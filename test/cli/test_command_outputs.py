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

"""What commands write: never over a file unasked, never to a device, and said before the work."""

from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel, complex_modes, OperatingPoint
from squeal_core.model.brake_model import BrakeModel as Model
from squeal_ros.cli.main import main

SMALL = np.arange(9.0).reshape(3, 3)
ODD: list[Any] = [
    {'brake': {'a': [1, {'b': None}]}, 'sources': [1], 'settings': 'x', 'software': 3, 'audit': 7},
    {'brake': 'a\x1b[2J\nb\x07', 'sources': {'k\n': 3}, 'audit': [1, None, {}, {'value': 'x'}]},
    {'brake': 'x' * 100_000, 'settings': {f'k{i}': 'y' * 1000 for i in range(1000)}},
    {'brake': '\ud800', 'audit': [{'name': 'n', 'passed': 1, 'value': 10**400, 'limit': [1]}]},
    {'brake': None, 'audit': [{'name': ['n'], 'passed': True, 'value': float('nan'), 'limit': 1}]},
    {}]


def run(arguments: Sequence[object], capsys: Any) -> tuple[int, str, str]:
    code = main([str(argument) for argument in arguments])
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.fixture
def model(tmp_path: Path) -> Path:
    Model(angular_frequencies=[1e3, 2e4, 3e4], friction_couple=SMALL,
          contact_stiffness=np.eye(3)).save(tmp_path / 'small.npz')
    return tmp_path / 'small.npz'


def commands(model: Path, folder: Path, name: str) -> list[list[object]]:
    """Each command that writes, with all its outputs under a name."""
    ranges = ['--rotor-speed', 5, 6, '--preload', 1900, 2000, '--friction', 0.4, 0.42]
    return [
        ['map', model, '--over', 'friction=0:0.5:3', '--friction', 0.4, '-o',
         folder / f'{name}.csv'],
        ['map', model, '--over', 'friction=0:0.5:3', '--friction', 0.4, '--plot',
         folder / f'{name}.svg'],
        ['locus', model, '--over', 'friction=0:0.5:3', '-o', folder / f'{name}.json',
         '--without-rotation'],
        ['locus', model, '--over', 'friction=0:0.5:3', '--plot', folder / f'{name}.pdf'],
        ['tabulate', model, '-o', folder / f'{name}.npz', *ranges, '--workers', 0,
         '--no-growth']]


def test_an_existing_file_needs_force(model: Path, tmp_path: Path, capsys: Any) -> None:
    for command in commands(model, tmp_path, 'out'):
        code, _, error = run(command, capsys)
        assert code in (0, 1), error
    written = {p: p.read_bytes() for p in tmp_path.glob('out*')}
    assert {p.name for p in written} == {
        'out.csv', 'out.svg', 'out.json', 'out_without_rotation.json', 'out.pdf', 'out.npz'}
    for path in written:
        path.write_text('mine')
    for command in commands(model, tmp_path, 'out'):
        code, _, error = run(command, capsys)
        assert (code, error.count('\n')) == (2, 1)
        assert '--force to replace it' in error
    assert {p.read_text() for p in written} == {'mine'}
    for command in commands(model, tmp_path, 'out'):
        code, _, error = run([*command, '--force'], capsys)
        assert code in (0, 1), error
    assert all(p.stat().st_size > 100 for p in written)
    assert {p.name for p in tmp_path.iterdir()} == {'small.npz', *(p.name for p in written)}


def test_the_second_file_of_a_locus_needs_force_too(model: Path, tmp_path: Path,
                                                    capsys: Any) -> None:
    (tmp_path / 'out_without_rotation.json').write_text('mine')
    code, _, error = run(commands(model, tmp_path, 'out')[2], capsys)
    assert code == 2
    assert 'out_without_rotation.json: exists' in error


@pytest.mark.parametrize(('place', 'words'), [
    ('/dev/full', 'is a device'), ('{folder}', 'is a folder'),
    ('{folder}/none/out.npz', 'a folder that does not exist'), ('{folder}/pipe', 'is a pipe'),
    ('{folder}/small.npz/out.npz', 'Not a directory')])
def test_bad_places_are_said_before_the_work(place: str, words: str, model: Path, tmp_path: Path,
                                             capsys: Any, monkeypatch: Any) -> None:
    import squeal_core.assembly.build
    monkeypatch.setattr(squeal_core.assembly.build, 'build_model', None)  # the work would fail
    os.mkfifo(tmp_path / 'pipe')
    path = place.format(folder=tmp_path)
    code, _, error = run(['build', 'kang2009', '-o', path, '--force'], capsys)
    assert (code, error.count('\n')) == (2, 1)
    assert words in error
    assert path in error


def test_an_input_is_never_replaced(model: Path, tmp_path: Path, capsys: Any) -> None:
    before = model.read_bytes()
    (tmp_path / 'link.npz').symlink_to(model)
    for path in (model, tmp_path / 'link.npz'):
        code, _, error = run(['map', model, '-o', path, '--force'], capsys)
        assert code == 2
        assert 'is what this command reads' in error
    assert model.read_bytes() == before


def test_figures_need_force(tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    from squeal_core import verification
    monkeypatch.setattr(verification, 'verify', None)  # the work would fail
    (tmp_path / 'figure_10.png').write_text('mine')
    code, _, error = run(['verify', '--figures', tmp_path], capsys)
    assert code == 2
    assert 'figure_10.png: exists; give --force' in error
    code, _, error = run(['verify', '--figures', tmp_path / 'figure_10.png'], capsys)
    assert code == 2
    assert 'is no folder' in error
    assert [p.name for p in tmp_path.iterdir()] == ['figure_10.png']


def test_a_sweep_too_large_to_store_is_refused_before_it_runs(tmp_path: Path,
                                                              capsys: Any) -> None:
    Model(angular_frequencies=np.linspace(1e3, 1e5, 400)).save(tmp_path / 'many.npz')
    code, _, error = run(['map', tmp_path / 'many.npz', '--over', 'friction=0:0.5:20000', '-o',
                          tmp_path / 'out.npz'], capsys)
    assert code == 2
    assert '20000 points of 400 modes are more than a record holds' in error


@pytest.mark.parametrize('provenance', ODD)
def test_info_of_any_provenance(provenance: Any, tmp_path: Path, capsys: Any) -> None:
    path = tmp_path / 'odd.npz'
    Model(angular_frequencies=[1e3, 2e4, 3e4], friction_couple=SMALL,
          names=('a\x1bb', 'ü' * 5000, '\ud800'), provenance=provenance).save(path)
    code, out, error = run(['info', path], capsys)
    assert (code, error) == (0, '')
    assert all(line.isprintable() and len(line) < 300 for line in out.splitlines())
    assert len(out.splitlines()) < 200
    code, out, error = run(['info', path, '--json'], capsys)
    assert (code, error) == (0, '')
    json.loads(out, parse_constant=pytest.fail)


def test_models_that_are_no_files_are_refused_at_once(tmp_path: Path, capsys: Any) -> None:
    os.mkfifo(tmp_path / 'pipe')
    (tmp_path / 'zero').symlink_to('/dev/zero')
    with (tmp_path / 'sparse').open('wb') as file:
        file.truncate(2**36)
    for name in ('pipe', 'zero', 'sparse'):
        for command in (['info'], ['build', '-o', tmp_path / 'out.npz'], ['drive'],
                        ['policy', '--config']):
            code, _, error = run([*command, tmp_path / name], capsys)
            assert (code, error.count('\n')) == (2, 1), command
            assert 'no regular file' in error or 'bytes, more than the' in error


def test_the_library_replaces_and_may_be_told_not_to(model: Path) -> None:
    small = BrakeModel.load(model)
    small.save(model)
    with pytest.raises(ValueError, match='exists'):
        small.save(model, overwrite=False)


@pytest.mark.skipif(not find_spec('rclpy') or not find_spec('rosbags'), reason='needs both')
def test_a_recording_and_a_demo_need_force(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / 'live.csv').write_text('mine')
    code, _, error = run(['demo', '--output', tmp_path], capsys)
    assert (code, error.count('\n')) == (2, 1)
    assert 'live.csv: exists; give --force' in error
    code, _, error = run(['demo', '--output', tmp_path / 'live.csv'], capsys)
    assert (code, error.count('\n')) == (2, 1)
    for name, words in (('live.csv', 'exists'), ('none/a.mcap', 'does not exist'),
                        ('../../../../../../dev/full', 'is a device')):
        code, _, error = run(['drive', '--record', tmp_path / name], capsys)
        assert (code, error.count('\n')) == (2, 1)
        assert words in error
    assert (tmp_path / 'live.csv').read_text() == 'mine'
    assert [path.name for path in tmp_path.iterdir()] == ['live.csv']


def test_a_damping_scale_and_what_contact_damping_adds(capsys: Any) -> None:
    point = ['--rotor-speed', 20, '--friction', 0.42, '--damping-scale', 0.1]
    code, out, _ = run(['modes', 'kang2009_damped', *point, '--json'], capsys)
    found = json.loads(out)
    assert (code, found['point']['damping_scale']) == (0, 0.1)
    model = BrakeModel.load('kang2009_damped')
    at = OperatingPoint(**{**found['point'], 'damping_scale': 1.0})
    weaker = replace(model, damping_ratios=0.1 * model.damping_ratios,
                     contact_retardation_time=0.1 * model.contact_retardation_time)
    grown = [mode for mode in found['modes'] if mode['kind'] == 'flutter']
    expected = [mode.growth_rate for mode in complex_modes(weaker, at).modes
                if mode.kind == 'flutter']
    assert [mode['growth_rate'] for mode in grown] == pytest.approx(expected, abs=1e-6)
    for mode in grown:
        assert sum(mode['contributions'].values()) == pytest.approx(mode['growth_rate'], abs=1e-4)
        assert mode['contributions']['contact_damping'] != 0.0
        assert mode['sensitivity']['damping_scale'] is not None
    assert 'loss factor 0.05 at 1 kHz' in run(['info', 'kang2009_damped'], capsys)[1]
    assert 'contact damping' not in run(['info', 'kang2009'], capsys)[1]
    code, _, error = run(['modes', 'kang2009', *point[:-1], -1], capsys)
    assert code == 2
    assert '--damping-scale: is -1; give 0 to 1000' in error
