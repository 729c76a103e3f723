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

"""The page: sections in their order, figures, style and script in one HTML file."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
import json
from string import Template
from typing import Any

from squeal_core.common.errors import SquealError
from squeal_core.common.version import __version__
from squeal_core.sound.comparison import Comparison
from squeal_core.view.report import charts
from squeal_core.view.report.drives import Drive, read_drives, Stretch
from squeal_core.view.report.figure import Figure
from squeal_core.view.report.friction_chart import friction_chart
from squeal_core.view.report.known import known_section
from squeal_core.view.report.markup import element, Markup, markup, prose
from squeal_core.view.report.measured import measured_figures, measured_section
from squeal_core.view.report.occurrence import CONDITIONS, occurrence
from squeal_core.view.report.operating_map import operating_map
from squeal_core.view.report.runs import Run
from squeal_core.view.report.summary import differences_section, quality_section, summary_section
from squeal_core.view.report.timeline import timeline
from squeal_core.view.report.worst_mode import mechanism_figure, shape_figure, worst_mode

NOTICE = ('Predictions of squeal, advisory and no safety function. Not known is never silence: '
          'hatched boxes and dashes say where nothing is known.')


@dataclass(eq=False)
class Page:
    """A page: sections and figures in the order in which they are added."""

    contents: list[Markup] = field(default_factory=list)
    sections: list[Markup] = field(default_factory=list)
    figures: list[Figure] = field(default_factory=list)

    def add(self, name: str, title: str, *content: Any) -> None:
        self.contents.append(element('a', title, href=f'#{name}'))
        self.sections.append(element(
            'section', element('h2', title), *content, id=name, class_='chapter'))

    def draw(self, *figures: Figure) -> Markup:
        """Return the places of figures; the page's script draws them."""
        self.figures += [one for one in figures if not one.unknown]
        return element('div', map(_place, figures), class_='figures')

    def whole(self, title: str, plotly: str = '') -> str:
        """
        Return the HTML of the page.

        Parameters
        ----------
        title : str
            Heading of the page.
        plotly : str
            Name of the file of plotly.js beside the page; by default it is in the page.

        """
        templates = files('squeal_core.view.report') / 'templates'
        html, style, own = ((templates / f'page.{kind}').read_text('utf-8')
                            for kind in ('html', 'css', 'js'))
        figures = json.dumps([one.as_plotly() for one in self.figures], separators=(',', ':'),
                             allow_nan=False)
        script = '' if plotly else plotly_script()
        for name, content in (('plotly.js', script), ('the page', own)):
            if '</script' in content.lower() or '<!--' in content:
                raise SquealError(f'{name}: its script cannot be embedded; install plotly again')
        return Template(html).substitute(
            title=markup(title), notice=markup(f'{NOTICE} Made by squeal_ros {__version__}.'),
            contents=markup(self.contents), sections=markup(self.sections), style=style,
            # a text that would end the element is escaped as in JSON
            figures=figures.replace('<', '\\u003c'), plotly=script, script=own,
            beside=markup(plotly), sources=" 'self' file:" if plotly else '')


def _place(figure: Figure) -> Markup:
    kinds = [kind for kind, is_so in (('wide', figure.wide), ('solid', 'scene' in figure.layout))
             if is_so]
    if figure.unknown:
        inside = [element('div', element('span', prose(figure.unknown)), class_='unknown',
                          id=figure.name)]
    else:
        inside = [element('div', class_='plot', id=figure.name,
                          style=f'height: {figure.height}px')]
        if 'solid' in kinds:
            inside.append(Markup(f'<img class="printed" alt="{markup(figure.title)}">'))
    return element('figure', element('h3', figure.title), *inside,
                   element('figcaption', prose(figure.caption)), class_=' '.join(kinds))


