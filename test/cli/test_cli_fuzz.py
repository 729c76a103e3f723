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

"""
Damaged files of every kind given to commands: 0, 1 or 2, one line for 2, never a traceback.

What is solved or played once the files are read is left out: a damaged file may well be readable.
"""

from collections.abc import Callable, Iterator
from contextlib import redirect_stderr, redirect_stdout
import io
import json
from pathlib import Path
import random
import subprocess
import sys
import time
import traceback
from typing import Any
import warnings

import pytest
from squeal_core.common.errors import SquealError
from squeal_core.common.resources import find
from squeal_core.surrogate.table_builder import build_table
from squeal_core.surrogate.table_domain import TableDomain
from squeal_core.surrogate.table_file import write_table
from squeal_ros.cli.main import main
from support.mutants import damaged, lines_moved, mutant_of_archive, mutant_of_text
from support.reader_samples import write_sample
from support.reading_mutants import small_model
import yaml

pytest.importorskip('rclpy', reason='needs rclpy')
pytest.importorskip('rosbags', reason='needs rosbags')

COUNT = 15  # mutants of each kind; test_mutations.py has hundreds of some
LONGEST = 1000  # characters of a line beyond the paths in it
SHIPPED = yaml.safe_load(find('brakes', 'kang2009', '.yaml').read_bytes())
SETTINGS = {'brakes': ['fl'], 'rate': 10.0, 'fl': {
    'rotor_speed': {'topic': '/speed', 'type': 'std_msgs/msg/Float64', 'field': 'data'},
    'pressure': {'topic': '/pressure', 'type': 'std_msgs/msg/Float64', 'field': 'data'},
    'friction': {'topic': '/fl/friction', 'type': 'std_msgs/msg/Float64', 'field': 'data'}}}
FE = ('frd', 'unv', 'unv_2414', 'nastran_h5', 'table', 'ansys', 'abaqus', 'vtu')


def stopped(*_: Any, **__: Any) -> Any:
    raise SquealError('all files were read')


@pytest.fixture(autouse=True)
def _only_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    import squeal_core.modes.fe.axisymmetric
    import squeal_core.modes.fe.solid
    import squeal_ros.cli.player
    monkeypatch.setattr(squeal_core.modes.fe.axisymmetric, 'disc_modes', stopped)
    monkeypatch.setattr(squeal_core.modes.fe.solid, 'pad_modes', stopped)
    monkeypatch.setattr(squeal_ros.cli.player, 'BrakePlayer', stopped)


