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
Plots of studies: lines over one parameter, a map over two, a matrix of projections over more.

A projection shows two parameters; of all others it takes the worst point, and says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

try:
    from matplotlib import colormaps, rc_context
    from matplotlib.colors import Normalize, PowerNorm
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.studies.study_record import Study
from squeal_core.surrogate.grid_columns import IMPOSSIBLE
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import COLOURS, LINES, slide
from squeal_core.view.stability_map import axis_ends, end_at_points, GROWTH_OR_NOT
from squeal_core.view.study_labels import (
    parameter_in_words,
    study_axis,
    study_conditions,
    wrapped,
)
from squeal_core.view.study_loci import draw_loci

_LEAST_SPAN = 0.02  # of an axis of frequency, relative: less is no change to look at


def plot_study(study: Study, path: FigureTarget, *, title: str = '',
               overwrite: bool = True) -> None:
    """
    Draw a study.

    Parameters
    ----------
    study : Study
        The study.
    path : path or binary file
        Where the figure goes.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.

    """
    task = study.about['task']
    heading = title or '{} over {}'.format(
        {'map': 'Largest growth rate', 'locus': 'Modes'}.get(task, 'Stability boundary'),
        ', '.join(parameter_in_words(name)[0] for name in study.axes))
    with rc_context({'hatch.color': '0.55', 'axes.formatter.useoffset': False}), slide(
            path, heading, study_conditions(study), overwrite=overwrite) as figure:
        if task == 'locus':
            draw_loci(figure, study)
        else:
            draw = {1: _line, 2: _map}.get(len(study.axes), _matrix)
            draw(figure, study, _growth(study) if task == 'map' else _critical(study))


@dataclass(frozen=True, eq=False)
class _Shown:
    """A figure of each point, as the grid; `worst` tells which of several points to show."""

    values: FloatArray
    label: str
    norm: Any
    colours: Any
    worst: Any
    worst_in_words: str
    level: float | None = None


def _growth(study: Study) -> _Shown:
    values = study.grid('growth_rate')
    low, high = (end / 1e3 for end in study.about['band'])
    most = float(np.nanmax(values)) if np.isfinite(values).any() else 1.0
    return _Shown(values, f'largest growth rate, {low:g} to {high:g} kHz  1/s',
                  PowerNorm(0.5, 0.0, max(most, 1.0)), GROWTH_OR_NOT, np.fmax,
                  'the largest growth rate', 0.0)


def _critical(study: Study) -> _Shown:
    name, unit, factor = parameter_in_words(study.about['parameter'])
    values = {side: study.grid(side) / factor for side in ('above', 'below')}
    side = max(values, key=lambda one: int(np.isfinite(values[one]).sum()))
    result, known = values[side], np.isfinite(values[side])
    ends = (result[known].min(), result[known].max()) if known.any() else (0.0, 1.0)
    # the nearest one is the worst to a stable point, the farthest one to an unstable point
    unstable = 2 * (study.grid('growth_rate')[known] > 0.0).sum() > known.sum()
    lowest = (side == 'above') != unstable
    worst, words = (np.fmin, 'the lowest') if lowest else (np.fmax, 'the highest')
    return _Shown(result, f'stability boundary of {name}, {side} the point  {unit}'.rstrip(),
                  Normalize(*ends), colormaps['viridis'], worst, words)


def _line(figure: Any, study: Study, shown: _Shown) -> None:
    x, label = study_axis(study, next(iter(study.axes)))
    top, bottom = figure.subplots(2, 1, sharex=True)
    if study.about['task'] == 'map':
        growth, hertz = study.columns['growth_rate'], study.columns['frequency_hz'] / 1e3
        unstable = study.columns['squeal_modes'] > 0.0
        top.plot(x, growth, color=COLOURS[0], marker='o', markersize=6)
        top.axhline(0.0, color='0.4', linewidth=0.8)
        top.set_ylabel('growth rate  1/s')
        bottom.plot(x[~unstable], hertz[~unstable], 'o', markerfacecolor='none', color='0.5',
                    label='stable')
        bottom.plot(x[unstable], hertz[unstable], 's', color=COLOURS[1], label='unstable')
        bottom.set_ylabel('its frequency  kHz')
        bottom.legend(frameon=False)
    else:
        name, unit, factor = parameter_in_words(study.about['parameter'])
        for i, side in enumerate(('below', 'above')):
            top.plot(x, study.columns[side] / factor, color=COLOURS[i], linestyle=LINES[i],
                     marker='ov'[i], markersize=6, label=f'{side} the point')
            bottom.plot(x, study.columns[f'{side}_hz'] / 1e3, color=COLOURS[i],
                        linestyle=LINES[i], marker='ov'[i], markersize=6)
        top.set_ylabel(f'boundary of\n{name}  {unit}'.rstrip())
        top.legend(frameon=False)
        bottom.set_ylabel('frequency there  kHz')
    bottom.set(xlabel=label, xlim=axis_ends(x))
    low, high = bottom.get_ylim()
    room = max(0.0, _LEAST_SPAN * high - (high - low)) / 2.0
    bottom.set_ylim(low - room, high + room)
    lost = x[study.columns['source'] == IMPOSSIBLE]
    for panel in (top, bottom):
        panel.grid(color='0.93')
        if lost.size:  # the layout takes an empty line for one of great length
            panel.plot(lost, 0.0 * lost + 0.03, 'x', color='black', clip_on=False,
                       transform=panel.get_xaxis_transform())


