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

"""Frequencies and growth rates of modes over several parameters, as lines."""

from itertools import product
from typing import Any

try:
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.lines import Line2D
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.studies.study_record import Study
from squeal_core.view.slide import COLOURS, GREY, LINES, MARKERS
from squeal_core.view.stability_map import axis_ends
from squeal_core.view.study_labels import study_axis

_MOST_LINES = 60  # of one panel
_SAMPLES = np.linspace(0.0, 0.9, 256)  # of the colour map: its end is too light for lines


def draw_loci(figure: Any, study: Study) -> None:
    """
    Draw a row of panels a mode, over the first parameter.

    Colours and markers are of the second parameter, line styles of all others.

    Parameters
    ----------
    figure : matplotlib Figure
        Of a slide.
    study : Study
        Of the task 'locus'.

    """
    names = list(study.axes)
    x, label = study_axis(study, names[0])
    lines = study.size // len(x)
    second = study.axes[names[1]] if len(names) > 1 else np.zeros(1)
    inner = lines // len(second)
    looks = _looks(len(second), len(x))
    numbers = study.about['numbers']
    panels = figure.subplots(len(numbers), 2, squeeze=False, sharex=True)
    shown = np.unique(np.linspace(0, lines - 1, _MOST_LINES).round().astype(int)).tolist()
    for row, number in zip(panels, numbers, strict=True):
        for panel, what, unit in zip(row, ('frequency_hz', 'growth_rate'), (1e3, 1.0),
                                     strict=True):
            values = study.columns[f'{what}_{number}'].reshape(len(x), -1) / unit
            for i in shown:
                style = {} if inner == 1 else {'linestyle': LINES[i % inner % len(LINES)]}
                panel.plot(x, values[:, i], linewidth=1.6, **looks[i // inner] | style)
            panel.grid(color='0.93')
            panel.set_xlim(*axis_ends(x))
        row[0].set_ylabel(f'mode {number}\nfrequency  kHz')
        row[1].set_ylabel('growth rate  1/s')
        row[1].axhline(0.0, color='0.4', linewidth=0.8)
    for panel in panels[-1]:
        panel.set_xlabel(label)
    if len(names) > 1:
        _explain(figure, panels, study, looks)


def _looks(count: int, points: int) -> list[dict[str, Any]]:
    """Return the line styles of each value of the second parameter."""
    colours = COLOURS if count <= len(MARKERS) else colormaps['viridis'](
        np.linspace(0.0, 0.9, count))
    return [{'color': colours[i], 'marker': MARKERS[i % len(MARKERS)], 'markersize': 6.0,
             'markevery': 1 + points // 15, 'linestyle': LINES[i % len(LINES)]}
            for i in range(count)]


def _explain(figure: Any, panels: Any, study: Study, looks: list[dict[str, Any]]) -> None:
    """Draw the legend of colours and line styles."""
    names = list(study.axes)
    values, words = study_axis(study, names[1])
    rest = {name: study_axis(study, name) for name in names[2:]}
    of_styles = ', '.join(label for _, label in rest.values())
    places = list(product(*(own.tolist() for own, _ in rest.values()))) if rest else []
    if told := 0 < len(places) <= len(LINES):
        _legend(figure, of_styles, [
            ({'color': GREY, 'linestyle': line}, ', '.join(f'{value:.4g}' for value in place))
            for line, place in zip(LINES, places, strict=False)], 'outside lower right')
    elif places:
        words += f'\n({len(places)} lines each, of {of_styles}; their styles repeat)'
    if len(values) <= len(MARKERS):
        solid = {'linestyle': '-'} if rest else {}
        _legend(figure, words, [(look | solid, f'{value:.4g}') for value, look in zip(
            values.tolist(), looks, strict=True)], f'outside lower {"left" if told else "center"}')
    else:
        figure.colorbar(_colour_key(values), ax=panels, pad=0.01, aspect=35, label=words)


def _legend(figure: Any, title: str, lines: list[tuple[dict[str, Any], str]], at: str) -> None:
    figure.legend(handles=[Line2D([], [], linewidth=1.6, label=text, **look)
                           for look, text in lines],
                  title=title, loc=at, ncols=len(lines), frameon=False)


def _colour_key(values: FloatArray) -> Any:
    colours = LinearSegmentedColormap.from_list('', colormaps['viridis'](_SAMPLES))
    return ScalarMappable(Normalize(*axis_ends(values)), colours)
