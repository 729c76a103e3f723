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

"""What charts, captions and notes of `squeal report` say: classes, axes, times, stretches."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from squeal_core.view.report.figure import fitted_range
from squeal_core.view.report.markup import prose
from squeal_core.view.report.runs import load_runs
from support.drive_results import SyntheticDrive
from support.report_pages import figures_of, page_of, unpacked
from support.rows import each

pytest.importorskip('plotly', reason='needs plotly')


@pytest.fixture(scope='module')
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return SyntheticDrive(150.0, brakes=('left', 'right')).write(
        tmp_path_factory.mktemp('report') / 'one')


def test_bars_are_in_the_classes_of_their_values(tmp_path: Path) -> None:
    """Predicted and measured ones, of one run and of two; one class does not fill the chart."""
    folders = [SyntheticDrive(60.0, brakes=('left',), seed=seed).write(tmp_path / f'{seed}')
               for seed in (1, 2)]
    figures = {one['id']: one for one in figures_of(page_of(*folders))}
    for name in ('frequency', 'pressure', 'temperature', 'speed'):
        bars, layout = figures[f'occurrence-{name}']['data'], figures[f'occurrence-{name}'][
            'layout']
        names = layout['xaxis']['categoryarray']
        assert layout['xaxis']['tickson'] == 'boundaries'
        assert layout['xaxis']['range'] == [-0.5, len(names) - 0.5]
        assert [bar['x'] for bar in bars] == [names, names]
        assert layout['bargap'] >= 0.2
    assert figures['occurrence-speed']['layout']['xaxis']['categoryarray'] == ['70 to 80']
    assert figures['occurrence-speed']['layout']['bargap'] == 0.8
    (bars, _), names = (figures['occurrence-frequency']['data'],
                        figures['occurrence-frequency']['layout']['xaxis']['categoryarray'])
    squeals = [one.frequency_hz for one in load_runs(folders[:1])[0].squealing]
    for at, height in zip(names, unpacked(bars['y']), strict=True):
        low, high = (1e3 * float(end) for end in at.split(' to '))
        assert height > 0.0 if any(low <= one < high for one in squeals) else height == 0.0


def test_frequency_axes_tell_close_pitches_apart(drive: Path) -> None:
    assert fitted_range([1.363, np.nan, 1.386]) == pytest.approx([1.34914, 1.39986])
    assert fitted_range([1.0, 16.0]) == pytest.approx([0.1, 16.9])
    assert fitted_range([]) == [0.0, 1.0]
    figures = {one['id']: one for one in figures_of(page_of(drive))}
    for name, axis in (('main-peak', 'yaxis'), ('frequency-time', 'yaxis'),
                       ('timeline-0-0', 'yaxis8')):
        low, high = figures[name]['layout'][axis]['range']
        assert 1.3 < low < 1.655, name  # the lowest mode of the drive, in kHz
        assert high < 6.1


def test_axes_without_values_have_no_scale(tmp_path: Path) -> None:
    folder = SyntheticDrive(30.0, brakes=('left',)).write(tmp_path / 'drive')
    for name in ('table.csv', 'applications.csv'):
        with (folder / name).open(newline='') as file:
            rows = list(csv.DictReader(file))
        with (folder / name).open('w', newline='') as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows({**row, 'temperature_k': 'nan'} for row in rows)
    page = page_of(folder)
    assert 'the settings name no temperature of a brake as an input' in page
    layout = next(one for one in figures_of(page) if one['id'] == 'timeline-0-0')['layout']
    assert layout['yaxis6']['showticklabels'] is False
    assert 'showticklabels' not in layout['yaxis3']


@each(('seconds', 'words', 'drawn'), [
    (1.0, 'There is no line of the predicted stability boundary', 0),
    (150.0, 'Lines, in the colour of a class', 2)])
def test_lines_of_the_friction_chart(tmp_path: Path, seconds: float, words: str,
                                     drawn: int) -> None:
    """Each of the two panels explains its lines in its legend; without any it is said why."""
    folder = SyntheticDrive(seconds, 4.0, brakes=('left',)).write(tmp_path / f'{seconds}')
    page = page_of(folder)
    assert words in page
    traces = next(one for one in figures_of(page) if one['id'] == 'friction')['data']
    assert sum(one['name'] == 'stability boundary' for one in traces) == drawn
    assert any(one['name'].startswith('boundary, ') for one in traces) == bool(drawn)


def test_runs_of_different_stretches_are_told(tmp_path: Path, drive: Path) -> None:
    warning = 'are not of the same drive'
    same = SyntheticDrive(150.0, brakes=('left', 'right'), seed=5).write(tmp_path / 'same')
    assert warning not in page_of(drive, same)
    page = page_of(drive, SyntheticDrive(90.0, brakes=('left', 'right')).write(tmp_path / 'part'))
    assert page.index(f'part and one {warning}: part has drive from 2023-11-14 22:13:20 UTC to '
                      '2023-11-14 22:14:50 UTC, and not from') < page.index('part minus one')
    other = SyntheticDrive(150.0, name='monday', brakes=('left',)).write(tmp_path / 'other')
    assert f'{warning}: other has other recordings' in page_of(drive, other)


def test_what_the_risk_rests_on(tmp_path: Path, drive: Path) -> None:
    """Under "What is known", before any figure; of results that do not state it, too."""
    words = 'Squeal risk: not calibrated: the level of the risk is mostly the prior of damping.'
    page = page_of(drive)
    assert page.index('id="known"') < page.index(words) < page.index('id="summary"')
    folder = SyntheticDrive(30.0, brakes=('left',)).write(tmp_path / 'drive')
    summary = json.loads((folder / 'summary.json').read_text())
    (folder / 'summary.json').write_text(json.dumps(summary | {'risk_basis': 'by 12 events'}))
    page = page_of(folder)
    assert 'Squeal risk: by 12 events.' in page
    assert 'prior of damping' not in page


@each(('start', 'words'), [(1_700_000_000.0, '2023-11-14 22:13:20 UTC'), (12.0, '12.0 s')])
def test_times_say_their_clock(tmp_path: Path, start: float, words: str) -> None:
    page = page_of(SyntheticDrive(30.0, brakes=('left',), start=start).write(
        tmp_path / f'{start}'))
    assert f'<td>{words}</td>' in page
    assert 'start (UTC)' not in page
    assert page.count('The predicted squeal event') + page.count('predicted squeal events,') == 1
    assert 'may end after the braking' in page


def test_words_between_backticks_are_code() -> None:
    assert prose('see `squeal info M<` now') == 'see <code>squeal info M&lt;</code> now'
    assert prose('a ` b <') == 'a ` b &lt;'


def test_events_without_a_growing_mode_are_explained(tmp_path: Path) -> None:
    words = 'the mode of the nominal brake is stable there'
    folder = SyntheticDrive(30.0, brakes=('left',)).write(tmp_path / 'drive')
    assert words not in page_of(folder)
    text = (folder / 'events.csv').read_text()
    row = next(csv.DictReader(text.splitlines()))
    (folder / 'events.csv').write_text(text.replace(row['growth_rate_1_s'], '-1.1', 1))
    assert words in page_of(folder)