def _map(figure: Any, study: Study, shown: _Shown) -> None:
    axes = figure.subplots()
    shades = _shade(axes, study, (0, 1), shown)
    first, second = study.axes
    axes.set(ylabel=study_axis(study, first)[1], xlabel=study_axis(study, second)[1])
    bar = figure.colorbar(shades, ax=axes, pad=0.02, aspect=35,
                          extend='min' if shown.level is not None else 'neither')
    bar.set_label(f'{shown.label}\n{_legend(study, shown)}')


def _legend(study: Study, shown: _Shown) -> str:
    parts = [] if shown.level is None else ['white: stable']
    parts += ['hatched: none'] if np.isnan(shown.values).any() else []
    return f'({", ".join(parts)})' if parts else ''


def _shade(panel: Any, study: Study, pair: tuple[int, int], shown: _Shown) -> Any:
    """Shade a projection on two axes, the first one upwards; return what a colour bar takes."""
    names = list(study.axes)
    others = tuple(i for i in range(len(names)) if i not in pair)
    values = shown.worst.reduce(shown.values, axis=others) if others else shown.values
    if pair[0] > pair[1]:
        values = values.T
    y, x = (study_axis(study, names[i])[0] for i in pair)
    panel.patch.set(facecolor='0.92', hatch='///')
    shades = panel.pcolormesh(x, y, np.ma.masked_invalid(values), cmap=shown.colours,
                              shading='nearest', norm=shown.norm)
    end_at_points(panel, x, y, labelled=not others)
    level = shown.level
    if level is not None and min(values.shape) > 1 and (
            np.nanmin(values, initial=level) < level < np.nanmax(values, initial=level)):
        panel.contour(x, y, values, levels=[level], colors='black', linewidths=1.2)
    return shades


def _matrix(figure: Any, study: Study, shown: _Shown) -> None:
    """Below the diagonal the worst of all others, on it and above it how many points squeal."""
    names, count = list(study.axes), len(study.axes)
    panels = figure.subplots(count, count, squeeze=False)
    share, shades = _share(study), dict[bool, Any]()
    for row, own in enumerate(panels):
        for column, panel in enumerate(own):
            if row == column:
                _marginal(panel, study, row, share.values)
            else:
                shades[row > column] = _shade(panel, study, (row, column),
                                              shown if row > column else share)
            _labels(panel, study, names, row, column)
    figure.colorbar(shades[True], ax=panels, pad=0.01, aspect=45, location='right',
                    extend='min' if shown.level is not None else 'neither',
                    label=f'below the diagonal:\n{shown.label},\n{shown.worst_in_words} over '
                    f'all others\n{_legend(study, shown)}'.strip())
    figure.colorbar(shades[False], ax=panels, pad=0.01, aspect=45, location='bottom',
                    label=f'on and above the diagonal: {share.label}, over all other parameters')


def _share(study: Study) -> _Shown:
    source = study.grid('source')
    if study.about['task'] == 'map':
        bad, label = study.grid('squeal_modes') > 0.0, 'points with squeal  %'
    else:
        bad, label = study.grid('growth_rate') > 0.0, 'points with an unstable mode  %'
    known = (source != IMPOSSIBLE) & (source != 0.0)
    return _Shown(np.where(known, 100.0 * bad, np.nan), label, Normalize(0.0, 100.0),
                  colormaps['Blues'], _Mean(), 'the mean')


class _Mean:
    """The mean of points that are known, called as a numpy reduction."""

    @staticmethod
    def reduce(values: FloatArray, axis: tuple[int, ...]) -> FloatArray:
        known = np.isfinite(values)
        count = known.sum(axis=axis)
        total = np.where(known, values, 0.0).sum(axis=axis)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)


def _marginal(panel: Any, study: Study, axis: int, share: FloatArray) -> None:
    x = study_axis(study, list(study.axes)[axis])[0]
    rows = np.moveaxis(share, axis, 0).reshape(len(x), -1)
    panel.plot(x, _Mean.reduce(rows, (1,)), color=COLOURS[0], marker='o', markersize=3)
    panel.set(ylim=(-3.0, 103.0), xlim=axis_ends(x))
    panel.yaxis.tick_right()
    panel.set_yticks([0, 50, 100], ['0', '50', '100 %'])
    panel.spines[['right']].set_visible(True)
    panel.grid(color='0.93')


def _labels(panel: Any, study: Study, names: Sequence[str], row: int, column: int) -> None:
    last = len(names) - 1
    panel.tick_params(labelsize=10)
    if row == last:
        panel.set_xlabel(wrapped(study_axis(study, names[column])[1]), fontsize=11)
    else:
        panel.tick_params(labelbottom=False)
    if column == 0:
        panel.set_ylabel(wrapped(study_axis(study, names[row])[1]), fontsize=11)
    if row != column and column != 0:
        panel.tick_params(labelleft=False)
