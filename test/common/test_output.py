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

"""Outputs: whole or not at all, regular files only, never over one unasked."""

from collections.abc import Callable, Iterator
import os
from pathlib import Path
import socket
import subprocess

import pytest
from squeal_core.common.output import check_target, output_file, OutputError, OutputFiles, PARTIAL
from support.processes import process

ENDED = 2**22 + 1  # no process has this number: Linux gives at most 2**22


def listing(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def write(*outputs: tuple[Path, str], overwrite: bool = False,
          then: Callable[[], object] = lambda: None) -> None:
    """Write texts as one set of outputs; `then` happens before they are committed."""
    with OutputFiles(overwrite=overwrite) as files:
        for path, text in outputs:
            files.add(path).partial.write_text(text)
        then()


def fails(error: BaseException) -> Callable[..., None]:
    def fail(*_: object, **__: object) -> None:
        raise error
    return fail


def refused(path: str | Path, words: str, *, overwrite: bool = True, folder: bool = False) -> None:
    with pytest.raises(OutputError, match=words) as caught:
        check_target(path, overwrite=overwrite, folder=folder)
    assert str(path) in str(caught.value)
    assert '\n' not in str(caught.value)


def test_a_file_appears_whole(tmp_path: Path) -> None:
    target = tmp_path / 'model.npz'
    with output_file(target) as partial:
        assert partial.parent == tmp_path
        assert str(os.getpid()) in partial.name
        partial.write_bytes(b'first')
        assert not target.exists()
    assert target.read_bytes() == b'first'
    assert listing(tmp_path) == {'model.npz'}


def test_an_existing_file_stays_unless_it_may_be_replaced(tmp_path: Path) -> None:
    target = tmp_path / 'model.npz'
    target.write_text('old')
    target.chmod(0o640)
    refused(target, 'exists; give --force', overwrite=False)
    with pytest.raises(OutputError, match='--force'):
        write((target, 'new'))
    assert target.read_text() == 'old'
    write((target, 'new'), overwrite=True)
    assert target.read_text() == 'new'
    assert target.stat().st_mode & 0o777 == 0o640
    assert listing(tmp_path) == {'model.npz'}


def test_a_file_that_came_meanwhile_stays(tmp_path: Path) -> None:
    target = tmp_path / 'model.npz'
    with pytest.raises(OutputError, match='exists by now'):
        write((target, 'mine'), then=lambda: target.write_text('of somebody else'))
    assert target.read_text() == 'of somebody else'
    assert listing(tmp_path) == {'model.npz'}


@pytest.mark.parametrize('error', [KeyboardInterrupt(), ValueError('of the work')])
def test_an_error_leaves_everything_as_it_was(tmp_path: Path, error: BaseException) -> None:
    target = tmp_path / 'model.npz'
    target.write_text('old')
    with pytest.raises(type(error)):
        write((target, 'half'), overwrite=True, then=fails(error))
    assert (listing(tmp_path), target.read_text()) == ({'model.npz'}, 'old')


def test_cleanup_does_not_hide_the_first_error(tmp_path: Path,
                                               monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, 'unlink', fails(OSError(5, 'Input/output error')))
    with pytest.raises(ZeroDivisionError):
        write((tmp_path / 'model.npz', 'half'), then=fails(ZeroDivisionError()))


def test_two_outputs_are_committed_together(tmp_path: Path) -> None:
    bag, table = tmp_path / 'out.mcap', tmp_path / 'out.csv'
    with pytest.raises(OutputError, match='exists by now'):
        write((bag, 'new bag'), (table, 'new table'), then=lambda: table.write_text('not mine'))
    assert (listing(tmp_path), table.read_text()) == ({'out.csv'}, 'not mine')
    write((bag, 'new bag'), (table, 'new table'), overwrite=True)
    assert (bag.read_text(), table.read_text()) == ('new bag', 'new table')
    assert listing(tmp_path) == {'out.mcap', 'out.csv'}


def test_what_was_replaced_comes_back_when_a_later_rename_fails(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bag, table = tmp_path / 'out.mcap', tmp_path / 'out.csv'
    write((bag, 'old bag'), (table, 'old table'))
    rename = Path.replace

    def fails_at_the_table(path: Path, target: Path) -> Path:
        if target == table:
            raise OSError(5, 'Input/output error')
        return rename(path, target)

    monkeypatch.setattr(Path, 'replace', fails_at_the_table)
    with pytest.raises(OutputError, match='Input/output'):
        write((bag, 'new bag'), (table, 'new table'), overwrite=True)
    assert (bag.read_text(), table.read_text()) == ('old bag', 'old table')
    assert listing(tmp_path) == {'out.mcap', 'out.csv'}


def test_one_name_for_two_outputs_is_refused(tmp_path: Path) -> None:
    (tmp_path / 'link').symlink_to(tmp_path)
    with pytest.raises(OutputError, match='two outputs'):
        write((tmp_path / 'a.svg', ''), (tmp_path / 'link' / 'a.svg', ''))
    assert listing(tmp_path) == {'link'}


@pytest.mark.parametrize(('path', 'words'), [
    ('/dev/full', 'device'), ('/dev/null', 'device'), ('/dev/zero', 'device'),
    ('/proc/squeal.npz', 'No such file|read-only|denied'),
    ('/etc/passwd/a.npz', 'Not a directory'),
    ('/nowhere/at/all.npz', 'folder that does not exist'), ('a\0b', 'null'),
    ('/tmp/' + 300 * 'a', 'too long'), ('.', 'a folder')])
def test_what_cannot_be_written_is_said_before_the_work(path: str, words: str) -> None:
    refused(path, words)


def test_other_kinds_of_files_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / 'pipe')
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / 'socket'))
        refused(tmp_path / 'pipe', 'is a pipe')
        refused(tmp_path / 'socket', 'is a socket')
    refused(tmp_path, 'is a folder')
    (tmp_path / 'to_device').symlink_to('/dev/null')
    refused(tmp_path / 'to_device', 'is a device')
    (tmp_path / 'loop').symlink_to(tmp_path / 'loop')
    refused(tmp_path / 'loop', 'leads nowhere')
    (tmp_path / 'dangling').symlink_to(tmp_path / 'nothing')
    refused(tmp_path / 'dangling', 'leads nowhere')


