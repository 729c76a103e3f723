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

"""Maps of stability: all frequencies over one parameter, or the growth rate over two."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

try:
    from matplotlib import colormaps, rc_context
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, PowerNorm
    from matplotlib.figure import Figure
except ImportError as error:
    raise ImportError("plots need matplotlib: pip install -e '.[view]' in the checkout") from error
import numpy as np
from squeal_core.common.arrays import FloatArray
from squeal_core.stability.eigensolution import SQUEAL_BAND
from squeal_core.studies.sweep_record import Sweep
from squeal_core.view.saving import FigureTarget, save_figure
from squeal_core.view.slide import pressure_words, slide, stiffness_words
from squeal_core.view.study_labels import shown_axis

STYLE = {'font.size': 10, 'axes.spines.top': False, 'axes.spines.right': False,
         'axes.linewidth': 0.8, 'axes.titlesize': 11, 'axes.titlelocation': 'left'}
# from yellow-orange on: the lightest colours of a map are lost on white
GROWTH = ListedColormap(colormaps['inferno_r'](np.linspace(0.22, 0.92, 256)), 'growth')
GROWTH_OR_NOT = ListedColormap(colormaps['inferno_r'](np.linspace(0.02, 0.92, 256)),
                               'growth or not').with_extremes(under='white')
_CONDITIONS: tuple[tuple[str, Callable[[float, float | None], str]], ...] = (
    # parameter, and in words its value (and the brake pressure)
    ('rotor_speed', lambda value, _: f'Ω = {value:g} rad/s'),
    ('friction', lambda value, _: f'µ = {value:.3g}'),
    ('friction_slope', lambda value, _: f'slope = {value:.3g} s/m'),
    ('contact_pressure', pressure_words))
_USUAL_HZ = 8000.0  # up to here K09's maps go
_MOST_MARKS = 900  # points of a map that are marked
_MOST_TICKS = 9  # values of an axis of a map that all have their label


def axis_of(record: Sweep, parameter: str) -> tuple[FloatArray, str]:
    """Return a swept parameter in the unit it is shown in, and the axis' label."""
    if parameter == 'contact_stiffness':
        share = record.axes[parameter] / record.about['nominal_contact_stiffness']
        return 100.0 * share, 'contact stiffness  % of nominal'
    return shown_axis(parameter, record.axes[parameter])


def conditions(record: Sweep, *, brief: bool = False) -> str:
    """Return in words what was not swept; in brief without a contact stiffness that is nominal."""
    about, parts = record.about, [str(record.about['model'])]
    law, brake_pressure = about['friction_law'], None if brief else (
        about.get('brake_pressure') or None)
    by_law = {True: ('friction', 'friction_slope'), 'slope': ('friction_slope',)}.get(law, ())
    for name, text in _CONDITIONS:
        values = record.column(name)
        # usual values are omitted; a slope that changes follows the friction
        usual = {'friction_slope': 0.0}.get(name)
        if name not in record.axes and name not in by_law and np.any(values != usual):
            parts.append('slope in proportion to µ' if np.ptp(values) != 0.0
                         else text(values[0], brake_pressure))
    parts += _stiffness(record, brief)
    parts += {True: ['friction by its law of speed'],
              'slope': ['slope by the law of friction']}.get(law, [])
    parts += [] if about['rotation'] else ['without rotation']
    parts += [] if record.complete else [f'{record.done.sum()} of {len(record.points)} points']
    return ', '.join(filter(None, parts))


def _stiffness(record: Sweep, brief: bool) -> list[str]:
    values, nominal = record.column('contact_stiffness'), record.about['nominal_contact_stiffness']
    if 'contact_stiffness' in record.axes:  # whose axis is in per cent
        return [] if brief else [f'nominal contact stiffness {stiffness_words(nominal)}']
    if brief:
        return [] if np.all(values == nominal) else [f'stiffness {values[0] / nominal:.0%}']
    return [f'contact stiffness {stiffness_words(values.min(), values.max())}']


def shown_to(record: Sweep, top: float) -> str:
    """Return the frequency [Hz] up to which modes are drawn, in words; '' if all are."""
    above = (record.frequencies_hz > top) & np.isin(record.kinds, ('flutter', 'stable'))
    if not above.any():
        return ''
    unstable = 'some unstable' if (record.kinds[above] == 'flutter').any() else 'nothing unstable'
    return f', shown to {top / 1e3:.3g} kHz ({unstable} above)'


@contextmanager
def sheet(path: FigureTarget, record: Sweep, heading: str, title: str, *,
          paper: tuple[float, float] | None, overwrite: bool, more: str = '') -> Iterator[Any]:
    """Yield the figure of a slide, or of a size on paper [in], with a title; save it."""
    if paper is None:
        with slide(path, title or heading, conditions(record) + more,
                   overwrite=overwrite) as figure:
            yield figure
        return
    with rc_context(STYLE):
        figure = Figure(figsize=paper, layout='constrained')
        yield figure
        words = conditions(record, brief=True)
        words = f'{title}\n{words}' if title else words
        grid = figure.axes[0].get_gridspec()
        if grid is not None and grid.ncols > 1:
            figure.suptitle(words, fontsize=11, x=0.01, ha='left')
        else:
            figure.axes[0].set_title(words)
        save_figure(figure, path, dpi=130, overwrite=overwrite)