def report_page(runs: Sequence[Run], *, comparisons: Sequence[Comparison] = (),
                stretch: Stretch | None = None,
                progress: Callable[[int, int], None] = lambda done, total: None,
                plotly: str = '') -> str:
    """
    Return the page of one or several runs.

    Parameters
    ----------
    runs : sequence of Run
        The first one is what the others are compared with.
    comparisons : sequence of Comparison
        With measured squeal, one a run; none: nothing was measured.
    stretch : (start, end), optional
        Of the timeline [s]; default: the whole recording with the worst event, and its
        surroundings.
    progress : callable
        Told how many recordings were read, of how many.
    plotly : str
        Name of the file of plotly.js beside the page; by default it is in the page.

    Raises
    ------
    SquealError
        For results that cannot be read, and a stretch that is in no recording.

    """
    page = Page()
    if not plotly:
        plotly_script()  # says before the work that it is missing
    drives, boundary = read_drives(runs, stretch, progress)
    if len(runs) > 1:
        page.add('differences', 'Differences', *differences_section(runs))
    page.add('known', '1 What is known', *_each(runs, known_section))
    page.add('summary', '2 Summary', *_each(runs, summary_section),
             *_measured(page, runs, comparisons))
    page.add('charts', '3 Charts', page.draw(
        *(occurrence(runs, condition, comparisons) for condition in CONDITIONS),
        charts.main_peaks(runs), charts.worst_levels(runs),
        charts.frequencies_over_time(runs, comparisons), friction_chart(runs, boundary)))
    page.add('timeline', '4 Timeline', page.draw(*(
        figure for drive in drives for figure in _timelines(drive, comparisons[drive.place:]))))
    page.add('map', '5 Operating map', page.draw(*(
        operating_map(drive.map, drive.path.numbers, f'map-{drive.place}', drive.of_path,
                      f'Operating map{drive.of_run}') for drive in drives)))
    page.add('mode', '6 Worst mode', page.draw(*(
        figure for drive in drives for figure in _worst_mode(drive))))
    page.add('quality', '7 Data quality', *_each(runs, quality_section))
    return page.whole(f'Squeal report: {", ".join(run.name for run in runs)}', plotly)


def _each(runs: Sequence[Run], section: Callable[[Run], list[Markup]]) -> Iterator[Markup]:
    """Yield a section of each run, under its name where there are several."""
    for run in runs:
        if len(runs) > 1:
            yield element('h3', run.name)
        yield from section(run)


def _measured(page: Page, runs: Sequence[Run],
              comparisons: Sequence[Comparison]) -> Iterator[Markup]:
    """Yield measured beside predicted squeal of each run."""
    for place, (run, result) in enumerate(zip(runs, comparisons, strict=False)):
        of_run = f': {run.name}' if len(runs) > 1 else ''
        yield from measured_section(result, of_run)
        yield page.draw(*measured_figures(result, str(place), of_run))


def _timelines(drive: Drive, comparisons: Sequence[Comparison]) -> Iterator[Figure]:
    measured = [event for result in comparisons[:1]
                for event in charts.measured_in(drive.result, result)]
    for place, (title, words, envelope) in enumerate(drive.stretches):
        yield timeline(envelope, name=f'timeline-{drive.place}-{place}', title=title, what=words,
                       measured=measured)


def _worst_mode(drive: Drive) -> Iterator[Figure]:
    result = drive.result
    found = worst_mode(result.summary['model'] or {}, result.paths.summary.parent,
                       drive.path.numbers)
    yield shape_figure(found, f'shape-{drive.place}', drive.of_run)
    yield mechanism_figure(found, f'mechanism-{drive.place}', drive.of_run)


def plotly_script() -> str:
    """
    Return plotly.js.

    Raises
    ------
    ImportError
        Where it is not installed.

    """
    try:
        package = files('plotly')
    except ImportError as error:
        raise ImportError("reports need plotly: pip install -e '.[report]' in the checkout"
                          ) from error
    return (package / 'package_data' / 'plotly.min.js').read_text('utf-8')
