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

"""The page of `squeal report`: order, what is not known, escapes, figures as plotly has them."""

import base64
import csv
import json
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from squeal_core.view.report.drives import read_drives
from squeal_core.view.report.figure import fitted_range
from squeal_core.view.report.markup import element, prose, table
from squeal_core.view.report.page import report_page
from squeal_core.view.report.runs import load_runs
from squeal_ros.cli.main import main
from support.drive_results import SyntheticDrive
from support.rows import each

graphs = pytest.importorskip('plotly.graph_objects', reason='needs plotly')

NASTY = '</script><img src=x onerror=alert(1)>'


def page_of(*folders: Path) -> str:
    return report_page(load_runs(folders))


def figures_of(page: str) -> list[dict[str, Any]]:
    found = re.search(r'<script type="application/json" id="figures">(.*?)</script>', page)
    assert found
    return list(json.loads(found[1]))


def unpacked(array: dict[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(array['bdata']), array['dtype'])


@pytest.fixture(scope='module')
def drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return SyntheticDrive(150.0, brakes=('left', 'right')).write(
        tmp_path_factory.mktemp('report') / 'one')


def test_sections_and_figures(drive: Path) -> None:
    page = page_of(drive)
    order = [page.index(f'id="{name}"') for name in (
        'known', 'summary', 'charts', 'timeline', 'map', 'mode', 'quality')]
    assert order == sorted(order)
    assert 'Squeal risk known for 80 % of the braking time' in page
    figures = figures_of(page)
    assert [figure['id'] for figure in figures] == [
        'occurrence-frequency', 'occurrence-pressure', 'occurrence-temperature',
        'occurrence-speed', 'main-peak', 'worst-level', 'frequency-time', 'friction',
        'timeline-0-0', 'timeline-0-1', 'map-0', 'shape-0', 'mechanism-0']
    for figure in figures:  # raises for what plotly does not know
        graphs.Figure(figure['data'], figure['layout'])
        assert figure['data']


def test_the_page_needs_nothing_else(drive: Path) -> None:
    page = page_of(drive)
    own = page[:page.index('id="plotly"')] + page[page.index('</script>', page.index(
        'id="plotly"')):]
    assert not re.search(r"""(src|href)=["'](?!#)|@import|url\(""", own)
    assert len(page) < 8e6


def test_bars_of_the_mechanism_sum_to_the_growth_rate(drive: Path) -> None:
    bars = figures_of(page_of(drive))[-1]['data'][0]
    assert bars['measure'][-1] == 'total'
    assert sum(bars['x'][:-1]) == pytest.approx(bars['x'][-1])


def test_nothing_known_is_said_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = SyntheticDrive(60.0, brakes=('left',), known=False).write(tmp_path / 'none')
    assert main(['report', str(folder), '-o', str(tmp_path / 'page.html')]) == 1
    assert 'nothing is known of squeal' in capsys.readouterr().out
    page = (tmp_path / 'page.html').read_text()
    assert page.index('Nothing is known of squeal') < page.index('<table>')
    assert page.count('class="unknown"') >= 9
    for name in ('occurrence-frequency', 'worst-level', 'frequency-time', 'map-0', 'shape-0'):
        assert re.search(f'<div class="unknown" id="{name}">'
                         '<span>Not known', page), name
    assert 'Squeal events: not known' in page


def test_differences_first(tmp_path: Path, drive: Path) -> None:
    other = SyntheticDrive(150.0, 20.0, brakes=('left', 'right'), seed=5).write(tmp_path / 'two')
    page = page_of(drive, other)
    assert page.index('id="differences"') < page.index('id="known"')
    assert 'two minus one' in page
    assert 'rate: 10.0 -&gt; 20.0' in page
    assert {'map-0', 'map-1', 'timeline-1-0', 'shape-1'} <= {
        figure['id'] for figure in figures_of(page)}


def test_text_of_recordings_is_no_html(tmp_path: Path) -> None:
    folder = SyntheticDrive(60.0, brakes=(NASTY,), name=NASTY).write(tmp_path / '<b>run')
    page = page_of(folder)
    assert '<img src=x' not in page
    assert '<b>run' not in page
    texts = json.dumps(figures_of(page))
    assert NASTY not in texts
    assert '&lt;/script&gt;&lt;img' in texts  # as plotly reads it


def test_markup_escapes_all_but_markup() -> None:
    assert element('p', '<b>', element('i', 'a&b'), title='"x"') == (
        '<p title="&quot;x&quot;">&lt;b&gt;<i>a&amp;b</i></p>')
    assert '<td class="number">&lt;</td>' in table(('', ''), [('a', '<')])
    assert element('p', 'a\x00\ud800b') == '<p>a\ufffd\ufffdb</p>'


def test_a_model_that_is_not_found_is_said(tmp_path: Path) -> None:
    folder = SyntheticDrive(60.0, brakes=('left',)).write(tmp_path / 'drive')
    summary = json.loads((folder / 'summary.json').read_text())
    summary['model']['sha256'] = '0' * 64
    (folder / 'summary.json').write_text(json.dumps(summary))
    page = page_of(folder)
    assert re.search('id="shape-0"><span>Not known: the model kang2009_damped with SHA-256 '
                     '000000000000', page)


@each(('options', 'words'), [
    (['--stretch', '20', '10'], '--stretch: 20 to 10 s'),
    (['--stretch', '500', '600'], '--stretch: 500 to 600 s is in no recording'),
    (['-o', 'page.txt'], 'end it in .html'), (['nowhere'], 'nowhere')])
def test_bad_input(tmp_path: Path, drive: Path, monkeypatch: pytest.MonkeyPatch,
                   capsys: pytest.CaptureFixture[str], options: list[str], words: str) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(['report', str(drive), *options]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count('\n') == 1
    assert not list(tmp_path.iterdir())


def test_a_chosen_stretch(tmp_path: Path, drive: Path) -> None:
    output = tmp_path / 'page.html'
    assert main(['report', str(drive), '-o', str(output), '--stretch', '30', '45.5']) == 0
    timelines = [figure for figure in figures_of(output.read_text())
                 if figure['id'].startswith('timeline')]
    assert len(timelines) == 1
    assert timelines[0]['layout']['xaxis']['range'] == pytest.approx([30.0, 45.5])


@each('seconds', [0.1, 30.0])
def test_the_timeline_holds_the_tick_after_the_last_message(tmp_path: Path,
                                                            seconds: float) -> None:
    folder = SyntheticDrive(seconds, brakes=('left',)).write(tmp_path / f'{seconds}')
    summary = json.loads((folder / 'summary.json').read_text())
    last = summary['recording']['end_s'] - 0.1  # of the ticks
    summary['recording'] |= {'start_s': summary['recording']['start_s'] - 0.03,
                             'end_s': last - 0.03}
    (folder / 'summary.json').write_text(json.dumps(summary))
    (drive,), _ = read_drives(load_runs([folder]), None, lambda done, total: None)
    envelope = drive.stretches[0].envelope
    assert np.isfinite(envelope.brakes['left'].high['rotor_speed_rad_s']).sum() == round(
        10.0 * seconds)


def test_measured_squeal(tmp_path: Path, drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    applications = [one for one in load_runs([drive])[0].known if one.alarm]
    measured = tmp_path / 'measured.csv'
    measured.write_text('time_s,frequency_hz,brake,end_s\n' + ''.join(
        f'{one.start_s + 2.5},{1.01 * one.frequency_hz},{one.brake},{one.start_s + 3.0}\n'
        for one in applications[1:]))
    output = tmp_path / 'page.html'
    assert main(['report', str(drive), '-o', str(output), '--sound', str(measured), '--json']) == 0
    found = json.loads(capsys.readouterr().out)
    counts = found['comparisons'][0]['counts']
    assert (counts['hit'], counts['false alarm'], counts['miss']) == (len(applications) - 1, 1, 0)
    page = output.read_text()
    order = ['id="summary"', 'Measured squeal</h3>', 'nothing says when somebody listened',
             '<th scope="row">hit</th>', 'id="charts"']
    places = [page.index(text) for text in order]
    assert places == sorted(places)
    figures = {figure['id']: figure for figure in figures_of(page)}
    assert {'calibration-0', 'pitch-0'} <= set(figures)
    assert [trace['name'] for trace in figures['occurrence-pressure']['data']] == [
        'predicted', 'measured']
    heard = figures['frequency-time']['data'][-1]
    assert (heard['name'], len(heard['text'])) == ('measured', len(applications) - 1)
    start = load_runs([drive])[0].results[0].summary['recording']['start_s']
    assert unpacked(heard['x']) == pytest.approx(
        [one.start_s + 2.5 - start for one in applications[1:]])
    lines = figures['timeline-0-0']['data'][-1]
    assert lines['name'] == 'measured squeal'
    assert unpacked(lines['x']).reshape(-1, 3)[:, :2] == pytest.approx(np.array(
        [(one.start_s + 2.5 - start, one.start_s + 3.0 - start) for one in applications[1:]]))
    for figure in figures.values():
        graphs.Figure(figure['data'], figure['layout'])


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


def test_measured_squeal_on_no_clock_is_refused(
        tmp_path: Path, drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    measured, output = tmp_path / 'measured.csv', tmp_path / 'page.html'
    measured.write_text('time_s,frequency_hz\n2.5,2000\n')
    measured.with_suffix('.json').write_text(json.dumps(
        {'offset_s': None, 'clock': 'sync', 'clock_note': 'two places'}))
    assert main(['report', str(drive), '-o', str(output), '--sound', str(measured)]) == 2
    error = capsys.readouterr().err
    assert 'not found (two places)' in error
    assert error.count('\n') == 1
    assert not output.exists()


def test_inputs_of_several_recordings_are_summed(tmp_path: Path) -> None:
    for number in range(3):
        SyntheticDrive(60.0, brakes=('left',), name=f'drive {number}').write(
            tmp_path / f'run/{number}')
    page = page_of(tmp_path / 'run')
    row = re.search('<tr><th scope="row">left</th><td>pressure</td>.*?</tr>', page)
    assert row
    assert re.findall('"number">(.*?)</td>', row[0]) == [
        '3', '3000', '20.0', '6', '1.20', '24.0', '4.5', 'stuck: 4.5 s']
    assert page.count('3 recordings, 3.0 min') == 1


@each(('change', 'words'), [
    ({'report': None}, 'has no report'), ({'report': {}}, 'has no report.braking_s'),
    ({'rate_hz': 0.0}, 'rate_hz is 0.0'), ({'settings': 'x'}, 'has no settings')])
def test_summaries_that_lack_something(tmp_path: Path, capsys: pytest.CaptureFixture[str],
                                       change: dict[str, Any], words: str) -> None:
    folder = SyntheticDrive(30.0, brakes=('left',)).write(tmp_path / words)
    summary = folder / 'summary.json'
    summary.write_text(json.dumps(json.loads(summary.read_text()) | change))
    assert main(['report', str(folder), '-o', str(tmp_path / 'page.html')]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert error.count('\n') == 1
