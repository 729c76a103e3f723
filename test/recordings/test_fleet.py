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


"""Fleets: one result for each content, tables over all, what fails, what is kept, their page."""

from collections.abc import Iterator
from contextlib import suppress
import csv
from functools import partial
import json
import os
from pathlib import Path
import shutil
import signal
import subprocess
import sys
import time
from typing import Any

import pytest

pytest.importorskip('distributed', reason='needs dask')
pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core.common.partial_files import PARTIAL  # noqa: E402
from squeal_core.monitor.results.result_summary import file_hash  # noqa: E402
from squeal_ros.cli.main import main  # noqa: E402
from squeal_ros.recordings.fleet.fleet_engine import FleetLost  # noqa: E402
from squeal_ros.recordings.fleet.fleet_task import evaluate_recording, FleetError  # noqa: E402
from squeal_ros.recordings.fleet.fleet_vehicles import read_vehicles, vehicles_of  # noqa: E402
from squeal_ros.recordings.recording_files import find_recordings  # noqa: E402
from support.bags import braking, settings_file, storage_file, write_bag  # noqa: E402, I100
from support.commands import squeal  # noqa: E402
from support.fleets import SerialEngine  # noqa: E402
from support.rows import each  # noqa: E402


@pytest.fixture
def cars(tmp_path: Path) -> Path:
    """Return a folder of two cars: three drives, a copy of one, and a damaged recording."""
    folder = tmp_path / 'cars'
    for number, name in enumerate(('a/one', 'a/two', 'b/three')):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_bag(folder / name, braking(2.0, pressure=1e5 + 4e5 * number))
    shutil.copytree(folder / 'a/one', folder / 'b/same')
    storage_file(write_bag(folder / 'b/damaged', braking(1.0))).write_bytes(b'junk')
    settings_file(tmp_path / 'config.yaml')
    return folder


def command(cars: Path, out: str, *options: str) -> list[str]:
    return ['fleet', str(cars), '-o', str(cars.parent / out), '--config',
            str(cars.parent / 'config.yaml'), *options]


def rows(cars: Path, name: str, out: str = 'out') -> list[dict[str, str]]:
    with (cars.parent / out / f'{name}.csv').open() as file:
        return list(csv.DictReader(file))


