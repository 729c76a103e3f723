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

"""Options of commands: explained, refused before any work, and an audit at the end of a build."""

from functools import partial
from pathlib import Path

import pytest
from squeal_core.assembly import build as building
from squeal_ros.cli import sweep_commands
from squeal_ros.cli.main import main
from support.commands import answer, FEW, squeal

COMMANDS = ('build', 'info', 'modes', 'map', 'locus', 'critical', 'verify', 'settings', 'replay',
            'drive', 'demo', 'tabulate', 'listen')


@pytest.mark.parametrize('command', COMMANDS)
def test_every_command_explains_itself(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main([command, '--help'])
    assert ended.value.code == 0
    assert f'usage: squeal {command}' in capsys.readouterr().out


@pytest.mark.parametrize(('arguments', 'words'), [
    (['map', *FEW, '-o', 'x.txt'], '--output: x.txt is of no kind that is known'),
    (['map', *FEW, '-o', 'no/x.npz'], '--output: no/x.npz: is in a folder that does not exist'),
    (['map', *FEW, '--plot', 'x.foo'], '--plot: x.foo is of no kind'),
    (['locus', *FEW, '--plot', 'no/x.png'], '--plot: no/x.png: is in a folder'),
    (['map', *FEW, *FEW], '--over: friction, friction; give each one once'),
    (['map', '--over', 'friction=0:nan:3'], 'friction=0:nan:3'),
    (['map', '--over', 'friction=0:1:200000'], 'at most 100000 points'),
    (['map', '--over', 'mu=0:1:2'], 'contact_stiffness'),
    (['map', '--over', 'rotor_speed=1:5:2', '--friction-slope', '-0.1'], 'give --friction too'),
    (['map', *FEW, '--workers', '-1'], '--workers: is -1'),
    (['locus', *FEW, '--over', 'rotor_speed=1:5:2'], '--modes: give the modes to follow'),
    (['locus', *FEW, '--modes', '25,93'], '1 to 92'),
    (['critical', '--rotor-speed', '5', '--modes', '0'], '1 to 92'),
    (['critical', '--rotor-speed', '5', '--parameter', 'mu'], "'mu'")])
def test_what_would_fail_later_is_refused_before_any_work(
        arguments: list[str], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    for work in ('sweep', 'critical_value'):
        monkeypatch.setattr(sweep_commands, work, lambda *_, **__: pytest.fail('work was begun'))
    command, *rest = arguments
    code, out, err = squeal(capsys, command, 'kang2009', *rest)
    assert (code, out) == (2, '')
    assert len(err.splitlines()) == 1
    assert words in err
    assert not list(tmp_path.iterdir())


def test_numbers_that_are_none(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(['locus', 'kang2009', '--modes', '25,x'])
    assert ended.value.code == 2
    assert "'25,x' are no numbers of modes; write 13,14" in capsys.readouterr().err


def test_figures_go_to_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / 'file').write_text('')
    code, _, err = squeal(capsys, 'verify', '--figures', str(tmp_path / 'file'))
    assert code == 2
    assert 'is no folder' in err


def test_a_build_ends_with_its_audit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                     capsys: pytest.CaptureFixture[str]) -> None:
    """Coarse on purpose: the same checks in the answer, in the file and in `info`."""
    monkeypatch.setattr(building, 'build_model', partial(
        building.build_model, disc_order=2, pad_elements=(3, 6, 1), contact_points=2))
    path = str(tmp_path / 'coarse.npz')
    checks = answer(capsys, 'build', 'kang2009', '-o', path)['audit']
    kept = answer(capsys, 'info', path)['provenance']['audit']
    assert checks == kept
    names = [check['name'] for check in checks]
    assert {'doublets without partner', 'contact quadrature', 'basis truncation to 60%',
            'basis truncation to 80%', 'backward error'} <= set(names)
    assert {f'{kind} of radial_dissipation' for kind in ('symmetry', 'definiteness')} <= set(names)
    _, out, _ = squeal(capsys, 'info', path)
    for check in checks:
        assert check['passed'] == (check['value'] <= check['limit'])
        (line,) = [line for line in out.splitlines() if f' {check["name"]} ' in line]
        assert (line.split()[1] == 'ok') == check['passed']
    code, _, err = squeal(capsys, 'build', 'kang2009', '-o', str(tmp_path / 'no' / 'a.npz'))
    assert code == 2
    assert 'is in a folder that does not exist' in err