def run(arguments: list[str]) -> tuple[int, str, str]:
    """Run a command in this process; return its code, and what went to stdout and stderr."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main(arguments)
        except SystemExit as end:
            code = int(end.code or 0)
    return code, out.getvalue(), err.getvalue()


def wrong(arguments: list[str], folder: Path, codes: list[int]) -> str:
    """Return what is wrong with how a command ended, '' for nothing; add its code to `codes`."""
    start = time.process_time()
    try:
        code, _, said = run(arguments)
    except BaseException:
        return traceback.format_exc()[-1500:]
    seconds = time.process_time() - start
    codes.append(code if 'all files were read' not in said else 0)
    lines = [line for line in said.splitlines() if not line.startswith('squeal: warning: ')]
    if code not in (0, 1, 2):
        return f'ended with {code}'
    if 'Traceback' in said:
        return said[-1500:]
    if code == 2 and (len(lines) != 1 or not lines[0].startswith('squeal: ')):
        return f'2 with the lines {lines}'
    if code == 2 and len(lines[0].replace(str(folder), '')) > LONGEST:
        return f'a line of {len(lines[0])} characters: {lines[0][:200]}'
    # HDF5 is opened by another process; some commands import for a second
    if code == 2 and seconds > 3.0 and '.h5' not in said:
        return f'refused after {seconds:.1f} s of computing'
    return ''


def mutant_of_lines(data: bytes, draw: random.Random) -> bytes:
    return (lines_moved if draw.random() < 0.5 else lambda d, r: damaged(d, r, [b'nan', b';']))(
        data, draw)


def mutant_of_bytes(data: bytes, draw: random.Random) -> bytes:
    return damaged(data, draw, [b'\x00' * 9, b'\xff' * 9])


class Files:
    """Whole files of every kind, and the commands that read them."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        model = small_model()
        self.model = folder / 'whole.npz'
        model.save(self.model)
        self.table = folder / 'table.npz'
        write_table(build_table(model, TableDomain.usual(
            model, rotor_speed=(18.0, 22.0), preload=(1000.0, 2000.0), friction=(0.4, 0.45))),
            model, self.table)
        self.settings = self._yaml('settings.yaml', self._parameters())
        self.bag = folder / 'in.mcap'
        from support.bags import float_messages, write_floats
        write_floats(self.bag, float_messages(2.0))

    def _parameters(self, **changes: Any) -> Any:
        return {'/**': {'ros__parameters': {**SETTINGS, 'model': str(self.model), **changes}}}

    def _yaml(self, name: str, content: Any) -> Path:
        path = self.folder / name
        path.write_text(yaml.safe_dump(content))
        return path

    def replay(self, bag: Path, settings: Path) -> list[str]:
        return ['replay', str(bag), '--config', str(settings), '--force',
                '-o', str(self.folder / 'out.mcap')]

    def cases(self) -> Iterator[tuple[str, Path, Any, Callable[[Path], list[list[str]]]]]:
        """Yield the name of a kind, a whole file, how it is damaged, and commands on a mutant."""
        other = str(self.folder / 'other.npz')
        yield 'model', self.model, mutant_of_archive, lambda path: [
            ['info', str(path)], ['info', str(path), '--json'],
            ['modes', str(path), '--rotor-speed', '20', '--friction', '0.42', '--json']]
        yield ('brake', find('brakes', 'kang2009', '.yaml'), mutant_of_text, lambda path: [
            ['build', str(path), '--force', '-o', other]])
        yield 'settings', self.settings, mutant_of_text, lambda path: [
            self.replay(self.bag, path)]
        yield 'table', self.table, mutant_of_archive, lambda path: [
            self.replay(self.bag, self._yaml('tabulated.yaml', self._parameters(
                table=str(path))))]
        yield 'bag', self.bag, mutant_of_bytes, lambda path: [self.replay(path, self.settings)]
        yield 'vehicle', find('vehicles', 'midsize', '.yaml'), mutant_of_text, lambda path: [
            ['drive', '--vehicle', str(path)]]
        yield 'schedule', find('schedules', 'short', '.yaml'), mutant_of_text, lambda path: [
            ['drive', str(path), '--duration', '1']]
        yield 'cycle', find('drive_cycles', 'us06', '.csv'), mutant_of_lines, lambda path: [
            ['drive', str(path)]]

    def modal_results(self) -> Iterator[tuple[str, Path, Any, Callable[[Path], list[list[str]]]]]:
        for name in FE:
            whole = write_sample(name, self.folder)
            text = whole.suffix not in ('.h5',)
            yield name, whole, mutant_of_lines if text else mutant_of_bytes, self._build

    def _build(self, path: Path) -> list[list[str]]:
        source = {'file': str(path), 'length_unit': 'mm', 'mass_unit': 't', 'modal_mass': 1.0}
        pad = {'modes_from': source, 'thickness_mm': 11.0, 'density_kg_m3': 7820.0}
        brake = self._yaml('brake.yaml', {
            **SHIPPED, 'pads': {'top': pad, 'bottom': SHIPPED['pads']}})
        return [['build', str(brake), '--force', '-o', str(self.folder / 'other.npz')]]


def fuzz(folder: Path, cases: Any, count: int) -> None:
    failed = []
    for name, whole, mutate, commands in cases:
        data, codes = whole.read_bytes(), list[int]()
        for number in range(count):
            path = folder / f'mutant{whole.suffix}'
            with warnings.catch_warnings(action='ignore'):  # numbers that overflow, complex ones
                mutant = mutate(data, random.Random(f'{name} {number}'))
            path.write_bytes(mutant)
            failed += [f'{name} {number}, {arguments[0]}: {text}' for arguments in commands(path)
                       if (text := wrong(arguments, folder, codes))]
        least = 0.02 if name == 'bag' else 0.2  # of a bag what is whole is read
        assert codes.count(2) > least * count, f'{name}: hardly one is refused'
    assert failed == [], '\n'.join(failed)


@pytest.fixture(scope='module')
def files(tmp_path_factory: pytest.TempPathFactory) -> Files:
    return Files(tmp_path_factory.mktemp('whole'))


def test_damaged_files(files: Files) -> None:
    fuzz(files.folder, files.cases(), COUNT)


def test_damaged_modal_results(files: Files) -> None:
    fuzz(files.folder, files.modal_results(), COUNT // 3)


def test_whole_files_are_read(files: Files) -> None:
    """So that the others fail for their damage."""
    for name, whole, _, commands in files.cases():
        for arguments in commands(whole):
            code, _, said = run(arguments)
            assert code in (0, 1) or 'all files were read' in said, (name, code, said)


def test_a_process_of_its_own_ends_alike(files: Files, tmp_path: Path) -> None:
    for name, whole, mutate, commands in files.cases():
        if name not in ('brake', 'bag'):
            continue  # the way out of the process is the same
        data = whole.read_bytes()
        for number in range(100):  # the first that is refused
            path = tmp_path / f'mutant{whole.suffix}'
            path.write_bytes(mutate(data, random.Random(f'{name} {number}')))
            *_, arguments = commands(path)
            code, _, said = run(arguments)
            if code == 2 and 'all files were read' not in said:
                break
        else:
            pytest.fail(f'no mutant of {name} is refused')
        done = subprocess.run([sys.executable, '-m', 'squeal_ros.cli', *arguments], text=True,
                              capture_output=True, check=False, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, '')
        assert done.stderr == said, json.dumps(arguments)
