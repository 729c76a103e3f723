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

import json
from pathlib import Path
import re
from typing import Any

import numpy as np
import pytest
from squeal_core.view.report.drives import read_drives
from squeal_core.view.report.markup import element, table
from squeal_core.view.report.runs import load_runs
from squeal_ros.cli.main import main
from support.drive_results import SyntheticDrive
from support.report_pages import figures_of, page_of, unpacked
from support.rows import each

graphs = pytest.importorskip('plotly.graph_objects', reason='needs plotly')

NASTY = '</script><img src=x onerror=alert(1)>'


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