def test_a_link_to_a_file_stays_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / 'models').mkdir()
    real, link = tmp_path / 'models' / 'real.npz', tmp_path / 'link.npz'
    real.write_bytes(b'old')
    link.symlink_to(real)
    refused(link, 'exists', overwrite=False)
    with output_file(link, overwrite=True) as partial:
        assert partial.parent == real.parent
        partial.write_bytes(b'new')
    assert link.is_symlink()
    assert real.read_bytes() == b'new'


def test_a_folder_is_replaced_only_if_it_is_a_bag(tmp_path: Path) -> None:
    bag, home = tmp_path / 'bag', tmp_path / 'home'
    for folder, names in ((bag, ('metadata.yaml', 'a.mcap')), (home, ('metadata.yaml', 'letter'))):
        folder.mkdir()
        for name in names:
            (folder / name).write_text('old')
    refused(bag, 'exists', overwrite=False, folder=True)
    refused(home, 'more than a bag', folder=True)
    with OutputFiles(overwrite=True) as files:
        (files.add(bag, folder=True).partial / 'metadata.yaml').write_text('new')
    assert (listing(tmp_path), listing(bag)) == ({'bag', 'home'}, {'metadata.yaml'})


@pytest.fixture
def small(tmp_path: Path) -> Iterator[Path]:
    """Return a file system of 64 kB, where this process may mount one."""
    folder = tmp_path / 'small'
    folder.mkdir()
    try:
        mounted = subprocess.run(['mount', '-t', 'tmpfs', '-o', 'size=64k', 'tmpfs', folder],
                                 capture_output=True, check=False).returncode == 0
    except FileNotFoundError:
        mounted = False
    if not mounted:
        pytest.skip('may not mount a file system here')
    yield folder
    subprocess.run(['umount', folder], check=True)


def test_a_full_disk_is_said_before_the_work_and_leaves_nothing(small: Path) -> None:
    (small / 'filler').write_bytes(bytes(16384))
    refused(small / 'model.npz', 'No space left on device.*make room')
    with pytest.raises(OutputError, match='No space left'), output_file(small / 'm') as partial:
        partial.write_bytes(bytes(100_000))
    assert listing(small) == {'filler'}


def test_a_read_only_disk_is_said_before_the_work(small: Path) -> None:
    subprocess.run(['mount', '-o', 'remount,ro', small], check=True)
    refused(small / 'model.npz', 'Read-only file system')


def test_leftovers_of_ended_processes_go_and_those_of_running_ones_stay(tmp_path: Path) -> None:
    ended = tmp_path / f'a.npz.{ENDED}{PARTIAL}'
    ended.mkdir()
    (ended / 'half.mcap').write_text('half')
    (tmp_path / f'b.npz.{ENDED}{PARTIAL}').write_text('half')
    running = tmp_path / f'c.npz.{os.getppid()}{PARTIAL}'
    running.write_text('of a running process')
    others = [tmp_path / name for name in ('film.1.part', f'x{PARTIAL}', f'a.b{PARTIAL}')]
    for other in others:
        other.write_text('of another program')
    with OutputFiles() as files:
        files.add(tmp_path / 'd.npz').partial.write_text('first')
        with output_file(tmp_path / 'e.npz') as partial:  # does not take the first for a leftover
            partial.write_text('second')
    assert listing(tmp_path) == {running.name, 'd.npz', 'e.npz', *(p.name for p in others)}


def test_a_killed_run_leaves_nothing_for_long(tmp_path: Path) -> None:
    code = ('from squeal_core.common.output import OutputFiles\n'
            'import sys, time\n'
            'with OutputFiles(overwrite=True) as files:\n'
            '    files.add(sys.argv[1]).partial.write_text("half")\n'
            '    print("begun", flush=True)\n'
            '    time.sleep(600)\n')
    target = tmp_path / 'model.npz'
    target.write_text('old')
    with process(['-c', code, target], stdout=subprocess.PIPE) as run:
        assert run.stdout.readline() == b'begun\n'
        check_target(tmp_path / 'other.npz')
        assert len(listing(tmp_path)) == 2  # while it runs its file stays
        run.kill()
        run.wait()
    assert len(listing(tmp_path)) == 2
    check_target(tmp_path / 'other.npz')
    assert (listing(tmp_path), target.read_text()) == ({'model.npz'}, 'old')


def test_a_run_killed_while_it_replaces_is_undone(tmp_path: Path) -> None:
    (tmp_path / f'out.csv.{ENDED}.squeal-old').write_text('old')
    check_target(tmp_path / 'other')
    assert (tmp_path / 'out.csv').read_text() == 'old'
    assert listing(tmp_path) == {'out.csv'}
