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

"""Loci: frequency and growth rate of a few modes over one parameter."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from squeal_core.common.arrays import FloatArray
from squeal_core.studies.sweep_record import Sweep
from squeal_core.view.saving import FigureTarget
from squeal_core.view.slide import COLOURS, LINES, MARKERS
from squeal_core.view.stability_map import axis_ends, axis_of, sheet

_MARKED = 12  # places of a line, about, at which it has a marker


def plot_loci(record: Sweep, numbers: Sequence[int], path: FigureTarget, *,
              without: Sweep | None = None, title: str = '', overwrite: bool = True,
              paper: bool = False) -> None:
    """
    Draw the loci of some modes, with rotation (solid) and without (broken), as K09 figs 11, 12.

    Parameters
    ----------
    record : Sweep
        Of one parameter, tracked.
    numbers : sequence of int
        Identities of the modes.
    path : path
        Where the file is.
    without : Sweep, optional
        The same without rotation.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.
    paper : bool
        Whether it is for a page, not for a slide.

    """
    (parameter,) = record.axes
    label = axis_of(record, parameter)[1]
    with sheet(path, record, f'Modes over {label.split("  ")[0]}', title,
               paper=(9.5, 4.4) if paper else None, overwrite=overwrite) as figure:
        frequency, growth = figure.subplots(1, 2)
        markers = None if paper else MARKERS
        _loci(frequency, growth, record, numbers, '-', '', markers)
        if without is not None:
            _loci(frequency, growth, without, numbers, '--', ', without rotation', markers)
        growth.axhline(0.0, color='0.4', linewidth=0.8, zorder=1.6)  # over the grid
        frequency.set(xlabel=label, ylabel='frequency  Hz')
        growth.set(xlabel=label, ylabel='Re λ  1/s')
        for panel in (frequency, growth):
            panel.margins(x=0.0)
            panel.grid(color='0.93')
        handles, labels = frequency.get_legend_handles_labels()
        once = dict(zip(labels, handles, strict=True))  # a merged pair is said of both
        figure.legend(once.values(), once.keys(), loc='outside lower center',
                      ncols=3 if len(once) % 2 else min(len(once), 4), frameon=False)


def _loci(frequency: Any, growth: Any, record: Sweep, numbers: Sequence[int], style: str,
          words: str, markers: str | None) -> None:
    """Draw lines by number; grey dots where two modes are a merged pair, and which is not said."""
    (parameter,) = record.axes
    x = axis_of(record, parameter)[0]
    for i, number in enumerate(numbers):
        colour, eigenvalues, merged = COLOURS[i % len(COLOURS)], record.of(number), record.merged(
            number)
        for axes, values in ((frequency, eigenvalues.imag / (2.0 * np.pi)),
                             (growth, eigenvalues.real)):
            axes.plot(x, np.where(merged, np.nan, values), color=colour, linestyle=style,
                      linewidth=1.6, label=f'mode {number}{words}', **_marks(x, i, markers))
            if merged.any():
                pairs = ', '.join(sorted(set(record.names(number)[merged].tolist())))
                axes.plot(x, np.where(_from_before(merged), values, np.nan), color='0.35',
                          linestyle=style, linewidth=1.6, marker='.', markersize=3,
                          label=f'merged {pairs}{words}')


def _marks(x: FloatArray, place: int, markers: str | None) -> dict[str, Any]:
    """Return the markers of a line, apart from those of the lines before."""
    step = 1 + x.size // _MARKED
    return {} if markers is None else {
        'marker': markers[place % len(markers)], 'markersize': 7.0,
        'markevery': (place * max(step // 4, 1) % step, step)}


def _from_before(merged: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """With the points beside them, so that lines join."""
    wide = merged.copy()
    wide[:-1] |= merged[1:]
    wide[1:] |= merged[:-1]
    return wide


def plot_growth_rates(record: Sweep, path: FigureTarget, *, title: str = '',
                      overwrite: bool = True, numbers: Sequence[int] | None = None,
                      paper: bool = False) -> None:
    """
    Draw growth rates over a parameter, as K09 fig. 15 over speed; divergence apart.

    Parameters
    ----------
    record : Sweep
        Of one parameter, tracked.
    path : path or binary file
        Where the file is.
    title : str
        Above the figure.
    overwrite : bool
        Whether an existing file may be replaced.
    numbers : sequence of int, optional
        Identities; by default of the oscillating modes that grow anywhere in the sweep.
    paper : bool
        Whether it is for a page, not for a slide.

    """
    (parameter,) = record.axes
    x, label = axis_of(record, parameter)
    chosen = _growing(record) if numbers is None else list(numbers)
    divergence = np.where(record.kinds == 'divergence', record.eigenvalues.real, np.nan)
    apart = bool(np.isfinite(divergence).any())
    with sheet(path, record, f'Growth rates over {label.split("  ")[0]}', title,
               paper=(8.5, 6.5 if apart else 5.0) if paper else None,
               overwrite=overwrite) as figure:
        panels = figure.subplots(2 if apart else 1, 1, sharex=True, squeeze=False,
                                 height_ratios=(1, 3) if apart else (1,))[:, 0]
        if apart:
            panels[0].plot(x, divergence, color='0.25', linewidth=1.4)
            panels[0].set(ylabel='divergence  1/s')
            panels[0].set_ylim(bottom=0.0)
        _lines(panels[-1], record, x, chosen, None if paper else MARKERS)
        panels[-1].set(xlabel=label, ylabel='Re λ of oscillating modes  1/s')
        for panel in panels:
            panel.grid(color='0.93')
            panel.set_xlim(*axis_ends(x))


def _growing(record: Sweep) -> list[int]:
    """Return the numbers of the modes that flutter somewhere, once for a merged pair."""
    texts = np.unique(record.identities[record.kinds == 'flutter']).tolist()
    return sorted({int(text.split('/')[0]) for text in texts})


def _lines(axes: Any, record: Sweep, x: FloatArray, numbers: Sequence[int],
           markers: str | None) -> None:
    axes.axhline(0.0, color='0.4', linewidth=0.8, zorder=1.6)  # over the grid
    floor = 0.0
    for i, number in enumerate(numbers):
        eigenvalues = record.of(number)
        if not np.isfinite(eigenvalues).any():
            continue
        # at one end of the sweep or between, where it is worst
        worst = int(np.nanargmax(eigenvalues.real))
        colour = COLOURS[i % len(COLOURS)]
        name = str(record.names(number)[worst])  # of a merged pair both numbers
        axes.plot(x, eigenvalues.real, color=colour, linewidth=1.6,
                  linestyle=LINES[i // (1 if markers else len(COLOURS)) % len(LINES)],
                  **_marks(x, i, markers),
                  label=f'{name}: {eigenvalues.imag[worst] / 2.0 / np.pi:.0f} Hz')
        floor = min(floor, -np.nanmax(eigenvalues.real))
    axes.set_ylim(bottom=1.2 * floor)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc='upper left', bbox_to_anchor=(1.0, 1.0), frameon=False, title='mode')