def plot_stability_map(record: Sweep, path: FigureTarget, *, title: str = '',
                       overwrite: bool = True, highest_hz: float | None = None,
                       paper: bool = False) -> None:
    """
    Draw the frequencies of all modes over a parameter; those that grow are marked.

    Parameters
    ----------
    record : Sweep
        Of one parameter.
    path : path
        PNG, SVG or PDF.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.
    highest_hz : float, optional
        Where the frequency axis ends; by default at 8 kHz, or above the highest flutter.
    paper : bool
        Whether it is for a page, not for a slide.

    Notes
    -----
    As K09 figs 10 and 13: a circle marks Re(lambda) > 0; its colour is the growth rate. Crosses
    at zero frequency mark divergence.

    """
    (parameter,) = record.axes
    x, label = axis_of(record, parameter)
    oscillating = np.where(np.isin(record.kinds, ('flutter', 'stable')),
                           record.frequencies_hz, np.nan) / 1e3
    flutter = np.where(record.kinds == 'flutter', record.frequencies_hz, 0.0)
    top = highest_hz or max(_USUAL_HZ, 1.05 * float(flutter.max()))
    with sheet(path, record, f'Frequencies over {label.split("  ")[0]}', title,
               paper=(9.0, 6.5) if paper else None, overwrite=overwrite,
               more=shown_to(record, top)) as figure:
        axes = figure.subplots()
        axes.plot(x, oscillating, color='0.72', linewidth=0.7, zorder=1)
        _circles(axes, record, x, top)
        diverging = x[(record.kinds == 'divergence').any(axis=1)]
        if diverging.size:
            axes.plot(diverging, 0.0 * diverging, 'x', color='black', markersize=5, zorder=2,
                      clip_on=False, label='divergence')
            axes.legend(loc='lower right', frameon=False, bbox_to_anchor=(1.0, 1.0))
        axes.set(xlabel=label, ylabel='frequency  kHz', ylim=(0.0, top / 1e3), xlim=axis_ends(x))


def _circles(axes: Any, record: Sweep, x: FloatArray, top: float) -> None:
    """Mark the modes that flutter up to a frequency, the colour their growth rate."""
    place, mode = np.nonzero((record.kinds == 'flutter') & (record.frequencies_hz <= top))
    growth = record.eigenvalues.real[place, mode]
    if not growth.size:
        return
    shade = ScalarMappable(PowerNorm(0.5, 0.0, growth.max()), GROWTH)
    axes.scatter(x[place], record.frequencies_hz[place, mode] / 1e3, s=22, marker='o',
                 facecolors='none', edgecolors=shade.to_rgba(growth), linewidths=1.3, zorder=2,
                 clip_on=False)
    axes.figure.colorbar(shade, ax=axes, label='growth rate of unstable modes  1/s', pad=0.02,
                         aspect=35)


def axis_ends(x: FloatArray) -> tuple[float, float]:
    """Return the ends of an axis, with some margin about a single value."""
    low, high = float(x.min()), float(x.max())
    room = 0.0 if high > low else 0.05 * abs(low) or 1.0
    return low - room, high + room


def plot_growth_map(record: Sweep, path: FigureTarget, *, title: str = '', overwrite: bool = True,
                    band_hz: tuple[float, float] = SQUEAL_BAND) -> None:
    """
    Draw the largest growth rate in a band over two parameters; the black line is its zero.

    Parameters
    ----------
    record : Sweep
        Of two parameters.
    path : path or binary file
        Where the file is.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.
    band_hz : (2,) floats
        Low and high end [Hz].

    """
    first, second = record.axes
    (y, y_label), (x, x_label) = axis_of(record, first), axis_of(record, second)
    growth = np.maximum(record.largest_growth(*band_hz), -1e3)  # -inf: no mode in the band
    known = growth[np.isfinite(growth)]
    heading = 'Largest growth rate over ' + ' and '.join(
        one.split('  ')[0] for one in (x_label, y_label))
    with sheet(path, record, heading, title, paper=None, overwrite=overwrite) as figure:
        axes = figure.subplots()
        axes.set_facecolor('0.85')
        norm = PowerNorm(0.5, 0.0, max(known.max(initial=0.0), 1.0))
        shades = axes.pcolormesh(x, y, np.ma.masked_invalid(growth), cmap=GROWTH_OR_NOT,
                                 shading='nearest', norm=norm)
        if known.min(initial=0.0) < 0.0 < known.max(initial=0.0) and min(growth.shape) > 1:
            axes.contour(x, y, growth, levels=[0.0], colors='black', linewidths=1.4)
        figure.colorbar(shades, ax=axes, pad=0.02, aspect=35, extend='min', label=(
            f'largest growth rate, {band_hz[0] / 1e3:g} to {band_hz[1] / 1e3:g} kHz  1/s\n'
            '(white: stable, grey: not done)'))
        axes.set(xlabel=x_label, ylabel=y_label)
        end_at_points(axes, x, y, labelled=True)


def end_at_points(axes: Any, x: FloatArray, y: FloatArray, *, labelled: bool = False) -> None:
    """End the axes of a map at its outermost points; mark (and label) them where they are few."""
    axes.set(xlim=axis_ends(x), ylim=axis_ends(y))
    for axis, values in ((axes.xaxis, x), (axes.yaxis, y)):
        if labelled and 1 < values.size <= _MOST_TICKS:
            axis.set_ticks(values, [f'{value:.4g}' for value in values.tolist()])
    if x.size * y.size <= _MOST_MARKS:
        axes.plot(*map(np.ravel, np.meshgrid(x, y)), 'o', markersize=4.0,
                  markerfacecolor='white', markeredgecolor='0.3', clip_on=False, zorder=3)
