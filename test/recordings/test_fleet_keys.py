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


"""What a result of a fleet is kept under: all that decides what is in it, and no path."""

from collections.abc import Callable, Sequence
import csv
import json
from pathlib import Path
import shutil
from typing import Any

import pytest
import yaml

pytest.importorskip('distributed', reason='needs dask')
pytest.importorskip('rosbags', reason='needs rosbags')

from squeal_core import BrakeModel  # noqa: E402, I100
from squeal_ros.cli.fleet_commands import _everywhere  # noqa: E402
from squeal_ros.cli.main import parser  # noqa: E402
from squeal_ros.cli.replay_commands import replay_task  # noqa: E402
from squeal_ros.recordings.fleet.fleet_task import content_key  # noqa: E402
from support.bags import braking, write_bag  # noqa: E402, I100
from support.commands import squeal  # noqa: E402
from support.fleets import SerialEngine  # noqa: E402
from support.rows import each  # noqa: E402

SIGNALS = """brakes:
  fl:
    rotor_speed: {topic: joint_states, field: "velocity[name=fl_wheel_joint]", unit: rad/s}
    pressure: {topic: fl/brake_pressure, unit: Pa}
    friction: {constant: 0.4}
"""
FILES = ('table', 'growth_emulator', 'calibration')


def config(folder: Path, **settings: Any) -> str:
    path = folder / 'config.yaml'
    path.write_text(yaml.safe_dump({'/**': {'ros__parameters': {'brakes': ['fl'], **settings}}}))
    return str(path)


def key(*options: str) -> str:
    """Return the key of a recording with the options of `squeal fleet`."""
    task = _everywhere(replay_task(parser().parse_args(['fleet', 'x', *options])))
    return content_key(task, Path('x'), 'digest')


@each('options', [
    ('--rate', '5'), ('--model', 'kang2009_damped'), ('--namespace', '/car'), ('--from', '1'),
    ('--to', '2')])
def test_options_that_decide_results(tmp_path: Path, options: Sequence[str]) -> None:
    plain = ('--config', config(tmp_path))
    assert key(*plain) == key(*plain) != key(*plain, *options)


def test_settings_decide_results(tmp_path: Path) -> None:
    plain = key('--config', config(tmp_path))
    assert key('--config', config(tmp_path, risk_warning=0.6)) != plain
    assert key('--config', config(tmp_path)) == plain
    (tmp_path / 'config.yaml').rename(tmp_path / 'moved.yaml')
    assert key('--config', str(tmp_path / 'moved.yaml')) == plain


def given_signals(path: Path) -> list[str]:
    return ['--config', config(path.parent), '--signals', str(path)]


def given_types(path: Path) -> list[str]:
    folder = path.parent / f'types_{path.name}'
    folder.mkdir(exist_ok=True)
    shutil.copy(path, folder / 'Wheels.msg')
    return ['--config', config(path.parent), '--types', str(folder)]


def given_setting(name: str) -> Callable[[Path], list[str]]:
    return lambda path: ['--config', config(path.parent, **{name: str(path)})]


@each(('given', 'content'), [
    (given_signals, SIGNALS), (given_types, 'float64 speed\n'),
    *((given_setting(name), 'any') for name in FILES)])
def test_contents_of_files_decide_results_and_their_paths_do_not(
        tmp_path: Path, given: Callable[[Path], list[str]], content: str,
        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        'squeal_ros.recordings.replay.replay_batch.VehicleEvaluator', lambda *_: None)
    monkeypatch.setattr('squeal_core.monitor.results.result_summary._basis', lambda *_: '')
    first, second = tmp_path / 'first', tmp_path / 'second'
    first.write_text(content)
    second.write_text(content)
    before = key(*given(first))
    assert before == key(*given(second)) != key('--config', config(tmp_path))
    first.write_text(f'{content}# and another line\n')
    assert key(*given(first)) != before


@pytest.fixture
def drives(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr('squeal_ros.cli.fleet_commands.FleetEngine', SerialEngine)
    write_bag(tmp_path / 'drive', braking(1.0, pressure=2e6))
    return tmp_path


def run(folder: Path, capsys: pytest.CaptureFixture[str], *options: str) -> tuple[Any, list[str]]:
    """Return what a run says of itself, and the growth rates of its ticks."""
    out = folder / 'out'
    _, said, err = squeal(capsys, 'fleet', str(folder / 'drive'), '-o', str(out), '--config',
                          config(folder), '--json', *options)
    assert not err
    (row,) = csv.DictReader((out / 'recordings.csv').read_text().splitlines())
    ticks = csv.DictReader((out / row['result'] / 'table.csv').read_text().splitlines())
    return json.loads(said), [tick['growth_rate_1_s'] for tick in ticks]


def test_another_signals_file_computes_again_and_the_page_names_it(
        drives: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip('plotly', reason='needs plotly')
    signals, page = drives / 'mine.yaml', drives / 'page.html'
    pages = []
    for friction in (0.4, 0.4, 0.5):
        signals.write_text(SIGNALS.replace('0.4', str(friction)))
        said, growth = run(drives, capsys, '--signals', str(signals))
        assert squeal(capsys, 'report', str(drives / 'out'), '-o', str(page), '--force')[0] == 0
        pages.append((said['results_computed'], growth, page.read_text()))
    assert [computed for computed, *_ in pages] == [1, 0, 1]
    assert pages[0][1] != pages[2][1]
    sources = json.loads((drives / 'out/fleet.json').read_text())['sources']
    assert sources['signals']['sha256'] in pages[2][2]
    assert '<td>mine.yaml</td>' in pages[2][2]
    assert sources['signals']['sha256'] not in pages[0][2]


def test_a_model_that_is_replaced_is_read_again(
        drives: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A worker of a cluster outlives the file of a model."""
    model, growths = drives / 'model.npz', []
    for name in ('kang2009', 'kang2009_damped'):
        BrakeModel.load(name).save(model)
        said, growth = run(drives, capsys, '--model', str(model))
        assert said['results_computed'] == 1
        growths.append(growth)
    assert growths[0] != growths[1]
    assert growths[1] == run(drives, capsys, '--model', 'kang2009_damped')[1]
