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

"""`squeal tabulate`: builds that were ended go on; what is refused before the work."""

import json
from pathlib import Path
import re
import signal
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from squeal_core import BrakeModel
from squeal_core.brake.friction import FrictionLaw
from squeal_ros.cli.main import main
from support.archives import parts, rewrite
from support.engine_models import random_model

RANGES = ['--rotor-speed', '8', '20', '--preload', '1000', '1500', '--friction', '0.3', '0.45',
          '--tolerance', '0.1']
# the real command, ended by a real signal as soon as the first row is kept
ENDED = """
import os, sys
from squeal_core.surrogate.build_checkpoint import BuildCheckpoint
from squeal_ros.cli.main import main
keep = BuildCheckpoint.keep
def keep_and_end(checkpoint, row, leaves):
    keep(checkpoint, row, leaves)
    os.kill(os.getpid(), int(sys.argv[1]))
BuildCheckpoint.keep = keep_and_end
if __name__ == '__main__':
    sys.exit(main(sys.argv[2:]))
"""


@pytest.fixture(scope='module')
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('model') / 'model.npz'
    random_model(10, 1, friction_law=FrictionLaw()).save(path)
    return path


@pytest.fixture(scope='module')
def whole(model: Path) -> Path:
    """Build the table without a disturbance."""
    path = model.with_name('whole.npz')
    assert main(command(model, path)) == 0
    return path


def command(model: Path, path: Path, *more: str) -> list[str]:
    return ['tabulate', str(model), '-o', str(path), '--workers', '0', '--no-growth', *RANGES,
            *more]


def ended(number: int, arguments: list[str]) -> Any:
    return subprocess.run([sys.executable, '-c', ENDED, str(number), *arguments],
                          capture_output=True, text=True, check=False)


def same(ours: Path, theirs: Path) -> bool:
    """Whether all arrays of two tables are the same bit for bit."""
    first, second = (parts(path)[1] for path in (ours, theirs))
    return first.keys() == second.keys() and all(
        first[name].tobytes() == second[name].tobytes() for name in first)


def folders(path: Path) -> list[Path]:
    return [item for item in path.parent.iterdir() if item.is_dir()]


@pytest.mark.parametrize(('number', 'code'), [(signal.SIGKILL, -9), (signal.SIGINT, 130)])
def test_a_build_that_was_ended_goes_on_with_the_same_table(
        number: int, code: int, model: Path, whole: Path, tmp_path: Path,
        capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    first = ended(number, command(model, path, '--workers', '2'))
    assert first.returncode == code
    assert 'Traceback' not in first.stderr
    assert ('squeal: 1 rows of boxes are kept' in first.stderr) == (number == signal.SIGINT)
    assert not path.exists()
    [folder] = folders(path)
    assert [file.suffix for file in folder.iterdir()] == ['.npz']
    assert main(command(model, path)) == 0
    assert '1 of 2 rows of boxes were kept from an earlier build' in capsys.readouterr().err
    assert same(path, whole)
    assert not folders(path)


def test_damaged_and_foreign_rows_are_built_again(
        model: Path, whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    ended(signal.SIGKILL, command(model, path))
    [folder] = folders(path)
    [row] = folder.iterdir()
    rewrite(row, {'row': 7})
    (folder / '1.npz').write_bytes(row.read_bytes()[:-10])
    assert main(command(model, path)) == 0
    said = capsys.readouterr().err
    assert 'is a row of another table; it is built again' in said
    assert '1.npz: is damaged' in said
    assert 'were kept' not in said
    assert same(path, whole)


def test_rows_of_other_settings_are_not_taken_and_removed(
        model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    ended(signal.SIGKILL, command(model, path))
    assert len(folders(path)) == 1
    assert main(command(model, path, '--tolerance', '0.2')) == 0
    assert 'were kept' not in capsys.readouterr().err
    assert not folders(path)


def test_what_is_not_replaced_unasked_is_named(
        model: Path, whole: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / 'table.npz'
    path.write_bytes(whole.read_bytes())

    def refusal() -> str:
        assert main(command(model, path)) == 2
        return capsys.readouterr().err

    assert 'exists; give --force' in refusal()
    for header in ({'schema': 3}, {'format': 'squeal_ros table of anchors', 'schema': 1}):
        rewrite(path, header)
        earlier = r'was written by an earlier version \(format \d; this one reads 5\); '
        assert re.search(f'{earlier}give another name, or --force', refusal())
        assert main(['info', str(path)]) == 2
        assert re.search(f'{earlier}build it again with: squeal tabulate MODEL',
                         capsys.readouterr().err)
    np.savez(path, gains=np.ones(3))
    assert "is no table file; it holds 'gains'" in refusal()
    BrakeModel.load('kang2009').save(path)
    assert "its header says 'squeal_ros brake model'" in refusal()


def test_the_growth_emulator_is_built_alone_shown_and_not_replaced_unasked(
        tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    model = tmp_path / 'model' / 'small.npz'
    model.parent.mkdir()
    random_model(3, 3, friction_law=FrictionLaw()).save(model)
    alone = ['tabulate', str(model), '-o', str(tmp_path / 'brake.npz'), '--growth-only',
             '--workers', '0']
    assert main([*alone, '--json']) == 0
    summary = json.loads(capsys.readouterr().out)
    path = tmp_path / 'brake.growth.npz'
    assert summary['output'] == str(path)
    assert not (tmp_path / 'brake.npz').exists()
    assert main(['info', str(path)]) == 0
    shown = capsys.readouterr().out
    assert f'{summary["error"]["rms"]:.3g} 1/s rms' in shown
    assert 'rotor speed      0.5 to 120 rad/s' in shown
    assert 'pressure x friction / rotor speed up to' in shown
    assert re.search(r'piece 1 of [1-9]\d* +contact stiffness', shown)
    assert main(alone) == 2
    assert 'brake.growth.npz: exists; give --force' in capsys.readouterr().err
    assert main([*alone, '--force', '--friction', '0.3', '0.4']) == 2
    assert '--friction: is of the table' in capsys.readouterr().err