def hashes(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of all files in a folder by their paths in it, without leftovers."""
    return {str(path.relative_to(folder)): file_hash(path)[0]
            for path in folder.rglob('*') if path.is_file() and PARTIAL not in str(path)}


@pytest.fixture
def serial(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('squeal_ros.cli.fleet_commands.FleetEngine', SerialEngine)


@pytest.mark.usefixtures('serial')
def test_only_what_is_new_is_computed(cars: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By content: copies once, moved recordings not again, changed settings all."""
    def run(*options: str) -> tuple[int, Any]:
        code, out, _ = squeal(capsys, *command(cars, 'out', '--json', *options))
        return code, json.loads(out)

    code, found = run('--vehicles', str(_vehicles(cars.parent / 'vehicles.csv')))
    assert code == 1
    assert (found['recordings_found'], found['recordings_evaluated']) == (5, 4)
    assert (found['results_computed'], found['results_kept']) == (3, 0)
    (failure,) = found['failures']
    assert failure['recording'] == 'damaged'
    assert 'cannot be read' in failure['error']
    recordings = {row['recording']: row for row in rows(cars, 'recordings')}
    assert recordings['one']['result'] == recordings['same']['result']
    assert {name for name, row in recordings.items() if row['copy_of'] == 'one'} == {'same'}
    assert (found['recordings_copied'], found['recordings_with_notes']) == (1, 0)
    assert [recordings[name]['vehicle'] for name in ('one', 'two', 'three')] == ['X 1', 'a', 'b']
    assert recordings['two']['mileage_km'] == '12000.0'
    assert recordings['three']['mileage_km'] == ''
    assert recordings['one']['date'] == '2023-11-14'
    for kind, key in (('applications', 'applications'), ('events', 'events')):
        assert len(rows(cars, kind)) == found['totals'][key] == sum(
            int(row[key]) for row in recordings.values() if not row['copy_of']) > 0
    assert {row['brake'] for row in rows(cars, 'brakes')} == {'fl'}
    shutil.rmtree(cars / 'b/damaged')
    (cars / 'a/two').rename(cars / 'b/moved')
    code, found = run()
    assert (code, found['results_computed'], found['results_kept']) == (0, 0, 3)
    assert rows(cars, 'failures') == []
    table = cars.parent / 'out' / recordings['three']['result'] / 'table.csv'
    whole = table.read_bytes()
    table.write_bytes(whole[:-10])
    assert run()[1]['results_computed'] == 1
    assert table.read_bytes() == whole
    assert run('--rate', '5')[1]['results_computed'] == 3


class Ended(SerialEngine):
    """Is interrupted, or lost, after the first of the results that it computes."""

    def __init__(self, *_: Any, interrupt: bool, **__: Any) -> None:
        self._interrupt = interrupt

    def results(self, function: Any, jobs: Any, going_on: Any) -> Iterator[tuple[str, Any]]:
        every = super().results(function, jobs, going_on)
        if function is not evaluate_recording:
            yield from every
            return
        yield next(every)
        if self._interrupt:
            signal.raise_signal(signal.SIGINT)
            yield from every
        else:
            list(every)  # by workers, of which nobody hears
            raise FleetLost('the scheduler x', 'is gone', 'see its log')


@each(('interrupt', 'code', 'computed', 'not_reached', 'why'), [
    (True, 130, 1, 3, 'the run was interrupted; run it again'),
    (False, 1, 3, 1, 'the scheduler x: is gone; see its log')])
def test_a_run_that_ends_early(
        cars: Path, interrupt: bool, code: int, computed: int, not_reached: int, why: str,
        monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """It says why, tells what it did not come to from what failed, and counts all results."""
    monkeypatch.setattr('squeal_ros.cli.fleet_commands.FleetEngine',
                        partial(Ended, interrupt=interrupt))
    found, out, _ = squeal(capsys, *command(cars, f'out_{code}'))
    assert found == code
    assert f'{computed} result' in out
    assert 'copies of other recordings, which count once: 1' in out
    assert f'stopped: {why}' in out
    manifest = json.loads((cars.parent / f'out_{code}' / 'fleet.json').read_text())
    assert why in manifest['partial']
    assert manifest['recordings_evaluated'] == computed + 1
    assert (manifest['recordings_not_reached'], manifest['recordings_failed']) == (not_reached, 0)


def _vehicles(path: Path) -> Path:
    path.write_text('recording,vehicle,mileage_km\none,X 1,11000\n*/a/two,,12000\n')
    return path


@pytest.mark.skipif(os.name != 'posix', reason='needs signals')
def test_a_killed_run_keeps_what_is_finished_and_any_workers_give_the_same(
        cars: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Two processes of workers, ended with their client by SIGKILL; then this process alone."""
    out = cars.parent / 'out' / 'recordings'
    run = subprocess.Popen([sys.executable, '-m', 'squeal_ros.cli',
                            *command(cars, 'out', '--workers', '2')], start_new_session=True)
    finished: list[str] = []
    while not finished and run.poll() is None:
        time.sleep(0.01)
        with suppress(FileNotFoundError):
            finished = [path.name for path in out.iterdir() if PARTIAL not in path.name]
    os.killpg(run.pid, signal.SIGKILL)  # a worker that is alive would go on for a while
    run.wait()
    assert finished
    monkeypatch.setattr('squeal_ros.cli.fleet_commands.FleetEngine', SerialEngine)
    code, said, _ = squeal(capsys, *command(cars, 'out', '--json'))
    assert (code, json.loads(said)['results_kept'] >= len(finished)) == (1, True)
    assert main(command(cars, 'new')) == 1
    assert hashes(cars.parent / 'out') == hashes(cars.parent / 'new')


@pytest.mark.skipif(os.name != 'posix', reason='needs pipes and links')
@pytest.mark.usefixtures('serial')
def test_each_bad_recording_is_named_with_its_own_path(
        cars: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Also a copy of a bad one, and what is no file: nothing holds the run up."""
    os.mkfifo(cars / 'b/pipe.mcap')
    (cars / 'b/link.mcap').symlink_to(cars / 'nowhere.mcap')
    (cars / 'b/empty.mcap').touch()
    shutil.copytree(cars / 'b/damaged', cars / 'b/damaged_too')
    code, said, _ = squeal(capsys, *command(cars, 'out', '--json'))
    errors = {one['recording']: one['error'] for one in json.loads(said)['failures']}
    assert (code, json.loads(said)['recordings_evaluated']) == (1, 4)
    for name, path, words in (
            ('pipe', 'pipe.mcap', 'is a pipe'), ('nowhere', 'link.mcap', 'does not exist'),
            ('empty', 'empty.mcap', 'empty'), ('damaged', 'damaged', 'cannot be read'),
            ('damaged_too', 'damaged_too', 'cannot be read')):
        assert f'b/{path}' in errors[name]
        assert words in errors[name]


@pytest.mark.usefixtures('serial')
def test_the_page_of_a_fleet(cars: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is not known first; names are text; a link to the page of a recording."""
    pytest.importorskip('plotly', reason='needs plotly')
    (cars / 'b/three').rename(cars / 'b/<i>x')
    cut = storage_file(cars / 'a/two')
    cut.write_bytes(cut.read_bytes()[:-2_000])
    code, said, _ = squeal(capsys, *command(cars, 'out'))
    assert (code, '1 recording with notes, as of damage' in said) == (1, True)
    (notes,) = filter(None, (row['notes'] for row in rows(cars, 'recordings')))
    assert 'messages are whole and read, the rest is lost' in notes
    page = cars.parent / 'fleet.html'
    code, said, _ = squeal(capsys, 'report', str(cars.parent / 'out'), '-o', str(page),
                           '--pages', '1', '--json')
    assert code == 0
    assert json.loads(said)['pages_linked'] == 1
    text = page.read_text()
    assert 'messages are whole and read, the rest is lost' in text
    assert 'Copies of other recordings, which count once: 1.' in text
    assert text.index('1 of 5 recordings could not be evaluated') < text.index(
        'Squeal risk known for all of the braking time') < text.index('id="by-vehicle"')
    assert '<i>' not in text
    (link,) = {part.partition('"')[0] for part in text.split('href="')[1:]
               if part.startswith('fleet_recordings')}
    assert 'data-beside="plotly.min.js"' in (cars.parent / link).read_text()
    assert (cars.parent / 'fleet_recordings' / 'plotly.min.js').stat().st_size > 1e6
    assert squeal(capsys, 'report', str(cars.parent / 'out'), '--pages', 'x')[0] == 2
    assert 'give it alone' in squeal(capsys, 'report', str(cars.parent / 'out'), 'b')[2]


@each(('files', 'given', 'vehicles'), [
    (('r/a/x.mcap', 'r/b/y.mcap'), 'r', 'a b'), (('r/a/x.mcap', 'r/b/y.mcap'), 'r/a r/b', 'a b'),
    (('r/a/x.mcap', 'r/b/y.csv', 'r/b/z.mcap'), 'r', 'a b b'), (('r/a/x.mcap',), 'r', 'a'),
    (('r/a/x.mcap', 'r/a/y.mcap'), 'r', 'a a'), (('r/a/x.mcap', 'r/a/y.mcap'), 'r/a', ' '),
    (('r/a/x.mcap',), 'r/a', ''), (('r/a/x.mcap',), 'r/a/x.mcap', ''),
    (('r/a/x_0.mcap', 'r/a/x_1.mcap', 'r/b/y.mcap'), 'r', 'a b'),  # a split bag is one recording
    (('r/x/x_0.mcap', 'r/x/x_1.mcap', 'r/b/y.mcap'), 'r', ' b'),  # in a folder of its own
    (('r/a/x/x_0.mcap', 'r/b/y/metadata.yaml', 'r/b/y/z_0.db3'), 'r', 'a b'),
    (('r/x.mcap', 'r/a/y.mcap'), 'r', ' a')])
def test_vehicles_are_folders_whatever_number_of_recordings_they_hold(
        tmp_path: Path, files: tuple[str, ...], given: str, vehicles: str) -> None:
    at = tmp_path / str(hash((files, given)))
    for file in files:
        (at / file).parent.mkdir(parents=True, exist_ok=True)
        (at / file).touch()
    paths = [at / one for one in given.split()]
    found = vehicles_of({str(path): path for path in find_recordings(paths)}, (), paths)
    assert sorted(one.vehicle for one in found.values()) == vehicles.split(' ')


@each(('text', 'said'), [
    ('name,vehicle\n', 'has the columns name, vehicle'), ('', 'has the columns none'),
    ('recording,mileage\n', 'did you mean mileage_km?'),
    ('recording,mileage_km\na,far\n', 'line 2: is a,far'),
    ('recording,mileage_km\na,-1\n', 'line 2: is a,-1'),
    ('recording\na,b\n', 'line 2'), ('recording\n\xff\n', 'is no CSV in UTF-8')])
def test_vehicles_that_cannot_be_read(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / 'vehicles.csv'
    path.write_bytes(text.encode('latin-1'))
    with pytest.raises(FleetError) as error:
        read_vehicles(path)
    assert said in str(error.value)
    assert str(path) in str(error.value)


@each(('options', 'said'), [
    (('--workers', '0'), '--workers: is 0; give 1 to 256'),
    (('--retries', '-1'), '--retries: is -1'), (('--timeout', '0'), '--timeout: is 0.0')])
def test_bad_options(cars: Path, options: tuple[str, ...], said: str,
                     capsys: pytest.CaptureFixture[str]) -> None:
    code, _, err = squeal(capsys, *command(cars, 'out', *options))
    assert (code, said in err) == (2, True)
    (cars.parent / 'other').mkdir(exist_ok=True)
    (cars.parent / 'other' / 'mine.txt').touch()
    code, _, err = squeal(capsys, *command(cars, 'other'))
    assert (code, 'holds mine.txt and no fleet.json' in err) == (2, True)
